"""What of a hologram and of its Fourier plane a pane needs: filtered before it is sampled.

A hologram that is shown smaller by leaving out pixels, or by means over a few, shows zone plates
that are not there. So what a pane shows of it is resampled by a windowed sinc, which passes what
the screen can show and nothing else.
"""

from dataclasses import dataclass
from math import ceil, floor

import numpy as np
from numpy.typing import NDArray

from reconstruct.viewer.view import Rectangle, View


@dataclass(frozen=True)
class Sight:
    """A part of a picture on the screen: box (left, top, right, bottom) in whole pixels of the
    picture, and (width, height) screen pixels."""

    box: tuple[int, int, int, int]
    size: tuple[int, int]

    @property
    def covers(self) -> Rectangle:
        """(left, top, width, height)."""
        left, top, right, bottom = self.box
        return float(left), float(top), float(right - left), float(bottom - top)


def sight_of(view: View, density: float) -> Sight:
    """What a view shows; at zooms of 1 and more, the picture's own pixels.

    density : framebuffer pixels per unit of the view
    """
    left, top = view.to_picture(0, 0)
    right, bottom = view.to_picture(view.screen_width, view.screen_height)
    whole = (0, 0, view.width, view.height)
    zoom = view.scale * density
    if zoom >= 1:
        return Sight(whole, (view.width, view.height))
    box = (
        max(floor(left), 0),
        max(floor(top), 0),
        min(ceil(right), view.width),
        min(ceil(bottom), view.height),
    )
    if box[2] <= box[0] or box[3] <= box[1]:
        return Sight(whole, (1, 1))
    size = (max(round((box[2] - box[0]) * zoom), 1), max(round((box[3] - box[1]) * zoom), 1))
    return Sight(box, size)


def shrunk(levels: NDArray[np.uint8], sight: Sight) -> NDArray[np.uint8]:
    """(h, w) grey levels as a sight shows them, low-passed before they are sampled."""
    if sight.size == (levels.shape[1], levels.shape[0]):
        return levels
    from PIL import Image

    small = Image.fromarray(levels).resize(sight.size, Image.Resampling.LANCZOS, box=sight.box)
    return np.asarray(small, dtype=np.uint8)


def fourier_covers(shape: tuple[int, int], side: float) -> Rectangle:
    """Where samples of the Fourier plane, zero frequency in the middle, lie on a square of `side`
    that spans the Nyquist band: half a sample up and left, since zero is at n/2."""
    rows, columns = shape
    return -0.5 * side / columns, -0.5 * side / rows, side, side
