"""A key group: frames of one object that share its baseband on the sphere."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.interface import (
    Axes,
    Axis,
    Budget,
    Factor,
    Line,
    Plane,
    Reference,
    Remainder,
    Summed,
    Wave,
    alone,
    bounding_box,
    budget_of,
    cluster_axes,
    part_of,
    reference_at,
    run_all,
    series_for,
    sum_points,
)
from chrmc.compensation.ch_rmc_object.sphere import Sphere, View, coordinates, grid_shape
from chrmc.compensation.ledger import FrameRecord
from chrmc.optics.footprint import SOFT_SHARE
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import ObjectFrame, Pose

Floats = NDArray[np.float64]
Span = tuple[float, float]

MOST_VALUES = 60_000_000
"""Complex numbers that a baseband on the sphere may hold: 480 MB."""
_TILT, _AZIMUTH, _ELEVATION = 1.0, 1.2, 1.0  # where the grid of directions ends
_MANY = 3000  # points from which sub-clusters have a series each
_FOLD = 0.5  # changed points, in shares of the key frame's, from which the grid takes them in


@dataclass(frozen=True)
class _Count:
    """Points that appeared and vanished, and pixels of strips summed from the points."""

    appeared: int
    vanished: int
    soft: int


@dataclass(frozen=True, eq=False)
class _Plan:
    """A frame's reference wave and nodes, at some tolerance."""

    thing: ObjectFrame
    aim: float
    reference: Reference
    axes: Axes

    @property
    def spans(self) -> tuple[Span, Span] | None:
        """The rectangle of nodes that the sphere is looked up at; None without one."""
        parts = [part_of(axis, False)[0] for axis in self.axes]
        return None if any(len(p.nodes) == 0 for p in parts) else (parts[0].span, parts[1].span)

    def beyond(self, targets: tuple[Line, Line]) -> tuple[float, float]:
        """Metres that nodes may lie beyond the targets, with room for other frames."""
        out = []
        for axis, line in zip(self.axes, targets, strict=True):
            far = 0.0
            places = line.places
            for run in axis.runs:
                if not run.tapered:
                    blocks = axis.blocks_of(run)
                    nodes = axis.nodes[run.nodes]
                    first = places[blocks[0].targets.start]
                    last = places[blocks[-1].targets.stop - 1]
                    far = max(far, first - nodes.min(), nodes.max() - last)
            out.append(1.3 * float(far) + line.step)
        return out[0], out[1]


class Group:
    """One object's baseband on the sphere, made once and looked up for every frame it covers.

    The sphere holds a set of the body's points. Points that appeared or vanished since are added
    to or taken from the baseband at the frame's nodes; when they are many, from the sphere itself.
    Where a footprint's soft edge crosses the hologram the weight of a point changes with its
    place, which no rotation carries along: those strips are summed from the points.
    """

    def __init__(
        self,
        thing: ObjectFrame,
        ahead: Sequence[Pose],
        targets: tuple[Line, Line],
        plane: Plane,
        tolerance: float,
    ) -> None:
        assert thing.body is not None and thing.ids is not None and thing.pose is not None
        self._body = thing.body
        self._targets, self._plane, self._tolerance = targets, plane, tolerance
        positions = self._body.positions
        self._middle = (positions.min(axis=0) + positions.max(axis=0)) / 2
        own = positions - self._middle
        self._axes = thing.pose.rotation
        self._size = float(np.linalg.norm(own, axis=1).max())
        self._plan: _Plan | None = None
        self._beyond = self._planned(thing, tolerance).beyond(targets)
        poses = self._within_reach([thing.pose, *ahead])
        self._axes = _mean_rotation([pose.rotation for pose in poses])
        views = [self._view(pose) for pose in poses]
        view = views[0]
        for other in views[1:]:
            view = view.union(other)
        own = own @ self._axes.T
        radius = float(np.hypot(own[:, 0], own[:, 2]).max()), float(np.abs(own[:, 1]).max())
        self._own = PointCloud(own, self._body.amplitude, self._body.phase)
        self._sphere = Sphere.empty(radius, view, plane.wavelength, tolerance)
        self._held = np.zeros(len(own), dtype=bool)
        self._count = _Count(0, 0, 0)

    @property
    def size(self) -> int:
        """Complex numbers on the sphere."""
        return self._sphere.values.size

    @alone
    def fill(self, thing: ObjectFrame) -> None:
        """Sum the key frame's visible points onto the sphere."""
        assert thing.ids is not None
        self._held[thing.ids] = True
        self._sphere.add(self._own.select(thing.ids))

    @alone
    def covers(self, thing: ObjectFrame, aim: float) -> bool:
        """A frame's directions and ranges, at the nodes of a tolerance, are on the sphere."""
        if thing.body is not self._body or thing.pose is None:
            return False
        spans = self._planned(thing, aim).spans
        return spans is None or self._sphere.view.covers(self._seen(thing.pose, spans))

    def _centre(self, pose: Pose) -> Floats:
        """(3,) the object's centre in the world."""
        return pose.apply(self._middle[None])[0]

    def _planned(self, thing: ObjectFrame, aim: float) -> _Plan:
        """A frame's reference wave and nodes, as it was planned last if that was the same."""
        assert thing.pose is not None
        plan = self._plan
        if plan is not None and plan.thing is thing and plan.aim == aim:
            return plan
        cx, cy, cz = self._centre(thing.pose).tolist()
        reference = reference_at((cx, cy, cz), bounding_box(thing.cloud.positions), self._plane)
        axes = cluster_axes(thing.cloud, reference, self._targets, self._plane, aim)
        self._plan = _Plan(thing, aim, reference, axes)
        return self._plan

    def changes(self, thing: ObjectFrame) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Ids that appeared and that vanished, against what the sphere holds."""
        assert thing.ids is not None
        now = np.zeros(len(self._held), dtype=bool)
        now[thing.ids] = True
        return np.flatnonzero(now & ~self._held), np.flatnonzero(self._held & ~now)

    @alone
    def factor(self, thing: ObjectFrame, record: FrameRecord, aim: float) -> tuple[Factor, Budget]:
        """The frame's low-rank factor and its expected error.

        aim : tolerance for its nodes and series; the sphere keeps its own
        """
        pose = thing.pose
        assert pose is not None and thing.ids is not None
        with record.stage("PE"):
            appeared, vanished = self.changes(thing)
        with record.stage("EC"):
            if len(appeared) + len(vanished) > _FOLD * max(int(self._held.sum()), 1):
                self._sphere.add(self._signed(appeared, vanished, self._own))
                self._held[appeared], self._held[vanished] = True, False
                appeared = vanished = np.zeros(0, dtype=np.intp)
        with record.stage("PA"):
            plan = self._planned(thing, aim)
            reference, (axis_x, axis_y) = plan.reference, plan.axes
            smooth_x, at_x = part_of(axis_x, False)
            smooth_y, at_y = part_of(axis_y, False)
            soft_x, at_soft_x = part_of(axis_x, True)
            soft_y, at_soft_y = part_of(axis_y, True)
            baseband = np.zeros((len(axis_y.nodes), len(axis_x.nodes)), dtype=np.complex64)
            changed = self._signed(appeared, vanished, self._body)
            changed = PointCloud(pose.apply(changed.positions), changed.amplitude, changed.phase)
            shared = None
            if baseband.size and len(thing.cloud) < _MANY:
                every = PointCloud.concatenate([thing.cloud, changed])
                shared = series_for(every, (axis_x, axis_y), reference, self._plane, aim)
        # Strips and changes are summed beside the look-up, and their time counts with it.
        missed = Remainder()
        with record.stage("RMC"):
            works: list[Callable[[], Summed]] = []
            places: list[tuple[NDArray[np.intp], NDArray[np.intp]]] = []
            if len(at_x) and len(at_y):
                works.append(
                    partial(self._carried, pose, reference, smooth_x.nodes, smooth_y.nodes)
                )
                places.append((at_y, at_x))
            for cloud, axis, other, place in (
                (thing.cloud, soft_x, axis_y, (np.arange(len(axis_y.nodes)), at_soft_x)),
                (thing.cloud, smooth_x, soft_y, (at_soft_y, at_x)),
                (changed, smooth_x, smooth_y, (at_y, at_x)),
            ):
                if len(cloud) and len(axis.nodes) and len(other.nodes):
                    axes = axis, other
                    works.append(
                        partial(sum_points, cloud, axes, reference, self._plane, aim, series=shared)
                    )
                    places.append(place)
            for (real, imag, left), (rows, columns) in zip(run_all(works), places, strict=True):
                baseband.real[np.ix_(rows, columns)] += real
                baseband.imag[np.ix_(rows, columns)] += imag
                if columns is at_soft_x or rows is at_soft_y:
                    missed = left
        factor = Factor(
            axis_x, axis_y, reference, np.ascontiguousarray(baseband.real),
            np.ascontiguousarray(baseband.imag),
        )  # fmt: skip
        with record.stage("PA"):
            budget = budget_of(
                factor,
                thing.cloud,
                (self._targets[0].places, self._targets[1].places),
                Wave(reference, self._plane.wavelength, self._plane.reach),
                missed,
            )
            carried = self._sphere.expected_error(self._own.select(thing.ids))
            budget = Budget(budget.error + carried**2 * budget.light, budget.light)
        self._count = _Count(
            len(appeared),
            len(vanished),
            _pixels(axis_x) * _pixels(axis_y) - _pixels(smooth_x) * _pixels(smooth_y),
        )
        return factor, budget

    def book(self, thing: ObjectFrame, record: FrameRecord) -> None:
        """Count what the last factor took."""
        changed = self._count.appeared + self._count.vanished
        pixels = self._plane.x[2] * self._plane.y[2]
        record.points_computed += changed
        record.points_added += self._count.appeared
        record.points_removed += self._count.vanished
        record.point_pixels += changed * pixels + len(thing.cloud) * self._count.soft
        record.blank_share = max(record.blank_share, self._count.soft / pixels)

    def _carried(self, pose: Pose, reference: Reference, x: Floats, y: Floats) -> Summed:
        """The sphere's light at nodes x, y over the reference wave."""
        centre = self._centre(pose)
        cx, cy, _ = centre.tolist()
        m = self._sphere.look_up(self._axes @ pose.rotation.T, centre, x, y)
        wavelength = self._plane.wavelength
        wave = reference.residual(x - cx, y[:, None] - cy, centre[2:], wavelength)
        start = float(reference.start(centre[2:], wavelength)[0])
        wave *= np.exp(2j * np.pi * start) * float(reference.modulus(centre[2:])[0])
        m *= wave.astype(np.complex64)
        return m.real, m.imag, Remainder()

    def _signed(
        self, appeared: NDArray[np.intp], vanished: NDArray[np.intp], points: PointCloud
    ) -> PointCloud:
        gone = points.select(vanished)
        return PointCloud.concatenate(
            [points.select(appeared), PointCloud(gone.positions, -gone.amplitude, gone.phase)]
        )

    def _view(self, pose: Pose) -> View:
        """Directions and ranges in which the hologram is seen in a frame to come, about."""
        centre = self._centre(pose)
        spans = []
        for axis, (low, high, _) in enumerate((self._plane.x, self._plane.y)):
            far = (1 - SOFT_SHARE) * (centre[2] + self._size) * self._plane.reach[axis]
            far += self._size
            a, b = max(low, centre[axis] - far), min(high, centre[axis] + far)
            beyond = self._beyond[axis]
            spans.append((min(a, b) - beyond, max(a, b) + beyond))
        return self._seen(pose, (spans[0], spans[1]))

    def _seen(self, pose: Pose, spans: tuple[Span, Span]) -> View:
        """Directions and ranges in which a rectangle of the hologram is seen in one frame."""
        centre = self._centre(pose)
        turn = self._axes @ pose.rotation.T
        sides = [
            np.linspace(*span, 7) - middle for span, middle in zip(spans, centre, strict=False)
        ]
        x, y = np.meshgrid(*sides)
        q = np.einsum("ij,jyx->iyx", turn, np.stack([x, y, np.full_like(x, -centre[2])]))
        u, v, rho = coordinates(q)
        # The nearest place lies between the samples: the foot of the perpendicular, or an edge.
        near = [min(max(0.0, side[0]), side[-1]) for side in sides]
        nearest = float(np.hypot(np.hypot(*near), centre[2]))
        along = turn[:, 1]
        tilt = abs(along[0]) / max(abs(along[1]), 1e-9) if along[1] > 0 else np.inf
        u_range, v_range, s_range = (
            _range(values) for values in (u, v, 1 / np.append(rho, nearest))
        )
        return View(u_range, v_range, s_range, float(tilt) * 1.02 + (1e-6 if tilt else 0.0))

    def _within_reach(self, poses: list[Pose]) -> list[Pose]:
        """As many poses, from the first, as one grid of directions may cover."""
        kept: list[Pose] = []
        view: View | None = None
        for pose in poses:
            one = self._view(pose)
            both = one if view is None else view.union(one)
            fits = (
                both.tilt < _TILT
                and max(map(abs, both.u)) < _AZIMUTH
                and max(map(abs, both.v)) < _ELEVATION
            )
            if fits:
                radius = self._size, self._size
                fits = self._values(radius, both) <= MOST_VALUES
            if kept and not fits:
                break
            kept.append(pose)
            view = both
        return kept

    def _values(self, radius: tuple[float, float], view: View) -> float:
        return float(np.prod(grid_shape(radius, view, self._plane.wavelength, self._tolerance)))


def _range(values: Floats) -> tuple[float, float]:
    """Lowest and highest, with room for what lies between the samples."""
    slack = 0.02 * float(np.ptp(values))
    return float(values.min()) - slack, float(values.max()) + slack


def _mean_rotation(rotations: list[Floats]) -> Floats:
    """The rotation nearest to the mean of some (polar decomposition)."""
    left, _, right = np.linalg.svd(np.mean(rotations, axis=0))
    left[:, -1] *= np.sign(np.linalg.det(left @ right))
    return left @ right


def _pixels(axis: Axis) -> int:
    return sum(block.target_count for block in axis.blocks)
