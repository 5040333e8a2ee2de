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

from chrmc.cgh.method import CGHMethod
from chrmc.cgh.wrp_paths import Path, grid_length, paths_to
from chrmc.kept import Kept
from chrmc.optics.footprint import reach, taper
from chrmc.optics.passband import Passband
from chrmc.optics.propagation import cycles_to_phasor, transfer_function
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM
from chrmc.threads import workers
from chrmc.window import Window

NEAR = 5e-3
"""Default planes stand so that no point is farther from its plane than this, metres."""
MOST_PLANES = 12
"""But never more planes than this unless asked for."""
_LONGEST = 1 << 17  # samples of one point's footprint per axis
_DEPTH_GRID = NEAR / 10  # metres
_LARGEST = 1 << 26  # samples of the grid that planes are propagated on
_MOST_ON_PLANES = 1 << 28  # samples of all planes' grids: half a minute
_MOST_SAMPLES = 1e10  # of all patches on a plane: half a minute
_BLOCK = 1 << 20  # samples held at once while patches are made


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
    depths = place_planes(z, planes)
    if planes is None and depths[0] > 10 * _DEPTH_GRID:
        # Whole steps, so that a moving scene meets kept transfer functions again.
        depths = np.unique(np.rint(depths / _DEPTH_GRID)) * _DEPTH_GRID
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


def place_planes(
    z: NDArray[np.float64], planes: int | Sequence[float] | None = None
) -> NDArray[np.float64]:
    """Depths of the recording planes, metres, ascending.

    z : (N,) depths of the points
    planes : as for `field`. A number asks for at most that many, each midway between the nearest
        and farthest of its points, so that the largest |dz| is the least possible.
    """
    if planes is not None and not isinstance(planes, int | np.integer):
        depths = np.sort(np.asarray(planes, dtype=np.float64).reshape(-1))
        if depths.size == 0 or not (np.isfinite(depths).all() and depths[0] > 0):
            raise ValueError(f"recording planes need depths z > 0, not {list(planes)}")
        return depths
    levels = np.unique(z)
    if planes is None:
        most = MOST_PLANES
        width = 2 * NEAR
    else:
        most = int(planes)
        width = 0.0
    if most < 1:
        raise ValueError(f"at least one recording plane is needed, not {planes}")
    starts = _cover(levels, width)
    if len(starts) > most:
        low, high = width, float(levels[-1] - levels[0])
        for _ in range(60):
            middle = (low + high) / 2
            if len(_cover(levels, middle)) > most:
                low = middle
            else:
                high = middle
        starts = _cover(levels, high)
    ends = [*[s - 1 for s in starts[1:]], len(levels) - 1]
    return np.array([(levels[s] + levels[e]) / 2 for s, e in zip(starts, ends, strict=True)])


def _cover(levels: NDArray[np.float64], width: float) -> list[int]:
    """First index of each interval of the given width that a walk through the levels needs."""
    starts = [0]
    while True:
        limit = levels[starts[-1]] + width
        after = int(np.searchsorted(levels, limit * (1 + 1e-12), side="right"))
        if after >= len(levels):
            return starts
        starts.append(max(after, starts[-1] + 1))


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
    half_y, patch_y = _patches(y - slm.y(row), z, depth, slm, wavelength, guard, paths[0])
    half_x, patch_x = _patches(x - slm.x(column), z, depth, slm, wavelength, guard, paths[1])
    # The axes' patches each hold exp(ikz)/√z; one exp(ikz) of the two is taken out again.
    once = cycles_to_phasor(cloud.phase / (2 * np.pi) - (z - depth) / wavelength)
    patch_y = patch_y * (cloud.amplitude * once)[:, None].astype(np.complex64)
    reach_y, reach_x = (patch_y.shape[1] - 1) // 2, (patch_x.shape[1] - 1) // 2
    top, left = int(row.min()) - reach_y, int(column.min()) - reach_x
    shape = (int(row.max()) + reach_y + 1 - top, int(column.max()) + reach_x + 1 - left)
    _check_grid(shape, z)
    samples = float(np.sum((2.0 * half_y + 1) * (2.0 * half_x + 1)))
    if samples > _MOST_SAMPLES:
        raise ValueError(
            f"wrp would need {samples:.2g} samples for the patches of {len(cloud)} points on one "
            "plane: use rt, fresnel or curved"
        )
    canvas = np.zeros(shape, dtype=np.complex64)
    for j in range(len(cloud)):
        my, mx = half_y[j], half_x[j]
        r, c = row[j] - top, column[j] - left
        canvas[r - my : r + my + 1, c - mx : c + mx + 1] += (
            patch_y[j, reach_y - my : reach_y + my + 1, None]
            * patch_x[j, reach_x - mx : reach_x + mx + 1]
        )
    return RecordedPlane(canvas, (top, left), depth)


def _patches(
    offset: NDArray[np.float64],
    z: NDArray[np.float64],
    depth: float,
    slm: SLM,
    wavelength: float,
    guard: float,
    path: Path,
) -> tuple[NDArray[np.intp], NDArray[np.complex64]]:
    """One axis of every point's patch: half-widths (N,) in pixels and samples (N, 2·max + 1).

    offset : (N,) metres from the nearest pixel centre, which is the patch's middle sample
    """
    p, slope = slm.pixel_pitch, path.slope
    # From far away only part of the band reaches the window: a narrower cone, a finer spectrum.
    used = min(slope, path.spread / float(z.max()))
    pad = guard * wavelength / (2 * np.sin(np.arctan(used)) * p)
    footprint = int(np.ceil(min(float(z.max()) * slope, path.spread) / p))
    half = np.ceil(np.abs(z - depth) * used / p + pad).astype(np.intp)
    widest = int(half.max())
    length = scipy.fft.next_fast_len(2 * footprint + 2 * widest + 64)
    if length > _LONGEST:
        raise ValueError(
            f"wrp would need {length} samples for the footprint of a point at "
            f"{z.max():.4g} m (at most {_LONGEST}): use rt, fresnel or curved"
        )
    f = scipy.fft.fftfreq(length, p)
    back = cycles_to_phasor(-depth * np.sqrt(np.maximum(1 / wavelength**2 - f**2, 0)))
    sample = np.arange(-(length // 2), length - length // 2)
    # Points that share depth and sub-pixel offset, as RGB-D points do, share the patch.
    pairs, first = np.unique(
        np.stack([np.round(offset / (p * 1e-9)), z]), axis=1, return_inverse=True
    )
    unique_offset, unique_z = pairs[0] * (p * 1e-9), pairs[1]
    out = np.empty((len(unique_z), 2 * widest + 1), dtype=np.complex64)
    middle = length // 2
    step = max(1, _BLOCK // length)
    for start in range(0, len(unique_z), step):
        part = slice(start, start + step)
        zj = unique_z[part, None]
        distance = sample * p - unique_offset[part, None]
        wave = cycles_to_phasor(np.sqrt(distance**2 + zj**2) / wavelength)
        weight = taper(distance, zj * slope) * path.weight(distance)
        wave *= weight / np.sqrt(np.sqrt(distance**2 + zj**2))
        spectrum = scipy.fft.fft(
            scipy.fft.ifftshift(wave, axes=1), axis=1, workers=workers(), overwrite_x=True
        )
        spectrum *= back
        wave = scipy.fft.ifft(spectrum, axis=1, workers=workers(), overwrite_x=True)
        wave = scipy.fft.fftshift(wave, axes=1)
        out[part] = wave[:, middle - widest : middle + widest + 1]
    patch = out[first.reshape(-1)]
    if pad > 0:
        # The last 30 % of the guard fade out, so that the cut itself diffracts little.
        inside = half[:, None] + 1 - np.abs(np.arange(-widest, widest + 1))
        patch *= np.sin(np.pi / 2 * np.clip(inside / (0.3 * pad + 1), 0, 1)) ** 2
    return half, patch


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


METHOD = CGHMethod(field, new_cache=Kept, settings=tuple({"planes": n} for n in (1, 4, 12)))
