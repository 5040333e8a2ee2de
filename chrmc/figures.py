"""Figures: PNG, PDF or SVG by the suffix, in colours and marks that everybody can tell apart."""

from io import BytesIO
from pathlib import Path
from typing import Any
from warnings import catch_warnings, filterwarnings

from chrmc.files import replacing

KINDS = (".png", ".pdf", ".svg")
MARKERS = "osD^vPX*<>"
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#000000", "#e69f00", "#56b4e9")
"""Of Okabe and Ito (Color Universal Design, 2008), less the yellow that paper swallows."""


def check_figure(path: str | Path) -> Path:
    """The path, or ValueError for a kind of file that figures are not written as."""
    path = Path(path)
    if path.suffix.lower() not in KINDS:
        raise ValueError(f"{path}: figures are written as {', '.join(KINDS)}")
    return path


def series(number: int) -> dict[str, str]:
    """Colour and mark of one series of many: no pair repeats within seventy."""
    return {
        "color": COLOURS[number % len(COLOURS)],
        "marker": MARKERS[number % len(MARKERS)],
    }


def new_figure(size: tuple[float, float], rows: int = 1, columns: int = 1, **more: Any) -> Any:
    """(figure, axes) of matplotlib without a window; size in inches."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    return figure, figure.subplots(rows, columns, **more)


def save(figure: Any, path: str | Path, dpi: float = 130, **more: Any) -> None:
    """Write a figure, whole or not at all; `more` as `Figure.savefig` takes it."""
    path = check_figure(path)
    from matplotlib.text import Text

    for text in figure.findobj(Text):  # of strangers' names and comments
        text.set_text("".join(c if c.isprintable() or c == "\n" else "?" for c in text.get_text()))
    # Not onto the disk at once: writers of PDF stumble over a full one.
    buffer = BytesIO()
    with catch_warnings():
        filterwarnings("ignore", "Glyph .* missing")  # a box is drawn for it
        figure.savefig(
            buffer, format=path.suffix[1:].lower(), dpi=dpi, facecolor=figure.get_facecolor(),
            **more,
        )  # fmt: skip
    with replacing(path) as partial:
        partial.write_bytes(buffer.getvalue())


def log_ticks(axis: Any, words: Any = None) -> None:
    """Ticks for a logarithmic axis that has at least three of them, however short it is.

    axis : such as `axes.xaxis`; words : a formatter, such as `seconds`
    """
    from math import log10

    from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullFormatter

    low, high = sorted(axis.get_view_interval())
    decades = log10(high / low)
    steps = [1.0] if decades > 3 else [1.0, 3.0] if decades > 1.4 else [1.0, 2.0, 5.0]
    ticks = LogLocator(subs=steps, numticks=20).tick_values(low, high)
    inside = [t for t in ticks if low <= t <= high]
    if len(inside) > 7:
        inside = inside[:: -(-len(inside) // 7)]
    axis.set_major_locator(FixedLocator(inside))
    axis.set_minor_formatter(NullFormatter())
    if words is not None:
        axis.set_major_formatter(FuncFormatter(lambda value, _: words(value)))


def seconds(value: float) -> str:
    """A time in words: 20 ms, 3 s."""
    for size, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")):
        if value >= 0.999 * size:
            return f"{value / size:.3g} {unit}"
    return f"{value:.1g} s"


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
    label = f"{length:g} mm" if length >= 0.1 else f"{length * 1e3:g} µm"
    axis.annotate(
        label, ((start + end) / 2, y), (0, 4), textcoords="offset points", color=colour,
        ha="center", va="bottom", fontsize=8, path_effects=edge,
    )  # fmt: skip
