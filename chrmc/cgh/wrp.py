"""Wavefront recording planes: short patches near the object, then one propagation each.

A point's wave is narrow on a plane close to it. Each point adds its own patch, with its own
distance dz, to the nearest recording plane; the planes travel to the hologram by the
band-limited angular spectrum (the idea of Shimobaba, Masuda and Ito, Opt. Lett. 34, 3133, 2009).

The patch is the point's soft footprint, seen from the plane: per axis, the tapered wave on the
hologram carried back to the plane by a one-dimensional angular spectrum, cut to the half-width
|dz|·tan α + guard. Tapering a spherical wave on the plane itself instead looks the same in ray
optics, but at the Fresnel numbers of a short patch its edges diffract: 11 % wrong at |dz| = 20 mm
and 36 % at 1 mm (one dimension), where this form stays below 0.5 % at any dz, nought included.

Errors against `chrmc.reference`, in this order of size:
- the cut of the patch: see `guard`;
- the product of two one-dimensional patches lacks the mixed term of the wave's path, up to
  (π/2)·|dz|·λ³·fx²·fy² rad: it falls with |dz|, hence with the number of planes;
- what the truth's own soft edge loses beyond the pixels' Nyquist frequency: the floor.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from chrmc.cgh.counts import OperationCounts
from chrmc.cgh.method import CGHMethod
from chrmc.cgh.wrp_patches import NEAR, patches, place_planes, travelled
from chrmc.cgh.wrp_paths import Path, grid_length, paths_to
from chrmc.kept import Kept
from chrmc.optics.footprint import reach
from chrmc.optics.passband import UNLIMITED, Passband
from chrmc.optics.propagation import cycles_to_phasor, transfer_function
from chrmc.reference import true_waves
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM
from chrmc.threads import workers
from chrmc.window import Window

_DEPTH_GRID = NEAR / 10  # metres
_LARGEST = 1 << 26  # samples of the grid that planes are propagated on
_MOST_ON_PLANES = 1 << 28  # samples of all planes' grids: half a minute


def field(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    passband: Passband,
    *,
    planes: int | Sequence[float] | None = None,
    guard: float = 32.0,
    cache: Kept | None = None,
) -> NDArray[np.complex64]:
    """Field on the window by wavefront recording planes.

    planes : how many, placed so that the largest |dz| is least; or their depths in metres;
        default as few as keep every |dz| within 5 mm (12 at most). More planes: smaller patches
        and a smaller error, but an FFT each.
    guard : what is added to a patch's half-width, in samples of the band (1/(2·f_max)): pixels
        for the full band, twice as many across a half band
    cache : keeps transfer functions from frame to frame

    Relative error at 250 mm, full band, any number of planes: 4e-3 with guard 32, 1e-2 with 16,
    0.1 to 0.2 with 0. The floor falls with the footprints' Fresnel number: 4e-2 at 50 mm, 0.15 at
    10 mm, where the soft edges are a few pixels wide; 6e-5 at 2 m, whose edges miss the SLM.
    Domain: a soft footprint within the pixels' Nyquist band, and a grid of at most 2^26 samples;
    else ValueError.
    """
    limits = (passband.fx_max, passband.fy_max)
    if not all(f <= slm.nyquist * (1 + 1e-9) for f in limits):
        raise ValueError(
            f"wrp needs a soft footprint within the Nyquist frequency {slm.nyquist:.4g}/m; the "
            f"passband reaches {max(limits):.4g}/m: use footprint='soft', or the method rt"
        )
    if guard < 0:
        raise ValueError(f"guard must not be negative, not {guard}")
    cloud = cloud.select(_reaches(cloud, slm, wavelength, window, passband))
    if len(cloud) == 0:
        return np.zeros(window.shape, dtype=np.complex64)
    z = cloud.positions[:, 2]
    depths = _depths(z, planes)
    nearest = np.argmin(np.abs(z[:, None] - depths), axis=1)
    used = np.unique(nearest)
    groups = [cloud.select(nearest == i) for i in used]
    paths = paths_to(cloud, slm, wavelength, window, passband)
    recorded = [
        record_plane(group, slm, wavelength, float(depths[i]), guard, paths)
        for i, group in zip(used, groups, strict=True)
    ]
    grid = tuple(
        grid_length(
            [(r.origin[axis], r.origin[axis] + r.field.shape[axis]) for r in recorded],
            (span[0], span[-1] + 1),
            paths[axis].spread / slm.pixel_pitch,
        )
        for axis, span in ((0, window.rows), (1, window.columns))
    )
    shape = (grid[0], grid[1])
    _check_grid(shape, z, len(used))
    kept = Kept() if cache is None else cache
    total = np.zeros(shape, dtype=np.complex64)
    for i, plane in zip(used, recorded, strict=True):
        # The circular convolution knows no origin: place and read modulo the grid.
        canvas = np.zeros(shape, dtype=np.complex64)
        rows = np.arange(plane.field.shape[0]) + plane.origin[0]
        columns = np.arange(plane.field.shape[1]) + plane.origin[1]
        canvas[np.ix_(rows % shape[0], columns % shape[1])] = plane.field
        spectrum = scipy.fft.fft2(canvas, workers=workers(), overwrite_x=True)
        optics = shape, slm.pixel_pitch, wavelength, float(depths[i])
        spectrum *= kept.get(optics, partial(transfer_function, *optics))
        total += spectrum
    out: NDArray[np.complex64] = scipy.fft.ifft2(total, workers=workers(), overwrite_x=True)
    return np.ascontiguousarray(
        out[np.ix_(window.rows % shape[0], window.columns % shape[1])], dtype=np.complex64
    )


def _depths(z: NDArray[np.float64], planes: int | Sequence[float] | None) -> NDArray[np.float64]:
    """Depths of the recording planes, metres."""
    depths = place_planes(z, planes)
    if planes is None and depths[0] > 10 * _DEPTH_GRID:
        # Whole steps, so that a moving scene meets kept transfer functions again.
        depths = np.unique(np.rint(depths / _DEPTH_GRID)) * _DEPTH_GRID
    return depths


@dataclass(frozen=True, eq=False)
class RecordedPlane:
    """A recording plane's field.

    field : complex64, on the SLM's pixel grid continued past its edges
    origin : (row, column) of field[0, 0] on the SLM, possibly negative
    depth : metres
    """

    field: NDArray[np.complex64]
    origin: tuple[int, int]
    depth: float


def _check_grid(shape: tuple[int, int], z: NDArray[np.float64], planes: int = 1) -> None:
    samples = shape[0] * shape[1]
    if samples > _LARGEST or samples * planes > _MOST_ON_PLANES:
        raise ValueError(
            f"wrp would need {planes} grids of {shape[1]} × {shape[0]} samples for points up to "
            f"{z.max():.4g} m away: use rt, fresnel or curved"
        )


def record_plane(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    depth: float,
    guard: float,
    paths: tuple[Path, Path],
) -> RecordedPlane:
    """The patches of all points on the plane z = depth; arguments as for `field`.

    paths : how far along y and x the points' light is needed
    """
    x, y, z = cloud.positions.T
    column = np.rint(x / slm.pixel_pitch + (slm.width - 1) / 2).astype(np.intp)
    row = np.rint(y / slm.pixel_pitch + (slm.height - 1) / 2).astype(np.intp)
    half_y, patch_y = patches(y - slm.y(row), z, depth, slm, wavelength, guard, paths[0])
    half_x, patch_x = patches(x - slm.x(column), z, depth, slm, wavelength, guard, paths[1])
    # The axes' patches each hold exp(ikz)/√z; one exp(ikz) of the two is taken out again.
    once = cycles_to_phasor(cloud.phase / (2 * np.pi) - (z - depth) / wavelength)
    patch_y = patch_y * (cloud.amplitude * once)[:, None].astype(np.complex64)
    reach_y, reach_x = (patch_y.shape[1] - 1) // 2, (patch_x.shape[1] - 1) // 2
    top, left = int(row.min()) - reach_y, int(column.min()) - reach_x
    shape = (int(row.max()) + reach_y + 1 - top, int(column.max()) + reach_x + 1 - left)
    _check_grid(shape, z)
    canvas = np.zeros(shape, dtype=np.complex64)
    for j in range(len(cloud)):
        my, mx = half_y[j], half_x[j]
        r, c = row[j] - top, column[j] - left
        canvas[r - my : r + my + 1, c - mx : c + mx + 1] += (
            patch_y[j, reach_y - my : reach_y + my + 1, None]
            * patch_x[j, reach_x - mx : reach_x + mx + 1]
        )
    return RecordedPlane(canvas, (top, left), depth)


def _reaches(
    cloud: PointCloud, slm: SLM, wavelength: float, window: Window, passband: Passband
) -> NDArray[np.bool_]:
    """Which points have a pixel of the window in their footprint."""
    keep = np.ones(len(cloud), dtype=bool)
    z = cloud.positions[:, 2]
    for axis, pixels, f_max in (
        (0, slm.x(window.columns), passband.fx_max),
        (1, slm.y(window.rows), passband.fy_max),
    ):
        half = z * reach(wavelength, f_max)
        keep &= cloud.positions[:, axis] + half > pixels[0]
        keep &= cloud.positions[:, axis] - half < pixels[-1]
    return keep


def cost(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    passband: Passband,
    *,
    planes: int | Sequence[float] | None = None,
    guard: float = 32.0,
    **_: object,
) -> OperationCounts:
    """Patches, and a transform for each plane and one back; ValueError for grids too large."""
    cloud = cloud.select(_reaches(cloud, slm, wavelength, window, passband))
    if len(cloud) == 0:
        return OperationCounts(calls=100.0)
    z, depths = cloud.positions[:, 2], _depths(cloud.positions[:, 2], planes)
    away = np.abs(z[:, None] - depths).min(axis=1)
    used = len(np.unique(np.argmin(np.abs(z[:, None] - depths), axis=1)))
    grid, samples, tables = [], np.ones(len(cloud)), 0.0
    for axis, (pixels, path) in enumerate(
        zip((window.rows, window.columns), paths_to(cloud, slm, wavelength, window, passband),
            strict=True)
    ):  # fmt: skip
        steep = min(path.slope, path.spread / float(z.max()))
        pad = guard * wavelength / (2 * np.sin(np.arctan(steep)) * slm.pixel_pitch)
        half = away * steep / slm.pixel_pitch + pad
        at = cloud.positions[:, 1 - axis] / slm.pixel_pitch + (slm.shape[axis] - 1) / 2
        reached = int((at - half).min()), int((at + half).max()) + 1
        spread = path.spread / slm.pixel_pitch
        grid.append(grid_length([reached], (int(pixels[0]), int(pixels[-1]) + 1), spread))
        samples *= 2 * half + 1
        tables += 2 * (min(float(z.max()) * path.slope, path.spread) / slm.pixel_pitch + half.max())
    _check_grid((grid[0], grid[1]), z, used)
    size = float(grid[0]) * grid[1]
    return OperationCounts(
        phasors=8 * len(cloud) * tables,
        lookups=2 * float(samples.sum()),
        transforms=(used + 1) * size * np.log2(size) + 2 * len(cloud) * tables * np.log2(tables),
        bytes=(60 * used + 40) * size,
        calls=30.0 * len(cloud) + 300.0 * used,
        memory=(8.0 * used + 24.0) * size,
    )


def waves(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    rows: NDArray[np.intp],
    columns: NDArray[np.intp],
    passband: Passband,
    *,
    planes: int | Sequence[float] | None = None,
    guard: float = 32.0,
    **others: object,
) -> NDArray[np.complex128]:
    """Each point's wave at pixels of its own, (N, K), from its patch, an axis at a time.

    The patch of an axis travels on alone, to be compared with that axis's own wave; what the
    product of two patches lacks is put on as the phase that the module names.
    """
    window = Window.full(slm)
    z = cloud.positions[:, 2]
    depths = _depths(z, planes)
    depth = depths[np.argmin(np.abs(z[:, None] - depths), axis=1)]
    paths = paths_to(cloud, slm, wavelength, window, passband)
    bare = true_waves(cloud, slm, wavelength, rows, columns, UNLIMITED)
    slopes = []
    for axis, (index, places) in enumerate(((rows, slm.y), (columns, slm.x))):
        at = cloud.positions[:, 1 - axis]
        middle = np.rint(at / slm.pixel_pitch + (slm.shape[axis] - 1) / 2).astype(np.intp)
        offset = at - places(middle)
        for j in range(len(cloud)):
            one = slice(j, j + 1)
            steps = index[j] - middle[j]
            d = steps * slm.pixel_pitch - offset[j]
            patch = patches(offset[one], z[one], depth[j], slm, wavelength, guard, paths[axis])[1]
            arrived = travelled(
                patch[0], depth[j], slm.pixel_pitch, wavelength, paths[axis].spread, steps
            )
            r = np.sqrt(d**2 + z[j] ** 2)
            bare[j] *= arrived * np.sqrt(r) * np.exp(-2j * np.pi * np.remainder(r / wavelength, 1))
        slopes.append((index * slm.pixel_pitch - middle[:, None] * slm.pixel_pitch) / z[:, None])
    lacking = np.pi / (4 * wavelength) * (z - depth)[:, None] * (slopes[0] * slopes[1]) ** 2
    return bare * np.exp(2j * lacking)


METHOD = CGHMethod(
    field,
    cost=cost,
    waves=waves,
    rounding=1e-6,
    shares_cores=False,
    new_cache=Kept,
    settings=tuple({"planes": n} for n in (1, 4, 12)),
)
