"""Few points in place of very many that lie close together, with the same light.

Over a small box the wave of a point is a smooth function of its place, once a plane wave is taken
out. It is read off Chebyshev nodes in the box, so all points of the box together are as many
points as there are nodes, each with what its polynomial gathers:

    Σ_j s_j·g(P_j) ≈ Σ_a g(P_a)·Σ_j s_j·L_a(P_j)

Soft edges are part of g: their kinks ask for close nodes.
"""

from dataclasses import dataclass
from itertools import product
from math import ceil, inf, lgamma, log, pi, prod

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved import clusters
from chrmc.cgh.curved.chebyshev import chebyshev, interpolation, node_count
from chrmc.cgh.curved.clusters import Plane
from chrmc.cgh.curved.nodes import Axis
from chrmc.cgh.curved.wave import phasors
from chrmc.optics.footprint import SOFT_SHARE
from chrmc.parallel import in_parallel
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

SHARE = 0.1  # of the tolerance
_KINK = 0.2  # rms error at an edge over (distance of nodes/width of the edge)²: measured
_MANY = 20_000  # points that are worth it
_MOST = 5000  # nodes of a box
# In multiply-adds of a matrix product, as measured: for each point itself, an entry of a table, a
# pair of them along y and z, a node of its box; what a point takes that is transformed.
_POINT, _ENTRY, _PAIR, _PRODUCT, _TRANSFORMED = 1e4, 300.0, 190.0, 8.0, 4e4
_WORTH = 0.7  # of the work, that must be left
_TIGHT, _DOUBLE = 5e-5, 2.0  # tolerances in double precision, and what that takes more
_READ = 3e-4  # tolerances that filters, hence transforms, serve
_BOXES = (1, 2, 4, 8, 16, 32, 64, 128, 256)
_CHUNK = 1 << 14  # points gathered at once


@dataclass(frozen=True)
class Condensing:
    """How a cloud is condensed.

    boxes : into how many it is cut along x, y, z
    nodes : of a box
    carrier : cycles per metre along x, y, z of the plane wave that is taken out
    """

    boxes: tuple[int, int, int]
    nodes: tuple[int, int, int]
    carrier: tuple[float, float, float]

    @property
    def count(self) -> int:
        """Nodes in all."""
        return prod(self.boxes) * self.per_box

    @property
    def each(self) -> float:
        """Multiply-adds of a matrix product, about, in the time that a point takes."""
        entries = _ENTRY * sum(self.nodes) + _PAIR * self.nodes[1] * self.nodes[2]
        return _POINT + entries + _PRODUCT * self.per_box

    @property
    def per_box(self) -> int:
        """Nodes of a box."""
        return prod(self.nodes)


def condensing_of(
    box: Floats, count: int, axes: tuple[Axis, Axis], plane: Plane, tolerance: float
) -> Condensing | None:
    """The way that takes least; None where summing the points as they are takes no more.

    box : (3, 2) of `count` points
    axes : the nodes that they are summed at
    """
    if count < _MANY or _grazing(box, plane):
        return None
    carrier, swings = _slopes(box, plane)
    closest = _closest(box, plane, SHARE * tolerance)
    sizes = np.ptp(box, axis=1).tolist()
    ways = [
        _along(size, swing, close, SHARE * tolerance / 2)
        for size, swing, close in zip(sizes, swings, closest, strict=True)
    ]
    each = clusters.cost_at(axes, box, count, plane, tolerance) / count
    if tolerance < _TIGHT:
        each *= _DOUBLE
    elif tolerance > _READ:
        each = min(each, _TRANSFORMED)
    best, chosen = _WORTH * each * count, None
    for x, y, z in product(*ways):
        way = Condensing((x[0], y[0], z[0]), (x[1], y[1], z[1]), carrier)
        work = count * way.each + way.count * each
        if way.per_box <= _MOST and work < best:
            best, chosen = work, way
    return chosen


def _along(size: float, swing: float, close: float, tolerance: float) -> list[tuple[int, int]]:
    """Numbers of boxes along an axis, and of nodes in each."""
    ways: list[tuple[int, int]] = []
    for boxes in _BOXES:
        # Nodes in a box's middle lie π/2 times as far apart as on the average.
        nodes = max(_nodes(swing / boxes, tolerance), ceil(pi / 2 * size / boxes / close))
        ways.append((boxes, nodes if size > 0 else 1))
        if size <= 0 or nodes <= 2:
            break
    return ways


def condensed(cloud: PointCloud, way: Condensing) -> PointCloud:
    """The cloud's light from few points."""
    box = clusters.bounding_box(cloud.positions)
    middle = box.mean(axis=1)
    carrier = np.array(way.carrier)
    parts = clusters.leaves(cloud, box, way.boxes)
    tasks = [
        (number, slice(first, first + _CHUNK))
        for number, part in enumerate(parts)
        for first in range(0, len(part), _CHUNK)
    ]
    boxes = [clusters.bounding_box(part.positions) for part in parts]

    def gather(task: tuple[int, slice]) -> Complexes:
        part = parts[task[0]].select(task[1])
        away = (part.positions - middle) @ carrier
        cycles = part.phase / (2 * pi) + away
        wave = phasors(2 * pi * (cycles - np.rint(cycles)), part.amplitude)
        tables = [
            _polynomials(part.positions[:, axis], boxes[task[0]][axis], way.nodes[axis])
            for axis in range(3)
        ]
        across = (tables[1][:, :, None] * tables[2][:, None, :]).reshape(len(part), -1)
        both = np.concatenate([across * wave.real[:, None], across * wave.imag[:, None]], axis=1)
        real, imag = np.split(tables[0].T @ both, 2, axis=1)
        return np.asarray(real + 1j * imag).reshape(way.nodes)

    sums = in_parallel(gather, tasks)
    places, waves = [], []
    for number, own in enumerate(boxes):
        axes = [
            (low + high) / 2 + (high - low) / 2 * chebyshev(n)
            for (low, high), n in zip(own.tolist(), way.nodes, strict=True)
        ]
        places.append(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3))
        whole = sum(one for (i, _), one in zip(tasks, sums, strict=True) if i == number)
        waves.append(np.asarray(whole).ravel())
    positions, strength = np.concatenate(places), np.concatenate(waves)
    cycles = (positions - middle) @ carrier
    phase = np.angle(strength) - 2 * pi * (cycles - np.rint(cycles))
    return PointCloud(positions, np.abs(strength), phase)


def _polynomials(values: Floats, ends: Floats, count: int) -> Floats:
    """(N, count) of Lagrange at Chebyshev nodes."""
    low, high = ends.tolist()
    if high <= low:
        out = np.zeros((len(values), count))
        out[:, 0] = 1.0
        return out
    return interpolation(count, (2 * values - low - high) / (high - low))


def _slopes(box: Floats, plane: Plane) -> tuple[tuple[float, float, float], list[float]]:
    """The carrier, and what is left of a wave's change over half the box along x, y, z: radians,
    and shares of its modulus."""
    near, far = box[2].tolist()
    ranges = []
    for axis, line in enumerate(plane.lines):
        reach = far * plane.reach[axis]
        low, high = line.first - box[axis, 1], line.last - box[axis, 0]
        ranges.append((max(low, -reach), min(high, reach)))
    aside = [max(abs(low), abs(high)) for low, high in ranges]
    inside = [max(low, -high, 0.0) for low, high in ranges]
    steep = []
    for axis, ends in enumerate(ranges):
        across = inside[1 - axis], aside[1 - axis]
        sines = [d / np.hypot(np.hypot(d, z), a) for d in ends for z in (near, far) for a in across]
        steep.append((-max(sines), -min(sines)))
    cosines = [z / np.hypot(np.hypot(*some), z) for some in (aside, inside) for z in (near, far)]
    steep.append((min(cosines), max(cosines)))
    carrier = [(low + high) / 2 / plane.wavelength for low, high in steep]
    swings = [
        size / 2 * (pi * (high - low) / plane.wavelength + 1 / near)
        for size, (low, high) in zip(np.ptp(box, axis=1).tolist(), steep, strict=True)
    ]
    return (carrier[0], carrier[1], carrier[2]), swings


def _closest(box: Floats, plane: Plane, tolerance: float) -> list[float]:
    """Metres along x, y, z that nodes may lie apart for the soft edges."""
    closest = [inf, inf, inf]
    near = float(box[2, 0])
    for axis, (line, reach) in enumerate(zip(plane.lines, plane.reach, strict=True)):
        flat = (1 - SOFT_SHARE) * near * reach
        if box[axis, 1] - flat <= line.first and box[axis, 0] + flat >= line.last:
            continue  # no edge falls on the plane
        width, lit = SOFT_SHARE * near * reach, clusters.lit(box, plane)[axis]
        close = (tolerance * width**2 * lit**0.5 / _KINK) ** 0.4
        closest[axis] = min(close, width / 2)
        closest[2] = min(closest[2], closest[axis] / reach)
    return closest


def _grazing(box: Floats, plane: Plane) -> bool:
    """Whether the plane lies where footprints fade: with less light errors would count more."""
    for axis, (line, reach) in enumerate(zip(plane.lines, plane.reach, strict=True)):
        away = max(line.first - box[axis, 0], box[axis, 1] - line.last, 0.0)
        if away > (1 - 2 * SOFT_SHARE) * box[2, 0] * reach:
            return True
    return False


def _nodes(kappa: float, tolerance: float) -> int:
    """Chebyshev nodes for waves of up to ±kappa radians: few of them where that is little."""
    most = node_count(kappa, tolerance)
    if kappa > 2 * _MOST:
        return most
    # The bound falls from κ/2 on.
    for few in range(max(1, int(kappa / 2)), most):
        if few * log(max(kappa / 2, 1e-300)) - lgamma(few + 1) <= log(tolerance / 2):
            return few
    return most
