"""Long runs of play, live and generate: memory, handles, threads and OpenGL objects must stay flat.

Run by scripts/soak.sh. The commands run at the same time, each in a process of its own, which is
looked at from outside through /proc. It writes down itself how many OpenGL objects it holds.
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
PANEL = ["--slm", "480x300:32.4um"]
COMMANDS = {
    "play": ["play", "video", "--headless", "--loop"],
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
    """A process at a moment: seconds since its start, megabytes resident, handles, threads, mapped
    pieces of memory, OpenGL objects."""

    seconds: float
    megabytes: float
    handles: int
    threads: int
    maps: int
    objects: int


def sample(process: int, seconds: float, counted: Path) -> Sample | None:
    """What /proc says, and the process of its OpenGL objects; None for one that has ended."""
    place = Path(f"/proc/{process}")
    try:
        lines = dict(
            line.split(":", 1)
            for line in (place / "status").read_text().splitlines()
            if ":" in line
        )
        return Sample(
            seconds,
            int(lines["VmRSS"].split()[0]) / 1024,
            len(list((place / "fd").iterdir())),
            int(lines["Threads"]),
            (place / "maps").read_bytes().count(b"\n"),
            int(counted.read_text() or 0) if counted.exists() else 0,
        )
    except (OSError, KeyError):
        return None


def inside(counted: Path, arguments: list[str]) -> None:
    """Run a command line, and write down every second how many OpenGL objects are not released.

    What is dropped without a release stays on the card, so it stays in the count too.
    """
    import moderngl

    from chrmc.cli.main import main

    held: list[moderngl.Texture] = []

    def noted(name: str) -> None:
        make = getattr(moderngl.Context, name)

        def made(*given: object, **named: object) -> object:
            obj = make(*given, **named)
            held.append(obj)
            return obj

        setattr(moderngl.Context, name, made)

    for name in ("texture", "buffer", "program", "vertex_array", "framebuffer", "renderbuffer",
                 "simple_framebuffer", "sampler", "query"):  # fmt: skip
        noted(name)

    def count() -> None:
        while True:
            time.sleep(1)
            held[:] = [h for h in held if not isinstance(h.mglo, moderngl.InvalidObject)]
            fresh = counted.with_suffix(".new")
            fresh.write_text(str(len(held)))
            fresh.replace(counted)

    threading.Thread(target=count, daemon=True).start()
    main(arguments)


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
        ("maps", min, 8),
        ("objects", min, 0),
    ):
        first, last = (measure(getattr(s, name) for s in part) for part in (before, after))
        if last > first + slack:
            told.append(f"{name} from {first:.0f} to {last:.0f}")
    return ", ".join(told)


def soak(name: str, arguments: list[str], folder: Path, minutes: float) -> str:
    """Run a command, print what it takes, and say what went wrong."""
    counted = folder / f"{name}.objects"
    process = subprocess.Popen(
        [sys.executable, __file__, "--inside", str(counted), *arguments],
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
        now = sample(process.pid, time.monotonic() - start, counted)
        if now is None:
            break
        samples.append(now)
        if now.seconds >= shown:
            shown = now.seconds + 60 * minutes / 10
            print(
                f"{name:<10}{now.seconds / 60:>8.1f} min{now.megabytes:>8.0f} MB"
                f"{now.handles:>5} handles{now.threads:>4} threads{now.maps:>6} maps"
                f"{now.objects:>4} OpenGL objects",
                flush=True,
            )
    early = process.poll()
    if early is None:
        process.send_signal(signal.SIGTERM)  # a job in the background hears no SIGINT
    told = process.communicate()[1].strip()
    if early not in (None, 0):
        return f"{name} ended with {early}: {told[-200:]}"
    # At the end the manifest is read back whole: a hundred frames, a megabyte.
    growth = grown(samples, 16 + 0.01 * len(list((folder / "made").glob("frame_*"))))
    return f"{name} grows: {growth}" if growth else ""


def main() -> int:
    if sys.argv[1:2] == ["--inside"]:
        inside(Path(sys.argv[2]), sys.argv[3:])
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("commands", nargs="*", help=f"of {', '.join(COMMANDS)} [all]")
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--fps", type=float, default=60, help="of play and live")
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

        def run(name: str) -> str:
            pace = [] if name == "generate" else ["--fps", str(asked.fps)]
            return soak(name, [*COMMANDS[name], *pace], folder, asked.minutes)

        with ThreadPoolExecutor() as together:
            wrong = [told for told in together.map(run, asked.commands or list(COMMANDS)) if told]
    for line in wrong:
        print(line)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    sys.exit(main())
