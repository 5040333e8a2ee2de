"""Whether an object's frames are better looked up than computed afresh, and in how many parts.

All costs are counted in multiply-adds of a matrix product, from the shapes of the work, so that
the same scene is decided the same way on every machine.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from math import ceil

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.interface import Line, Plane, bounding_box, cost_of_sums
from chrmc.compensation.ch_rmc_object.chart import Views, mean_rotation
from chrmc.compensation.ch_rmc_object.grid import Grid, make_grid
from chrmc.compensation.ch_rmc_object.plan import Outline, Plan, views_ahead
from chrmc.scene.scene import ObjectFrame, Pose, Scene

Floats = NDArray[np.float64]

LOOK_AHEAD = 600
"""Frames whose poses are asked for, at most."""
MOST_VALUES = 100_000_000
"""Complex numbers that the grids of all objects may hold: 800 MB."""

# In multiply-adds of a matrix product, as measured: an entry of a table of phases, a place of a
# grid that is added to, a place looked up and each of its neighbours, a small product's fixed
# work, a tile's series, a frame's plan.
_ENTRY, _PLACE, _LOOK, _TAP = 500.0, 300.0, 3000.0, 250.0
_CALL, _SERIES, _FRAME = 5e6, 2.5e8, 3e8
_TERMS = 2.0  # of a tile's series, about
_WAIT = 16  # frames until reuse is thought of again; longer from this share of the cost on
_HARDLY = 1.3
_TURN = 2.0  # points that change per radian of turning, in shares of those seen


@dataclass(frozen=True)
class Choice:
    """How an object's next frames are made.

    parts : of the object along the chart's axes; None for afresh
    frames : for so many
    why : in words
    """

    parts: tuple[int, int, int] | None
    frames: int
    why: str


def choose(
    plan: Plan,
    outline: Outline,
    poses: Sequence[Pose],
    targets: tuple[Line, Line],
    plane: Plane,
    tolerance: float,
    most: int = MOST_VALUES,
    always: bool = False,
) -> Choice:
    """The cheapest way, counted per frame.

    poses : of the frames to come, this one first
    most : complex numbers that its grid may hold
    always : reuse, whether it pays or not
    """
    thing = plan.thing
    count = len(thing.cloud)
    nodes = len(plan.axes[0].nodes), len(plan.axes[1].nodes)
    fresh = _SERIES + cost_of_sums(bounding_box(thing.cloud.positions), count, nodes, plane)
    best, chosen = np.inf, Choice(None, _WAIT, "no chart of directions holds two of its frames")
    for frames in _lengths(len(poses)):
        axes = mean_rotation(poses[:frames])
        own = (outline.rim - outline.middle) @ axes.T
        size = np.abs(bounding_box(own)).max(axis=1)
        views = views_ahead(plan, outline, poses[:frames], axes, size, targets, plane, 0.0)
        view = views.until(frames)
        if not view.whole:
            break
        longest = always  # that one chart can hold
        turned = _turned(poses[:frames])
        for parts in _divisions(count):
            half = size / parts
            grid = make_grid(half, view, _width(views), plane.wavelength, tolerance)
            number = int(np.prod(parts))
            if number * len(grid.layers) * grid.count[0] * grid.count[1] > most:
                continue
            cost = _cost(grid, views, count, parts, nodes, half, plan, turned / frames)
            if cost <= 1.02 * best or longest:
                longest = False
                best, chosen = cost, Choice(parts, frames, "")
    share = best / fresh
    if chosen.parts is None or (share > 1 and not always):
        why = f"looking up would cost {share:.2g} times as much" if share < np.inf else chosen.why
        return Choice(None, _WAIT if share < _HARDLY else 4 * _WAIT, why)
    number = int(np.prod(chosen.parts))
    return replace(
        chosen,
        why=f"{number} part{'s' * (number > 1)} for up to {chosen.frames} frames, each at "
        f"{share:.2g} of what it would cost afresh",
    )


def _lengths(most: int) -> list[int]:
    """Numbers of frames that are tried."""
    out = [2]
    while out[-1] < most:
        out.append(min(2 * out[-1], most))
    return out if most > 1 else [1]


def _divisions(count: int) -> list[tuple[int, int, int]]:
    """Numbers of parts that are tried, for so many points."""
    few = (1, 2, 4, 8, 16)
    every = [(a, b, c) for a, b, c in product(few, few, (1, 2, 4)) if c <= max(a, b)]
    return [d for d in every if np.prod(d) == 1 or (np.prod(d) <= 64 and 16 * np.prod(d) <= count)]


def _width(views: Views) -> tuple[float, float]:
    return (
        float(np.max(views.alpha[1] - views.alpha[0])),
        float(np.max(views.beta[1] - views.beta[0])),
    )


def _turned(poses: Sequence[Pose]) -> float:
    """Radians between the first pose and the next, and so on, in all."""
    out = 0.0
    for a, b in pairwise(poses):
        out += float(np.linalg.norm(a.rotation - b.rotation)) / np.sqrt(2)
    return out


def _tiles(grid: Grid, views: Views) -> tuple[int, float]:
    """Tiles that some frame needs, and those that one needs, on the average."""
    needed: set[tuple[int, int]] = set()
    touched = 0
    bounds = []
    for (low, high), first, step, tile in zip(
        (views.alpha, views.beta), grid.first, grid.step, grid.tile, strict=True
    ):
        bounds.append([((end - first) / step // tile).astype(int) for end in (low, high)])
    for a0, a1, b0, b1 in zip(*bounds[0], *bounds[1], strict=True):
        ones = set(product(range(a0, a1 + 1), range(b0, b1 + 1)))
        touched += len(ones)
        needed |= ones
    return len(needed), touched / len(views.tilt)


def _cost(
    grid: Grid,
    views: Views,
    count: int,
    parts: tuple[int, int, int],
    nodes: tuple[int, int],
    half: Floats,
    plan: Plan,
    turned: float,
) -> float:
    """Of a frame, on the average, without what it would cost afresh as well."""
    number = int(np.prod(parts))
    layers, taps = len(grid.layers), grid.taps.count
    wide, high = grid.tile
    needed, touched = _tiles(grid, views)
    places = number * wide * high

    def sums(points: float) -> float:
        each = _ENTRY * (wide + high) + 4 * _TERMS * wide * high
        some = min(1.0, points / number)
        return layers * (points * each + some * (number * _CALL + _TERMS * _PLACE * places))

    frames = len(views.tilt)
    new = needed * (sums(count) + layers * _SERIES) / frames
    changed = touched * sums(min(_TURN * turned, 1.0) * count)
    x, y = (len(reading.places) for reading in plan.readings)
    carry = 0.0
    if number > 1:
        few = []
        for axis, length in ((0, x), (1, y)):
            span = float(np.ptp(plan.readings[axis].places)) if length else 0.0
            depth = plan.wave.reference.z
            waves = 2 * half[axis] / depth / plan.wave.wavelength * span
            few.append(min(length, ceil(1.15 * waves + 10)))
        carry = number * few[1] * (2 * x * few[0] + 4 * x * y + 250 * x + 400 * y)
        x, y = few
    # Rows of the grid that a frame reads, about.
    rows = min(grid.count[1], _width(views)[1] / grid.step[1] + taps)
    look = number * x * (rows * (layers * _TAP * taps + _LOOK) + y * (_TAP * taps + 2 * _LOOK))
    return float(_FRAME + new + changed + look + carry)


def poses_ahead(scene: Scene, thing: ObjectFrame, later: Sequence[int]) -> list[Pose]:
    """An object's poses in the frames to come, as far as the scene can tell."""
    poses: list[Pose] = []
    for number in later[:LOOK_AHEAD]:
        pose = scene.pose(thing.name, number)
        if pose is None:
            break
        poses.append(pose)
    return poses
