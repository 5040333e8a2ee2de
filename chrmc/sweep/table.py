"""A sweep's table: its columns, as CSV and as text."""

import csv
import io
from collections.abc import Sequence
from typing import Any

Row = dict[str, Any]

COLUMNS = {
    "scene": "what the hologram is of",
    "method": "CGH method and video method",
    "tolerance": "asked for; empty where the method promises none",
    "encoding": "of field to grey levels",
    "slm": "the panel",
    "frames": "made",
    "points": "visible ones, in the mean of the frames",
    "seconds": "per frame, all stages, the median of the frames",
    "seconds_first": "of the first frame, a key frame",
    "seconds_total": "of all frames",
    "keys": "key frames",
    "error": "relative field error against the float64 truth, the largest of the frames",
    "error_median": "the same, the median of the frames",
    "error_expected": "the largest that the method itself expected",
    "in_focus": "share of the judged objects that pass `chrmc check`",
    "depth_error": "metres between focus and object, the largest",
    "lateral_error": "metres sideways, the largest",
    "alike": "correlation with the scene's map of light, the least",
    "psnr": "dB, against the reconstruction of the scene's own field, the least",
    "ssim": "the same, the least",
    "megabytes": "of a frame's file, in the mean",
    "machine": "that the times were taken on",
    "refused": "why there is no more in this row",
}
"""Name of each column, and what stands in it. Lengths are metres, times seconds."""

TEXT = ("scene", "method", "encoding", "slm", "machine", "refused")
"""Columns of words; all others hold numbers."""
_SHOWN = ("scene", "method", "tolerance", "encoding", "slm", "frames", "seconds", "error",
          "in_focus", "depth_error", "psnr")  # fmt: skip


def fits(name: str, value: Any) -> bool:
    """Whether a value can stand in a column: a number, words, or nothing."""
    if name in TEXT:
        return value is None or isinstance(value, str)
    plain = isinstance(value, int | float) and not isinstance(value, bool)
    return name in COLUMNS and (value is None or (plain and abs(value) < 1e300))


def to_csv(rows: Sequence[Row]) -> str:
    """The table, a line per row; numbers in full."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in rows:
        writer.writerow(["" if row.get(name) is None else row[name] for name in COLUMNS])
    return out.getvalue()


def to_text(rows: Sequence[Row]) -> str:
    """The columns that are looked at most, aligned; what was refused below."""
    cells = [[name for name in _SHOWN]]
    cells += [[_told(name, row.get(name)) for name in _SHOWN] for row in rows]
    widths = [max(len(line[k]) for line in cells) for k in range(len(_SHOWN))]
    lines = [
        "  ".join(
            text.ljust(width) if name in TEXT else text.rjust(width)
            for name, text, width in zip(_SHOWN, line, widths, strict=True)
        ).rstrip()
        for line in cells
    ]
    for row, number in zip(rows, range(1, len(rows) + 1), strict=True):
        if row.get("refused"):
            lines.append(f"row {number} refused: {row['refused']}")
    return "\n".join(lines) + "\n"


def _told(name: str, value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.3g}" if name != "in_focus" else f"{value:.0%}"
    return str(value)
