"""Rivals of the low-rank forms, as strong as we could write them: what `bench speed` compares with.

Each gives the coded signal Re(field·carrier) of a cloud, with the same soft footprint.
"""

from math import pi

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.interface import (
    Factor,
    Line,
    Reference,
    alone,
    bounding_box,
    lines_of,
    make_series,
    phasors,
    plane_of,
    signal_of,
    spread,
)
from chrmc.cgh.curved.wave import by_curvature
from chrmc.compensation.ch_rmc_object.plan import outline_of, planned
from chrmc.compensation.ch_rmc_object.taps import taps_for
from chrmc.encoding import Coding
from chrmc.optics.footprint import reach, taper
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import ObjectFrame, Pose
from chrmc.slm import SLM
from chrmc.threads import workers
from chrmc.window import Window

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]

_AIM, _SHARE = 0.7, 0.2  # of the tolerance: for nodes and filters, for grids and series
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
    its = Reference(0.0, 0.0, 0.0, far_x, far_y)
    z_0 = 1 / its.modulus(z)
    nothing = np.zeros(1)
    still = its.residual_parts(nothing, nothing, z, wavelength)[0]
    out = np.empty(slm.shape, dtype=np.float32)

    def along(axis: int) -> Singles:
        """(N, 2·terms, pixels) of every term's cosine and sine."""
        t, at, deep, f_max = (
            (slm.x(), x, its.along_x(z), coding.passband.fx_max),
            (slm.y(), y, its.along_y(z), coding.passband.fy_max),
        )[axis]
        made = np.empty((len(z), 2 * terms, len(t)), dtype=np.float32)

        def some(part: slice) -> None:
            d = t - at[part]
            offset = (d, nothing) if axis == 0 else (nothing, d)
            own = its.residual_parts(*offset, z[part], wavelength)[0] / np.sqrt(-still[part])
            own = own.astype(np.float32)
            share = taper(d.astype(np.float32), z[part] * reach(wavelength, f_max))
            d *= d
            r = np.sqrt(d + deep[part] ** 2)
            d /= (r + deep[part]) * wavelength
            share *= (z_0[part] / r).astype(np.float32)
            if axis == 1:
                d += coding.carrier * t
                d += its.start(z[part], wavelength) + cloud.phase[part, None] / (2 * pi)
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
                made[part, 2 * power], made[part, 2 * power + 1] = both
                cos, sin = cos * own, sin * own

        spread(some, [slice(n, n + _POINTS) for n in range(0, len(z), _POINTS)])
        return made

    right, left = along(0), along(1)
    half = z[:, 0] * reach(wavelength, coding.passband.fy_max)

    def multiply(first: int) -> None:
        rows = slice(first, first + _ROWS)
        low, high = slm.y()[rows][[0, -1]]
        seen = np.flatnonzero((y[:, 0] + half > low) & (y[:, 0] - half < high))
        near = slice(int(seen[0]), int(seen[-1]) + 1) if len(seen) else slice(0, 0)
        part = left[near, :, rows].reshape(-1, len(out[rows]))
        np.matmul(part.T, right[near].reshape(-1, slm.width), out=out[rows])

    spread(multiply, range(0, slm.height, _ROWS))
    return out


@alone
def nonuniform_signal(
    cloud: PointCloud, slm: SLM, wavelength: float, coding: Coding, tolerance: float
) -> Singles:
    """The baseband by non-uniform Fourier transforms (finufft), everything else as in `curved`.

    A point's wave over the reference is exp(−2πi·t·u), u its direction, times a rest that depends
    weakly on the point: a short series in place and point, each term of which is one transform of
    the same points. Footprints' edges are filtered as on the object surface.

    Raises ValueError where strips are too narrow for filters.
    """
    import finufft

    window = Window.full(slm)
    targets, plane = lines_of(slm, window), plane_of(slm, wavelength, window, coding.passband)
    body = PointCloud(cloud.positions, cloud.amplitude, cloud.phase)
    still = Pose(np.eye(3), np.zeros(3))
    thing = ObjectFrame("cloud", cloud, body, np.arange(len(cloud)), still)
    plan = planned(thing, outline_of(body), targets, plane, _AIM * tolerance)
    if any(plan.from_points):
        raise ValueError(f"no filter is good enough for the soft edges at {tolerance:g}")
    its, aim = plan.wave.reference, _SHARE * tolerance
    along = plan.readings
    x, y, z = cloud.positions.T
    outer = plan.some.positions  # stand for all
    taps = taps_for(aim)
    lines, matrices, angles = [], [], []
    for t, at, own in ((along[0].places, x, its.x), (along[1].places, y, its.y)):
        u = (at / z - own / its.z) / wavelength
        step = taps.step(1.02 * float(np.abs(u).max()))
        count = int(np.ceil((t.max() - t.min()) / step)) + taps.count + 1
        first = float(t.min()) - step * (taps.count // 2)
        line = Line(first, step, count)
        lines.append(line)
        matrices.append(taps.matrix((t - first) / step, count))
        angles.append((-2 * pi * step * u).astype(np.float32))
    middles = [line.first + line.step * (line.count // 2) for line in lines]

    def rest(tx: Floats, ty: Floats, px: Floats, py: Floats, pw: Floats) -> tuple[Floats, Floats]:
        pz = 1 / pw
        r = [
            ((t - p) ** 2 / (np.sqrt((t - p) ** 2 + deep**2) + deep), t, p, own, deep_own)
            for t, p, own, deep, deep_own in (
                (tx, px, its.x, its.along_x(pz), its.z_x), (ty, py, its.y, its.along_y(pz), its.z_y)
            )
        ]  # fmt: skip
        path = 0.0
        for way, t, p, own, deep in r:
            mine = (t - own) ** 2 / (np.sqrt((t - own) ** 2 + deep**2) + deep)
            path = path + way - mine + t * (p / pz - own / its.z)
        turn, modulus = its.residual_parts(tx - px, ty - py, pz, wavelength)
        start = (px * px + py * py) / (2 * pz)  # of a wave at t = 0, put on the points
        return turn + 2 * pi / wavelength * (path - start), modulus

    box = bounding_box(by_curvature(outer))
    slack = 0.02 * (box[:, 1:] - box[:, :1]) * [-1, 1]
    series = make_series(
        (lines[0].places[0], lines[0].places[-1]), (lines[1].places[0], lines[1].places[-1]),
        box + slack, rest, aim,
    )  # fmt: skip
    if series is None:
        raise ValueError("no short series fits the points")
    cycles = its.start(z, wavelength) + cloud.phase / (2 * pi)
    cycles += ((x * x + y * y) / (2 * z)) / wavelength
    cycles -= (middles[0] * (x / z - its.x / its.z) + middles[1] * (y / z - its.y / its.z)) / (
        wavelength
    )
    cycles -= np.rint(cycles)
    strength = phasors((2 * pi * cycles).astype(np.float32), cloud.amplitude * its.modulus(z))
    sums = finufft.nufft2d1(
        *angles, (series.at_points(by_curvature(cloud.positions)) * strength).astype(np.complex64),
        (lines[0].count, lines[1].count), eps=max(aim, 2e-7), isign=1, nthreads=workers(),
        upsampfac=1.25,
    ).reshape(series.terms, lines[0].count, lines[1].count)  # fmt: skip
    weights = series.on_nodes(lines[0].places, lines[1].places, np.float32)
    plain = sum(
        one * (weight[0] + 1j * weight[1]).T
        for one, weight in zip(sums, map(weights.of, range(series.terms)), strict=True)
    )
    plain = (matrices[0] @ plain @ matrices[1].T).astype(np.complex64)
    wide = along[0].of(plain, len(plan.axes[0].nodes), along[1].places)
    values = along[1].of(np.ascontiguousarray(wide.T), len(plan.axes[1].nodes), plan.axes[0].nodes)
    factor = Factor(*plan.axes, its, values.real.copy(), values.imag.copy())
    return signal_of([factor], slm, wavelength, window, coding.carrier)
