"""Whether an object's frames are better looked up than computed afresh, and in how many parts.

All costs are counted in multiply-adds of a matrix product, from the shapes of the work, so that
the same scene is decided the same way on every machine.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from math import ceil, log10, pi

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.interface import (
    MANY_POINTS,
    Plane,
    bounding_box,
    cost_of_sums,
    part_of,
)
from chrmc.compensation.ch_rmc_object.chart import View, Views, mean_rotation
from chrmc.compensation.ch_rmc_object.grid import Grid, make_grid
from chrmc.compensation.ch_rmc_object.plan import Outline, Plan, views_ahead
from chrmc.compensation.ch_rmc_object.transforms import MOST_TERMS, TRANSFORMED
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
_CALL, _SERIES, _FRAME = 5e6, 2.5e8, 8e8
_POINT = 1e5  # a point of a fresh sum besides its products: sorting, soft edges, the look at pixels
_TRANSFORMS = 6.5e9, 9e4  # a fresh sum by non-uniform Fourier transforms, and a point of it
_TERM = 1.3e8, 4.5e3  # a term of a tile's sum by such transforms, and a point of it
_PARTS = 1.8  # what parts take beside what is counted: small products wait for memory
_TERMS = 2.0  # of a tile's series, about
_LAYER = 0.5  # what a layer of range takes of the first
_WAIT = 64  # frames until reuse is thought of again, which takes as long as a small frame
_PAYS = 0.9  # of what afresh takes, up to which looking up is sure to take no longer
_MOST_PARTS = 64
_TURN = 2.0  # points that change per radian of turning, in shares of those seen


Parts = tuple[int, int, int]
"""Of an object, along its chart's axes."""


@dataclass(frozen=True)
class Choice:
    """How an object's next frames are made.

    parts : of the object along the chart's axes; None for afresh
    frames : for so many
    why : in words
    fresh, reused : counted multiply-adds of a frame's baseband computed afresh, and of one looked
        up, key frame and changes spread over `frames`; inf where no chart holds two frames
    """

    parts: Parts | None
    frames: int
    why: str
    fresh: float = np.inf
    reused: float = np.inf

    @property
    def cost(self) -> float:
        """Multiply-adds of a frame's baseband the way that was chosen."""
        return self.fresh if self.parts is None else self.reused


def choose(
    plan: Plan,
    outline: Outline,
    poses: Sequence[Pose],
    plane: Plane,
    tolerance: float,
    most: int = MOST_VALUES,
    always: bool = False,
) -> Choice:
    """The cheapest way, counted per frame from shapes alone: no clock, no points are summed.

    plan : of the first frame, from `planned`; outline : of the body, from `outline_of`
    poses : of the frames to come, this one first
    plane : the hologram's pixels, from `plane_of`
    tolerance : that spheres and nodes aim at
    most : complex numbers that its grid may hold
    always : reuse, whether it pays or not

    What both ways share, nodes to pixels, is not in the costs.
    """
    obj = plan.obj
    count = len(obj.cloud)
    nodes = len(plan.axes[0].nodes), len(plan.axes[1].nodes)
    box = bounding_box(obj.cloud.positions)

    def summed(nodes: tuple[int, int]) -> float:
        return cost_of_sums(box, count, nodes, plane) + _SERIES + _POINT * count

    fresh = summed(nodes)
    if count >= MANY_POINTS and not any(plan.from_points):
        digits = _digits(tolerance)
        fresh = min(fresh, digits**2 * (_TRANSFORMS[0] + _TRANSFORMS[1] * count))
    # Strips that no filter is good enough for are summed from the points in every frame.
    soft_x, soft_y = (len(part_of(axis, True)[1]) for axis in plan.axes)
    strips = summed((soft_x, nodes[1])) if plan.from_points[0] and soft_x else 0.0
    strips += summed((nodes[0], soft_y)) if plan.from_points[1] and soft_y else 0.0
    best = _Way(np.inf, None, _WAIT)
    parts: Parts = (1, 1, 1)
    for frames in _lengths(len(poses)):
        to_chart = mean_rotation(poses[:frames])
        size = np.abs(bounding_box((outline.rim - outline.middle) @ to_chart.T)).max(axis=1)
        views = views_ahead(plan, outline, poses[:frames], to_chart, size, plane, 0.0)
        view = views.until(frames)
        if not view.whole:
            break
        turned = _turned(poses[:frames]) / frames

        def cost(
            parts: Parts, size: Floats = size, views: Views = views, view: View = view,
            turned: float = turned,
        ) -> float:  # fmt: skip
            half = size / parts
            grid = make_grid(half, view, _width(views), plane.wavelength, tolerance)
            if np.prod(parts) * len(grid.layers) * grid.count[0] * grid.count[1] > most:
                return np.inf
            return strips + _cost(grid, views, count, parts, half, plan, turned)

        least, parts = _cheapest(cost, parts, count)
        # The longest that one chart can hold, if it has to be reuse.
        if least < np.inf and (always or least <= 1.02 * best.cost):
            best = _Way(least, parts, frames)
    ratio = best.cost / fresh
    if best.parts is None or (ratio > _PAYS and not always):
        why = "no chart of directions holds two of its frames"
        if ratio < np.inf:
            why = f"looking up would cost {ratio:.2g} times as much"
        return Choice(None, _WAIT, why, fresh, best.cost)
    number = int(np.prod(best.parts))
    why = (
        f"{number} part{'s' * (number > 1)} for up to {best.frames} frames, each at "
        f"{ratio:.2g} of what it would cost afresh"
    )
    return Choice(best.parts, best.frames, why, fresh, best.cost)


def _digits(tolerance: float) -> float:
    """Digits that are aimed at, over those of 1e-3, at which the counts were measured."""
    return -log10(tolerance) / 3.15


@dataclass(frozen=True)
class _Way:
    cost: float
    parts: Parts | None
    frames: int


def _lengths(most: int) -> list[int]:
    """Numbers of frames that are tried."""
    out = [min(4, most)]
    while out[-1] < most:
        out.append(min(2 * out[-1], most))
    return out


def _cheapest(cost: Callable[[Parts], float], start: Parts, count: int) -> tuple[float, Parts]:
    """The least cost downhill from one part, from some and from `start`, by twice and half as many
    along each axis: one part is summed in a way of its own."""
    known: dict[Parts, float] = {}
    for at in dict.fromkeys(((1, 1, 1), start, (4, 2, 1))):
        if _allowed(at, count):
            known.setdefault(at, cost(at))
            _descend(cost, known, at, count)
    best = min(known, key=lambda parts: (known[parts], parts))
    return known[best], best


def _descend(
    cost: Callable[[Parts], float], known: dict[Parts, float], at: Parts, count: int
) -> None:
    """Work out the costs of parts on the way down from some."""
    while True:
        nearby = [at]
        for axis in range(3):
            for number in (2 * at[axis], at[axis] // 2):
                near = (*at[:axis], number, *at[axis + 1 :])
                assert len(near) == 3
                if _allowed(near, count):
                    if near not in known:
                        known[near] = cost(near)
                    nearby.append(near)
        least = min(nearby, key=lambda parts: (known[parts], parts))
        if least == at:
            return
        at = least


def _allowed(parts: Parts, count: int) -> bool:
    """Whether so many points may be cut so."""
    number = parts[0] * parts[1] * parts[2]
    if number <= 1:
        return number == 1
    few = max(parts[:2]) <= 16 and parts[2] <= min(4, max(parts[:2]))
    return few and number <= _MOST_PARTS and 16 * number <= count


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
    half: Floats,
    plan: Plan,
    turned: float,
) -> float:
    """Of a frame, on the average, without what it would cost afresh as well."""
    number = int(np.prod(parts))
    layers, taps = len(grid.layers), grid.taps.count
    more = 1 + _LAYER * (layers - 1)
    wide, high = grid.tile
    needed, touched = _tiles(grid, views)
    places = number * wide * high

    def sums(points: float) -> float:
        each = _ENTRY * (wide + high) + 4 * more * _TERMS * wide * high
        some = min(1.0, points / number)
        return points * each + more * some * (number * _CALL + _TERMS * _PLACE * places)

    frames = len(views.tilt)
    whole = sums(count) + layers * _SERIES
    if number == 1 and count >= TRANSFORMED:
        # What curves over a tile, in radians: its series takes a transform for each term.
        bend = ((wide * grid.step[0]) ** 2 + (high * grid.step[1]) ** 2) / 8
        terms = 5 + 2.5 * 2 * pi / plan.wave.wavelength * float(half[2]) * bend
        if terms <= MOST_TERMS / 2:
            terms *= more * _digits(plan.aim)
            whole = min(whole, layers * _SERIES + terms * (_TERM[0] + _TERM[1] * count))
    new = needed * whole / frames
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
    look = number * x * (rows * (more * _TAP * taps + _LOOK) + y * (_TAP * taps + 2 * _LOOK))
    if number == 1:
        return float(_FRAME + new + 0.5 * changed + look)
    return float(_FRAME + _PARTS * (new + changed + look + carry))


class Patience:
    """When an object's reuse is thought of again: twice as late each time that it did not pay."""

    def __init__(self) -> None:
        self._until: dict[str, tuple[int, int]] = {}

    def over(self, name: str, number: int) -> bool:
        """Whether it is time in a frame."""
        return number >= self._until.get(name, (number, 0))[0]

    def put_off(self, name: str, number: int, frames: int) -> None:
        """For some frames, or twice as many as the last time."""
        frames = max(frames, 2 * self._until.get(name, (0, 0))[1])
        self._until[name] = number + frames, frames

    def end(self, name: str) -> None:
        """It paid."""
        self._until.pop(name, None)


def poses_ahead(scene: Scene, obj: ObjectFrame, later: Sequence[int]) -> list[Pose]:
    """An object's poses in the frames to come, as far as the scene can tell."""
    poses: list[Pose] = []
    for number in later[:LOOK_AHEAD]:
        pose = scene.pose(obj.name, number)
        if pose is None:
            break
        poses.append(pose)
    return poses
