"""What a sweep over extremes found, kind by kind, and its rows on disk."""

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from chrmc.bench.extremes import Outcome
from chrmc.bench.extremes_cases import KINDS, OBJECT, VIDEOS, case_of
from chrmc.cgh import DEFAULT_METHOD, METHODS


@dataclass
class Summary:
    """Outcomes of one kind and method: how many, and the worst of each."""

    name: str
    cases: int = 0
    refused: int = 0
    faults: int = 0
    ratio: float = 0.0
    blind: float = 0.0
    cpu: float = 0.0
    words: dict[str, int] = field(default_factory=dict)

    def add(self, row: dict[str, Any]) -> None:
        """Count a row as `Outcome.row` gives it; its numbers may be text."""
        self.cases += 1
        self.refused += bool(row["refused"])
        self.faults += bool(row["fault"])
        error, expected = float(row["error"]), float(row["expected"])
        if np.isfinite(error) and promises(row):
            self.ratio = max(self.ratio, error / promises(row))
        if np.isfinite(error) and expected > 0:
            self.blind = max(self.blind, error / expected)
        self.cpu = max(self.cpu, float(row["cpu"]))
        if row["refused"]:
            words = str(row["refused"]).split(":")[0]
            self.words[words] = self.words.get(words, 0) + 1


def promises(row: dict[str, Any]) -> float:
    """The error that a row's method promises; 0 where it promises none."""
    found = float(row["promised"])
    return found if np.isfinite(found) else 0.0


def to_csv(rows: Sequence[Mapping[str, Any]]) -> str:
    """Rows as text, one line each."""
    out = io.StringIO()
    writer = csv.DictWriter(out, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue()


def read(path: Path) -> list[dict[str, Any]]:
    """Rows that an earlier run left; none where there is no file. ValueError for another table."""
    if not path.exists():
        return []
    rows: list[dict[str, Any]] = list(csv.DictReader(path.read_text("utf-8").splitlines()))
    columns = list(Outcome(case_of(0)).row())
    if not rows or any(list(row) != columns for row in rows):
        raise ValueError(f"{path} is no table of extremes: choose another --out, or --force")
    return rows


def summaries(rows: list[dict[str, Any]]) -> Iterator[Summary]:
    """One for each kind with the default method, and one for each other method, of videos too."""
    found: dict[str, Summary] = {}
    for row in rows:
        if row["kind"] == "video":
            name = row["video"]
        else:
            name = row["kind"] if row["method"] == DEFAULT_METHOD else row["method"]
        found.setdefault(name, Summary(name)).add(row)
    yield from (found[name] for name in (*KINDS, *METHODS, OBJECT, *VIDEOS) if name in found)
