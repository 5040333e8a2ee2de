"""What a video cost and how wrong it is, in a few lines."""

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

from chrmc.store.video import Video

STAGES = {
    "PE": "find what moved, and how",
    "PA": "bring the hologram to where it is turned, and back",
    "CON": "flat hologram to curved, and back",
    "RMC": "turn the curved hologram: the motion compensation itself",
    "HC": "compute what cannot be reused: key frames, blank parts",
    "EC": "correct points that changed",
    "encode": "field to grey levels",
}
"""Plain words for the stages of a frame; the abbreviations are the paper's."""


def summary(video: Video) -> Iterator[str]:
    """Lines about a stored video: key frames, time per stage, points, coverage, errors."""
    entries = video.frames
    n = max(len(entries), 1)
    keys = sum(e["key"] for e in entries)
    why = _why_nothing_is_reused(video)
    yield f"{len(entries)} frames" + (why or f", {keys} of them key frames")
    stages: dict[str, float] = {}
    for entry in entries:
        for name, seconds in entry["stage_seconds"].items():
            stages[name] = stages.get(name, 0.0) + seconds
    total = sum(stages.values())
    yield f"{'stage':<12}{'ms per frame':>14}{'share':>9}"
    for name, seconds in stages.items():
        words = f"  {STAGES[name]}" if name in STAGES else ""
        yield f"{name:<12}{1e3 * seconds / n:>14.2f}{seconds / max(total, 1e-12):>9.1%}{words}"
    yield f"{'total':<12}{1e3 * total / n:>14.2f}"
    computed = np.mean([e["points_computed"] for e in entries]) if entries else 0.0
    seen = np.mean([sum(o.get("points", 0) for o in e["objects"]) for e in entries] or [0])
    yield (
        f"points computed per frame: {computed:.0f} of {seen:.0f} visible ones (a reused point "
        "costs none; one that is added, and one taken out again, count one each)"
    )
    shares: dict[str, list[float]] = {}
    for obj in (o for e in entries for o in e["objects"]):
        if "coverage" in obj:
            shares.setdefault(obj["name"], []).append(obj["coverage"])
    for name, found in shares.items():
        yield f"{name}: its fringes cover {min(found):.0%} to {max(found):.0%} of the panel"
    checked = [e["error_pixels"] for e in entries if e.get("error_pixels")]
    on = ""
    if checked:
        # Squares of error and light are 1/√n uncertain each, the root of their ratio √2/(2√n).
        sure = 2 * (0.5 / min(checked)) ** 0.5
        on = f" on {min(checked)} pixels of {len(checked)} frames, each ± {sure:.0%} (95 %)"
    yield from _errors(entries, "error_reference", f"field error against the float64 truth{on}")
    yield from _errors(
        entries,
        "error_reuse",
        "by reuse alone, on all pixels, against the same method afresh (rekey_error limits it)",
    )


def _errors(entries: list[dict[str, Any]], key: str, words: str) -> Iterator[str]:
    errors = [e[key] for e in entries if e.get(key) is not None]
    if errors:
        yield f"{words}: median {np.median(errors):.1e}, worst {max(errors):.1e}"


def _why_nothing_is_reused(video: Video) -> str:
    """The reason, where every frame of several was computed afresh; else nothing."""
    if len(video.frames) < 2 or not all(e["key"] for e in video.frames):
        return ""
    if video.methods.get("compensation") == "none":
        return ", each computed afresh: without compensation nothing is reused"
    reasons: dict[str, str] = {}
    times: Counter[str] = Counter()
    for entry in video.frames:
        for name, text in entry.get("reuse", {}).items():
            how, _, why = str(text).partition(": ")
            times[name] += how == "afresh"
            if how == "afresh" and why:
                reasons.setdefault(name, why)
    # An object that rested, or was computed afresh now and then, is no reason.
    reasons = {name: why for name, why in reasons.items() if 2 * times[name] > len(video.frames)}
    if not reasons:
        return ""
    poses = "; ids and the poses of all objects in scene.json would tell"
    told = [
        f"{name} is computed afresh in each ({why}{poses if 'not known again' in why else ''})"
        for name, why in reasons.items()
    ]
    names = dict.fromkeys(obj["name"] for entry in video.frames for obj in entry["objects"])
    if reasons.keys() <= names.keys():  # and not all objects as one
        told += [f"{name} is reused" for name in names if name not in reasons]
    return ": " + ", ".join(told)
