"""Where recording planes stand, and a point's patch on one, an axis at a time."""

from collections.abc import Sequence

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from chrmc.cgh.wrp_paths import Path
from chrmc.optics.footprint import taper
from chrmc.optics.propagation import cycles_to_phasor
from chrmc.slm import SLM
from chrmc.threads import workers

NEAR = 5e-3
"""Default planes stand so that no point is farther from its plane than this, metres."""
MOST_PLANES = 12
"""But never more planes than this unless asked for."""
_LONGEST = 1 << 17  # samples of one point's footprint per axis
_BLOCK = 1 << 20  # samples held at once while patches are made


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


def patches(
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


def travelled(
    patch: NDArray[np.complex64],
    depth: float,
    pixel_pitch: float,
    wavelength: float,
    spread: float,
    steps: NDArray[np.intp],
) -> NDArray[np.complex128]:
    """One axis of a patch, carried to the hologram by itself, at pixels from its middle.

    patch : (2·half + 1,)
    depth : metres of its plane; spread : metres that its light strays; steps : (K,)
    """
    half = len(patch) // 2
    far = max(int(np.abs(steps).max()) + 1, int(1.15 * spread / pixel_pitch))
    length = scipy.fft.next_fast_len(2 * (half + far) + 64)
    canvas = np.zeros(length, dtype=np.complex128)
    canvas[np.arange(-half, half + 1) % length] = patch
    f = scipy.fft.fftfreq(length, pixel_pitch)
    kernel = cycles_to_phasor(depth * np.sqrt(np.maximum(1 / wavelength**2 - f**2, 0)))
    arrived = scipy.fft.ifft(scipy.fft.fft(canvas) * kernel)
    found: NDArray[np.complex128] = arrived[steps % length]
    return found
