"""A reconstruction as a figure for a paper: axes, colour bar, scale bar and settings."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.files import replacing
from reconstruct.viewer.shade import Look, colour_table, level_of, light_of, shade

_LENGTHS = ("depth", "wavelength", "pixel_pitch", "dc_block", "aperture")
FIGURES = (".png", ".pdf", ".svg")


def round_length(room: float) -> float:
    """The longest of 1, 2, 5 times a power of ten that fits, metres."""
    lengths = [m * 10.0**e for e in range(-8, 2) for m in (1, 2, 5)]
    return max((v for v in lengths if v <= room * (1 + 1e-9)), default=room)


def length_words(length: float) -> str:
    """A length with its unit."""
    for unit, size in (("mm", 1e-3), ("µm", 1e-6)):
        if length >= size:
            return f"{length / size:.6g} {unit}"
    return f"{length * 1e9:.6g} nm"


def write_figure(
    path: str | Path,
    field: NDArray[np.complexfloating],
    white: float,
    look: Look,
    pitch: float,
    origin: tuple[float, float],
    settings: dict[str, Any],
    glow: NDArray[np.float32] | None = None,
) -> None:
    """Write a picture as .png, .pdf or .svg.

    field : (h, w) complex; white : intensity shown as white; pitch : metres between its samples
    origin : (x, y) metres of its first sample
    settings : told below the picture, and kept in the file
    glow : (h, w, 3) linear sRGB of a video in colours, in the unit of white
    """
    path = Path(path)
    if path.suffix.lower() not in FIGURES:
        raise ValueError(f"{path}: figures are written as {', '.join(FIGURES)}")
    from matplotlib.figure import Figure

    rows, columns = field.shape
    width, height = columns * pitch * 1e3, rows * pitch * 1e3
    left, top = origin[0] * 1e3 - pitch * 500, origin[1] * 1e3 - pitch * 500
    tall = min(max(6.0 * height / width, 2.5), 9.0)
    figure = Figure(figsize=(7.5, tall + 1.3), dpi=200, layout="constrained")
    axes = figure.add_subplot()
    extent = (left, left + width, top + height, top)
    axes.imshow(shade(field, white, look, glow), extent=extent, interpolation="nearest")
    axes.set_xlabel("x (mm)")
    axes.set_ylabel("y (mm)")
    axes.set_title(
        f"{settings.get('source', '')}, frame {settings.get('frame')}, at "
        f"{float(settings.get('depth', 0)) * 1e3:.2f} mm",
        fontsize=10,
    )
    bar = round_length(width * 1e-3 / 5)
    x, y = left + 0.04 * width, top + 0.94 * height
    axes.plot([x, x + bar * 1e3], [y, y], color="black", linewidth=5, solid_capstyle="butt")
    axes.plot([x, x + bar * 1e3], [y, y], color="white", linewidth=3, solid_capstyle="butt")
    axes.text(
        x, y - 0.02 * height, length_words(bar), color="white", fontsize=9, va="bottom",
        bbox={"facecolor": "black", "alpha": 0.6, "pad": 1.5, "linewidth": 0},
    )  # fmt: skip
    _colour_bar(figure, axes, field, white, look)
    told = "   ".join(f"{k}: {v}" for k, v in _words(settings))
    figure.supxlabel(told, fontsize=6, color="0.35", wrap=True)
    kept = {"Title": f"{settings.get('source', '')}"}
    key = {".png": "Description", ".pdf": "Subject", ".svg": "Description"}[path.suffix.lower()]
    kept[key] = told
    with replacing(path) as partial:
        figure.savefig(partial, metadata=kept)


def _words(settings: dict[str, Any]) -> list[tuple[str, str]]:
    found = []
    for name, value in settings.items():
        words = name.replace("_", " ")
        if isinstance(value, float) and name in _LENGTHS:
            found.append((words, length_words(value)))
        elif isinstance(value, float):
            found.append((words, f"{value:.6g}"))
        elif value is not None:
            found.append((words, str(value)))
    return found


def _colour_bar(
    figure: Any, axes: Any, field: NDArray[np.complexfloating], white: float, look: Look
) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import FuncNorm, ListedColormap, Normalize

    if look.mode == "phase":
        phases = np.linspace(-np.pi, np.pi, 256)
        from reconstruct.viewer.shade import hues

        scale = ScalarMappable(Normalize(-np.pi, np.pi), ListedColormap(hues(phases)))
        bar = figure.colorbar(scale, ax=axes, shrink=0.8, ticks=[-np.pi, 0, np.pi])
        bar.ax.set_yticklabels(["−π", "0", "π"])
        bar.set_label("phase (brightness: amplitude)")
        return
    top = light_of(1.0, white, look)
    low = light_of(0.0, white, look)

    def forward(v: NDArray[np.floating]) -> NDArray[np.floating]:
        return level_of(np.maximum(np.asarray(v, dtype=np.float64), 0), white, look)

    def inverse(level: NDArray[np.floating]) -> NDArray[np.floating]:
        flat = [light_of(float(x), white, look) for x in np.ravel(level)]
        return np.reshape(flat, np.shape(level))

    norm = FuncNorm((forward, inverse), vmin=low, vmax=top) if top > 0 else Normalize(0, 1)
    colours = ListedColormap(colour_table(look.colours))
    bar = figure.colorbar(ScalarMappable(norm, colours), ax=axes, shrink=0.8)
    bar.set_ticks([light_of(v, white, look) for v in (0, 0.25, 0.5, 0.75, 1)])
    bar.ax.set_yticklabels([f"{light_of(v, white, look):.3g}" for v in (0, 0.25, 0.5, 0.75, 1)])
    bar.set_label("intensity, log scale" if look.mode == "log" else "intensity")
