"""The rows of a sweep made one after the other, each kept as soon as it stands.

A row is a video on the engine of `chrmc.generation`, measured and then judged. Its record is a
file of its own, found again by the digest of all that decides it; so a sweep that was cut off goes
on with the frame it was at, and a recipe that has grown makes only what is new.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from chrmc.files import read_json, replacing, still_there, sweep, told_when_full, write_json
from chrmc.generation.make import make_video
from chrmc.progress import progress
from chrmc.scene.scene import Scene
from chrmc.store.lock import writer_lock
from chrmc.store.video import Video, open_video
from chrmc.store.writer import remove_video
from chrmc.survey import spot_check
from chrmc.sweep.case import Case
from chrmc.sweep.table import Row, fits, to_csv, to_text

Judge = Callable[[Video, Sequence[int], Scene], Mapping[str, float | None]]
"""(video, frames, scene) → columns of the table that only a reconstruction can tell."""

TABLE, TEXT_TABLE = "sweep.csv", "sweep.txt"
_ROWS, _VIDEOS = "rows", "videos"


def run_sweep(
    cases: Sequence[Case],
    folder: Path,
    judge: Judge,
    machine: str,
    *,
    anew: bool = False,
    keep_videos: bool = False,
    **engine: Any,
) -> list[Row]:
    """Make the rows that `folder` does not hold yet; all of them, in the cases' order.

    judge : looks at a finished video
    machine : in words, for the table
    anew : make those too that are there; each is replaced when the new one stands
    keep_videos : leave them in the folder; else each goes when its row stands
    engine : `workers`, `scheduler` of `make_video`

    Choices that do not fit together make a row that says so. OSError, in one line, where the
    folder takes no more; rows that are finished are kept.
    """
    names = _digests(cases)
    with told_when_full(folder), writer_lock(folder):
        sweep(folder)
        sweep(folder / _ROWS)
        # Nothing of before goes until what takes its place stands.
        before = {name for name in names if name and anew}

        def kept(k: int) -> Row | None:
            return None if names[k] in before else _kept(cases[k], names[k], folder)

        found = [kept(k) for k in range(len(cases))]
        if not anew:
            _store_tables(found, folder)
        for k in progress([k for k, row in enumerate(found) if row is None], "sweep", unit="row"):
            found[k] = kept(k)  # another case may have been the same
            if found[k] is None:
                found[k] = _made(cases[k], names[k], folder, judge, machine, engine)
                before.discard(names[k])
                _store_tables(found, folder)
            if not keep_videos:
                _without_video(names[k], folder)
        for name, row in zip(names, found, strict=True):
            if row is not None and name and not keep_videos:
                _without_video(name, folder)
    return [row for row in found if row is not None]


def _digests(cases: Sequence[Case]) -> list[str]:
    """What each case's record and video are called; "" for those without a recipe."""
    from chrmc import __version__

    spots: dict[int, str] = {}
    names = []
    for case in cases:
        if case.recipe is None:
            names.append("")
            continue
        scene = case.recipe.scene
        if id(scene) not in spots:
            spots[id(scene)] = spot_check(scene)
        names.append(case.digest(__version__, spots[id(scene)]))
    return names


def _without_video(name: str, folder: Path) -> None:
    """Remove what a row's video left, and nothing else."""
    video = folder / _VIDEOS / name
    remove_video(video)
    with suppress(OSError):
        video.rmdir()
        video.parent.rmdir()


def _store_tables(rows: Sequence[Row | None], folder: Path) -> None:
    """The rows so far, as CSV and as text."""
    still_there(folder)
    done = [row for row in rows if row is not None]
    for name, text in ((TABLE, to_csv(done)), (TEXT_TABLE, to_text(done))):
        with replacing(folder / name) as partial:
            partial.write_text(text, encoding="utf-8")


def _kept(case: Case, name: str, folder: Path) -> Row | None:
    """The row of a case where nothing has to be made for it."""
    if case.recipe is None:
        return case.names | {"refused": case.refused}
    path = folder / _ROWS / f"{name}.json"
    if not path.exists():
        return None
    content = read_json(path, "row of a sweep")
    if not isinstance(content, dict) or not all(fits(k, v) for k, v in content.items()):
        raise ValueError(f"{path} is no row of a sweep: remove it")
    return case.names | content


def _made(
    case: Case,
    name: str,
    folder: Path,
    judge: Judge,
    machine: str,
    engine: Mapping[str, Any],
) -> Row:
    """Make, measure and judge a case's video, and keep its row."""
    recipe = case.recipe
    assert recipe is not None
    still_there(folder)
    measured: Row
    try:
        make_video(recipe, folder / _VIDEOS / name, case.frames, **engine)
        video = open_video(folder / _VIDEOS / name)
        measured = figures(video) | dict(judge(video, case.checked, recipe.scene))
    except ValueError as refusal:
        measured = {"refused": str(refusal)}
    still_there(folder)
    row = measured | {"machine": machine}
    write_json(folder / _ROWS / f"{name}.json", row)
    return case.names | row


def figures(video: Video) -> Row:
    """What the frames' own records tell."""
    entries = video.frames
    seconds = [sum(entry["stage_seconds"].values()) for entry in entries]
    errors = _known(entries, "error_reference")
    expected = _known(entries, "error_predicted")
    points = [sum(o.get("points", 0) for o in entry["objects"]) for entry in entries]
    sizes = [video.path(number).stat().st_size for number in video.numbers]
    return {
        "frames": len(entries),
        "points": float(np.mean(points)),
        "seconds": float(np.median(seconds)),
        "seconds_first": seconds[0],
        "seconds_total": sum(seconds),
        "keys": sum(bool(entry["key"]) for entry in entries),
        "error": max(errors, default=None),
        "error_median": float(np.median(errors)) if errors else None,
        "error_expected": max(expected, default=None),
        "megabytes": float(np.mean(sizes)) / 1e6,
    }


def _known(entries: Sequence[Mapping[str, Any]], key: str) -> list[float]:
    return [float(entry[key]) for entry in entries if entry.get(key) is not None]
