"""Ray tracing: the true spherical wave of every point on every pixel of its footprint.

Float32 cannot hold k·r (one step of it is 0.25 rad at 0.25 m), so a distance is split into

    r = z + s_x + s_y + rest,   s_x = √(dx² + z²) − z,   s_y = √(dy² + z²) − z,
    rest = −2·s_x·s_y / (r + z + s_x + s_y),

an identity. z, s_x and s_y belong to a point, a column and a row: their phases are reduced in
float64 before they are cast. Only `rest` is left for the pixel; within an SLM's footprint it is a
fraction of a wavelength, and relative rounding of 1e-6 of it is nothing.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.counts import OperationCounts
from chrmc.cgh.method import CGHMethod
from chrmc.optics.footprint import coverage, reach, taper
from chrmc.optics.passband import Passband
from chrmc.reference import true_waves
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM
from chrmc.threads import workers
from chrmc.window import Window

_POINTS = 256  # whose tables are held at once
_BLOCK = 1 << 15  # pixels a thread works on at once: its few buffers stay in the cache
_ENTRY = 20.0  # phasors that an entry of the tables takes as long as, as measured
PROMISED = 1e-5
"""Relative error of a field."""
_ALLOWED = 4e-6  # expected error up to which single precision will do; some pixels see twice that
_WAVE, _REST = 1.7e-7, 6e-7  # error of a wave in float32, and for each wavelength of its `rest`
_STORED = 2.5e-8  # relative error of a double that is stored in single precision
_DOUBLE = 5.5  # of the time, in double precision
_WAVE_IN_DOUBLE = 1e-13  # error of a wave, beside the reference's: 6e-14 was measured at 20,000 λ
_ADDED = 3e-8  # of a sum, for each wave added to it, at random


@dataclass(frozen=True)
class _Axis:
    """One axis of some points, all (points, pixels); turn in [−π, π], lengths in metres."""

    offset2: NDArray[Any]
    excess: NDArray[Any]  # √(offset² + z²) − z
    turn: NDArray[Any]
    weight: NDArray[Any]
    spans: list[tuple[int, int]]  # the pixels of each point's footprint

    @classmethod
    def make(
        cls,
        coordinate: NDArray[np.float64],
        centre: NDArray[np.float64],
        z: NDArray[np.float64],
        wavelength: float,
        f_max: float,
    ) -> "_Axis":
        offset = coordinate - centre[:, None]
        weight = taper(offset, (z * reach(wavelength, f_max))[:, None])
        offset2 = offset**2
        # Written so that nothing cancels near the axis.
        excess = offset2 / (np.sqrt(offset2 + z[:, None] ** 2) + z[:, None])
        cycles = excess / wavelength
        turn = 2 * np.pi * (cycles - np.rint(cycles))
        spans = []
        for row in weight > 0:
            lit = np.flatnonzero(row)
            spans.append((int(lit[0]), int(lit[-1]) + 1) if lit.size else (0, 0))
        return cls(offset2, excess, turn, weight, spans)

    def select(self, some: NDArray[np.bool_]) -> "_Axis":
        if some.all():
            return self
        spans = [span for span, kept in zip(self.spans, some, strict=True) if kept]
        return _Axis(
            self.offset2[some], self.excess[some], self.turn[some], self.weight[some], spans
        )

    def cast(self, dtype: type[np.floating[Any]]) -> "_Axis":
        return _Axis(
            self.offset2.astype(dtype),
            self.excess.astype(dtype),
            self.turn.astype(dtype),
            self.weight.astype(dtype),
            self.spans,
        )


def field(
    cloud: PointCloud, slm: SLM, wavelength: float, window: Window, passband: Passband
) -> NDArray[np.complex64]:
    """Σ w·a/r·exp(i(kr + φ)) on the window, (rows, columns) complex64.

    cloud : points at z > 0, metres; wavelength : metres
    passband : what the soft footprint of each point ends at; infinite for bare waves

    Relative error against `chrmc.reference_field` below 1e-5 (tested from 1 mm to 10 m depth,
    bare waves at steep angles included: where `rest` passes 6 wavelengths the points are
    computed in float64, several times slower; so are all where waves cancel). Raises ValueError
    where waves cancel past double precision.
    """
    out, noise = _sum(cloud, slm, wavelength, window, passband, np.complex64)
    if noise > _ALLOWED**2 * _power(out):
        exact, noise = _sum(cloud, slm, wavelength, window, passband, np.complex128)
        if noise > PROMISED**2 * _power(exact):
            held = np.sqrt(noise / _power(exact)) if exact.any() else np.inf
            raise ValueError(
                f"waves all but cancel: double precision holds what is left to {held:.2g}, and rt "
                f"promises {PROMISED:g}; leave out points that cancel each other"
            )
        return exact.astype(np.complex64)
    return out


def one_by_one(
    cloud: PointCloud, slm: SLM, wavelength: float, window: Window, passband: Passband
) -> NDArray[np.complex64]:
    """The same within 1e-5 of the light that the points have one by one, however little of it is
    left where waves cancel: each wave is the same whatever others there are."""
    return _sum(cloud, slm, wavelength, window, passband, np.complex64)[0]


def quick_field(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    passband: Passband,
    allowed: float = _ALLOWED,
) -> NDArray[np.complex64] | None:
    """`field` where single precision is enough for all of it, else None.

    allowed : relative error that is expected of it
    """
    x, y = slm.x(window.columns), slm.y(window.rows)
    if np.max(_doubt(_rest(cloud, x, y, wavelength, passband))) > allowed:
        return None
    out, noise = _sum(cloud, slm, wavelength, window, passband, np.complex64, allowed)
    return None if noise > allowed**2 * _power(out) else out


def _sum(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    passband: Passband,
    kind: type[np.complexfloating[Any, Any]],
    allowed: float = _ALLOWED,
) -> tuple[NDArray[Any], float]:
    """The field, each point in single precision where that is enough, or all in double; and the
    power of the error that this leaves, points of unrelated phases."""
    noise = 0.0
    added = _ADDED**2 * (min(len(cloud), _POINTS) + len(cloud) / _POINTS)
    x, y = slm.x(window.columns), slm.y(window.rows)
    out = np.zeros(window.shape, dtype=kind)
    step = max(1, _BLOCK // max(1, len(x)))
    blocks = [slice(i, min(i + step, len(y))) for i in range(0, len(y), step)]
    with ThreadPoolExecutor(workers()) as pool:
        for first in range(0, len(cloud), _POINTS):
            part = cloud.select(slice(first, first + _POINTS))
            z = part.positions[:, 2]
            axis_x = _Axis.make(x, part.positions[:, 0], z, wavelength, passband.fx_max)
            axis_y = _Axis.make(y, part.positions[:, 1], z, wavelength, passband.fy_max)
            cycles = z / wavelength
            cycles -= np.rint(cycles)
            cycles += part.phase / (2 * np.pi)
            axis_y.turn[...] += 2 * np.pi * (cycles - np.rint(cycles))[:, None]
            axis_y.weight[...] *= part.amplitude[:, None]
            waves = np.sum(axis_x.weight**2, axis=1) * np.sum(axis_y.weight**2, axis=1)
            doubt = _doubt(_rest(part, x, y, wavelength, passband))
            single = (doubt <= allowed) & (kind is np.complex64)
            each = doubt**2 * single + added if kind is np.complex64 else _WAVE_IN_DOUBLE**2
            noise += float(np.sum(waves / z**2 * each))
            sorts: tuple[tuple[NDArray[np.bool_], type[np.floating[Any]]], ...]
            sorts = (single, np.float32), (~single, np.float64)
            for some, dtype in sorts:
                if not some.any():
                    continue
                own_x, own_y = (axis.select(some).cast(dtype) for axis in (axis_x, axis_y))
                arguments = (z[some], wavelength, own_x, own_y, out)
                for done in [pool.submit(_add, rows, *arguments) for rows in blocks]:
                    done.result()
    return out, noise


def _power(field: NDArray[Any]) -> float:
    return float(np.vdot(field, field).real)


def _doubt(rest: NDArray[np.float64]) -> NDArray[np.float64]:
    """Relative error of waves in float32, of so many wavelengths of `rest`."""
    return np.hypot(_WAVE, _REST * rest)


def _rest(
    cloud: PointCloud,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    wavelength: float,
    passband: Passband,
) -> NDArray[np.float64]:
    """(N,) largest `rest` of each point on its footprint, cycles."""
    z = cloud.positions[:, 2]
    s = []
    for axis, pixels, f_max in ((0, x, passband.fx_max), (1, y, passband.fy_max)):
        at = cloud.positions[:, axis]
        far = np.maximum(np.abs(at - pixels[0]), np.abs(at - pixels[-1]))
        far = np.minimum(far, z * reach(wavelength, f_max))
        s.append(far**2 / (np.hypot(far, z) + z))
    return np.asarray(2 * s[0] * s[1] / ((2 * z + s[0] + s[1]) * wavelength))


def _add(
    rows: slice,
    z: NDArray[np.float64],
    wavelength: float,
    axis_x: _Axis,
    axis_y: _Axis,
    out: NDArray[Any],
) -> None:
    """Add the points' waves to out[rows], each on its own footprint."""
    dtype = axis_x.turn.dtype
    shape = out[rows].shape
    real, imaginary = np.zeros(shape, dtype), np.zeros(shape, dtype)
    scratch = np.empty((4, shape[0] * shape[1]), dtype)
    scale = dtype.type(-4 * np.pi / wavelength)
    for j in range(len(z)):
        c0, c1 = axis_x.spans[j]
        r0, r1 = axis_y.spans[j]
        r0, r1 = max(r0, rows.start), min(r1, rows.stop)
        if c0 >= c1 or r0 >= r1:
            continue
        size = (r1 - r0, c1 - c0)
        r, t, turn, wave = (b[: size[0] * size[1]].reshape(size) for b in scratch)
        sx = axis_x.excess[j, None, c0:c1]
        sy = axis_y.excess[j, r0:r1, None]
        depth = dtype.type(z[j])
        np.add(axis_x.offset2[j, None, c0:c1] + depth**2, axis_y.offset2[j, r0:r1, None], out=r)
        np.sqrt(r, out=r)
        np.add(r, sx + depth, out=t)
        t += sy
        np.multiply(scale * sx, sy, out=turn)
        turn /= t
        turn += axis_x.turn[j, None, c0:c1]
        turn += axis_y.turn[j, r0:r1, None]
        np.multiply(axis_x.weight[j, None, c0:c1], axis_y.weight[j, r0:r1, None], out=t)
        t /= r
        here = (slice(r0 - rows.start, r1 - rows.start), slice(c0, c1))
        np.cos(turn, out=wave)
        wave *= t
        real[here] += wave
        np.sin(turn, out=wave)
        wave *= t
        imaginary[here] += wave
    target = out[rows]
    target.real += real
    target.imag += imaginary


def cost(
    cloud: PointCloud, slm: SLM, wavelength: float, window: Window, passband: Passband
) -> OperationCounts:
    """A phase for each point and pixel of its footprint, dear where single precision will not do,
    and tables of rows and columns.

    That waves will cancel, so that all is computed again in double, no count foresees.
    """
    share = coverage(cloud, slm, wavelength, passband)
    x, y = slm.x(window.columns), slm.y(window.rows)
    doubt = _doubt(_rest(cloud, x, y, wavelength, passband)) > _ALLOWED
    lit = float(share.sum() + (_DOUBLE - 1) * share[doubt].sum()) * window.size
    blocks = window.size / _BLOCK
    high = 2 * cloud.positions[:, 2] * reach(wavelength, passband.fy_max) / slm.pixel_pitch
    met = np.minimum(high / max(len(y), 1) * blocks + 1, blocks)
    return OperationCounts(
        phasors=1.5 * lit + _ENTRY * len(cloud) * sum(window.shape),
        bytes=250.0 * window.size,
        calls=25.0 * float(met.sum()) + 0.5 * len(cloud) * blocks,
        memory=16.0 * window.size + 80.0 * _POINTS * sum(window.shape),
    )


def waves(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    rows: NDArray[np.intp],
    columns: NDArray[np.intp],
    passband: Passband,
) -> NDArray[np.complex128]:
    """The true ones, (N, K) at pixels of (N, K), as far off as single precision puts them."""
    doubt = _doubt(_rest(cloud, slm.x(), slm.y(), wavelength, passband)) > _ALLOWED
    turn = np.where(doubt, 0.0, _WAVE)[:, None]
    return true_waves(cloud, slm, wavelength, rows, columns, passband) * (1 + 1j * turn)


METHOD = CGHMethod(field, one_by_one=one_by_one, cost=cost, waves=waves, rounding=_STORED)
