"""How far the colours of a picture are from those of the scene, CIEDE2000.

A difference of 1 is about what an eye can just tell, 5 what it sees without looking for it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.colour import mixed
from chrmc.scene.scene import SceneFrame
from reconstruct.four_f_system import FourF
from reconstruct.looks import in_focus, rendered_view
from reconstruct.metrics import scale_to

LIT = 0.05
"""Share of the view's brightest light below which a pixel is none of the object's."""
BRIGHTEST = 0.99
"""Quantile of the object's light in the view that is drawn as white."""
CELL = 8
"""Pixels of the squares whose means are compared, too: speckle is finer."""


@dataclass(frozen=True)
class ColourLikeness:
    """Colour differences of an object from its rendered view.

    pixels : mean over the object's pixels, speckle and all
    cells : of the mean light in squares of CELL pixels, mean over the object's
    whole : of the object's mean light
    """

    name: str
    pixels: float
    cells: float
    whole: float


def compare_colours(
    image: NDArray[np.floating],
    frames: Sequence[SceneFrame],
    systems: Sequence[FourF],
    depth: float,
) -> list[ColourLikeness]:
    """The objects in focus at a depth, each against its rendered view in the lasers' light.

    image : (H, W, lasers) balanced intensities (`reconstruct.colour_image`)
    frames, systems : of each laser

    One factor for all lasers fits the picture to the view, so that a wrong balance shows.
    """
    wavelengths = [system.wavelength for system in systems]
    found = []
    # What any laser has in focus: depths of focus differ little.
    for name, part, patch in in_focus(frames[0], systems[0], depth):
        view = np.stack(
            [
                rendered_view(frame.cloud, system, depth, patch)
                for frame, system in zip(frames, systems, strict=True)
            ],
            axis=-1,
        )
        shown = np.asarray(image[part], dtype=np.float64)
        light = view.sum(axis=-1)
        lit = light > LIT * light.max(initial=0)
        if not lit.any():
            continue
        white = float(np.quantile(view[lit].max(axis=-1), BRIGHTEST))
        pair = (shown * scale_to(shown, view) / white, view / white)
        pixels = delta_e(*(mixed(p, wavelengths) for p in pair))[lit].mean()
        small = [_means(p) for p in (*pair, lit[..., None])]
        inside = small[2][..., 0] == 1
        cells = delta_e(*(mixed(p, wavelengths) for p in small[:2]))
        whole = delta_e(*(mixed(p[lit].mean(axis=0), wavelengths) for p in pair))
        found.append(
            ColourLikeness(
                name,
                float(pixels),
                float(cells[inside].mean()) if inside.any() else float("nan"),
                float(whole),
            )
        )
    return found


def delta_e(one: NDArray[np.floating], other: NDArray[np.floating]) -> NDArray[np.float64]:
    """(…,) CIEDE2000 between colours in (…, 3) linear sRGB; more than 1 is cut to 1."""
    from skimage.color import deltaE_ciede2000, xyz2lab

    from chrmc.colour import RGB_TO_XYZ

    lab = [xyz2lab(np.clip(c, 0, 1) @ RGB_TO_XYZ.T) for c in (one, other)]
    difference: Any = deltaE_ciede2000(*lab)
    return np.asarray(difference)


def _means(image: NDArray[Any]) -> NDArray[np.float64]:
    """Means over squares of CELL pixels; what is left over at the ends is left out."""
    rows, columns = (n // CELL for n in image.shape[:2])
    blocks = image[: rows * CELL, : columns * CELL].astype(np.float64)
    return np.asarray(blocks.reshape(rows, CELL, columns, CELL, -1).mean(axis=(1, 3)))
