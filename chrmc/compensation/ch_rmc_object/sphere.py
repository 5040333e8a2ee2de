"""An object's light on the sphere of directions around its centre, in layers of range.

With q' a place seen from the object's centre in the object's own axes and ρ = |q'|, the light is
exp(ikρ)/ρ·m(direction, ρ). A rotation of the object only turns the directions; m changes slowly
with ρ, like k·δ²/(2ρ) for a point δ from the centre, so a few layers, interpolated in 1/ρ, hold
it at all ranges.

Directions are written as azimuth u about the axes' y and tangent of elevation v:
q' = ρ·(sin u, v, −cos u)/√(1 + v²), so that turning about y shifts u and leaves v.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from math import ceil, factorial, pi

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.interface import (
    Kernel,
    Series,
    chebyshev,
    interpolation,
    make_series,
    node_count,
    phasor_table,
    weighted_products,
)
from chrmc.compensation.ch_rmc_object.taps import rms_error, step_for, taps_for, weights
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]

Axes = Callable[[Floats, Floats, Floats], tuple[Floats, Floats]]
"""(u, v, positions) → cycles along u and along v, (N, n_u) and (N, n_v)."""

_PANEL_KAPPA = 80.0
_SHARE = 0.2
"""Of the tolerance: for each of azimuth, elevation, range and the sums behind the grid."""


@dataclass(frozen=True)
class View:
    """Ranges of azimuth, elevation tangent and 1/ρ that a grid has to cover.

    tilt : largest |Δu/Δv| along a column of the hologram
    """

    u: tuple[float, float]
    v: tuple[float, float]
    s: tuple[float, float]
    tilt: float

    def union(self, other: "View") -> "View":
        """Covering both."""
        pairs = ((self.u, other.u), (self.v, other.v), (self.s, other.s))
        u, v, s = ((min(a[0], b[0]), max(a[1], b[1])) for a, b in pairs)
        return View(u, v, s, max(self.tilt, other.tilt))

    def covers(self, other: "View") -> bool:
        """The other lies inside, up to rounding."""
        slack = 1e-9
        inside = all(
            a[0] - slack * max(1, abs(a[0])) <= b[0] and b[1] <= a[1] + slack * max(1, abs(a[1]))
            for a, b in ((self.u, other.u), (self.v, other.v), (self.s, other.s))
        )
        return inside and other.tilt <= self.tilt + slack


def coordinates(q: Floats) -> tuple[Floats, Floats, Floats]:
    """u, v, ρ of places (3, …) seen from the centre."""
    level = np.hypot(q[0], q[2])
    return np.arctan2(q[0], -q[2]), q[1] / level, np.hypot(level, q[1])


@dataclass(frozen=True, eq=False)
class Sphere:
    """m on a grid of directions and layers.

    values : (n_u, n_v, layers) complex64, u_i = u0 + i·du, v likewise
    layers : (L,) 1/ρ of the layers
    taps : neighbours used per axis
    wavelength, tolerance : what it was made for
    view : what it covers
    """

    values: NDArray[np.complex64]
    u0: float
    du: float
    v0: float
    dv: float
    layers: Floats
    taps: int
    wavelength: float
    tolerance: float
    view: View

    @classmethod
    def empty(
        cls, radius: tuple[float, float], view: View, wavelength: float, tolerance: float
    ) -> "Sphere":
        """A grid of zeros for points within `radius` (across y, along y) of the centre, metres."""
        taps = taps_for(tolerance)
        du, dv = _steps(radius, view, wavelength, tolerance)
        n_u, n_v, count = grid_shape(radius, view, wavelength, tolerance)
        pad = taps // 2 + 1
        half = (view.s[1] - view.s[0]) / 2
        layers = (view.s[0] + view.s[1]) / 2 + half * chebyshev(count)
        values = np.zeros((n_u, n_v, count), dtype=np.complex64)
        u0, v0 = view.u[0] - pad * du, view.v[0] - pad * dv
        return cls(values, u0, du, v0, dv, layers, taps, wavelength, tolerance, view)

    def add(self, points: PointCloud) -> None:
        """Add the waves of points, positions from the centre in the grid's axes, to all layers."""
        if len(points) == 0:
            return
        n_u = self.values.shape[0]
        reach = float(np.hypot(points.positions[:, 0], points.positions[:, 2]).max())
        kappa = pi * reach / self.wavelength * n_u * self.du
        cuts = np.linspace(0, n_u, max(1, round(kappa / _PANEL_KAPPA)) + 1).round().astype(int)
        # What the separable tables leave depends on ρ as 1/ρ of a small part of it.
        alike = np.ptp(self.layers) <= min(0.03, 100 * self.tolerance) * self.layers.mean()
        for first, last in pairwise(cuts):
            series: Series | None = None
            for number, s in enumerate(self.layers):
                values, series = self._panel(
                    points, float(1 / s), first, last, series if alike else None
                )
                self.values[first:last, :, number] += values

    def _panel(
        self, points: PointCloud, rho: float, first: int, last: int, series: Series | None
    ) -> tuple[NDArray[np.complex64], Series]:
        """(last − first, n_v) waves at grid azimuths first … last − 1 on one layer.

        series : one made before for the same panel, if it will do
        """
        n_v = self.values.shape[1]
        u_range = self.u0 + first * self.du, self.u0 + (last - 1) * self.du
        v_range = self.v0, self.v0 + (n_v - 1) * self.dv
        share = _SHARE * self.tolerance
        # Chebyshev nodes hold the panel with a fraction of the samples of the even grid.
        u, to_u = _nodes(*u_range, last - first, _bandwidth(points, 0, v_range, self), share)
        v, to_v = _nodes(*v_range, n_v, _bandwidth(points, 1, v_range, self), share)
        kernel, axes = panel_kernel(rho, float(u.mean()), float(v.mean()), self.wavelength)
        box = np.stack([points.positions.min(axis=0), points.positions.max(axis=0)], axis=1)
        if series is None:
            series = make_series(
                (float(u[0]), float(u[-1])), (float(v[0]), float(v[-1])), box, kernel, share
            )
        if series is None:
            raise ValueError(
                f"object of {1e3 * float(np.ptp(box, axis=1).max()):.3g} mm is too large for a "
                "baseband on a sphere; use compensation none"
            )
        precision = np.float32 if self.tolerance >= 5e-6 else np.float64
        total = np.zeros((len(v), len(u)), dtype=np.complex128)
        for start in range(0, len(points), 4096):
            part = points.select(slice(start, start + 4096))
            across, down = axes(u, v, part.positions)
            down += part.phase[:, None] / (2 * pi)
            scale = series.at_points(part.positions) * part.amplitude
            real, imag = weighted_products(
                phasor_table(across.__getitem__, across.shape, precision),
                phasor_table(down.__getitem__, down.shape, precision),
                scale.astype(precision), series.on_nodes(u, v, precision),
            )  # fmt: skip
            total += real + 1j * imag
        even = to_u @ (to_v @ total).T
        return even.astype(np.complex64), series

    def look_up(self, turn: Floats, centre: Floats, x: Floats, y: Floats) -> NDArray[np.complex64]:
        """(len(y), len(x)) m at places (x, y, 0) of the hologram.

        turn : (3, 3) world axes to the grid's; centre : (3,) the object's centre in the world

        Two passes, as images are turned: along u onto the hologram's columns, for every v of the
        grid, then along v.
        """
        base = turn @ np.stack(
            [x - centre[0], np.full(len(x), -centre[1]), np.full(len(x), -centre[2])]
        )
        along = turn[:, 1]
        q = base[:, None, :] + along[:, None, None] * y[:, None]
        to_v = (coordinates(q)[1] - self.v0) / self.dv
        low = int(np.floor(to_v.min())) - (self.taps // 2 - 1)
        high = int(np.floor(to_v.max())) + self.taps // 2 + 1
        rows = np.arange(low, high)
        if low < 0 or high > self.values.shape[1]:
            raise IndexError("elevation outside the grid")
        columns = self._columns(base, along, np.asarray(self.v0 + rows * self.dv), slice(low, high))
        first, weight = weights(to_v, self.taps)
        flat = columns.ravel()
        index = (first - low) * len(x) + np.arange(len(x))
        out = np.zeros(index.shape, dtype=np.complex64)
        for k, share in enumerate(weight):
            out += np.take(flat, index + k * len(x)) * share.astype(np.float32)
        return out

    def _columns(
        self, base: Floats, along: Floats, v: Floats, rows: slice
    ) -> NDArray[np.complex64]:
        """(len(v), n_x) m where the hologram's columns pass the grid's elevations."""
        level = np.hypot(base[0], base[2])[None, :]
        # Along a column q' = base + y·along; find y with q'_y = v·√(q'_x² + q'_z²). The level
        # distance hardly changes along a column, so the plain iteration converges fast.
        for _ in range(40):
            y = (v[:, None] * level - base[1]) / along[1]
            new = np.hypot(base[0] + y * along[0], base[2] + y * along[2])
            done = np.max(np.abs(new - level)) <= 1e-13 * np.max(new)
            level = new
            if done:
                break
        q = base[:, None, :] + along[:, None, None] * y
        u, _, rho = coordinates(q)
        layer_weights = _lagrange(self.layers, 1 / rho)
        to_u = (u - self.u0) / self.du
        level_turn = abs(along[0]) < 1e-12 and abs(along[2]) < 1e-12
        if level_turn:
            to_u = to_u[:1]
        first, weight = weights(to_u, self.taps)
        if first.min() < 0 or first.max() + self.taps > self.values.shape[0]:
            raise IndexError("azimuth outside the grid")
        out = np.zeros(rho.shape, dtype=np.complex64)
        window = self.values[:, rows]
        if level_turn:
            wide = np.zeros((len(base[0]), *window.shape[1:]), dtype=np.complex64)
            for k, share in enumerate(weight):
                wide += window[first[0] + k] * share[0].astype(np.float32)[:, None, None]
            for number, share in enumerate(layer_weights):
                out += wide[:, :, number].T * share.astype(np.float32)
            return out
        row = np.arange(len(v))[:, None]
        for number, layer in enumerate(layer_weights):
            part = np.zeros(rho.shape, dtype=np.complex64)
            for k, share in enumerate(weight):
                part += window[first + k, row, number] * share.astype(np.float32)
            out += part * layer.astype(np.float32)
        return out

    def expected_error(self, points: PointCloud) -> float:
        """Relative rms error of a look-up, averaged over the points' power."""
        x, y, z = points.positions.T
        power = points.amplitude**2
        level = np.hypot(x, z)
        far_v = max(abs(self.view.v[0]), abs(self.view.v[1]))
        scale = 2 * pi / self.wavelength
        # Azimuth frequency varies with direction: rms over the seen arc, about level/√2 or less.
        middle = (self.view.u[0] + self.view.u[1]) / 2
        f_u = np.hypot(x * np.cos(middle) + z * np.sin(middle), 0.3 * level)
        f_v = np.abs(y) + far_v * level / 2 + f_u * self.view.tilt
        error = rms_error(scale * f_u * self.du, self.taps) ** 2
        error += rms_error(scale * f_v * self.dv, self.taps) ** 2
        half = (self.view.s[1] - self.view.s[0]) / 2
        count = len(self.layers)
        swing = pi * (level**2 + y**2) / self.wavelength * half
        error += 2 * ((swing / 2) ** count / factorial(count)) ** 2
        error += 3 * (0.5 * _SHARE * self.tolerance) ** 2 + (5e-7) ** 2
        total = float(power.sum())
        return float(np.sqrt(power @ error / total)) if total > 0 else 0.0


def _steps(
    radius: tuple[float, float], view: View, wavelength: float, tolerance: float
) -> tuple[float, float]:
    taps = taps_for(tolerance)
    f_u = radius[0] / wavelength
    far_v = max(abs(view.v[0]), abs(view.v[1]))
    f_v = (radius[1] + far_v * radius[0]) / wavelength + f_u * view.tilt
    return step_for(f_u, taps, _SHARE * tolerance), step_for(f_v, taps, _SHARE * tolerance)


def grid_shape(
    radius: tuple[float, float], view: View, wavelength: float, tolerance: float
) -> tuple[int, int, int]:
    """(n_u, n_v, layers) of the grid for points within `radius` of the centre."""
    pad = taps_for(tolerance) // 2 + 1
    n_u, n_v = (
        ceil((high - low) / step) + 2 * pad + 1
        for (low, high), step in zip(
            (view.u, view.v), _steps(radius, view, wavelength, tolerance), strict=True
        )
    )
    delta2 = radius[0] ** 2 + radius[1] ** 2
    swing = pi * delta2 * (view.s[1] - view.s[0]) / 2 / wavelength
    return n_u, n_v, layer_count(swing, _SHARE * tolerance)


def layer_count(swing: float, tolerance: float) -> int:
    """Layers for a phase of ±swing radians over the range: 2·J_L(swing) ≤ tolerance, about."""
    count = 1
    while 2 * (swing / 2) ** count / factorial(count) > tolerance and count < 40:
        count += 1
    return count


def panel_kernel(rho: float, u0: float, v0: float, wavelength: float) -> tuple[Kernel, Axes]:
    """Separable cycles of |q' − b| − ρ around (u0, v0), and the kernel of what they leave."""

    at_u, at_v = np.array(u0), np.array(v0)

    def path(u: Floats, v: Floats, b: tuple[Floats, Floats, Floats]) -> Floats:
        across = b[0] * np.sin(u) - b[2] * np.cos(u)
        towards = (across + b[1] * v) / np.sqrt(1 + v * v)
        b2 = b[0] ** 2 + b[1] ** 2 + b[2] ** 2
        change = b2 - 2 * rho * towards
        return np.asarray(change / (np.sqrt(rho * rho + change) + rho), dtype=np.float64)

    def kernel(u: Floats, v: Floats, bx: Floats, by: Floats, bz: Floats) -> tuple[Floats, Floats]:
        b = bx, by, bz
        here = path(u, v, b)
        rest = here - path(u, at_v, b) - path(at_u, v, b) + path(at_u, at_v, b)
        return 2 * pi / wavelength * rest, rho / (rho + here)

    def axes(u: Floats, v: Floats, positions: Floats) -> tuple[Floats, Floats]:
        b = positions[:, 0, None], positions[:, 1, None], positions[:, 2, None]
        corner = path(at_u, at_v, b)
        return path(u, at_v, b) / wavelength, (path(at_u, v, b) - corner) / wavelength

    return kernel, axes


def _bandwidth(
    points: PointCloud, axis: int, v_range: tuple[float, float], sphere: Sphere
) -> float:
    """Largest frequency of m along u (axis 0) or v (axis 1)."""
    level = np.hypot(points.positions[:, 0], points.positions[:, 2])
    if axis == 0:
        return float(level.max()) / sphere.wavelength
    far = max(abs(v_range[0]), abs(v_range[1]))
    return float(np.max(np.abs(points.positions[:, 1]) + far * level)) / sphere.wavelength


def _nodes(
    low: float, high: float, count: int, bandwidth: float, tolerance: float
) -> tuple[Floats, Floats]:
    """Chebyshev nodes on [low, high], and the matrix to `count` even samples of it."""
    n = node_count(pi * bandwidth * (high - low), tolerance)
    if n >= count or high <= low:
        return np.linspace(low, high, count), np.eye(count)
    nodes = (low + high) / 2 + (high - low) / 2 * chebyshev(n)
    return nodes, interpolation(n, np.linspace(-1, 1, count))


def _lagrange(nodes: Floats, at: Floats) -> list[Floats]:
    """Weight of each node for polynomial interpolation at places of any shape."""
    out = []
    for i, node in enumerate(nodes):
        weight = np.ones_like(at)
        for j, other in enumerate(nodes):
            if i != j:
                weight *= (at - other) / (node - other)
        out.append(weight)
    return out
