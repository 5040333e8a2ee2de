"""One object's frames from its light on a sphere of directions."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi

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
    budget_of,
    part_of,
    sum_points,
)
from chrmc.compensation.ch_rmc_object.chart import mean_rotation
from chrmc.compensation.ch_rmc_object.grid import make_grid
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
        plane: Plane,
        tolerance: float,
    ) -> None:
        self.body = body = outline.body
        self._plane = plane
        self._middle = outline.middle
        self._to_chart = mean_rotation(poses)
        own = (body.positions - self._middle) @ self._to_chart.T
        half = np.abs(own).max(axis=0)
        views = views_ahead(first, outline, poses, self._to_chart, plane)
        width = tuple(float(np.max(high - low)) for low, high in (views.alpha, views.beta))
        grid = make_grid(
            half, views.until(len(poses)), (width[0], width[1]), plane.wavelength, tolerance
        )
        points = PointCloud(own, body.amplitude, body.phase)
        self.sphere = Sphere(points, half, grid, plane.wavelength, tolerance)
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
            missed = Remainder(None, self.sphere.expected_error(visible))
            places = self._plane.x.places, self._plane.y.places
            budget = budget_of(factor, plan.some, places, wave, missed, plan.scale)
            budget = replace(budget, error=budget.error + plan.missed)
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
        wavelength = self._plane.wavelength
        centre = pose.apply(self._middle[None])[0]
        m = self.sphere.look_up(self._to_chart @ pose.rotation.T, centre, x, y, visible)
        z = centre[2:]
        radians, modulus = reference.residual_parts(
            (x - centre[0])[:, None], y - centre[1], z, wavelength
        )
        start = 2 * pi * reference.start(z, wavelength)
        radians = radians.astype(m.real.dtype)
        rest = np.empty_like(m)
        np.cos(radians, out=rest.real)
        np.sin(radians, out=rest.imag)
        rest *= modulus.astype(m.real.dtype)
        m *= rest
        m *= (reference.modulus(z) * np.exp(1j * start)).astype(m.dtype)
        return m

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
