"""Pictures and text: flat, transparent where they are black."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.colour import linear
from chrmc.ranges import short
from chrmc.scene.sources.model import Model
from chrmc.scene.surface.surface import Surface

TEXT_HEIGHT = 200
"""Pixels of a line of text."""
LONGEST_TEXT = 500


def read_picture(path: Path) -> Model:
    """A PNG, JPEG or TIFF of 8 or 16 bits, sRGB; alpha dims."""
    from chrmc.scene.sources.images import read_samples

    samples = read_samples(path)
    colour = samples.astype(np.float64) / np.iinfo(samples.dtype).max
    if samples.shape[2] < 3:
        light = linear(np.repeat(colour[:, :, :1], 3, axis=2))
    else:
        light = linear(colour[:, :, :3])
    if samples.shape[2] in (2, 4):
        light = light * colour[:, :, -1:]
    if not light.max() > 0:
        raise ValueError(f"{path} is black all over: nothing to show")
    return flat(path.stem, light)


def text_picture(words: str) -> Model:
    """White letters."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    if not words.strip():
        raise ValueError("text: says nothing; write text:HELLO")
    if not words.replace("\n", " ").isprintable():
        raise ValueError(f"text: {words[:40]!a} holds what is no letter")
    if len(words) > LONGEST_TEXT:
        raise ValueError(f"text: of {len(words)} letters; at most {LONGEST_TEXT} fit a panel")
    figure = Figure(figsize=(len(words) + 2, 2), dpi=TEXT_HEIGHT / 2, facecolor="black")
    figure.text(0.5, 0.5, words, color="white", fontsize=72, ha="center", va="center")
    canvas: Any = FigureCanvasAgg(figure)
    with warnings.catch_warnings():
        warnings.filterwarnings("error", "Glyph")
        try:
            canvas.draw()
        except UserWarning:
            raise ValueError(f"text: the font has not all letters of {short(words)}") from None
    grey = np.asarray(canvas.buffer_rgba())[:, :, 0].astype(np.float64) / 255
    rows, columns = np.flatnonzero(grey.any(axis=1)), np.flatnonzero(grey.any(axis=0))
    if not len(rows):
        raise ValueError(f"text: the font has no letters for {words!r}")
    return flat("text", grey[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1])


def flat(name: str, light: NDArray[np.float64]) -> Model:
    """A rectangle of (H, W) reflectances or (H, W, 3) linear colours, one unit per pixel."""
    height, width = light.shape[:2]
    vertices = np.array([[0, 0, 0], [width, 0, 0], [width, height, 0], [0, height, 0]], float)
    faces = np.array([[0, 2, 1], [0, 3, 2]])

    def paint(face: NDArray[np.intp], weights: NDArray[np.float64]) -> NDArray[np.float64]:
        place = np.einsum("nk,nkx->nx", weights, (vertices * [1, 1, 0])[faces[face]])
        column = np.clip(place[:, 0].astype(np.intp), 0, width - 1)
        row = np.clip(place[:, 1].astype(np.intp), 0, height - 1)
        return light[row, column]

    surface = Surface(vertices, faces, paint, closed=False, opaque=False)
    return Model({name: surface}, up="-y", flat=True)
