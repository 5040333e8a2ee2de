"""What fuzzing found once is tried again; see scripts/fuzz.sh."""

import subprocess
import sys
from pathlib import Path


def test_kept_cases_pass() -> None:
    shown = subprocess.run(
        [sys.executable, Path(__file__).with_name("fuzzing.py"), "--replay"],
        capture_output=True,
        text=True,
    )
    assert shown.returncode == 0, shown.stdout + shown.stderr
