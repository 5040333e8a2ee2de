"""One object's frames from its light on a sphere of directions."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.interface import (
    Axes,
    Axis,
    Budget,
    Factor,
    Plane,
    Reference,
    Remainder,
    bounding_box,
    budget_of,
    fewer,
    fewer_beyond,
    in_parallel,
    part_of,
    phasor,
    reference_cycles,
    sum_points,
)
from chrmc.compensation.ch_rmc_object.chart import mean_rotation
from chrmc.compensation.ch_rmc_object.grid import SHARE, make_grid
from chrmc.compensation.ch_rmc_object.plan import Outline, Plan, views_ahead
from chrmc.compensation.ch_rmc_object.sphere import Sphere
from chrmc.record import FrameRecord
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Pose

Floats = NDArray[np.float64]
Complexes = NDArray[np.complexfloating]


@dataclass(frozen=True)
class Count:
    """What a frame took.

    appeared, vanished : points
    soft : pixels of strips summed from the points
    directions : points summed in directions that no frame had needed before
    """

    appeared: int = 0
    vanished: int = 0
    soft: int = 0
    directions: int = 0


class Group:
    """One object's light on the sphere, and the frames looked up from it."""

    def __init__(
        self,
        first: Plan,
        outline: Outline,
        poses: Sequence[Pose],
        parts: tuple[int, int, int],
        plane: Plane,
        tolerance: float,
    ) -> None:
        self.body = body = outline.body
        self._plane, self._tolerance = plane, tolerance
        self._middle = outline.middle
        self._to_chart = mean_rotation(poses)
        own = (body.positions - self._middle) @ self._to_chart.T
        part, centres, self._half = cut(own, parts)
        z = min(float(pose.apply(self._middle[None])[0, 2]) for pose in poses)
        more = fewer_beyond(float(self._half[:2].max()) / z / plane.wavelength, SHARE * tolerance)
        views = views_ahead(
            first, outline, poses, self._to_chart, np.abs(centres).max(axis=0), plane,
            more if len(centres) > 1 else 0.0,
        )  # fmt: skip
        width = tuple(float(np.max(high - low)) for low, high in (views.alpha, views.beta))
        grid = make_grid(
            self._half, views.until(len(poses)), (width[0], width[1]), plane.wavelength, tolerance
        )
        points = PointCloud(own, body.amplitude, body.phase)
        self.sphere = Sphere(points, part, centres, self._half, grid, plane.wavelength, tolerance)
        self._visible = np.zeros(len(own), dtype=bool)
        self.count = Count()

    def factor(self, plan: Plan, record: FrameRecord) -> tuple[Factor, Budget]:
        """A frame's low-rank factor and its expected error. Raises NotCovered."""
        obj, wave, axes = plan.obj, plan.wave, plan.axes
        pose = obj.pose
        assert pose is not None and obj.ids is not None
        with record.stage("PE"):
            visible = np.zeros(len(self._visible), dtype=bool)
            visible[obj.ids] = True
            appeared = int(np.count_nonzero(visible & ~self._visible))
            vanished = int(np.count_nonzero(self._visible & ~visible))
        with record.stage("RMC"):
            values = self._baseband(pose, plan, visible)
        with record.stage("EC"):
            soft = self._strips(plan, values)
        with record.stage("PA"):
            factor = Factor(
                *axes, wave.reference, np.ascontiguousarray(values.real, dtype=np.float32),
                np.ascontiguousarray(values.imag, dtype=np.float32),
            )  # fmt: skip
            read = self.sphere.expected_error(visible)
            taps = 2 * (SHARE * self._tolerance) ** 2 if len(self.sphere.centres) > 1 else 0.0
            places = self._plane.x.places, self._plane.y.places
            budget = budget_of(
                factor, plan.some, places, wave, Remainder(None, sqrt(read**2 + taps))
            )
            budget = Budget(plan.scale * budget.error + plan.missed, budget.light)
        self.count = Count(appeared, vanished, soft, self.sphere.taken())
        self._visible = visible
        return factor, budget

    def _baseband(self, pose: Pose, plan: Plan, visible: NDArray[np.bool_]) -> Complexes:
        """(n_y, n_x) the baseband at the nodes, strips that are left to points being zero."""
        (along_x, along_y), (axis_x, axis_y) = plan.readings, plan.axes
        if not len(along_x.places) or not len(along_y.places):
            return np.zeros((len(axis_y.nodes), len(axis_x.nodes)), dtype=np.complex64)
        plain = self._plain(pose, plan.wave.reference, along_x.places, along_y.places, visible)
        wide = along_x.of(plain, len(axis_x.nodes), along_y.places)
        return along_y.of(np.ascontiguousarray(wide.T), len(axis_y.nodes), axis_x.nodes)

    def _plain(
        self,
        pose: Pose,
        reference: Reference,
        x: Floats,
        y: Floats,
        visible: NDArray[np.bool_],
    ) -> Complexes:
        """(len(x), len(y)) the baseband without footprints."""
        sphere, wavelength = self.sphere, self._plane.wavelength
        centre = pose.apply(self._middle[None])[0]
        turn = self._to_chart @ pose.rotation.T
        offsets = sphere.centres @ turn
        places = centre + offsets
        few_x, few_y = x, y
        to_x = to_y = None
        if len(places) > 1:
            half = np.abs(turn.T) @ self._half
            few_x, to_x = self._fewer(x, 0, places, half)
            few_y, to_y = self._fewer(y, 1, places, half)
        m = sphere.look_up(turn, centre, few_x, few_y, visible)
        z = places[:, 2]
        # The same split for every part: its wave is a product along x and y, a start and a rest.
        dx, dy = few_x - places[:, :1], few_y - places[:, 1:2]
        radians, modulus = reference.residual_parts(
            dx[:, :, None], dy[:, None, :], z[:, None, None], wavelength
        )
        start = 2 * pi * reference.start(z, wavelength)
        scale = (reference.modulus(z) * np.exp(1j * start)).astype(m.dtype)[:, None, None]
        radians = radians.astype(m.real.dtype)
        rest = np.empty_like(m)
        np.cos(radians, out=rest.real)
        np.sin(radians, out=rest.imag)
        rest *= modulus.astype(m.real.dtype)
        m *= rest
        m *= scale
        if to_x is None or to_y is None:
            return m[0]
        along_x, along_y = (
            _turns(t, places[:, i], distances(z), own, distances(centre[2:])[0], wavelength)
            for i, (t, distances, own) in enumerate(
                ((x, reference.along_x, centre[0]), (y, reference.along_y, centre[1]))
            )
        )
        return _carried(m, to_x, to_y, along_x, along_y)

    def _fewer(self, t: Floats, axis: int, places: Floats, half: Floats) -> tuple[Floats, Floats]:
        """Places that parts are looked up at, and the matrix from them to `t`."""
        low, high = float(t.min()), float(t.max())
        z = float(places[:, 2].min()) - half[2]
        off = max(abs(low - places[:, axis].max()), abs(high - places[:, axis].min())) + half[axis]
        # sin of the direction, ∂(Δ·d)/∂t: Δ over z, and Δ in depth by the slope.
        frequency = 1.03 * (half[axis] / z + half[2] * off / z**2) / self._plane.wavelength
        return fewer(t, frequency, SHARE * self._tolerance)

    def _strips(self, plan: Plan, values: Complexes) -> int:
        """Sum strips from the points where no filter is good enough; pixels that takes."""
        axes = plan.axes
        (soft_x, at_x), (smooth_x, inner) = (part_of(axes[0], tapered) for tapered in (True, False))
        soft_y, at_y = part_of(axes[1], True)
        works: list[tuple[Axes, NDArray[np.intp], NDArray[np.intp]]] = []
        if plan.from_points[0]:
            works.append(((soft_x, axes[1]), np.arange(len(axes[1].nodes)), at_x))
        if plan.from_points[1]:
            wide, columns = axes[0], np.arange(len(axes[0].nodes))
            if plan.from_points[0]:
                wide, columns = smooth_x, inner
            works.append(((wide, soft_y), at_y, columns))
        soft = 0
        for (along_x, along_y), rows, columns in works:
            if len(rows) and len(columns):
                reference = plan.wave.reference
                real, imag, _ = sum_points(
                    plan.obj.cloud, (along_x, along_y), reference, self._plane, plan.aim
                )
                values[np.ix_(rows, columns)] = real + 1j * imag
        pixels_x, pixels_y = (_pixels(axis) for axis in axes)
        if plan.from_points[0]:
            soft += _pixels(axes[0], True) * pixels_y
            pixels_x -= _pixels(axes[0], True)
        if plan.from_points[1]:
            soft += pixels_x * _pixels(axes[1], True)
        return soft


def _pixels(axis: Axis, tapered: bool = False) -> int:
    """Targets that are read from an axis's nodes, or from those of its strips."""
    runs = [run for run in axis.runs if run.tapered or not tapered]
    return sum(block.target_count for run in runs for block in axis.blocks_of(run))


def cut(own: Floats, parts: tuple[int, int, int]) -> tuple[NDArray[np.intp], Floats, Floats]:
    """Each point's part, the parts' centres (P, 3), and the largest offset from them (3,)."""
    if parts == (1, 1, 1):
        return np.zeros(len(own), dtype=np.intp), np.zeros((1, 3)), np.abs(own).max(axis=0)
    low, high = bounding_box(own).T
    cell = np.zeros(len(own), dtype=np.intp)
    for axis, number in enumerate(parts):
        if number > 1 and high[axis] > low[axis]:
            place = (own[:, axis] - low[axis]) / (high[axis] - low[axis])
            cell = cell * number + np.minimum((place * number).astype(np.intp), number - 1)
    _, part = np.unique(cell, return_inverse=True)
    count = int(part.max()) + 1
    ends = []
    for least in (np.minimum, np.maximum):
        end = np.full((count, 3), np.inf if least is np.minimum else -np.inf)
        least.at(end, part, own)
        ends.append(end)
    centres = (ends[0] + ends[1]) / 2
    return part, centres, np.max(ends[1] - centres, axis=0)


def _turns(
    t: Floats, places: Floats, z: Floats, own: float, z_own: float, wavelength: float
) -> NDArray[np.complex64]:
    """(P, len(t)) the parts' reference waves along an axis over the object's own."""
    mine = reference_cycles(t, own, z_own, wavelength)
    every = zip(places.tolist(), z.tolist(), strict=True)
    cycles = np.stack([reference_cycles(t, at, deep, wavelength) - mine for at, deep in every])
    cos, sin = phasor(cycles)
    return (cos + 1j * sin).astype(np.complex64)


def _carried(
    m: Complexes, to_x: Floats, to_y: Floats, along_x: Complexes, along_y: Complexes
) -> Complexes:
    """Σ_p (along_x_p∘to_x)·m_p·(along_y_p∘to_y)ᵀ, (n_x, n_y), in two real products."""
    parts, _, few = m.shape
    real = m.real.dtype
    left = np.moveaxis(m, 0, 1).reshape(m.shape[1], -1).view(real)
    both = along_y[:, None, :] * to_y.T.astype(real)
    right = np.empty((parts * few, 2, to_y.shape[0], 2), dtype=real)
    flat = both.reshape(parts * few, -1)
    right[:, 0, :, 0] = right[:, 1, :, 1] = flat.real
    right[:, 0, :, 1] = flat.imag
    np.multiply(flat.imag, real.type(-1), out=right[:, 1, :, 0])
    right = right.reshape(2 * parts * few, -1)
    matrix = to_x.astype(real)
    out = np.empty((len(to_x), to_y.shape[0]), dtype=m.dtype)

    def some(rows: slice) -> None:
        wide = (matrix[rows] @ left).view(m.dtype).reshape(-1, parts, few)
        wide *= along_x.T[rows, :, None]
        out[rows] = (wide.reshape(len(wide), -1).view(real) @ right).view(m.dtype)

    cuts = np.linspace(0, len(to_x), 5).astype(int)
    in_parallel(some, [slice(a, b) for a, b in pairwise(cuts) if b > a])
    return out
