"""The progress bar."""

import subprocess
import sys

BARS = """
import sys, threading
from chrmc.progress import progress
for label in ("one", "two"):
    assert list(progress(range(3), label)) == [0, 1, 2]
watching = [t for t in threading.enumerate() if t is not threading.main_thread()]
print(len(watching), "multiprocessing.synchronize" in sys.modules)
"""


def test_a_bar_makes_no_semaphore_and_one_thread() -> None:
    """A program ended by a signal leaves a semaphore behind, and newer Pythons say so."""
    shown = subprocess.run([sys.executable, "-c", BARS], capture_output=True, text=True, timeout=60)
    assert (shown.stdout, shown.stderr) == ("1 False\n", "")
