"""The baseband of a cluster at its nodes: separable tables times a short separable series.

With r_x = √(dx² + z²), r_y likewise, a spherical wave is

    exp(ikr)/r = [exp(ik(r_x − z))·exp(ik(r_y − z))·exp(ikz)/z] · G,
    G = z/r·exp(ike),  e = r − r_x − r_y + z ≈ −dx²·dy²/(4z³).

The bracket is separable: two small tables and one matrix product. G depends weakly on where in
the cluster the point is, so it is expanded there in products of Chebyshev polynomials,
G ≈ Σ_l F_l(x, y)·P_l(point), with the terms that the tolerance needs and no others; each term is
one matrix product more.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, log, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.nodes import Axis, chebyshev, interpolation, node_count
from chrmc.footprint import taper
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
_MINUS = np.float32(-1)  # np.negative skips rows of strided outputs in NumPy 2.4
Reals = NDArray[np.floating]

_POINTS = 4096  # points whose tables are held at once


@dataclass(frozen=True)
class Reference:
    """The separable reference wave exp(ik(r_x − z) + ik(r_y − z)) from a cluster's centre."""

    x: float
    y: float
    z: float


def axis_cycles(
    t: Floats, x: Floats, z: Floats, centre: float, z_centre: float, wavelength: float
) -> Floats:
    """(N, len(t)) cycles of (√((t−x)² + z²) − z) − the same of the centre, without cancellation."""
    x, z = x[:, None], z[:, None]
    own, offset = t - centre, t - x
    r_own, r = np.sqrt(own**2 + z_centre**2), np.sqrt(offset**2 + z**2)
    sagitta = own**2 / (r_own + z_centre) + offset**2 / (r + z)
    dx, dz = x - centre, z - z_centre
    return ((dx - 2 * own) * dx - dz * sagitta) / ((r_own + r) * wavelength)


def phase_table(
    nodes: Floats, x: Floats, z: Floats, centre: float, z_centre: float, wavelength: float
) -> Floats:
    """`axis_cycles` at many nodes, interpolated in double precision from as few as that takes.

    The cycles are analytic in t up to t = x ± iz, so a Chebyshev series of them falls by
    ρ = z/h + √(1 + (z/h)²) per term on an interval of half-length h.
    """
    low, high = float(nodes[0]), float(nodes[-1])
    half = (high - low) / 2
    if half > 0:
        ratio = float(min(z.min(), z_centre)) / half
        swing = (2 * half + float(np.ptp(x)) + 1e-3 * half) / wavelength
        few = 3 + ceil(log(1e10 * max(swing, 1.0)) / log(ratio + sqrt(1 + ratio * ratio)))
        if few < 0.7 * len(nodes):
            coarse = (low + high) / 2 + half * chebyshev(few)
            values = axis_cycles(coarse, x, z, centre, z_centre, wavelength)
            return values @ interpolation(few, (nodes - (low + high) / 2) / half).T
    return axis_cycles(nodes, x, z, centre, z_centre, wavelength)


def fold(cycles: Floats, precision: type[np.floating]) -> tuple[Reals, Reals]:
    """cos and sin of 2π·cycles in `precision`, reduced in float64; `cycles` is overwritten."""
    cycles -= np.rint(cycles)
    turn = cycles.astype(precision)
    turn *= precision(2 * pi)
    return np.cos(turn), np.sin(turn)


def _apply_taper(
    parts: tuple[Reals, Reals], axis: Axis, x: Floats, z: Floats, reach: float
) -> None:
    for panel in axis.panels:
        if panel.tapered:
            weight = taper(axis.nodes[panel.nodes] - x[:, None], (z * reach)[:, None])
            for part in parts:
                part[:, panel.nodes] *= weight


@dataclass(frozen=True, eq=False)
class Series:
    """G ≈ Σ_l F_l(x, y)·P_l(point) over a box of points and a rectangle of the hologram.

    orders : (L, 3) degrees of the Chebyshev polynomials in x, y, z of the point
    box : (3, 2) lowest and highest x, y, z
    grid : half-open, the Chebyshev grid of `values`: (low, high, count) for x and for y
    values : (L, ny, nx) complex128 F_l on that grid
    dropped : relative rms of the terms left out
    """

    orders: NDArray[np.intp]
    box: Floats
    grid: tuple[tuple[float, float, int], tuple[float, float, int]]
    values: NDArray[np.complex128]
    dropped: float

    def at_points(self, positions: Floats) -> Floats:
        """(L, N) P_l of each point."""
        out = np.ones((len(self.orders), len(positions)))
        for axis in range(3):
            low, high = self.box[axis]
            top = int(self.orders[:, axis].max())
            if top == 0:
                continue
            u = (2 * positions[:, axis] - low - high) / (high - low)
            polynomials = [np.ones_like(u), u]
            while len(polynomials) <= top:
                polynomials.append(2 * u * polynomials[-1] - polynomials[-2])
            for row, degree in enumerate(self.orders[:, axis]):
                if degree:
                    out[row] *= polynomials[degree]
        return out

    def missed(self, positions: Floats, wavelength: float, reach: tuple[float, float]) -> Floats:
        """(N,) mean of |G − Σ F·P|²/|G|² over the grid inside each point's footprint."""
        x, y = ((low + high) / 2 + (high - low) / 2 * chebyshev(n) for low, high, n in self.grid)
        px, py, pz = positions.T[:, :, None, None]
        dx, dy = x - px, y[:, None] - py
        exact = residual(dx, dy, pz, wavelength)
        series = np.tensordot(self.at_points(positions), self.values, (0, 0))
        inside = (np.abs(dx) < pz * reach[0]) & (np.abs(dy) < pz * reach[1])
        inside |= ~inside.any(axis=(1, 2), keepdims=True)
        ratio: Floats = np.mean(np.abs(exact - series) ** 2, axis=(1, 2), where=inside)
        return ratio / np.mean(np.abs(exact) ** 2, axis=(1, 2), where=inside)

    def on_grid(self, x: Floats, y: Floats, precision: type[np.floating]) -> tuple[Reals, Reals]:
        """Real and imaginary parts of F_l at nodes, (L, len(y), len(x)) each."""
        to_x, to_y = (
            interpolation(
                n, (2 * t - low - high) / (high - low) if high > low else np.zeros(len(t))
            )
            for t, (low, high, n) in zip((x, y), self.grid, strict=True)
        )
        flat = self.values.reshape(-1, self.values.shape[2])
        parts = []
        for part in (flat.real, flat.imag):
            wide = (part @ to_x.T).reshape(len(self.orders), self.values.shape[1], -1)
            parts.append((to_y @ wide).astype(precision))
        return parts[0], parts[1]


def residual(x: Floats, y: Floats, z: Floats, wavelength: float) -> NDArray[np.complex128]:
    """G at offsets x, y and depth z, broadcast, without cancellation."""
    radians, fall = residual_parts(x, y, z, wavelength)
    return phasors(radians, fall)


def phasors(radians: Floats, modulus: Floats | float = 1.0) -> NDArray[np.complex128]:
    """modulus·exp(i·radians), broadcast; several times faster than a complex exponential."""
    out = np.empty(np.broadcast_shapes(radians.shape, np.shape(modulus)), dtype=np.complex128)
    np.multiply(np.cos(radians), modulus, out=out.real)
    np.multiply(np.sin(radians), modulus, out=out.imag)
    return out


def residual_parts(x: Floats, y: Floats, z: Floats, wavelength: float) -> tuple[Floats, Floats]:
    """Phase of G in radians, not wrapped, and its modulus."""
    a, b = x * x, y * y
    r_x, r_y = np.sqrt(a + z * z), np.sqrt(b + z * z)
    r = np.sqrt(a + b + z * z)
    e = -a * b * (1 / (r + r_x) + 1 / (r_y + z)) / ((r + r_y) * (r_x + z))
    return 2 * pi / wavelength * e, z / r


Kernel = Callable[..., tuple[Floats, Floats]]
"""(tx, ty, px, py, pz), broadcast → phase in radians, not wrapped, and modulus."""


def plane_kernel(wavelength: float) -> Kernel:
    """G for targets (tx, ty) on the hologram and points (px, py, pz)."""

    def kernel(tx: Floats, ty: Floats, px: Floats, py: Floats, pz: Floats) -> tuple[Floats, Floats]:
        return residual_parts(tx - px, ty - py, pz, wavelength)

    return kernel


def _transform(count: int) -> Floats:
    """(count, count) values at Chebyshev nodes → Chebyshev coefficients."""
    polynomials = np.cos(np.arange(count)[:, None] * np.arccos(np.clip(chebyshev(count), -1, 1)))
    polynomials *= 2 / count
    polynomials[0] /= 2
    return polynomials


MOST_SAMPLES = 3_000_000


def make_series(
    x_range: tuple[float, float],
    y_range: tuple[float, float],
    box: Floats,
    kernel: Kernel,
    tolerance: float,
) -> Series | None:
    """The shortest `Series` with a relative rms remainder below `tolerance`; None when too long.

    x_range, y_range : the nodes' range, on the hologram for `plane_kernel`
    box : (3, 2) the points' range
    kernel : the function to expand
    """
    counts = _sample_counts(x_range, y_range, box, kernel, tolerance)
    if np.prod(counts, dtype=float) > MOST_SAMPLES:
        return None
    grids = [
        (low + high) / 2 + (high - low) / 2 * chebyshev(n)
        for (low, high), n in zip((x_range, y_range, *box), counts, strict=True)
    ]
    # axes: hologram y, hologram x, point x, point y, point z
    tx, ty, px, py, pz = grids
    radians, modulus = kernel(
        tx[None, :, None, None, None], ty[:, None, None, None, None], px[:, None, None],
        py[:, None], pz,
    )  # fmt: skip
    samples = phasors(radians, modulus)
    weight = np.ones(())
    for axis, n in zip((2, 3, 4), counts[2:], strict=True):
        samples = np.moveaxis(np.tensordot(samples, _transform(n), (axis, 1)), -1, axis)
        mean_square = np.full(n, 0.5)
        mean_square[0] = 1.0
        weight = np.multiply.outer(weight, mean_square)
    power = np.mean(np.abs(samples) ** 2, axis=(0, 1)) * weight
    order = np.argsort(power, axis=None)[::-1]
    left = np.cumsum(power.ravel()[order][::-1])[::-1]
    total = left[0]
    keep = max(1, int(np.searchsorted(-left, -total * tolerance**2)))
    chosen = np.stack(np.unravel_index(order[:keep], power.shape), axis=1)
    values = np.stack([samples[:, :, a, b, c] for a, b, c in chosen])
    dropped = sqrt(left[keep] / total) if keep < len(left) else 0.0
    return Series(
        chosen, box, ((*x_range, counts[0]), (*y_range, counts[1])), values, float(dropped)
    )


def _sample_counts(
    x_range: tuple[float, float],
    y_range: tuple[float, float],
    box: Floats,
    kernel: Kernel,
    tolerance: float,
) -> list[int]:
    """Chebyshev samples that resolve a kernel along target x, y and point x, y, z."""
    tx, ty = (np.linspace(low, high, 5) for low, high in (x_range, y_range))
    px, py, pz = (np.unique([low, (low + high) / 2, high]) for low, high in box)
    shape = (5, 5, len(px), len(py), len(pz))
    radians, modulus = kernel(
        tx[:, None, None, None, None], ty[:, None, None, None], px[:, None, None], py[:, None], pz
    )
    both = [np.broadcast_to(v, shape) for v in (radians, np.log(modulus))]
    counts = []
    for axis, samples in enumerate(shape):
        # The steepest slope of the phase, and of the modulus's logarithm, over [−1, 1].
        slope = sum(float(np.max(np.abs(np.diff(v, axis=axis)), initial=0.0)) for v in both)
        slope *= (samples - 1) / 2
        counts.append(1 if samples == 1 else 1 + node_count(slope, tolerance / 10))
    for axis, (low, high) in enumerate((x_range, y_range)):
        counts[axis] = max(counts[axis], 4) if high > low else 1
    return counts


def products(
    across: tuple[Reals, Reals], down: tuple[Reals, Reals], scale: Reals
) -> tuple[Reals, Reals]:
    """Σ_j scale_lj·down_j·across_j as real and imaginary parts, (L, n_y, n_x) each.

    across, down : cos and sin tables (N, n_x) and (N, n_y)
    scale : (L, N) real
    Complex products as real ones of twice the depth: sgemm runs several times faster than cgemm
    here, and the result comes apart into real and imaginary rows.
    """
    terms, n = scale.shape
    ny = down[0].shape[1]
    left = np.empty((2, n, terms, 2, ny), dtype=scale.dtype)
    for term in range(terms):
        np.multiply(down[0], scale[term][:, None], out=left[0, :, term, 0])
        np.multiply(down[1], scale[term][:, None], out=left[0, :, term, 1])
        np.multiply(left[0, :, term, 1], _MINUS, out=left[1, :, term, 0])
        left[1, :, term, 1] = left[0, :, term, 0]
    total = left.reshape(2 * n, -1).T @ np.concatenate(across)
    blocks = total.reshape(terms, 2, ny, -1)
    return blocks[:, 0], blocks[:, 1]


def weigh(series: tuple[Reals, Reals], sums: tuple[Reals, Reals]) -> tuple[Reals, Reals]:
    """Σ_l F_l·sum_l, complex, from and to real and imaginary parts."""
    real = np.einsum("lyx,lyx->yx", series[0], sums[0])
    real -= np.einsum("lyx,lyx->yx", series[1], sums[1])
    imag = np.einsum("lyx,lyx->yx", series[0], sums[1])
    imag += np.einsum("lyx,lyx->yx", series[1], sums[0])
    return real, imag


def separable_baseband(
    cloud: PointCloud,
    axis_x: Axis,
    axis_y: Axis,
    reference: Reference,
    wavelength: float,
    reach: tuple[float, float],
    series: Series,
    precision: type[np.floating] = np.float32,
) -> tuple[Reals, Reals]:
    """Real and imaginary parts (n_y, n_x) of Σ_j w·a/r·exp(i(kr + φ)) over the reference wave.

    precision : of the tables and sums; float32 adds about 5e-7 of noise
    """
    total: tuple[Reals, Reals] | None = None
    for start in range(0, len(cloud), _POINTS):
        part = slice(start, start + _POINTS)
        x, y, z = cloud.positions[part].T
        across = fold(
            phase_table(axis_x.nodes, x, z, reference.x, reference.z, wavelength), precision
        )
        cycles = phase_table(axis_y.nodes, y, z, reference.y, reference.z, wavelength)
        own = z / wavelength
        cycles += (own - np.rint(own) + cloud.phase[part] / (2 * pi))[:, None]
        down = fold(cycles, precision)
        _apply_taper(across, axis_x, x, z, reach[0])
        _apply_taper(down, axis_y, y, z, reach[1])
        scale = series.at_points(cloud.positions[part]) * (cloud.amplitude[part] / z)
        sums = products(across, down, scale.astype(precision))
        if total is None:
            total = sums
        else:
            total[0][...] += sums[0]
            total[1][...] += sums[1]
    assert total is not None
    return weigh(series.on_grid(axis_x.nodes, axis_y.nodes, precision), total)


def exact_baseband(
    cloud: PointCloud,
    axis_x: Axis,
    axis_y: Axis,
    reference: Reference,
    wavelength: float,
    reach: tuple[float, float],
) -> tuple[Singles, Singles]:
    """The same as `separable_baseband` point by point, for geometry that no short series fits."""
    nx, ny = len(axis_x.nodes), len(axis_y.nodes)
    total = np.zeros((ny, nx), dtype=np.complex128)
    block = max(1, (1 << 20) // max(1, nx * ny))
    for start in range(0, len(cloud), block):
        part = slice(start, start + block)
        x, y, z = cloud.positions[part].T
        dx, dy = axis_x.nodes - x[:, None], axis_y.nodes - y[:, None]
        wave = residual(dx[:, None, :], dy[:, :, None], z[:, None, None], wavelength)
        own = z / wavelength
        cycles_x = axis_cycles(axis_x.nodes, x, z, reference.x, reference.z, wavelength)
        cycles_y = axis_cycles(axis_y.nodes, y, z, reference.y, reference.z, wavelength)
        cycles_y += (own - np.rint(own) + cloud.phase[part] / (2 * pi))[:, None]
        phasor_x = np.exp(2j * pi * (cycles_x - np.rint(cycles_x)))
        phasor_y = np.exp(2j * pi * (cycles_y - np.rint(cycles_y)))
        phasor_x *= taper(dx, (z * reach[0])[:, None])
        phasor_y *= taper(dy, (z * reach[1])[:, None])
        phasor_y *= (cloud.amplitude[part] / z)[:, None]
        total += np.einsum("jyx,jy,jx->yx", wave, phasor_y, phasor_x, optimize=True)
    return total.real.astype(np.float32), total.imag.astype(np.float32)
