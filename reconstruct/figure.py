"""Figures: PNG, PDF or SVG by the suffix, in colours that everybody can tell apart."""

from pathlib import Path
from typing import Any

from chrmc.files import replacing

KINDS = (".png", ".pdf", ".svg")
MARKERS = "osD^vPX*<>"


def check_figure(path: str | Path) -> Path:
    """The path, or ValueError for a kind of file that figures are not written as."""
    path = Path(path)
    if path.suffix.lower() not in KINDS:
        raise ValueError(f"{path}: figures are written as {', '.join(KINDS)}")
    return path


def new_figure(size: tuple[float, float], rows: int = 1, columns: int = 1, **more: Any) -> Any:
    """(figure, axes) of matplotlib without a window; size in inches."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    return plt.subplots(rows, columns, figsize=size, layout="constrained", **more)


def save(figure: Any, path: str | Path) -> None:
    """Write a figure, whole or not at all, and forget it."""
    from matplotlib import pyplot as plt

    path = check_figure(path)
    with replacing(path) as partial:
        figure.savefig(partial, dpi=130, facecolor=figure.get_facecolor())
    plt.close(figure)


def scale_bar(axis: Any, view: tuple[float, float, float, float], colour: str = "white") -> None:
    """A bar of a round length in the lower right corner of a picture.

    view : (left, right, bottom, top) of the axis, millimetres
    """
    from math import floor, log10

    from matplotlib import patheffects

    left, right, bottom, top = view
    most = 0.16 * abs(right - left)
    power = 10.0 ** floor(log10(most))
    length = max(m * power for m in (1, 2, 5) if m * power <= most)
    y = bottom + 0.06 * (top - bottom)
    end = right - 0.03 * (right - left)
    start = end - length * (1 if right > left else -1)
    edge = [patheffects.withStroke(linewidth=4, foreground="black")]
    axis.plot([start, end], [y, y], color=colour, lw=2, path_effects=edge, solid_capstyle="butt")
    said = f"{length:g} mm" if length >= 0.1 else f"{length * 1e3:g} µm"
    axis.annotate(
        said, ((start + end) / 2, y), (0, 4), textcoords="offset points", color=colour,
        ha="center", va="bottom", fontsize=8, path_effects=edge,
    )  # fmt: skip
