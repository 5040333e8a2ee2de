"""Changes that no test can see are named by lines that are there."""

import subprocess
import sys
from pathlib import Path


def test_every_group_has_changes_and_every_exception_its_line():
    listed = subprocess.run(
        [sys.executable, Path(__file__).with_name("mutation.py"), "--list"],
        capture_output=True, text=True,
    )  # fmt: skip
    assert listed.returncode == 0, listed.stderr
    counts = [int(line.split(": ")[1].split()[0]) for line in listed.stdout.splitlines()]
    assert len(counts) == 7 and min(counts) > 100
