"""The trade-off's table: its entries, which of them nothing beats, and the file it is kept in."""

import csv
import io
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path

import numpy as np

from chrmc.files import read_text, replacing, still_there
from chrmc.ranges import Count


@dataclass
class Entry:
    """One method at one setting on one scene.

    kind : "cgh", a single frame, or "video"
    seconds : of each run; errors : relative L2 of each run's field
    predicted : the largest error that the method itself expected, or None
    psnr : worst object's, dB, or None where no images were compared
    refused : why there is nothing; reckoned : the seconds a frame that it was left out for
    front : nothing else is both faster and more exact
    pixels : on how many the errors were measured
    note : what else there is to say
    """

    scene: str
    kind: str
    method: str
    setting: str
    points: int
    seconds: list[float] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)
    predicted: float | None = None
    psnr: float | None = None
    refused: str = ""
    front: bool = False
    reckoned: float | None = None
    pixels: int = 0
    note: str = ""

    @property
    def time(self) -> float:
        """Median seconds per frame."""
        return float(np.median(self.seconds)) if self.seconds else float("nan")

    @property
    def error(self) -> float:
        """Largest over the runs."""
        return max(self.errors, default=float("nan"))

    @property
    def label(self) -> str:
        return f"{self.method} {self.setting}".strip()

    def leave_out(self, seconds: float, about: str = "about ") -> None:
        """Refuse it for the seconds a frame takes."""
        self.reckoned = seconds
        told = f"{seconds:.0f}" if seconds >= 10 else f"{seconds:.2g}"
        self.refused = f"left out: {about}{told} s a frame"


def mark_front(entries: Iterable[Entry]) -> None:
    """Mark, among the entries of one scene and kind, those that no other beats in both."""
    groups: dict[tuple[str, str], list[Entry]] = {}
    for entry in entries:
        if entry.seconds and not entry.refused:
            groups.setdefault((entry.scene, entry.kind), []).append(entry)
    for group in groups.values():
        least = float("inf")
        for entry in sorted(group, key=lambda e: (e.time, e.error)):
            entry.front = entry.error < least
            least = min(least, entry.error)


KINDS = ("cgh", "video")
RUNS = Count("runs", 0, 1_000_000)
_REMEDY = "choose another --out, or replace it with --force"
COLUMNS = (
    "scene", "kind", "method", "setting", "points", "seconds", "error", "predicted", "psnr_db",
    "front", "refused", "reckoned", "runs", "pixels", "note",
)  # fmt: skip


def to_csv(entries: Iterable[Entry]) -> str:
    """The table as text, one line per entry."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for e in entries:
        writer.writerow(
            (e.scene, e.kind, e.method, e.setting, e.points, _number(e.time), _number(e.error),
             _number(e.predicted), _number(e.psnr), int(e.front), e.refused, _number(e.reckoned),
             len(e.seconds), e.pixels, e.note)
        )  # fmt: skip
    return out.getvalue()


def from_csv(text: str) -> list[Entry]:
    """Entries of a table; each has its median time and its largest error for every run.

    Raises ValueError where it is no such table.
    """
    reader = csv.DictReader(io.StringIO(text), strict=True)
    try:
        if tuple(reader.fieldnames or ()) != COLUMNS:
            raise ValueError("its columns are others")
        return [_entry(row) for row in reader]
    except (csv.Error, TypeError) as error:
        raise ValueError(str(error)) from None


def _entry(row: dict[str, str]) -> Entry:
    def number(name: str) -> float | None:
        value = float(row[name]) if row[name] else None
        if value is not None and np.isnan(value):
            raise ValueError(f"{name} is no number")
        return value

    if not row["scene"].strip() or row["kind"] not in KINDS:
        raise ValueError(f"a row of scene {row['scene']!r} and kind {row['kind']!r}")
    time, error, runs = number("seconds"), number("error"), RUNS.of(int(row["runs"]))
    return Entry(
        row["scene"], row["kind"], row["method"], row["setting"], int(row["points"]),
        [] if time is None else [time] * runs, [] if error is None else [error],
        number("predicted"), number("psnr_db"), row["refused"], row["front"] == "1",
        number("reckoned"), int(row["pixels"]), row["note"],
    )  # fmt: skip


class Table:
    """A table on disk in the making, scene by scene, whole after each.

    path : the CSV file, below one line of what it was made with
    made_with : machine, scene and settings; the table of a run with others is refused
    anew : replace a table that is there

    done : rows asked for so far; kept : rows of an earlier run that were not asked for yet
    """

    def __init__(self, path: Path, made_with: Sequence[str], anew: bool = False) -> None:
        self.path, self.made_with = path, list(made_with)
        self.done: list[Entry] = []
        self.kept = [] if anew else _kept(path, self.made_with)

    @property
    def entries(self) -> list[Entry]:
        """All rows."""
        return self.done + self.kept

    def take(
        self, scene: str, kind: str, labels: Sequence[str], make: Callable[[], list[Entry]]
    ) -> list[Entry]:
        """Rows of one scene: an earlier run's if they are those `labels`, else made and stored."""
        mine = [e for e in self.kept if (e.scene, e.kind) == (scene, kind)]
        self.kept = [e for e in self.kept if (e.scene, e.kind) != (scene, kind)]
        found = [e.label for e in mine] == list(labels)
        if not found:
            mine = make()
            mark_front(mine)
        self.done += mine
        if not found:
            still_there(self.path.parent)
            with replacing(self.path) as part:
                text = f"# {'; '.join(self.made_with)}\n{to_csv(self.entries)}"
                part.write_text(text, encoding="utf-8")
        return mine


def read_table(path: Path) -> tuple[list[str], list[Entry]]:
    """What a stored table was made with, and its entries; ValueError where it is no such table."""
    try:
        first, _, rest = read_text(path).partition("\n")
    except ValueError:
        first, rest = "", ""
    if not first.startswith("# "):
        raise ValueError(f"{path} is no trade-off's table: {_REMEDY}")
    try:
        return first.removeprefix("# ").split("; "), from_csv(rest)
    except ValueError as error:
        raise ValueError(f"{path} is not what was written ({error}): {_REMEDY}") from None


def _kept(path: Path, made_with: list[str]) -> list[Entry]:
    """Entries that an earlier run left, none where there is no file; ValueError, with what
    differs, for the table of another run."""
    try:
        before, entries = read_table(path)
    except FileNotFoundError:
        return []
    for was, now in zip_longest(before, made_with, fillvalue="nothing"):
        if was != now:
            raise ValueError(f"{path} was made with “{was}”, not “{now}”: {_REMEDY}")
    return entries


def _number(value: float | None) -> str:
    return "" if value is None or np.isnan(value) else f"{value:.4g}"
