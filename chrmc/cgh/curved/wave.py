"""A spherical wave split into a factor along x, a factor along y, and a small rest.

With r_x = √(dx² + z_x²), z_x² = z² + Y², and likewise r_y with X,

    exp(ikr)/r = exp(ik(r_x − z_x))·exp(ik(r_y − z_y))·exp(ik(z_x + z_y − z_0))/z_0 · G,
    G = z_0/r·exp(ike),  e = r − r_x − r_y + z_0 ≈ −(dx² − X²)(dy² − Y²)/(4z³),

z_0² = z² + X² + Y². X and Y, about the rms distances on the hologram, halve the rest.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, log, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.chebyshev import chebyshev, interpolation
from chrmc.cgh.curved.nodes import Axis

Floats = NDArray[np.float64]

Kernel = Callable[..., tuple[Floats, Floats]]
"""(tx, ty, px, py, pz), broadcast → phase in radians, not wrapped, and modulus."""


@dataclass(frozen=True)
class Reference:
    """The separable reference wave exp(ik(r_x − z_x) + ik(r_y − z_y)) from a cluster's centre.

    x, y, z : the centre, metres
    far_x, far_y : X and Y of the split, for the centre and for all points around it
    """

    x: float
    y: float
    z: float
    far_x: float = 0.0
    far_y: float = 0.0

    def along_x(self, z: Floats) -> Floats:
        """z_x of points at depth z."""
        return np.hypot(z, self.far_y)

    def along_y(self, z: Floats) -> Floats:
        """z_y of points at depth z."""
        return np.hypot(z, self.far_x)

    def modulus(self, z: Floats) -> Floats:
        """1/z_0 of points at depth z."""
        return 1 / np.sqrt(z * z + self.far_x**2 + self.far_y**2)

    def start(self, z: Floats, wavelength: float) -> Floats:
        """Cycles of z_x + z_y − z_0, less whole ones."""
        path = self.along_x(z) + self.along_y(z) - 1 / self.modulus(z)
        cycles = path / wavelength
        return np.asarray(cycles - np.rint(cycles))

    @property
    def z_x(self) -> float:
        """z_x of the centre."""
        return float(np.hypot(self.z, self.far_y))

    @property
    def z_y(self) -> float:
        """z_y of the centre."""
        return float(np.hypot(self.z, self.far_x))

    def residual_parts(
        self, x: Floats, y: Floats, z: Floats, wavelength: float
    ) -> tuple[Floats, Floats]:
        """Phase of G in radians, not wrapped, and its modulus, at offsets x, y and depth z."""
        a, b, s = x * x, y * y, z * z
        far_a, far_b = self.far_x**2, self.far_y**2
        r_x, r_y = np.sqrt(s + a + far_b), np.sqrt(s + far_a + b)
        r, r_0 = np.sqrt(s + a + b), np.sqrt(s + far_a + far_b)
        e = (b - far_b) * (far_a - a) * (1 / (r + r_y) + 1 / (r_0 + r_x))
        e /= (r + r_x) * (r_y + r_0)
        return 2 * pi / wavelength * e, r_0 / r

    def residual(
        self, x: Floats, y: Floats, z: Floats, wavelength: float
    ) -> NDArray[np.complex128]:
        """G at offsets x, y and depth z, broadcast, without cancellation."""
        return phasors(*self.residual_parts(x, y, z, wavelength))

    def kernel(self, wavelength: float) -> Kernel:
        """G for targets (tx, ty) on the hologram and points (px, py, 1/pz), see `by_curvature`."""

        def kernel(
            tx: Floats, ty: Floats, px: Floats, py: Floats, pw: Floats
        ) -> tuple[Floats, Floats]:
            return self.residual_parts(tx - px, ty - py, 1 / pw, wavelength)

        return kernel


@dataclass(frozen=True)
class Wave:
    """The light of a cluster: what is taken out of its sums, its wavelength and its reach.

    reach : footprint half-width per depth in x and y
    """

    reference: Reference
    wavelength: float
    reach: tuple[float, float]


def by_curvature(positions: Floats) -> Floats:
    """(N, 3) x, y, 1/z: G is nearly a polynomial in them, however deep the cluster is."""
    return np.column_stack([positions[:, :2], 1 / positions[:, 2]])


_STEPS = 1024  # of a turn
_COS, _SIN = (turn(2 * pi / _STEPS * np.arange(_STEPS)) for turn in (np.cos, np.sin))


def phasor(cycles: Floats) -> tuple[Floats, Floats]:
    """cos and sin of 2π·cycles, to 4e-12: a table, and two terms of their series between its steps.

    Twice as fast as the functions, in blocks that fit the second cache.
    """
    rest = cycles * _STEPS
    whole = np.rint(rest)
    rest -= whole
    rest *= 2 * pi / _STEPS
    step = whole.astype(np.intp)
    step &= _STEPS - 1
    cos, sin = _COS.take(step), _SIN.take(step)
    less = -0.5 * rest * rest  # cos(rest) − 1
    rest += rest * less * (1 / 3)  # sin(rest)
    return cos + (cos * less - sin * rest), sin + (sin * less + cos * rest)


def phasors(radians: Floats, modulus: Floats | float = 1.0) -> NDArray[np.complex128]:
    """modulus·exp(i·radians), broadcast; several times faster than a complex exponential."""
    out = np.empty(np.broadcast_shapes(radians.shape, np.shape(modulus)), dtype=np.complex128)
    np.multiply(np.cos(radians), modulus, out=out.real)
    np.multiply(np.sin(radians), modulus, out=out.imag)
    return out


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
    axis: Axis, x: Floats, z: Floats, centre: float, z_centre: float, wavelength: float
) -> tuple[Floats, Floats | None]:
    """`axis_cycles` (N, n) at many nodes as a product (N, few)·(few, n), exact to 1e-10.

    Or the cycles themselves and None, where few would be many.

    The cycles are analytic in t up to t = x ± iz, so a Chebyshev series of them falls by
    ρ = z/h + √(1 + (z/h)²) per term on an interval of half-length h.
    """
    low, high = axis.span
    half = (high - low) / 2
    if half > 0:
        ratio = float(min(z.min(), z_centre)) / half
        swing = (2 * half + float(np.ptp(x)) + 1e-3 * half) / wavelength
        few = 3 + ceil(log(1e10 * max(swing, 1.0)) / log(ratio + sqrt(1 + ratio * ratio)))
        if few < 0.7 * len(axis.nodes):
            coarse = (low + high) / 2 + half * chebyshev(few)
            values = axis_cycles(coarse, x, z, centre, z_centre, wavelength)
            return values, interpolation(few, (axis.nodes - (low + high) / 2) / half).T
    return axis_cycles(axis.nodes, x, z, centre, z_centre, wavelength), None
