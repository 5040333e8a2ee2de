"""A focal stack: the intensity in a region at many depths.

The field is propagated once from the hologram to the middle of the depth range, on the region and
a margin; from there each depth is a short way on a small grid. Forty depths of a 2 mm region cost
a tenth of a second after the first 50 ms, at full resolution.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import ArrayLike, NDArray

from chrmc.optics.footprint import expected_power
from chrmc.optics.passband import Passband
from chrmc.optics.propagation import Patch, Propagator, cycles_to_phasor, soft_edge, spread
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM
from reconstruct.four_f_system import intensity

FAR = 4
"""A region whose surroundings would take more grids of the panel's size than this is far away."""


@dataclass(frozen=True, eq=False)
class FocalStack:
    """Intensities of one region.

    depths : (D,) metres, ascending, evenly spaced
    intensity : (D, h, w) float32
    patch : where the samples lie
    """

    depths: NDArray[np.float64]
    intensity: NDArray[np.float32]
    patch: Patch

    def index(self, depth: float) -> int:
        """Of the depth nearest to one, metres."""
        return int(np.argmin(np.abs(self.depths - depth)))

    @property
    def step(self) -> float:
        """Metres between depths."""
        return float(self.depths[1] - self.depths[0]) if len(self.depths) > 1 else 0.0


def brightness(
    patch: Patch,
    slm: SLM,
    wavelength: float,
    depths: tuple[float, float],
    passband: Passband,
) -> NDArray[np.float64]:
    """(2, h, w) light that equal points at two depths send to the SLM, relative to the brightest.

    It falls with the square of the depth, and towards the edges of the field, where a footprint
    leaves the panel: points look dimmer than they are. Dividing by this makes mean depths and
    centroids of images those of the scene. Not below 0.05.
    """
    y, x = patch.coordinates()

    def power(px: NDArray[np.float64], py: NDArray[np.float64], z: float) -> NDArray[np.float64]:
        places = np.column_stack([px, py, np.full(len(px), z)])
        ones = np.ones(len(px))
        return expected_power(PointCloud(places, ones, 0 * ones), slm, wavelength, passband)

    shares = []
    for z in depths:
        middle = power(np.zeros(1), np.zeros(1), z)[0]
        rows, columns = power(0 * y, y, z), power(x, 0 * x, z)
        shares.append(rows[:, None] * columns[None, :] / middle)
    both = np.array(shares)
    top = float(both.max())
    return np.maximum(both / top, 0.05) if top > 0 else np.ones_like(both)


def patch_around(
    low: ArrayLike, high: ArrayLike, pitch: float, margin: float, even: int = 1
) -> Patch:
    """Samples that cover x and y from `low` to `high` (x, y[, z]) and a margin on each side.

    even : rows and columns are made multiples of it
    """
    a, b = np.asarray(low, dtype=np.float64)[:2], np.asarray(high, dtype=np.float64)[:2]
    counts = [even * ceil(((b[i] - a[i] + 2 * margin) / pitch + 1) / even) for i in (1, 0)]
    centre = (a + b) / 2
    return Patch((float(centre[1]), float(centre[0])), (counts[0], counts[1]), pitch)


def focal_stack(
    field: NDArray[np.complex64],
    slm: SLM,
    wavelength: float,
    depths: ArrayLike,
    patch: Patch | None = None,
    band: Passband | None = None,
) -> FocalStack:
    """Intensity of a decoded field at many depths.

    field : (H, W) from `four_f_field`, hologram plane
    depths : metres, > 0, ascending
    patch : region, default the SLM's window; a pitch other than the SLM's resamples
    band : what the field occupies, default Nyquist
    """
    z = np.atleast_1d(np.asarray(depths, dtype=np.float64))
    region = Patch((0.0, 0.0), slm.shape, slm.pixel_pitch) if patch is None else patch
    out = np.empty((len(z), *region.shape), dtype=np.float32)
    for i, plane in enumerate(focal_planes(field, slm, wavelength, z, region, band)):
        out[i] = plane
    return FocalStack(z, out, region)


def focal_planes(
    field: NDArray[np.complex64],
    slm: SLM,
    wavelength: float,
    depths: ArrayLike,
    region: Patch,
    band: Passband | None = None,
) -> Iterator[NDArray[np.float32]]:
    """The (h, w) intensities of `focal_stack` one after the other, for who shows progress."""
    z = np.atleast_1d(np.asarray(depths, dtype=np.float64))
    if z.size == 0 or not np.isfinite(z).all() or z.min() <= 0 or (np.diff(z) <= 0).any():
        raise ValueError("depths must be positive, ascending metres")
    p = slm.pixel_pitch
    nyquist = 0.5 / p
    limits = (nyquist, nyquist) if band is None else (band.fy_max, band.fx_max)
    middle = (z[0] + z[-1]) / 2
    way = max(float(z[-1] - middle), 1e-9)
    # What reaches the region from its surroundings, and a Fresnel zone or two more.
    margins = [ceil(spread(wavelength, f, way) / p) + soft_edge(wavelength, way, p) for f in limits]
    rows, columns = (
        ceil(n * region.pitch / p) + 2 * m for n, m in zip(region.shape, margins, strict=True)
    )
    if rows * columns > FAR * max(field.size, 1 << 18):
        yield from _far_planes(field, slm, wavelength, z, region)
        return
    wide = Patch(region.centre, (rows, columns), p)
    there = Propagator(slm.shape, p, wavelength, float(middle), wide, band, keep=0)(
        field, -float(middle)
    )
    near = Propagator(
        wide.shape, p, wavelength, way, Patch((0.0, 0.0), region.shape, region.pitch), band, keep=0
    )
    spectrum = near.spectrum(there)
    for depth in z:
        yield intensity(near.at(spectrum, -(float(depth) - float(middle))))


def _far_planes(
    field: NDArray[np.complex64],
    slm: SLM,
    wavelength: float,
    depths: NDArray[np.float64],
    region: Patch,
) -> Iterator[NDArray[np.float32]]:
    """Intensities of a region far from the panel, straight from the field.

    |Σ U₀·exp(−ikr)|²·(p²/λz)², the distance r to a sample expanded about the region's centre: the
    sphere about that is taken off the field exactly, the rest is linear in the sample's place, and
    the other depths' difference is paraxial. So a depth is two matrix products. The terms left out
    stay below (A·s/2z²)²·k·z/2 radians for samples s from the centre and a panel of side A.
    """
    p = slm.pixel_pitch
    middle = float(depths.mean())
    (cy, cx), (sy, sx) = region.centre, region.coordinates()
    y, x = slm.y() - cy, slm.x() - cx
    rho = y[:, None] ** 2 + x[None, :] ** 2
    flat = field * cycles_to_phasor(-rho / (np.sqrt(rho + middle**2) + middle) / wavelength)
    for depth in depths:
        far = float(np.sqrt(depth**2 + cy**2 + cx**2))
        rows, columns = (
            cycles_to_phasor(
                (
                    np.outer(samples - centre, pixels) * (1 / far)
                    - pixels**2 / 2 * (1 / depth - 1 / middle)
                )
                / wavelength
            )
            for samples, centre, pixels in ((sy, cy, y), (sx, cx, x))
        )
        scale = np.float32((p**2 / (wavelength * depth)) ** 2)
        yield intensity((rows @ flat) @ columns.T) * scale


def all_in_focus(
    stack: FocalStack, window: float = 9.0
) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Every pixel at the depth of what stands there.

    window : extent of the surroundings that are judged together, samples

    Returns (h, w) intensity and (h, w) depth in metres. Sharpness is the local second moment of
    intensity over the squared local mean; each pixel's sharpest depth is then averaged over its
    neighbours, weighted by how much sharp light they hold, so that darkness takes the depth of
    what is beside it. Far from any light the depth means nothing.
    """
    from scipy.ndimage import gaussian_filter

    shape = stack.patch.shape
    best, light = np.full(shape, -np.inf), np.zeros(shape)
    sharpest = np.full(shape, stack.depths[0])
    floor = float(stack.intensity.mean()) * 1e-3 + np.finfo(np.float32).tiny
    for z, plane in zip(stack.depths, stack.intensity, strict=True):
        mean = gaussian_filter(plane, window / 3)
        square = gaussian_filter(plane * plane, window / 3)
        sharp = square / (mean + floor) ** 2
        better = sharp > best
        best[better], light[better], sharpest[better] = sharp[better], square[better], z
    weight = light + float(light.mean()) * 1e-6 + np.finfo(np.float32).tiny
    middle = float(stack.depths.mean())
    around = gaussian_filter(weight, window)
    depth = middle + gaussian_filter(weight * (sharpest - middle), window) / around
    return at_depths(stack.depths, stack.intensity, depth), depth


def at_depths(
    depths: NDArray[np.float64], planes: NDArray[np.float32], wanted: NDArray[np.float64]
) -> NDArray[np.float32]:
    """(h, w, …) of each pixel the plane whose depth is nearest to the one wanted there.

    depths : (D,) ascending; planes : (D, h, w, …) at them; wanted : (h, w)
    """
    index = np.clip(np.searchsorted(depths, wanted), 1, len(depths) - 1)
    if len(depths) == 1:
        index = np.zeros(wanted.shape, dtype=np.intp)
    else:
        index -= wanted - depths[index - 1] < depths[index] - wanted
    place = index.reshape(1, *wanted.shape, *(1,) * (planes.ndim - 3))
    image: NDArray[np.float32] = np.take_along_axis(planes, place, axis=0)[0]
    return image
