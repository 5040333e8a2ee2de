"""Rivals of the low-rank forms, as strong as we could write them: what `bench speed` compares with.

Each gives the coded signal Re(field·carrier) of a cloud, with the same soft footprint.
"""

from math import pi

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.interface import Reference, alone, in_parallel
from chrmc.encoding import Coding
from chrmc.optics.footprint import reach, taper
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]

_FAR = 0.6  # rms distance on the hologram, of the largest
_ROWS, _POINTS = 120, 64  # rows that see about the same points, points whose tables fit a cache


@alone
def corrected_signal(
    cloud: PointCloud, slm: SLM, wavelength: float, coding: Coding, terms: int
) -> Singles:
    """Separable products with corrections: exact along either axis, and between them by a series.

    terms : 2 or 3, the first of the series of exp(ike) in ke, up to 0.03 rad for a car

    As in `chrmc.cgh.curved.wave`, r = r_x + r_y − z_0 + e. To fourth order e is a product of a
    function of dx and one of dy, and so is every power of it: all terms are one real product.
    """
    cloud = cloud.select(np.argsort(cloud.positions[:, 1]))  # so that rows see a slice of them
    x, y, z = (column[:, None] for column in cloud.positions.T)
    far_x, far_y = (
        _FAR * min(float(np.abs(t[[0, -1]] - at).max()), float(z.max()) * reach(wavelength, f_max))
        for t, at, f_max in (
            (slm.x(), x, coding.passband.fx_max), (slm.y(), y, coding.passband.fy_max)
        )
    )  # fmt: skip
    reference = Reference(0.0, 0.0, 0.0, far_x, far_y)
    z_0 = 1 / reference.modulus(z)
    nothing = np.zeros(1)
    still = reference.residual_parts(nothing, nothing, z, wavelength)[0]
    out = np.empty(slm.shape, dtype=np.float32)

    def along(axis: int) -> Singles:
        """(N, 2·terms, pixels) of every term's cosine and sine."""
        t, at, deep, f_max = (
            (slm.x(), x, reference.along_x(z), coding.passband.fx_max),
            (slm.y(), y, reference.along_y(z), coding.passband.fy_max),
        )[axis]
        factors = np.empty((len(z), 2 * terms, len(t)), dtype=np.float32)

        def some(part: slice) -> None:
            d = t - at[part]
            dx, dy = (d, nothing) if axis == 0 else (nothing, d)
            rest = reference.residual_parts(dx, dy, z[part], wavelength)[0] / np.sqrt(-still[part])
            own = rest.astype(np.float32)
            share = taper(d.astype(np.float32), z[part] * reach(wavelength, f_max))
            d *= d
            r = np.sqrt(d + deep[part] ** 2)
            d /= (r + deep[part]) * wavelength
            share *= (z_0[part] / r).astype(np.float32)
            if axis == 1:
                d += coding.carrier * t
                d += reference.start(z[part], wavelength) + cloud.phase[part, None] / (2 * pi)
                share *= (cloud.amplitude[part, None] / z_0[part]).astype(np.float32)
            d -= np.rint(d)
            turn = d.astype(np.float32)
            turn *= np.float32(2 * pi)
            cos, sin = np.cos(turn) * share, np.sin(turn) * share
            for power in range(terms):
                # (XY)(1 − iab − a²b²/2), ab = −ke: real parts of XY, of −iXY and of XY again.
                both = (cos, sin)
                if axis == 1:
                    both = ((cos, -sin), (sin, cos), (cos * -0.5, sin * 0.5))[power]
                factors[part, 2 * power], factors[part, 2 * power + 1] = both
                cos, sin = cos * own, sin * own

        in_parallel(some, [slice(n, n + _POINTS) for n in range(0, len(z), _POINTS)])
        return factors

    right, left = along(0), along(1)
    half = z[:, 0] * reach(wavelength, coding.passband.fy_max)

    def multiply(first: int) -> None:
        rows = slice(first, first + _ROWS)
        low, high = slm.y()[rows][[0, -1]]
        seen = np.flatnonzero((y[:, 0] + half > low) & (y[:, 0] - half < high))
        near = slice(int(seen[0]), int(seen[-1]) + 1) if len(seen) else slice(0, 0)
        part = left[near, :, rows].reshape(-1, len(out[rows]))
        np.matmul(part.T, right[near].reshape(-1, slm.width), out=out[rows])

    in_parallel(multiply, range(0, slm.height, _ROWS))
    return out
