"""Long runs of play, live and generate: memory, handles and threads must stay flat.

Run by scripts/soak.sh; looks at the processes from outside, through /proc.
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
PANEL = ["--slm", "480x300:32.4um"]
COMMANDS = {
    "play": ["play", "video", "--headless", "--loop", "--fps", "60"],
    "live": ["live", "car-house", "--headless", "--loop", *PANEL],
    "generate": ["generate", "long.py:scene", "--out", "made", *PANEL, "--check-pixels", "16"],
}
LONG_SCENE = """
import numpy as np
import chrmc

places = np.random.default_rng(1).normal(0, 2e-4, (300, 3))
cloud = chrmc.PointCloud(places, np.ones(300), np.zeros(300))
angles = np.arange(10_000) * 2e-3
poses = [chrmc.Pose.from_rotvec([0, a, 0], [0, 0, 0.25]) for a in angles]
scene = chrmc.PointScene("long", {"cluster": cloud}, {"cluster": poses})
"""


@dataclass(frozen=True)
class Sample:
    """A process at a moment: seconds since its start, megabytes resident, handles, threads."""

    seconds: float
    megabytes: float
    handles: int
    threads: int


def sample(process: int, seconds: float) -> Sample | None:
    """What /proc says; None for a process that has ended."""
    place = Path(f"/proc/{process}")
    try:
        lines = dict(
            line.split(":", 1)
            for line in (place / "status").read_text().splitlines()
            if ":" in line
        )
        handles = len(list((place / "fd").iterdir()))
        return Sample(
            seconds, int(lines["VmRSS"].split()[0]) / 1024, handles, int(lines["Threads"])
        )
    except (OSError, KeyError):
        return None


def grown(samples: list[Sample], spare: float) -> str:
    """What grew from the second quarter to the last, in words; nothing when all is flat.

    spare : megabytes that it may grow by
    """
    quarter = len(samples) // 4
    if quarter < 2:
        return ""
    before, after = samples[quarter : 2 * quarter], samples[-quarter:]
    told = []
    # A frame's file is open for a moment only: the least of a quarter is what stays open.
    for name, measure, slack in (
        ("megabytes", max, spare),
        ("handles", min, 0),
        ("threads", min, 0),
    ):
        first, last = (measure(getattr(s, name) for s in part) for part in (before, after))
        if last > first + slack:
            told.append(f"{name} from {first:.0f} to {last:.0f}")
    return ", ".join(told)


def soak(name: str, arguments: list[str], folder: Path, minutes: float) -> str:
    """Run a command, print what it takes, and say what went wrong."""
    process = subprocess.Popen(
        [sys.executable, "-m", "chrmc", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    start, samples, shown = time.monotonic(), [], 0.0
    pause = min(5.0, 60 * minutes / 40)
    while process.poll() is None and time.monotonic() - start < 60 * minutes:
        time.sleep(pause)
        now = sample(process.pid, time.monotonic() - start)
        if now is None:
            break
        samples.append(now)
        if now.seconds >= shown:
            shown = now.seconds + 60 * minutes / 10
            print(
                f"{name:<10}{now.seconds / 60:>8.1f} min{now.megabytes:>8.0f} MB"
                f"{now.handles:>5} handles{now.threads:>4} threads",
                flush=True,
            )
    early = process.poll()
    if early is None:
        process.send_signal(signal.SIGINT)
    told = process.communicate()[1].strip()
    if early not in (None, 0):
        return f"{name} ended with {early}: {told[-200:]}"
    # A manifest keeps a record of each frame: a hundred frames, a megabyte.
    growth = grown(samples, 16 + 0.01 * len(list((folder / "made").glob("frame_*"))))
    return f"{name} grows: {growth}" if growth else ""


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("commands", nargs="*", help=f"of {', '.join(COMMANDS)} [all]")
    parser.add_argument("--minutes", type=float, default=60)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="soak") as place:
        folder = Path(place)
        (folder / "long.py").write_text(LONG_SCENE)
        made = ["generate", "car-house", "--out", "video", "--frames", "1:20", *PANEL]
        subprocess.run(
            [sys.executable, "-m", "chrmc", *made],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stdout=subprocess.DEVNULL,
            check=True,
        )
        chosen = asked.commands or list(COMMANDS)
        wrong = [w for n in chosen if (w := soak(n, COMMANDS[n], folder, asked.minutes))]
    for line in wrong:
        print(line)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
