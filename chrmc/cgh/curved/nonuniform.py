"""The baseband of very many points by non-uniform Fourier transforms (finufft).

A point's wave over the reference is exp(−2πi·s·u), s the sine of the direction in which a place is
seen from the centre, u the point's offset from there over wavelength and depth, times a rest that
depends weakly on the point: a short series in place and point (see `series`). Each term is one
transform of the same points to an even grid of sines. From there the nodes are read as on the
object surface: by taps, and by filters where footprints end.
"""

from dataclasses import dataclass
from functools import partial
from math import ceil, hypot, log2, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved import clusters
from chrmc.cgh.curved.clusters import Plane
from chrmc.cgh.curved.edge import Readings, readings_of
from chrmc.cgh.curved.nodes import Axis, Line
from chrmc.cgh.curved.series import Remainder, make_series
from chrmc.cgh.curved.taps import Taps, taps_for
from chrmc.cgh.curved.wave import Reference, by_curvature, phasors
from chrmc.parallel import in_parallel
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]
Reals = NDArray[np.floating]
Complexes = NDArray[np.complexfloating]

MANY_POINTS = 30_000
"""Points from which transforms are quicker than sub-clusters."""
_FILTER_SHARE = 0.75  # of the tolerance, of which filters take three quarters
_SHARE = 0.15  # for each of the taps along x and y, and the transforms
_SERIES = 2.0  # times that, for the series
_SINGLE = 5e-5  # smallest error that single precision serves: places are rounded to 1e-7 of a turn
_MOST_TERMS = 24
_STEEPEST, _LONGEST = 0.8, 0.02  # sine of the angle up to which directions are written so; step
_SWING, _SLICE = 0.1, 40_000  # cycles that curvatures turn waves by in a slice; points in one
# In multiply-adds of a matrix product: for each sample of a slice's transforms and log2 of their
# number, and for each point; of sub-clusters' work, that transforms must not pass.
_FOURIER, _GATHERED, _WORTH = 450.0, 2.5e4, 0.5
_TRIED = 2000  # points that stand for all when filters are tried
_CHUNK = 1 << 15  # points whose strengths are worked out at once: they fit the second cache


def readable(
    cloud: PointCloud,
    axes: tuple[Axis, Axis],
    reference: Reference,
    plane: Plane,
    tolerance: float,
) -> Readings | None:
    """How nodes are read off the plain baseband; None where no filter is good enough for edges."""
    some = cloud.select(slice(None, None, max(1, len(cloud) // _TRIED)))
    box, aim = clusters.bounding_box(cloud.positions), _FILTER_SHARE * tolerance
    read = readings_of(axes, reference, box, some, plane, aim)
    if any(read.from_points) or not all(len(one.places) for one in read.along):
        return None
    return read


def nonuniform_baseband(
    cloud: PointCloud,
    axes: tuple[Axis, Axis],
    reference: Reference,
    plane: Plane,
    tolerance: float,
) -> tuple[Reals, Reals, Remainder] | None:
    """Real and imaginary baseband (n_y, n_x) at given nodes, and what it misses.

    None where no filter is good enough for the soft edges, or the rest takes a long series.
    """
    read = readable(cloud, axes, reference, plane, tolerance)
    if read is None:
        return None
    box, along = clusters.bounding_box(cloud.positions), read.along
    aim = _SHARE * tolerance
    taps = taps_for(aim)
    both = _sides((along[0].places, along[1].places), box, reference, plane, taps)
    if _too_steep(both):
        return None
    count = _slices(both, box, len(cloud), reference, plane)
    slices = clusters.leaves(cloud, box, (1, 1, count))
    sums = in_parallel(
        partial(_slice, reference=reference, sides=both, plane=plane, tolerance=aim), slices
    )
    plain, dropped = None, 0.0
    for one in sums:
        if one is None:
            return None
        plain = one[0] if plain is None else plain + one[0]
        dropped = max(dropped, one[1])
    assert plain is not None
    near, far = (taps.matrix(side.at, side.grid.count).astype(plain.real.dtype) for side in both)
    plain = near @ plain @ far.T
    wide = along[0].of(plain, len(axes[0].nodes), along[1].places)
    out = along[1].of(np.ascontiguousarray(wide.T), len(axes[1].nodes), axes[0].nodes)
    filters = sqrt(read.missed / read.light) if read.light > 0 else 0.0
    missed = hypot(filters, dropped, sqrt(3) * aim)
    return out.real.copy(), out.imag.copy(), Remainder(None, missed)


@dataclass(frozen=True)
class _Side:
    """Directions along an axis, as sines seen from the reference's centre.

    centre, z : of the reference
    grid : even sines that transforms go to
    at : (n,) where on the grid the places are that are read, in steps
    still : the place at which a point's rest is put on the point
    """

    centre: float
    z: float
    grid: Line
    at: Floats
    still: float

    @property
    def places(self) -> Floats:
        """(count,) the grid's, in metres."""
        s = self.grid.places
        return np.asarray(self.centre + self.z * s / np.sqrt(1 - s * s))

    def turn(self, p: Floats, deep: Floats) -> Floats:
        """u of points at p, times the wavelength."""
        return (p - self.centre) * (self.z / deep)

    def path(self, t: Floats | float, p: Floats, deep: Floats) -> Floats:
        """What s·u leaves of the path from points to places t, over that from the centre."""
        own = np.asarray(t - self.centre)
        sine = own / np.sqrt(own * own + self.z**2)
        return _sagitta(t - p, deep) - _sagitta(own, self.z) + self.turn(p, deep) * sine

    def swing(self, depths: Floats, z: float) -> float:
        """Metres by which that differs, at most, over some depths."""
        far = float(np.abs(self.places[[0, -1]] - self.centre).max())
        return far * far / 4 * float(1 / depths[0] - 1 / depths[1]) if z > 0 else 0.0


def transforms_pay(
    count: int,
    box: Floats,
    axes: tuple[Axis, Axis],
    reference: Reference,
    plane: Plane,
    tolerance: float,
) -> bool:
    """Whether transforms of so many points in a box take less than sub-clusters, as counted.

    Grids are as large as the cluster is wide, and there is one for each slice of its depth.
    """
    if count < MANY_POINTS:
        return False
    places = axes[0].nodes, axes[1].nodes
    sides = _sides(places, box, reference, plane, taps_for(_SHARE * tolerance))
    if _too_steep(sides):
        return False
    samples = 4.0 * sides[0].grid.count * sides[1].grid.count  # twice as dense each way
    work = _FOURIER * _slices(sides, box, count, reference, plane) * samples * log2(samples)
    sums = clusters.cost_at(axes, box, count, plane, tolerance)
    return work + _GATHERED * count < _WORTH * sums


def _sides(
    places: tuple[Floats, Floats], box: Floats, reference: Reference, plane: Plane, taps: Taps
) -> tuple["_Side", "_Side"]:
    """Grids along x and y for places that are read."""
    sides = []
    for axis, (centre, z) in enumerate(
        ((reference.x, reference.z_x), (reference.y, reference.z_y))
    ):
        widest = float(np.abs(box[axis] - centre).max() / box[2, 0] * reference.z)
        sides.append(_side(places[axis], centre, z, widest / plane.wavelength, taps))
    return sides[0], sides[1]


def _too_steep(sides: tuple["_Side", "_Side"]) -> bool:
    """Whether a grid goes beyond the sines that places have, or nearly."""
    return max(float(np.abs(side.grid.places).max()) for side in sides) > _STEEPEST


def _slices(
    sides: tuple["_Side", "_Side"], box: Floats, count: int, reference: Reference, plane: Plane
) -> int:
    """Thin slices of depth, over which the curvature of waves changes little."""
    swing = sum(side.swing(box[2], reference.z) for side in sides) / plane.wavelength
    return max(1, min(ceil(swing / _SWING), count // _SLICE))


def _side(places: Floats, centre: float, z: float, widest: float, taps: Taps) -> _Side:
    """A grid for the places that are read; widest : largest |u|."""
    own = places - centre
    s = own / np.sqrt(own * own + z * z)
    low, high = float(s.min()), float(s.max())
    step = min(taps.step(1.02 * widest), _LONGEST)
    count = ceil((high - low) / step) + taps.count + 1
    grid = Line(low - step * (taps.count // 2), step, count)
    far = float(own[np.argmax(np.abs(own))])
    return _Side(centre, z, grid, (s - grid.first) / step, centre + far / sqrt(2))


def _sagitta(offset: Floats, z: Floats | float) -> Floats:
    """√(offset² + z²) − z."""
    square = offset * offset
    return np.asarray(square / (np.sqrt(square + z * z) + z))


def _slice(
    cloud: PointCloud,
    reference: Reference,
    sides: tuple[_Side, _Side],
    plane: Plane,
    tolerance: float,
) -> tuple[Complexes, float] | None:
    """(n_x, n_y) sums on the grid of sines, and what the series drops; None where it is long."""
    x, y = sides
    wavelength = plane.wavelength

    def kernel(tx: Floats, ty: Floats, px: Floats, py: Floats, pw: Floats) -> tuple[Floats, Floats]:
        pz = 1 / pw
        z_x, z_y = reference.along_x(pz), reference.along_y(pz)
        rest = x.path(tx, px, z_x) - x.path(x.still, px, z_x)
        rest = rest + y.path(ty, py, z_y) - y.path(y.still, py, z_y)
        radians, modulus = reference.residual_parts(tx - px, ty - py, pz, wavelength)
        return radians + 2 * pi / wavelength * rest, modulus

    places = x.places, y.places
    ends = [(float(t[0]), float(t[-1])) for t in places]
    box = clusters.bounding_box(by_curvature(cloud.positions))
    series = make_series(ends[0], ends[1], box, kernel, _SERIES * tolerance)
    if series is None or series.terms > _MOST_TERMS:
        return None
    real: type[np.floating] = np.float32 if tolerance >= _SINGLE else np.float64
    kind = np.result_type(real, np.complex64)
    strength = np.empty((series.terms, len(cloud)), dtype=kind)
    angles = [np.empty(len(cloud), dtype=real) for _ in range(2)]
    for first in range(0, len(cloud), _CHUNK):
        part = slice(first, first + _CHUNK)
        z = cloud.positions[part, 2]
        cycles = reference.start(z, wavelength) + cloud.phase[part] / (2 * pi)
        deeps = reference.along_x(z), reference.along_y(z)
        for side, p, deep, angle in zip(sides, cloud.positions[part].T[:2], deeps, angles,
                                        strict=True):  # fmt: skip
            turn, grid = side.turn(p, deep), side.grid
            # The transform counts places from the grid's middle.
            path = side.path(side.still, p, deep)
            path -= turn * (grid.first + grid.step * (grid.count // 2))
            cycles += path / wavelength
            angle[part] = turn * (-2 * pi * grid.step / wavelength)
        cycles -= np.rint(cycles)
        wave = phasors(2 * pi * cycles, cloud.amplitude[part] * reference.modulus(z)).astype(kind)
        factors = series.at_points(by_curvature(cloud.positions[part])).astype(real)
        np.multiply(factors, wave, out=strength[:, part])
    sums = transformed(angles, strength, (x.grid.count, y.grid.count), tolerance)
    weights = series.on_nodes(*places, real)
    plain = np.zeros(sums.shape[1:], dtype=kind)
    for term, one in enumerate(sums):
        cos, sin = weights.of(term)
        plain += one * (cos + 1j * sin).T
    return plain, series.dropped


def transformed(
    angles: list[Reals], strength: Complexes, shape: tuple[int, int], tolerance: float
) -> Complexes:
    """(L, n_x, n_y) Σ_j strength_j·exp(i(k·angle_x + l·angle_y)), k and l from the middle."""
    import finufft  # takes a while

    # One thread: several would add the points up in another order each time.
    plan = finufft.Plan(
        1, shape, n_trans=len(strength), eps=tolerance, isign=1, dtype=strength.dtype.name,
        nthreads=1, upsampfac=2.0,
    )  # fmt: skip
    plan.setpts(*angles)
    return np.asarray(plan.execute(strength)).reshape(len(strength), *shape)
