"""Where a frame's baseband is needed: reference wave, nodes, and how they are read off it."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.interface import (
    Axes,
    Plane,
    Reading,
    Wave,
    bounding_box,
    cluster_axes,
    readings_of,
    reference_at,
)
from chrmc.compensation.ch_rmc_object.chart import Views, views_of
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import ObjectFrame, Pose

Floats = NDArray[np.float64]
_MANY = 2000  # points from which some stand for all
_DIRECTIONS, _ROOM = 200, 1.02  # in which the rim is sought, and how much larger it is taken


@dataclass(frozen=True, eq=False)
class Plan:
    """Where a frame's baseband is needed, at some tolerance.

    some : some of the points, which stand for all; their power is 1/scale of all
    missed : expected power of the filters' error
    from_points : strips along x, along y that no filter is good enough for
    """

    obj: ObjectFrame
    aim: float
    wave: Wave
    axes: Axes
    readings: tuple[Reading, Reading]
    some: PointCloud
    scale: float
    missed: float
    from_points: tuple[bool, bool]


@dataclass(frozen=True, eq=False)
class Outline:
    """A body's place and size, so that a frame need not look at all of its points.

    middle : (3,) of its box: the centre of its spheres
    size : farthest point from there
    rim : (M, 3) points whose hull holds all others
    """

    body: PointCloud
    middle: Floats
    size: float
    rim: Floats


def outline_of(body: PointCloud) -> Outline:
    """The outline; for many points from those that are farthest in a few hundred directions."""
    middle = bounding_box(body.positions).mean(axis=1)
    own = body.positions - middle
    size = float(np.linalg.norm(own, axis=1).max())
    if len(own) > _MANY:
        # A golden spiral; between two directions the hull may be 1 − cos(half their angle) larger.
        k = np.arange(_DIRECTIONS) + 0.5
        height, turn = 1 - 2 * k / _DIRECTIONS, k * pi * (3 - sqrt(5))
        across = np.sqrt(1 - height**2)
        ways = np.column_stack([across * np.cos(turn), height, across * np.sin(turn)])
        single = np.ascontiguousarray(own.T, dtype=np.float32)
        own = _ROOM * own[np.unique(np.argmax(ways.astype(np.float32) @ single, axis=1))]
    return Outline(body, middle, size, own + middle)


def planned(obj: ObjectFrame, outline: Outline, plane: Plane, aim: float) -> Plan:
    """A frame's reference wave, its nodes, and how they are read off the plain baseband."""
    assert obj.pose is not None
    cx, cy, cz = obj.pose.apply(outline.middle[None])[0].tolist()
    cloud = rim = obj.cloud
    scale = 1.0
    if len(cloud) > _MANY:
        cloud = cloud.select(slice(None, None, len(cloud) // _MANY))
        scale = float(obj.cloud.amplitude @ obj.cloud.amplitude)
        scale /= max(float(cloud.amplitude @ cloud.amplitude), 1e-300)
        outer = obj.pose.apply(outline.rim)
        rim = PointCloud(outer, np.ones(len(outer)), np.zeros(len(outer)))
    box = bounding_box(rim.positions)
    reference = reference_at((cx, cy, cz), box, plane)
    axes = cluster_axes(rim, reference, plane, aim)
    read = readings_of(axes, reference, box, cloud, plane, aim, scale)
    return Plan(
        obj, aim, Wave(reference, plane.wavelength, plane.reach), axes, read.along,
        cloud, scale, read.missed, read.from_points,
    )  # fmt: skip


def views_ahead(
    first: Plan,
    outline: Outline,
    poses: Sequence[Pose],
    to_chart: Floats,
    plane: Plane,
) -> Views:
    """What frames need of a chart, about.

    to_chart : (3, 3) body to chart
    """
    middle, size = outline.middle, outline.size
    centre = np.stack([pose.apply(middle[None])[0] for pose in poses])
    sides = []
    for i, line in enumerate(plane.lines):
        far = size + (centre[:, 2] + size) * plane.reach[i]
        a, b = np.maximum(line.first, centre[:, i] - far), np.minimum(line.last, centre[:, i] + far)
        a, b = np.minimum(a, b), np.maximum(a, b)
        # Places lie beyond the light; about as far in the other frames as in the first.
        places = first.readings[i].places
        beyond = 4 * line.step
        if len(places):
            beyond += 1.3 * max(a[0] - float(places.min()), float(places.max()) - b[0], 0.0)
        sides.append((a - beyond, b + beyond))
    return views_of(poses, middle, to_chart, (sides[0], sides[1]))


def same_light(before: ObjectFrame, now: ObjectFrame) -> bool:
    """Nothing about the object's light changed."""
    if before.pose is not None and now.pose is not None and before.ids is not None:
        return (
            before.body is now.body
            and before.pose.same_as(now.pose)
            and now.ids is not None
            and np.array_equal(before.ids, now.ids)
        )
    a, b = before.cloud, now.cloud
    return a is b or (
        np.array_equal(a.positions, b.positions)
        and np.array_equal(a.amplitude, b.amplitude)
        and np.array_equal(a.phase, b.phase)
    )
