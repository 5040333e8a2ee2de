"""Light that points of one phase leave each other in a picture, where they are too close to be told
apart.

The picture of point i at a place near it is a_i·exp(iψ_i)·s(distance in resolutions): s is the
aperture's sinc and ψ_i = φ_i + k·|P_i − q|, q being the middle of the part of the panel that shows
it. Of Σ|…|² over all places, Σ_j a_i·a_j·cos(ψ_i − ψ_j)·s(between them) is point i's, a sinc being
its own autocorrelation. Random phases average out in a cell of the map; equal ones leave parts of
a line dark.

Points that stand one behind the other interfere at the depths between them: two turns of a helix
may be sharpest in the middle, where neither is. What a focal stack shows then is computed from the
points, each a spectrum behind its part of the panel.
"""

from math import prod

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from chrmc.optics.footprint import reach, shown_from, taper
from chrmc.optics.passband import Passband
from chrmc.optics.resolution import depth_of_focus, resolution
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM

MOST_POINTS = 5000
"""Of more, many lie in every cell, and their pairs would take longer than the hologram."""
_RESOLUTIONS = 3.0  # that a point's picture is followed away from it
_LIKE = 0.5  # |mean of exp(iΔφ)| of points that follow each other, from which phases count as equal


_MOST_SAMPLES = 6_000_000  # of a stack: about a second
_ROOM = 1.25  # sides of the stack's grid over what is read of it, so that light goes off its edge


def alike(cloud: PointCloud) -> bool:
    """Whether points that follow each other are of one phase, and few enough to be followed."""
    turns = np.exp(1j * np.diff(cloud.phase))
    return 1 < len(cloud) <= MOST_POINTS and abs(turns.mean()) >= _LIKE


def light_left(
    cloud: PointCloud, slm: SLM, wavelength: float, passband: Passband
) -> NDArray[np.float64]:
    """(N,) light of each point among its neighbours, for points that are `alike`.

    A point may have less than none: the sum over some resolutions is what a picture shows.
    """
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
        half = pixels * slm.pixel_pitch / 2
        middle[:, axis] = shown_from(middle[:, axis], z, half, wavelength, f_max)
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


def sharpness_shown(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    passband: Passband,
    centre: tuple[float, float],
    shape: tuple[int, int],
    cell: float,
    depths: NDArray[np.float64],
) -> NDArray[np.float64] | None:
    """(D, rows, columns) ΣI²/(ΣI)² of square cells, as the points' picture has it at some depths.

    centre : (y, x) of the cells, metres; shape : rows and columns of cells; cell : side, metres
    Every point is as bright as its amplitude says, however much of the panel shows it. None where
    that would be more samples than are worth it.
    """
    parts = max(4, round(cell / slm.pixel_pitch))
    sides = [scipy.fft.next_fast_len(int(_ROOM * n * parts)) for n in shape]
    if prod(sides) * len(depths) > _MOST_SAMPLES:
        return None
    pitch, z = cell / parts, cloud.positions[:, 2]
    middle = float(cloud.centroid[2])
    waves, steps = [], []
    for side, n, at, place, pixels, f_max in (
        (sides[0], shape[0], centre[0], 1, slm.height, passband.fy_max),
        (sides[1], shape[1], centre[1], 0, slm.width, passband.fx_max),
    ):
        f = scipy.fft.fftfreq(side, pitch)
        slope = wavelength * f
        cosine = np.sqrt(np.maximum(1 - slope**2, 1e-12))
        # The part of the panel that a frequency of the point goes through.
        away, own = z[:, None] * slope / cosine, cloud.positions[:, place, None]
        wave = taper(away, z[:, None] * reach(wavelength, f_max)).astype(np.complex128)
        wave *= np.abs(own + away) <= pixels * slm.pixel_pitch / 2
        wave *= slope**2 < 1
        wave /= np.sqrt((np.abs(wave) ** 2).sum(axis=1, keepdims=True)) + 1e-150
        steps.append((cosine - 1) / wavelength)
        first = at - (n * parts - 1) / 2 * pitch
        wave *= np.exp(2j * np.pi * ((z[:, None] - middle) * steps[-1] - f * (own - first)))
        waves.append(wave)
    turn = 2 * np.pi * np.mod((z - middle) / wavelength, 1) + cloud.phase
    both = (waves[0] * (cloud.amplitude * np.exp(1j * turn))[:, None]).T @ waves[1]
    out = np.empty((len(depths), *shape))
    for depth, found in zip(depths, out, strict=True):
        back = [np.exp(2j * np.pi * (middle - depth) * step) for step in steps]
        field = scipy.fft.ifft2(both * back[0][:, None] * back[1])
        shown = np.abs(field[: shape[0] * parts, : shape[1] * parts]) ** 2
        blocks = shown.reshape(shape[0], parts, shape[1], parts)
        light = blocks.sum(axis=(1, 3))
        found[:] = (blocks**2).sum(axis=(1, 3)) / (light + light.mean() * 1e-9 + 1e-150) ** 2
    return out
