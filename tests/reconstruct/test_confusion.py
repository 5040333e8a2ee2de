"""Random right and wrong pictures; other seeds by hand: `python tests/reconstruct/confusion.py`."""

import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.long
def test_right_pictures_pass_and_wrong_ones_fail() -> None:
    script = Path(__file__).with_name("confusion.py")
    done = subprocess.run([sys.executable, script, "12", "2"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
