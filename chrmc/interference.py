"""Light that points of one phase leave each other in a picture, where they are too close to be told
apart.

The picture of point i at a place near it is a_i·exp(iψ_i)·s(distance in resolutions): s is the
aperture's sinc and ψ_i = φ_i + k·|P_i − q|, q being the middle of the part of the panel that shows
it. Of Σ|…|² over all places, Σ_j a_i·a_j·cos(ψ_i − ψ_j)·s(between them) is point i's, a sinc being
its own autocorrelation. Random phases average out in a cell of the map; equal ones leave parts of
a line dark.
"""

import numpy as np
from numpy.typing import NDArray

from chrmc.optics.footprint import reach
from chrmc.optics.passband import Passband
from chrmc.optics.resolution import depth_of_focus, resolution
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM

MOST_POINTS = 5000
"""Of more, many lie in every cell, and their pairs would take longer than the hologram."""
_RESOLUTIONS = 3.0  # that a point's picture is followed away from it
_LIKE = 0.5  # |mean of exp(iΔφ)| of points that follow each other, from which phases count as equal


def light_left(
    cloud: PointCloud, slm: SLM, wavelength: float, passband: Passband
) -> NDArray[np.float64] | None:
    """(N,) light of each point among its neighbours; None where phases are random.

    A point may have less than none: the sum over some resolutions is what a picture shows.
    """
    turns = np.exp(1j * np.diff(cloud.phase))
    if not 1 < len(cloud) <= MOST_POINTS or abs(turns.mean()) < _LIKE:
        return None
    from scipy.spatial import cKDTree

    places, z = cloud.positions[:, :2], float(cloud.centroid[2])
    fine = np.array(resolution(slm, wavelength, z, passband)[::-1])
    near = cKDTree(places / fine).query_pairs(_RESOLUTIONS * 2**0.5, output_type="ndarray")
    one, two = cloud.select(near[:, 0]), cloud.select(near[:, 1])
    apart = one.positions - two.positions
    overlap = 1 / (1 + (apart[:, 2] / min(depth_of_focus(slm, wavelength, z, passband))) ** 2)
    middle = (one.positions[:, :2] + two.positions[:, :2]) / 2
    for axis, (pixels, f_max) in enumerate(
        ((slm.width, passband.fx_max), (slm.height, passband.fy_max))
    ):
        t = apart[:, axis] / fine[axis]
        ends = np.cos(np.pi / 2 * np.clip(t / _RESOLUTIONS, -1, 1)) ** 2
        overlap *= np.sinc(t) * ends
        half, far = pixels * slm.pixel_pitch / 2, z * reach(wavelength, f_max)
        at = middle[:, axis]
        middle[:, axis] = (np.maximum(at - far, -half) + np.minimum(at + far, half)) / 2
    near_to, far_from = (
        np.sqrt(((p.positions[:, :2] - middle) ** 2).sum(axis=1) + p.positions[:, 2] ** 2)
        for p in (one, two)
    )
    turn = 2 * np.pi / wavelength * (near_to - far_from) + one.phase - two.phase
    shared = one.amplitude * two.amplitude * np.cos(turn) * overlap
    light = cloud.intensity
    for ends_of in near.T:
        light = light + np.bincount(ends_of, shared, len(cloud))
    return light
