"""A sweep's plot: one column over another, a line for each method."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from chrmc.options import meant
from chrmc.sweep.table import COLUMNS, TEXT, Row

_SERIES = ("scene", "method", "encoding", "slm")
_LOGARITHMIC = 20.0
"""Span of positive values from which an axis is logarithmic."""


def plotted_columns(text: str) -> tuple[str, str]:
    """The two columns of --plot X,Y; ValueError for what is none."""
    names = [part.strip() for part in text.split(",")]
    if len(names) != 2:
        raise ValueError(f"--plot {text}: two columns, such as --plot seconds,error")
    for name in names:
        if name not in COLUMNS or name in ("machine", "refused"):
            raise ValueError(
                f"--plot {text}: there is no column {name!r}{meant(name, COLUMNS)}; there are "
                f"{', '.join(n for n in COLUMNS if n not in ('machine', 'refused'))}"
            )
    if names[1] in TEXT:
        raise ValueError(f"--plot {text}: {names[1]} holds words; put it first, a number second")
    return names[0], names[1]


def draw(rows: Sequence[Row], x: str, y: str, path: Path) -> int:
    """Write the figure, whole or not at all; the number of rows in it.

    Rows that differ in tolerance alone make a line. ValueError where no row has both columns.
    """
    shown = [r for r in rows if r.get(x) is not None and r.get(y) is not None]
    if not shown:
        raise ValueError(f"no row has both {x} and {y}")
    from chrmc.figures import MARKERS, new_figure, save

    varying = [n for n in _SERIES if n != x and len({str(r[n]) for r in shown}) > 1]
    series: dict[str, list[Row]] = {}
    for row in shown:
        series.setdefault(", ".join(str(row[n]) for n in varying), []).append(row)
    figure, axis = new_figure((6.4, 4.2))
    for index, (label, mine) in enumerate(series.items()):
        mine = sorted(mine, key=lambda r: (r["tolerance"] is None, r["tolerance"] or 0.0))
        axis.plot(
            [_place(r[x]) for r in mine],
            [r[y] for r in mine],
            marker=MARKERS[index % len(MARKERS)],
            color=f"C{index % 10}",
            ls="-" if len(mine) > 1 and x not in TEXT else "",
            ms=5,
            lw=1,
            label=label,
        )
    axis.set(xlabel=_told(x), ylabel=_told(y))
    for name, scale in ((x, axis.set_xscale), (y, axis.set_yscale)):
        values = [r[name] for r in shown]
        if name not in TEXT and min(values) > 0 and max(values) > _LOGARITHMIC * min(values):
            scale("log")
    if x in TEXT:
        axis.tick_params(axis="x", labelrotation=20)
    if len(series) > 1:
        axis.legend(frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    axis.grid(alpha=0.3)
    axis.spines[["top", "right"]].set_visible(False)
    save(figure, path)
    return len(shown)


def _place(value: Any) -> Any:
    return str(value) if isinstance(value, str) else value


def _told(name: str) -> str:
    units = {"depth_error": " (m)", "lateral_error": " (m)", "psnr": " (dB)"}
    return name.replace("_", " ") + units.get(name, "")
