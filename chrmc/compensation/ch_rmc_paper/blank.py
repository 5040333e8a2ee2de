"""Which part of the next hologram the previous one gives, and which is left blank.

Blank is what lay outside the panel before (shifted edge), what lies where the soft edge of a
point's footprint is or was (the tilt of a rotation moves the footprint's place in the light), and
nothing else: outside all footprints the field is zero and costs nothing.
"""

from collections.abc import Sequence
from math import ceil, floor

import numpy as np

from chrmc.optics.footprint import SOFT_SHARE, reach
from chrmc.optics.passband import Passband
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM
from chrmc.window import Window

GUARD = 6
"""Pixels beside a shifted edge that are not reused: the edge is blurred by the way there."""


def _span(low: float, high: float, count: int, pitch: float) -> tuple[int, int]:
    """Pixels whose centres lie in [low, high], metres, clipped to the panel."""
    middle = (count - 1) / 2
    first = 0 if low == -np.inf else max(0, ceil(low / pitch + middle))
    last = count - 1 if high == np.inf else min(count - 1, floor(high / pitch + middle))
    return (first, last + 1) if last >= first else (0, 0)


def _limits(
    cloud: PointCloud, axis: int, tangent: float, share: float
) -> tuple[np.ndarray, np.ndarray]:
    """(N,) low and high ends of the given share of each footprint along one axis, metres."""
    half = share * cloud.positions[:, 2] * tangent
    return cloud.positions[:, axis] - half, cloud.positions[:, axis] + half


def extent(cloud: PointCloud, slm: SLM, wavelength: float, passband: Passband) -> Window:
    """The smallest window that holds the footprints of all points; empty for no points."""
    if len(cloud) == 0:
        return Window(0, 0, 0, 0)
    spans = []
    for axis, count, f_max in ((1, slm.height, passband.fy_max), (0, slm.width, passband.fx_max)):
        low, high = _limits(cloud, axis, reach(wavelength, f_max), 1.0)
        spans.append(_span(float(low.min()), float(high.max()), count, slm.pixel_pitch))
    return Window(*spans[0], *spans[1])


def reusable(
    before: PointCloud,
    after: PointCloud,
    slm: SLM,
    wavelength: float,
    passband: Passband,
    shift: tuple[float, float],
    soft_axes: Sequence[int],
    margin: float = 0.0,
) -> Window:
    """The window on which the carried field stands for the whole object.

    before, after : the same points in the frame that was and that comes
    shift : (y, x) metres by which the carried light moves on the panel
    soft_axes : 0 for x, 1 for y: axes on which the footprints don't move along with the light, so
        that only columns (rows) inside the flat part of every footprint, before and after, serve
    margin : metres by which light from outside the panel reaches in
    """
    spans = []
    for axis, count, f_max in ((1, slm.height, passband.fy_max), (0, slm.width, passband.fx_max)):
        by = shift[0] if axis == 1 else shift[1]
        edge = (count - 1) / 2 * slm.pixel_pitch
        guard = (GUARD * slm.pixel_pitch if by else 0.0) + margin
        low = [-edge + max(by, 0.0) + guard if by > 0 or margin else -np.inf]
        high = [edge + min(by, 0.0) - guard if by < 0 or margin else np.inf]
        if axis in soft_axes and len(after):
            tangent = reach(wavelength, f_max)
            for cloud, moved in ((before, by), (after, 0.0)):
                flat = _limits(cloud, axis, tangent, 1 - SOFT_SHARE)
                low.append(float(flat[0].max()) + moved)
                high.append(float(flat[1].min()) + moved)
        spans.append(_span(max(low), min(high), count, slm.pixel_pitch))
    return Window(*spans[0], *spans[1])


def intersection(a: Window, b: Window) -> Window:
    """Pixels in both windows; an empty window when there are none."""
    row, column = max(a.row0, b.row0), max(a.column0, b.column0)
    return Window(
        row, max(row, min(a.row1, b.row1)), column, max(column, min(a.column1, b.column1))
    )


def difference(whole: Window, part: Window) -> list[Window]:
    """Up to four windows that together hold each pixel of `whole` outside `part` once."""
    inner = intersection(whole, part)
    if inner.size == 0:
        return [whole] if whole.size else []
    pieces = [
        Window(whole.row0, whole.row1, whole.column0, inner.column0),
        Window(whole.row0, whole.row1, inner.column1, whole.column1),
        Window(whole.row0, inner.row0, inner.column0, inner.column1),
        Window(inner.row1, whole.row1, inner.column0, inner.column1),
    ]
    return [piece for piece in pieces if piece.size]
