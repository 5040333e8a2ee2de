"""Point by point in single precision, each on its own footprint, where footprints are small.

Light of a near point falls on few pixels, and the nodes of a cluster of such points are as many as
the pixels: then summing them costs more than the waves themselves.
"""

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh import rt
from chrmc.cgh.counts import STATED
from chrmc.cgh.curved.clusters import Plane
from chrmc.cgh.curved.cost import cost_of, some_of
from chrmc.cgh.curved.verify import SURE, field_error
from chrmc.optics.footprint import coverage
from chrmc.optics.passband import Passband
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM
from chrmc.window import Window

_SMALL = 0.2  # share of the window in a mean footprint; in larger ones nodes are always fewer
_BEARABLE = 8.0  # seconds, as stated
_NOISE = 0.7, 1e-4  # expected of single precision: of the tolerance, and at most


def rays_pay(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    passband: Passband,
    plane: Plane,
    tolerance: float,
) -> bool:
    """Whether rays take less than the low-rank form, as counted."""
    if float(coverage(some_of(cloud)[0], slm, wavelength, passband).mean()) > _SMALL:
        return False
    seconds = STATED.seconds(rt.cost(cloud, slm, wavelength, window, passband))
    if seconds > _BEARABLE:
        return False
    return seconds < STATED.seconds(cost_of(cloud, plane, tolerance))


def by_rays(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    passband: Passband,
    plane: Plane,
    tolerance: float,
) -> tuple[NDArray[np.complex64], float] | None:
    """The field and its error on some pixels; None where rays take minutes, or single precision
    will not do."""
    given = cloud, slm, wavelength, window, passband
    if STATED.seconds(rt.cost(*given)) > _BEARABLE:
        return None
    out = rt.quick_field(*given, min(_NOISE[0] * tolerance, _NOISE[1]))
    if out is None:
        return None
    error = field_error(out, cloud, plane, tolerance)
    return (out, error) if error <= SURE * tolerance else None
