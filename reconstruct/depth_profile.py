"""What the sharpness of a cell should be against depth, where it holds several depths.

A cell of two turns of a helix is sharp at both, one of a wall seen from the side over its whole
depth. The scene's map says how much light a cell holds in each layer; a point's ΣI² falls with
defocus as its picture widens along both axes. So the sharpness to be expected is the sum over the
layers, and how like it the measured one is (correlation over depth) tells where the object is and
how deep.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from chrmc.light_map import LightMap, focus_lost
from reconstruct.focus import Cells

Floats = NDArray[np.float64]


def profile_likeness(
    cells: Cells, expected: LightMap, depths_of_focus: tuple[float, float]
) -> Callable[..., Floats]:
    """A function of the relief's stretch and an offset in depth, metres: (m, n) each cell's light
    times the correlation of its sharpness with that of the scene, so stretched and moved.

    expected : with layers; depths_of_focus : of both axes, metres
    """
    assert expected.layers is not None
    held = expected.layers * expected.light
    at = expected.layer_depths
    middle = float(np.average(at, weights=held.sum(axis=(1, 2))))
    found = _normal(cells.sharpness)

    def likeness(stretch: float, offset: float) -> Floats:
        away = cells.depths[:, None] - (middle + offset + stretch * (at - middle))
        focus = focus_lost(away, depths_of_focus)
        alike: Floats = (_normal(np.tensordot(focus, held, 1)) * found).sum(axis=0)
        return expected.light * alike

    return likeness


def _normal(curves: Floats) -> Floats:
    """(D, m, n) curves less their means, of length 1."""
    rest = curves - curves.mean(axis=0)
    length = np.sqrt((rest**2).sum(axis=0))
    normal: Floats = rest / np.maximum(length, 1e-300)
    return normal
