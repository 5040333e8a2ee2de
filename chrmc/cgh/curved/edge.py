"""The soft edge of a footprint as a filter over directions: strips without a sum over points.

At a place t of a strip a point's weight w depends on where its light comes from, and so does the
local frequency of its wave over the reference. A weight that depends on frequency is a filter:
the weighted baseband at t is a sum F·U of the plain one U at places around t. F is solved for in
least squares over waves from all of the object's box,

    min Σ_j |w_j(t)·e_j(t) − Σ_n F(t, n)·e_j(n)|²,   e_j the wave of a point at j,

which needs no expansion of the edge and says by what is left how good it is. What is left is that
a wave's frequency changes over the filter's length, and with the place across the strip.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import ceil, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.clusters import Plane
from chrmc.cgh.curved.nodes import Axis, Line
from chrmc.cgh.curved.predict import sample_points
from chrmc.cgh.curved.wave import Reference, axis_cycles, phasors
from chrmc.optics.footprint import SOFT_SHARE, taper
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]
Complexes = NDArray[np.complexfloating]

_BEYOND = 1.0  # of a soft edge's width, that a filter reads beyond its strip on either side
_DENSE = 1.3  # places for each that Nyquist asks for
_LEAST = 4.0  # the same in places
_FEWEST = 4.0  # places that a soft edge is read at, at least
_WAVES = 1.8  # waves for each place
_MOST = 2500  # places of a strip: solving for more takes longer than a sum over points
_SHARE = 0.75  # of the tolerance that filters may take; beyond it strips come from points
_NOISE = 0.3  # in the places, that a filter is made for, in shares of the tolerance


@dataclass(frozen=True, eq=False)
class Along:
    """Waves of points along one axis, over the separable reference wave.

    x, z : (N,) places of the points along the axis, and their depths
    far : of the reference, along the other axis
    reach : half-width of a footprint per depth
    centre, z_centre : of the reference, along the axis
    rest : places along the axis (N, n) or (n,), the points' (N, 1) x and z, to what is not
        separable, on some line across; None without it
    """

    x: Floats
    z: Floats
    far: float
    reach: float
    centre: float
    z_centre: float
    wavelength: float
    rest: Callable[[Floats, Floats, Floats], NDArray[np.complex128]] | None = None

    def cycles(self, t: Floats) -> Floats:
        """(N, len(t)) cycles of the waves at places t."""
        return axis_cycles(
            t, self.x, np.hypot(self.z, self.far), self.centre, self.z_centre, self.wavelength
        )

    def waves(self, t: Floats) -> NDArray[np.complex128]:
        """(N, len(t)) waves at places t."""
        cycles = self.cycles(t)
        out = phasors(2 * pi * (cycles - np.rint(cycles)))
        if self.rest is not None:
            out *= self.rest(t, self.x[:, None], self.z[:, None])
        return out

    def weights(self, t: Floats) -> Floats:
        """(N, len(t)) soft footprint."""
        return taper(t - self.x[:, None], (self.reach * self.z)[:, None])


@dataclass(frozen=True)
class Across:
    """The other axis: what is not separable grows with the square of the distance from the centre.

    lines : two places, for which filters are made
    centre : of the reference
    """

    lines: tuple[float, float]
    centre: float

    def shares(self, t: Floats) -> tuple[Floats, Floats]:
        """(n,) weights of either line's filter at places t."""
        near, far = ((line - self.centre) ** 2 for line in self.lines)
        if far - near <= 1e-9 * far:  # all targets on one line, as on a panel of one column
            return np.ones(len(t)), np.zeros(len(t))
        share = ((t - self.centre) ** 2 - near) / (far - near)
        return 1 - share, share


def across(targets: tuple[float, float], centre: float) -> Across:
    """Two lines on which the square of the distance is about that of most targets."""
    ends = [(end - centre) ** 2 for end in targets]
    least = 0.0 if targets[0] < centre < targets[1] else min(ends)
    side = 1.0 if ends[1] > ends[0] else -1.0
    away = [sqrt(least + part * (max(ends) - least)) for part in (0.1, 0.75)]
    return Across((centre + side * away[0], centre + side * away[1]), centre)


@dataclass(frozen=True, eq=False)
class Filter:
    """Some nodes of an axis from some places of the baseband.

    nodes, places : which
    matrices : (nodes, places) for two lines across; none where nodes and places are the same
    """

    nodes: slice
    places: slice
    matrices: tuple[Complexes, ...]


@dataclass(frozen=True, eq=False)
class Reading:
    """How the nodes of an axis are read off the plain baseband.

    places : (n,) metres, where it is needed
    filters : of all runs that are read
    across : the other axis
    """

    places: Floats
    filters: tuple[Filter, ...]
    across: Across

    def of(self, plain: Complexes, count: int, other: Floats) -> Complexes:
        """(count, m) values at the nodes from those at the places, (n, m).

        other : (m,) places along the other axis
        """
        if len(self.filters) == 1 and len(plain) == count and not self.filters[0].matrices:
            return plain
        out = np.zeros((count, *plain.shape[1:]), dtype=plain.dtype)
        shares = [share.astype(plain.real.dtype) for share in self.across.shares(other)]
        for one in self.filters:
            part = plain[one.places]
            if not one.matrices:
                out[one.nodes] = part
            for matrix, share in zip(one.matrices, shares, strict=False):
                out[one.nodes] += (matrix.astype(plain.dtype) @ part) * share
        return out

    def missed(self, axis: Axis, along: Along, other: Floats) -> Floats:
        """(N,) power of each point's error on the strips, over targets.

        other : (N,) where across it is tried
        """
        out = np.zeros(len(along.x))
        shares = self.across.shares(other)
        at_places = None
        for run in axis.runs:
            for one in self.filters:
                if one.nodes != run.nodes or not one.matrices:
                    continue
                if at_places is None:
                    at_places = along.waves(self.places)
                nodes = axis.nodes[one.nodes]
                error = along.waves(nodes) * along.weights(nodes)
                for matrix, share in zip(one.matrices, shares, strict=True):
                    error -= share[:, None] * (at_places[:, one.places] @ matrix.T)
                out += np.abs(error) ** 2 @ run.weight
        return out


def reading_of(
    axis: Axis, models: tuple[Along, Along], across: Across, smooth: bool, tolerance: float
) -> Reading | None:
    """The places that an axis's nodes need, and the filters from there; None for strips too long.

    models : the outermost points, on the two lines across; filters are made for all waves between
    smooth : leave the strips out
    """
    model = models[0]
    width = SOFT_SHARE * model.reach * float(model.z.min())
    strips = [run for run in axis.runs if run.tapered and not smooth]
    others = [run for run in axis.runs if not run.tapered]
    base = next((run.line for run in others if run.line is not None and run.line.count > 1), None)
    ends = [(float(axis.nodes[r.nodes].min()), float(axis.nodes[r.nodes].max())) for r in strips]
    places: list[Floats] = []
    filters: list[Filter] = []
    count = 0
    line: Line | None = None
    if base is not None and strips and base.step <= width / _FEWEST:
        # One line of places serves all runs.
        margin = max(_BEYOND * width, _LEAST * base.step)
        below = max(0, ceil((base.first - min(low for low, _ in ends) + margin) / base.step))
        last = base.first + base.step * (base.count - 1)
        above = max(0, ceil((max(high for _, high in ends) + margin - last) / base.step))
        line = Line(base.first - below * base.step, base.step, base.count + below + above)
        places.append(line.places)
        filters.append(Filter(others[0].nodes, slice(below, below + base.count), ()))
    else:
        for run in others:
            nodes = axis.nodes[run.nodes]
            places.append(nodes)
            filters.append(Filter(run.nodes, slice(count, count + len(nodes)), ()))
            count += len(nodes)
    for run, (low, high) in zip(strips, ends, strict=True):
        if line is not None:
            first, stop = np.searchsorted(line.places, (low - margin, high + margin))
            own = slice(max(0, int(first) - 1), min(line.count, int(stop) + 1))
            at = line.places[own]
        else:
            step = min(width / _FEWEST, 1 / (2 * _DENSE * _frequency(model, (low, high))))
            margin = max(_BEYOND * width, _LEAST * step)
            if (high - low + 2 * margin) / step > _MOST:
                return None
            at = np.arange(low - margin, high + margin + step, step)
            own = slice(count, count + len(at))
            places.append(at)
            count += len(at)
        if len(at) > _MOST:
            return None
        nodes = axis.nodes[run.nodes]
        filters.append(Filter(run.nodes, own, _solve(nodes, at, models, tolerance)))
    every = np.concatenate(places) if places else np.zeros(0)
    return Reading(every, tuple(filters), across)


def _frequency(model: Along, ends: tuple[float, float]) -> float:
    """Largest local frequency of the waves, cycles per metre."""
    t = np.array([*ends, sum(ends) / 2])
    step = 1e-3 * max(ends[1] - ends[0], 1e-9)
    return max(float(np.max(np.abs(model.cycles(t + step) - model.cycles(t)))) / step, 1e-3)


def _solve(
    nodes: Floats, places: Floats, models: tuple[Along, Along], tolerance: float
) -> tuple[Complexes, Complexes]:
    """(nodes, places) the filters of one strip on two lines across."""
    number = ceil(_WAVES * len(places)) + 10
    model = models[0]
    x = np.linspace(float(model.x.min()), float(model.x.max()), number)
    near, far = float(model.z.min()), float(model.z.max())
    # Either end of the depth by turns: a filter depends on it smoothly.
    z = np.where(np.arange(number) % 2, 0.9 * near + 0.1 * far, 0.1 * near + 0.9 * far)
    base = replace(model, x=x, z=z, rest=None)
    every = np.concatenate([places, nodes])
    waves, weights = base.waves(every), base.weights(nodes)
    noise = (_NOISE * tolerance) ** 2 * number
    out = []
    for one in models:
        assert one.rest is not None
        seen = waves * one.rest(every, x[:, None], z[:, None])
        given, wanted = seen[:, : len(places)], seen[:, len(places) :] * weights
        turned = given.conj().T
        among = turned @ given
        among[np.diag_indices(len(places))] += noise
        out.append(np.linalg.solve(among, turned @ wanted).T)
    return out[0], out[1]


@dataclass(frozen=True, eq=False)
class Readings:
    """How a cluster's nodes are read off its plain baseband.

    along : x, and y
    missed : expected power of the filters' error, and `light` what of it there is in all
    from_points : strips along x, along y that no filter is good enough for; they are left out
    """

    along: tuple[Reading, Reading]
    missed: float
    light: float
    from_points: tuple[bool, bool]


def readings_of(
    axes: tuple[Axis, Axis],
    reference: Reference,
    box: Floats,
    cloud: PointCloud,
    targets: tuple[Line, Line],
    plane: Plane,
    aim: float,
    scale: float = 1.0,
) -> Readings:
    """The readings along x and y, filters where the tolerance `aim` allows.

    box : (3, 2) of all points
    cloud : points on which filters are tried; their power is 1/scale of all
    """
    strength = scale * (cloud.amplitude * reference.modulus(cloud.positions[:, 2])) ** 2
    chosen, weight = sample_points(strength, cloud.positions)
    points = cloud.positions[chosen].T
    spots = [np.resize(axis.nodes[[0, len(axis.nodes) // 2, -1]], len(chosen)) for axis in axes]
    centres = (
        (reference.far_y, reference.x, reference.z_x),
        (reference.far_x, reference.y, reference.z_y),
    )
    light = [np.zeros(0)] * 2
    tried: list[Along] = []
    for i, (far, middle, z_middle) in enumerate(centres):
        rest = _rest(reference, i, spots[1 - i][:, None], points[1 - i][:, None], plane.wavelength)
        common = far, plane.reach[i], middle, z_middle, plane.wavelength
        tried.append(Along(points[i], points[2], *common, rest))
        some = targets[i].places[:: max(1, targets[i].count // 64)]
        light[i] = np.mean(tried[i].weights(some) ** 2, axis=1) * targets[i].count
    total = float(weight @ (light[0] * light[1]))
    allowed = (_SHARE * aim) ** 2 / 2 * total
    along: list[Reading] = []
    missed, from_points = 0.0, []
    for i, own in enumerate(tried):
        other = centres[1 - i][1]
        aside = across(axes[1 - i].span, other)
        corners = np.array([(at, deep) for at in box[i] for deep in box[2]]).T
        models = tuple(
            replace(
                own, x=corners[0], z=corners[1],
                rest=_rest(reference, i, np.array(line), np.array(other), plane.wavelength),
            )
            for line in aside.lines
        )  # fmt: skip
        reading = reading_of(axes[i], (models[0], models[1]), aside, False, aim)
        power = np.inf
        if reading is not None:
            power = float(weight @ (reading.missed(axes[i], own, spots[1 - i]) * light[1 - i]))
        from_points.append(power > allowed)
        if power > allowed:
            reading = reading_of(axes[i], (models[0], models[1]), aside, True, aim)
            power = 0.0
        assert reading is not None  # without strips there is nothing too long
        along.append(reading)
        missed += power
    return Readings((along[0], along[1]), missed, total, (from_points[0], from_points[1]))


def _rest(
    reference: Reference, axis: int, line: Floats, place: Floats, wavelength: float
) -> Callable[[Floats, Floats, Floats], NDArray[np.complex128]]:
    """What is not separable along an axis, on a line across it, of points at a place across."""

    def rest(t: Floats, x: Floats, z: Floats) -> NDArray[np.complex128]:
        offsets = (t - x, line - place) if axis == 0 else (line - place, t - x)
        return reference.residual(*offsets, z, wavelength)

    return rest
