"""One CSV line per flip, written as it happens, and the histogram at the end."""

import contextlib
import csv
import platform
import time
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from datetime import UTC, datetime
from io import FileIO, StringIO
from pathlib import Path
from types import TracebackType
from typing import Any

from chrmc.files import NO_SPACE, write_json
from display.timing import Summary


@dataclass(frozen=True)
class Flip:
    """One flip.

    flip : from 1
    frame : number of the frame on screen
    file, sha256 : what it was read from
    time : seconds on the monotonic clock, when the flip was done
    interval : seconds since the flip before; empty for the first
    shown : "new", "held" (the pace repeats it), "paused", or "waiting" (the next was not ready)
    status : "first", "ok", "late" (past 1.2 periods), "dropped" (refreshes were missed), "free"
    missed : refreshes missed just before this flip
    place : where the window was when last looked at: "ok", "moved", "covered" (by another window),
        "hidden" (minimised), "unknown" (Wayland), "" (no full-screen window)
    """

    flip: int
    frame: int
    file: str
    sha256: str
    time: float
    interval: float | None
    shown: str
    status: str
    missed: int
    place: str = ""

    @property
    def late(self) -> bool:
        """Whether it came past 1.2 periods."""
        return self.status in ("late", "dropped")


COLUMNS = tuple(f.name for f in fields(Flip))


class FlipLog:
    """A CSV file of whole lines at any moment, whatever kills the player or fills the disk.

    path : replaced if it exists; None keeps nothing

    What holds for all flips goes into a file beside it, of the same name with .json.
    """

    def __init__(self, path: str | Path | None) -> None:
        self.path = path = None if path is None else Path(path)
        self._file: FileIO | None = None
        self._size = 0  # of whole lines
        if path is not None:
            if path.is_dir():
                raise ValueError(f"{path} is a folder: --log needs a file name such as flips.csv")
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = FileIO(path, "w")
            self._line(COLUMNS)

    def describe(self, **facts: Any) -> None:
        """Write what holds for all flips; the time of day and that of the flips' clock with it."""
        if self.path is not None:
            now = {
                "utc": datetime.now(UTC).isoformat(timespec="microseconds"),
                "clock": time.perf_counter(),
            }
            write_json(self.path.with_suffix(".json"), now | facts | {"versions": versions()})

    def write(self, flip: Flip) -> None:
        """Add one line."""
        if self._file is not None:
            row = list(astuple(flip))
            # A name may come from anybody: it must not end the line, and be text.
            row[2] = "".join(c if c.isprintable() else "\ufffd" for c in flip.file)
            row[4] = f"{flip.time:.6f}"
            row[5] = "" if flip.interval is None else f"{flip.interval:.6f}"
            self._line(row)

    def _line(self, values: Sequence[Any]) -> None:
        """One line in one write, before the next flip; OSError where it does not fit."""
        assert self._file is not None
        text = StringIO()
        csv.writer(text, lineterminator="\n").writerow(values)
        line = text.getvalue().encode()
        try:
            if self._file.write(line) == len(line):
                self._size += len(line)
                return
            why = "no space is left"
        except OSError as error:
            why = "no space is left" if error.errno in NO_SPACE else str(error.strerror)
        with contextlib.suppress(OSError):  # devices have no length
            self._file.truncate(self._size)
        raise OSError(f"{self.path}: {why}; the flips before are in it")

    def __enter__(self) -> "FlipLog":
        return self

    def __exit__(
        self,
        _kind: type[BaseException] | None,
        _error: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; what was written is there."""
        if self._file is not None:
            self._file.close()
            self._file = None


def versions() -> dict[str, str]:
    """What showed the frames: this package, Python, the libraries in between, the system."""
    from importlib.metadata import PackageNotFoundError, version

    found = {"python": platform.python_version(), "system": platform.platform()}
    for name in ("chrmc", "numpy", "moderngl", "glfw"):
        with contextlib.suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def plot_intervals(summary: Summary, path: Path, title: str) -> None:
    """Histogram of the intervals and their course over the run: a .png, .pdf or .svg."""
    from chrmc.figures import new_figure, save

    milliseconds = [1e3 * v for v in summary.intervals]
    figure, (left, right) = new_figure((9, 3.6), 1, 2)
    if milliseconds:
        left.hist(milliseconds, bins=min(60, max(10, len(milliseconds) // 4)), color="#3b6ea5")
        right.plot(milliseconds, ".", markersize=3, color="#3b6ea5")
    left.set_yscale("symlog", linthresh=1)
    left.set(xlabel="interval between flips / ms", ylabel="flips", title=title)
    right.set(xlabel="flip", ylabel="interval / ms", title=summary.lines()[0])
    right.set_ylim(bottom=0)
    if summary.period is not None:
        for factor, style, label in ((1.0, "-", "period"), (1.2, "--", "late from here")):
            left.axvline(1e3 * factor * summary.period, color="#c0504d", ls=style, label=label)
            right.axhline(1e3 * factor * summary.period, color="#c0504d", ls=style)
        left.legend(fontsize=8)
    save(figure, path, dpi=120)
