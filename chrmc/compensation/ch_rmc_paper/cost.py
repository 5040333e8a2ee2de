"""What the published CH-RMC takes, and how wrong its steps are, before anything is computed.

The chain of a step (propagate, times T, shift, over T, propagate back) is followed along rays: each
of its parts is a phase at a place. On a ray through x of the local hologram the light of a point
should have the path r' from where the point is after the rotation, and has

    r(x + R·θ) + z(x + R·θ) − z(x),

the path from where it was, seen one shift aside, and the difference of two conversions. A pixel
keeps what all steps did since it was last computed from the points.
"""

from math import log2

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.counts import OperationCounts
from chrmc.cgh.method import DEFAULT_METHOD, method_named
from chrmc.compensation.ch_rmc_paper.blank import difference, extent, intersection
from chrmc.compensation.ch_rmc_paper.carry import Motion, Rotation, carried_window, moved
from chrmc.compensation.ch_rmc_paper.conversion import RADIUS, gap, sagitta
from chrmc.compensation.ch_rmc_paper.cylinder import grid_for, turned
from chrmc.compensation.ch_rmc_paper.plan import motions
from chrmc.compensation.counted import VideoCost
from chrmc.encoding import Coding
from chrmc.optics.footprint import expected_power, reach
from chrmc.optics.passband import Passband
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Pose, Scene
from chrmc.slm import SLM
from chrmc.window import Window

Floats = NDArray[np.float64]

_FRAMES = 24  # that steps are found from: about as many as it takes until nothing is left
_POINTS, _PIXELS = 8, 64  # that stand for an object and for what it lights
_MANY = 2000  # points that give an object's outline
_PASSES = 200.0  # bytes of a sample of the padded grid, beside transforms
_STEP = 2e4  # steps of Python of an object that is carried


def cost(
    name: str, scene: Scene, numbers: range, slm: SLM, wavelength: float, coding: Coding
) -> VideoCost | None:
    """Of the first frames, or None where nobody knows how the objects move."""
    first = scene.frame(numbers[0])
    method, passband = method_named(DEFAULT_METHOD), coding.passband
    if method.cost is None or not len(first.cloud):
        return None
    whole = Window.full(slm)
    key = method.cost(first.cloud, slm, wavelength, whole, passband)
    later = OperationCounts(bytes=16.0 * whole.size * len(first.objects))
    wrong, light = 0.0, 0.0
    for obj in first.objects:
        if not len(obj.cloud):
            continue
        own = float(expected_power(obj.cloud, slm, wavelength, passband).sum())
        light += own
        # Steps are found from frames that follow too, as the video does: few tell no arc.
        after = range(numbers[0], min(numbers[0] + _FRAMES, scene.frame_count + 1))
        poses = [scene.pose(obj.name, number) for number in after]
        known = [pose for pose in poses if pose is not None]
        if len(known) < len(poses):
            return None
        found = motions(np.array([pose.translation for pose in known]))
        known = known[: len(numbers)]
        moves = [found.get(n) for n in range(2, len(known) + 1)]
        outline = obj.cloud.select(slice(None, None, max(1, len(obj.cloud) // _MANY)))
        if not all(pose.same_as(known[0]) for pose in known):
            wrong += own * _missed(outline, known, moves, slm, wavelength, passband)
        move = next((m for m in moves if m is not None), None)
        if move is None:
            continue
        later += _carrying(move, slm, wavelength)
        reused = carried_window(outline, moved(outline, move), move, slm, wavelength, passband)
        lit = extent(outline, slm, wavelength, passband)
        for blank in difference(lit, intersection(reused, lit)):
            later += method.cost(obj.cloud, slm, wavelength, blank, passband)
    error = float(np.sqrt(wrong / light)) if light > 0 else 0.0
    return VideoCost(DEFAULT_METHOD, key, later, len(numbers), error)


def _carrying(move: Motion, slm: SLM, wavelength: float) -> OperationCounts:
    """Of one object's field over one step."""
    distance = 0.0
    if isinstance(move, Rotation):
        distance = move.centre[1] - RADIUS + sagitta(RADIUS, slm.width * slm.pixel_pitch)
    rows, columns = grid_for(slm, wavelength, distance)
    size = float(rows * columns)
    # There and back in both directions, and along rows for the shift.
    turns = 2 * (log2(rows) + log2(columns)) + 4 * log2(columns)
    return OperationCounts(
        transforms=size * turns, bytes=_PASSES * size, calls=_STEP, memory=40.0 * size
    )


def _missed(
    cloud: PointCloud, poses: list[Pose], moves: list[Motion], slm: SLM, wavelength: float,
    passband: Passband,
) -> float:  # fmt: skip
    """Mean square of the relative error over the frames of some steps.

    poses : of the object in N frames; moves : N − 1, that stand for what is between them
    """
    random = np.random.default_rng(0)
    chosen = random.choice(len(cloud), min(_POINTS, len(cloud)), replace=False)
    clouds = [cloud]
    for move in moves:
        clouds.append(moved(clouds[-1], move))
    squares = []
    for last in range(1, len(clouds)):
        points = clouds[last].positions[chosen]
        pixels = []
        for axis, (places, f_max) in enumerate(
            ((slm.x(), passband.fx_max), (slm.y(), passband.fy_max))
        ):
            far = points[:, 2] * reach(wavelength, f_max)
            low = np.maximum(points[:, axis] - far, places[0])
            high = np.maximum(np.minimum(points[:, axis] + far, places[-1]), low)
            share = random.random((len(points), _PIXELS))
            pixels.append(low[:, None] + share * (high - low)[:, None])
        x, y = pixels
        # The points' own motion, of which moves know no more than their object's place.
        turn = poses[last].rotation @ poses[0].rotation.T
        own = (cloud.positions[chosen] - poses[0].translation) @ turn.T + poses[last].translation
        apart = _distance(points, x, y, 0.0) - _distance(own, x, y, 0.0)
        wrong, kept = 2 * np.pi / wavelength * apart, np.ones(x.shape, dtype=bool)
        for step in range(last - 1, -1, -1):
            move = moves[step]
            before, after = clouds[step], clouds[step + 1]
            if not isinstance(move, Rotation):
                continue
            window = carried_window(before, after, move, slm, wavelength, passband)
            spans = []
            for places, (start, stop) in (
                (slm.x(), (window.column0, window.column1)),
                (slm.y(), (window.row0, window.row1)),
            ):
                empty = start >= stop
                spans.append((np.inf, -np.inf) if empty else (places[start], places[stop - 1]))
            kept &= (x >= spans[0][0]) & (x <= spans[0][1])
            kept &= (y >= spans[1][0]) & (y <= spans[1][1])
            middle = before.centroid
            lost, x, y = _step(before.positions[chosen], middle, x, y, move, slm, wavelength)
            wrong += np.where(kept, lost, 0.0)
        squares.append(np.mean(np.abs(np.exp(1j * wrong) - 1) ** 2))
    return float(np.mean(squares))


def _step(
    points: Floats, middle: Floats, x: Floats, y: Floats, move: Rotation, slm: SLM,
    wavelength: float,
) -> tuple[Floats, Floats, Floats]:  # fmt: skip
    """Radians by which a step is wrong on pixels (N, K), and the places that their light was at.

    points, middle : (N, 3) points and the (3,) centre of their object before the step
    """
    z0 = sagitta(RADIUS, slm.width * slm.pixel_pitch)
    distance = move.centre[1] - RADIUS + z0
    aside = RADIUS * move.angle
    after, to = turned(points, move.centre, move.angle), turned(middle, move.centre, move.angle)

    def paths(u: Floats, v: Floats, was: Floats, now: Floats) -> tuple[Floats, Floats]:
        """What the chain has and what it should have at (u, v) of the local hologram, metres."""
        old = _distance(was, u + aside, v, distance)
        new = _distance(now, u, v, distance)
        centre = move.centre[0]
        z = [gap(np.clip(t - centre, -RADIUS, RADIUS), RADIUS, z0) for t in (u + aside, u)]
        # The defocus that stands for the step in depth.
        slopes = ((now[..., 0:1] - u) ** 2 + (now[..., 1:2] - v) ** 2) / new**2
        return old + z[0] - z[1] - 0.5 * (to[2] - middle[2]) * slopes, new

    depth = (after[:, 2:] - distance) / after[:, 2:]
    u, v = after[:, :1] + (x - after[:, :1]) * depth, after[:, 1:2] + (y - after[:, 1:2]) * depth
    has, should = paths(u, v, points, after)
    # The constant phase is right for the object's middle, on the ray that meets the plane squarely.
    own = paths(to[None, :1], to[None, 1:2], middle[None], to[None])
    lost = 2 * np.pi / wavelength * (has - should - (own[0] - own[1]))
    back = points[:, 2:] / (points[:, 2:] - distance)
    x = points[:, :1] + (u + aside - points[:, :1]) * back
    y = points[:, 1:2] + (v - points[:, 1:2]) * back
    return lost, x, y


def _distance(points: Floats, u: Floats, v: Floats, depth: float) -> Floats:
    """(N, K) signed: points may lie before the local hologram."""
    far = points[:, 2:] - depth
    straight = np.sqrt((points[:, :1] - u) ** 2 + (points[:, 1:2] - v) ** 2 + far**2)
    return np.asarray(np.copysign(straight, far))
