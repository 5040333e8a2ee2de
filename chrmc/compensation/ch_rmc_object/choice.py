"""Whether an object's frames are better looked up than computed afresh.

All costs are counted in multiply-adds of a matrix product, from the shapes of the work, so that
the same scene is decided the same way on every machine.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from math import log10, pi

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.interface import (
    MANY_POINTS,
    Plane,
    bounding_box,
    cost_of_sums,
    part_of,
)
from chrmc.compensation.ch_rmc_object.chart import Views, mean_rotation
from chrmc.compensation.ch_rmc_object.grid import MOST_SWING, Grid, make_grid, most_swing
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
_TERM = 4.4e3, 4.5e3  # a place of a tile's sum by such transforms, and a point, for each term
_TERMS = 2.0  # of a tile's series, about
_LAYER = 0.5  # what a layer of range takes of the first
_WAIT = 64  # frames until reuse is thought of again, which takes as long as a small frame
_PAYS = 0.9  # of what afresh takes, up to which looking up is sure to take no longer
_TURN = 2.0  # points that change per radian of turning, in shares of those seen


@dataclass(frozen=True)
class Choice:
    """How an object's next frames are made.

    pays : looked up, else afresh
    frames : for so many
    why : in words
    fresh, reused : counted multiply-adds of a frame's baseband computed afresh, and of one looked
        up, key frame and changes spread over `frames`; inf where no chart holds two frames
    """

    pays: bool
    frames: int
    why: str
    fresh: float = np.inf
    reused: float = np.inf

    @property
    def cost(self) -> float:
        """Multiply-adds of a frame's baseband the way that was chosen."""
        return self.reused if self.pays else self.fresh


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
        return cost_of_sums(box, count, nodes, plane, tolerance) + _SERIES + _POINT * count

    fresh = summed(nodes)
    if count >= MANY_POINTS and not any(plan.from_points):
        digits = _digits(tolerance)
        fresh = min(fresh, digits**2 * (_TRANSFORMS[0] + _TRANSFORMS[1] * count))
    # Strips that no filter is good enough for are summed from the points in every frame.
    soft_x, soft_y = (len(part_of(axis, True)[1]) for axis in plan.axes)
    strips = summed((soft_x, nodes[1])) if plan.from_points[0] and soft_x else 0.0
    strips += summed((nodes[0], soft_y)) if plan.from_points[1] and soft_y else 0.0
    best, length = np.inf, _WAIT
    for frames in _lengths(len(poses)):
        to_chart = mean_rotation(poses[:frames])
        half = np.abs(bounding_box((outline.rim - outline.middle) @ to_chart.T)).max(axis=1)
        views = views_ahead(plan, outline, poses[:frames], to_chart, plane)
        view = views.until(frames)
        if not view.whole or most_swing(half, view.s, plane.wavelength) > MOST_SWING:
            break
        grid = make_grid(half, view, _width(views), plane.wavelength, tolerance)
        if len(grid.layers) * grid.count[0] * grid.count[1] > most:
            continue
        turned = _turned(poses[:frames]) / frames
        reused = strips + _cost(grid, views, count, half, plan, turned)
        # The longest that one chart can hold, if it has to be reuse.
        if always or reused <= 1.02 * best:
            best, length = reused, frames
    ratio = best / fresh
    if ratio < np.inf and (ratio <= _PAYS or always):
        why = f"for up to {length} frames, each at {ratio:.2g} of what it would cost afresh"
        return Choice(True, length, why, fresh, best)
    why = "no chart of directions and ranges holds two of its frames"
    if ratio < np.inf:
        why = f"looking up would cost {ratio:.2g} times as much"
    return Choice(False, _WAIT, why, fresh, best)


def _digits(tolerance: float) -> float:
    """Digits that are aimed at, over those of 1e-3, at which the counts were measured."""
    return -log10(tolerance) / 3.15


def _lengths(most: int) -> list[int]:
    """Numbers of frames that are tried."""
    out = [min(4, most)]
    while out[-1] < most:
        out.append(min(2 * out[-1], most))
    return out


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
    half: Floats,
    plan: Plan,
    turned: float,
) -> float:
    """Of a frame, on the average, without what it would cost afresh as well."""
    layers, taps = len(grid.layers), grid.taps.count
    more = 1 + _LAYER * (layers - 1)
    wide, high = grid.tile
    needed, touched = _tiles(grid, views)

    def sums(points: float) -> float:
        each = _ENTRY * (wide + high) + 4 * more * _TERMS * wide * high
        some = min(1.0, points)
        return points * each + more * some * (_CALL + _TERMS * _PLACE * wide * high)

    frames = len(views.tilt)
    whole = sums(count) + layers * _SERIES
    if count >= TRANSFORMED:
        # What curves over a tile, in radians: its series takes a transform for each term.
        bend = ((wide * grid.step[0]) ** 2 + (high * grid.step[1]) ** 2) / 8
        terms = 5 + 2.5 * 2 * pi / plan.wave.wavelength * float(half[2]) * bend
        if terms <= MOST_TERMS / 2:
            terms *= more * _digits(plan.aim)
            whole = min(
                whole, layers * _SERIES + terms * (_TERM[0] * wide * high + _TERM[1] * count)
            )
    new = needed * whole / frames
    changed = touched * sums(min(_TURN * turned, 1.0) * count)
    x, y = (len(reading.places) for reading in plan.readings)
    # Rows of the grid that a frame reads, about.
    rows = min(grid.count[1], _width(views)[1] / grid.step[1] + taps)
    look = x * (rows * (more * _TAP * taps + _LOOK) + y * (_TAP * taps + 2 * _LOOK))
    return float(_FRAME + new + 0.5 * changed + look)


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
