"""The soft edge of a footprint as a filter over directions: strips without a sum over points.

At a place t of a strip a point's weight w depends on where its light comes from, and so does the
local frequency of its wave over the reference. A weight that depends on frequency is a filter:
the weighted baseband at t is a sum F·U of the plain one U at places around t. F is solved for in
least squares over waves from all of the object's box,

    min Σ_j |w_j(t)·e_j(t) − Σ_n F(t, n)·e_j(n)|²,   e_j the wave of a point at j,

which needs no expansion of the edge and says by what is left how good it is. What is left is that
a wave's frequency changes over the filter's length, and with the place across the strip.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.along import Across, Along, across, rest_along, waves_along
from chrmc.cgh.curved.clusters import Plane
from chrmc.cgh.curved.nodes import Axis, Line, Run
from chrmc.cgh.curved.predict import sample_points, spots_of
from chrmc.cgh.curved.wave import Reference, Wave
from chrmc.optics.footprint import SOFT_SHARE
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]
Complexes = NDArray[np.complexfloating]

_BEYOND = 1.0  # of a soft edge's width, that a filter reads beyond its strip on either side
_DENSE = 1.3  # places for each that Nyquist asks for
_LEAST = 4.0  # the same in places
_FEWEST = 4.0  # places that a soft edge is read at, at least
_WAVES = 1.8  # waves for each place
_WHOLE = 120  # places that are solved for at once
_ASIDE = 1.25  # of the margin, that filters of a part of a strip read beyond it
_MOST = 2500  # places of a strip: finding filters for more takes longer than a sum over points
_MOST_WORK = 2e9  # third powers of places that a strip's filters are solved from: a second or two
_SHARE = 0.75  # of the tolerance that filters may take; beyond it strips come from points
_ROUNDING = 1e-6  # noise below which the equations are no longer sure to be solved
_NOISE = 0.3  # in the places, that a filter is made for, in shares of the tolerance


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


Missed = Callable[[Run, slice, Floats, tuple[Complexes, ...]], float]
"""A run, nodes of it, places that filters read and the filters → expected power of their error."""


def reading_of(
    axis: Axis,
    models: tuple[Along, Along],
    across: Across,
    tolerance: float,
    missed: Missed | None,
    allowed: float = np.inf,
) -> tuple[Reading, float] | None:
    """The places that an axis's nodes need, the filters from there, and what these miss.

    models : the outermost points, on the two lines across; filters are made for all waves between
    missed : None leaves the strips out
    allowed : of what is missed

    None for strips too long, and as soon as filters miss more than is allowed.
    """
    spent = 0.0
    model = models[0]
    width = SOFT_SHARE * model.reach * float(model.z.min())
    strips = [run for run in axis.runs if run.tapered and missed is not None]
    others = [run for run in axis.runs if not run.tapered]
    base = next((run.line for run in others if run.line.count > 1), None)
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
        assert missed is not None
        windows = list(_windows(nodes, at, margin))
        if sum((near.stop - near.start) ** 3 for _, near in windows) > _MOST_WORK:
            return None
        for few, near in windows:
            matrices = _solve(nodes[few], at[near], models, tolerance)
            spent += missed(run, few, at[near], matrices)
            if spent > allowed:
                return None
            filters.append(Filter(_moved(few, run.nodes.start), _moved(near, own.start), matrices))
    every = np.concatenate(places) if places else np.zeros(0)
    return Reading(every, tuple(filters), across), spent


def _moved(part: slice, by: int) -> slice:
    return slice(part.start + by, part.stop + by)


def _windows(nodes: Floats, places: Floats, margin: float) -> Iterator[tuple[slice, slice]]:
    """Nodes, and the places that their filters read: all of a short strip, of a long one those
    around, since solving takes the third power of them."""
    count = ceil(len(places) / _WHOLE)
    cuts = np.searchsorted(nodes, np.linspace(nodes[0], nodes[-1], count + 1)[1:-1])
    for start, stop in pairwise([0, *cuts.tolist(), len(nodes)]):
        if start < stop:
            ends = nodes[start] - _ASIDE * margin, nodes[stop - 1] + _ASIDE * margin
            first, last = np.searchsorted(places, ends)
            yield slice(start, stop), slice(max(0, int(first) - 1), min(len(places), int(last) + 1))


def _frequency(model: Along, ends: tuple[float, float]) -> float:
    """Largest local frequency of the waves, cycles per metre."""
    t = np.array([*ends, sum(ends) / 2])
    step = 1e-3 * max(ends[1] - ends[0], 1e-9)
    return max(float(np.max(np.abs(model.cycles(t + step) - model.cycles(t)))) / step, 1e-3)


def _solve(
    nodes: Floats, places: Floats, models: tuple[Along, Along], tolerance: float
) -> tuple[Complexes, Complexes]:
    """(nodes, places) the filters of one strip on two lines across."""
    from scipy.linalg import solve  # takes a while

    number = ceil(_WAVES * len(places)) + 10
    model = models[0]
    x = np.linspace(float(model.x.min()), float(model.x.max()), number)
    near, far = float(model.z.min()), float(model.z.max())
    # Either end of the depth by turns: a filter depends on it smoothly.
    z = np.where(np.arange(number) % 2, 0.9 * near + 0.1 * far, 0.1 * near + 0.9 * far)
    base = replace(model, x=x, z=z, rest=None)
    every = np.concatenate([places, nodes])
    waves, weights = base.waves(every), base.weights(nodes)
    noise = max(_NOISE * tolerance, _ROUNDING) ** 2 * number
    out = []
    for one in models:
        assert one.rest is not None
        seen = waves * one.rest(every, x[:, None], z[:, None])
        given, wanted = seen[:, : len(places)], seen[:, len(places) :] * weights
        turned = given.conj().T
        among = turned @ given
        among[np.diag_indices(len(places))] += noise
        out.append(solve(among, turned @ wanted, assume_a="pos", check_finite=False).T)
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
    spots = [spots_of(axes[i], points[i], plane.reach[i] * points[2]) for i in range(2)]
    light = [np.zeros(0)] * 2
    wave = Wave(reference, plane.wavelength, plane.reach)
    tried = [waves_along(wave, i, points, spots[1 - i]) for i in range(2)]
    for i in range(2):
        line = plane.lines[i]
        some = line.places[:: max(1, line.count // 64)]
        light[i] = np.mean(tried[i].weights(some) ** 2, axis=1) * line.count
    total = float(weight @ (light[0] * light[1]))
    allowed = (_SHARE * aim) ** 2 / 2 * total
    along: list[Reading] = []
    missed, from_points = 0.0, []
    for i, own in enumerate(tried):
        other = tried[1 - i].centre
        aside = across(axes[1 - i].span, other)
        corners = np.array([(at, deep) for at in box[i] for deep in box[2]]).T
        models = tuple(
            replace(
                own, x=corners[0], z=corners[1],
                rest=rest_along(reference, i, np.array(line), np.array(other), plane.wavelength),
            )
            for line in aside.lines
        )  # fmt: skip
        shares = aside.shares(spots[1 - i])

        def power(
            run: Run, nodes: slice, places: Floats, matrices: tuple[Complexes, ...],
            i: int = i, own: Along = own, shares: tuple[Floats, Floats] = shares,
        ) -> float:  # fmt: skip
            at = axes[i].nodes[run.nodes][nodes]
            error, given = own.waves(at) * own.weights(at), own.waves(places)
            for matrix, part in zip(matrices, shares, strict=True):
                error -= part[:, None] * (given @ matrix.T)
            return float(weight @ (np.abs(error) ** 2 @ run.weight[nodes] * light[1 - i]))

        both = models[0], models[1]
        reading = reading_of(axes[i], both, aside, aim, power, allowed)
        from_points.append(reading is None)
        if reading is None:
            reading = reading_of(axes[i], both, aside, aim, None)
        assert reading is not None  # without strips there is nothing too long
        along.append(reading[0])
        missed += reading[1]
    return Readings((along[0], along[1]), missed, total, (from_points[0], from_points[1]))
