"""What the NLUT videos take, from the corrections of a few frames whose fields are not made."""

from dataclasses import dataclass
from itertools import islice

import numpy as np

from chrmc.cgh.counts import OperationCounts
from chrmc.cgh.method import method_named
from chrmc.compensation.counted import VideoCost
from chrmc.compensation.held import Computer, Matcher
from chrmc.compensation.nlut import mc_nlut, tr_nlut
from chrmc.compensation.nlut.groups import Group, Moving, Search, next_group
from chrmc.compensation.shift import lens, lens_axis, moved
from chrmc.encoding import Coding
from chrmc.optics.footprint import expected_power, pixels_within
from chrmc.reference import relative_error, true_waves
from chrmc.scene.derived import DerivedScene
from chrmc.scene.scene import ObjectFrame, Scene, SceneFrame
from chrmc.slm import SLM
from chrmc.window import Window

CGH = "nlut"
_CHAINS = {"tr-nlut": tr_nlut.frames, "mc-nlut": mc_nlut.frames}
# frames of a group, and planes that are searched; of the search only what a few frames ask for
_GROUPS = {"mpeg-nlut": (4, 0), "3dmc-nlut": (8, 16)}
_SEARCH = 16, 16  # side of a block, and how far it is sought
_FRAMES = 4  # that are looked at
_MANY = 3000  # points of which some stand for all
_PASSES = 32.0  # bytes of a pixel, where a field is carried from frame to frame
_FIELD = 64.0  # the same of a block's own field, while it is made
_BLOCK = 24.0, 90.0  # and while it is shifted, and where a lens acts on it besides
_POINTS, _PIXELS = 8, 64  # on which lenses are tried


def cost(
    name: str, scene: Scene, numbers: range, slm: SLM, wavelength: float, coding: Coding
) -> VideoCost | None:
    """Of a video by its name; None where nothing is to be seen.

    What is shifted keeps the error that it was computed with, and what is taken out was put in
    with the same: nothing is added to the CGH method's own error, but by lenses, which stand for
    motions in depth.
    """
    first, method, pixels = scene.frame(numbers[0]), method_named(CGH), slm.width * slm.height
    if method.cost is None or not len(first.cloud):
        return None
    whole = key = method.cost(first.cloud, slm, wavelength, Window.full(slm), coding.passband)
    step = max(1, len(first.cloud) // _MANY)
    some: Scene = scene if step == 1 else _Some(scene, step)
    passes, fields, carried, serves = _PASSES, 1, 0.0, len(numbers)
    if name in _CHAINS:
        made = _CHAINS[name](some, slm, wavelength, CGH, numbers[:_FRAMES], coding)
        records = [frame.record for frame in islice(made, _FRAMES)]
    else:
        serves, planes = _GROUPS[name]
        search = Search(min(serves, _FRAMES), *_SEARCH, planes, "sad")
        computer = Computer(slm, wavelength, CGH, coding.passband, {})
        group, general = next_group(some, numbers, Matcher.of(scene, None), computer, search)
        records = [group.record, *(record for _, record in general)]
        moves = [move for frame, _ in general for move in frame.moves if move]
        fields += sum(group.alone)
        passes += sum(_BLOCK[bool(move.depth)] for move in moves) / max(1, len(general))
        key += OperationCounts(bytes=_FIELD * pixels * sum(group.alone))
        carried = _missed(group, [frame for frame, _ in general], slm, wavelength, coding)
    work = [record.point_pixels for record in records]
    share = float(np.mean(work[1:])) / work[0] if work[1:] and work[0] else 1.0
    later = whole.times(share)
    later += OperationCounts(bytes=passes * pixels, memory=8.0 * pixels * (fields + 1))
    return VideoCost(CGH, key, later, serves, carried)


def _missed(
    group: Group, frames: list[Moving], slm: SLM, wavelength: float, coding: Coding
) -> float:
    """Relative error that lenses make, in the root mean square over some frames: a few points'
    waves as a lens makes them against those of the points that it is said to show."""
    random, passband = np.random.default_rng(0), coding.passband
    clouds = [block.points.cloud for block in group.blocks]
    light = [float(expected_power(cloud, slm, wavelength, passband).sum()) for cloud in clouds]
    squares = []
    for frame in frames:
        deep = [i for i, move in enumerate(frame.moves) if move.depth]
        tried: list[int] = []
        if deep:
            tried = random.choice(deep, min(_POINTS, len(deep)), replace=False).tolist()
        wrong = power = 0.0
        for i in tried:
            move, cloud = frame.moves[i], clouds[i]
            one = np.array([random.integers(len(cloud))])
            shown = moved(cloud, move, slm, wavelength).select(one)
            rows, columns = pixels_within(shown, slm, wavelength, passband, _PIXELS, random)
            truth = true_waves(shown, slm, wavelength, rows, columns, passband)
            x, y, z = lens_axis(cloud, move, slm)
            in_y, in_x = lens(slm, wavelength, (x, y), z, move.depth)
            before = rows - move.rows, columns - move.columns
            made = true_waves(cloud.select(one), slm, wavelength, *before, passband)
            made = made * in_y[rows] * in_x[columns]
            wrong += light[i] * relative_error(made, truth) ** 2
            power += light[i]
        share = sum(light[i] for i in deep) / sum(light)
        squares.append(share * wrong / power if power > 0 else 0.0)
    return float(np.sqrt(np.mean(squares))) if squares else 0.0


@dataclass(frozen=True, eq=False, repr=False)
class _Some(DerivedScene):
    """A scene of every so many points: those of some identities, or on some of its pixels."""

    step: int

    def frame(self, number: int) -> SceneFrame:
        return SceneFrame(number, tuple(map(self._part, self.scene.frame(number).objects)))

    def _part(self, obj: ObjectFrame) -> ObjectFrame:
        if obj.ids is not None:
            kept = obj.ids % self.step == 0
            return ObjectFrame(obj.name, obj.cloud.select(kept), obj.body, obj.ids[kept], obj.pose)
        column, row = np.rint(obj.cloud.positions[:, :2].T / self.scene.pixel_pitch).astype(int)
        return ObjectFrame(obj.name, obj.cloud.select((31 * row + column) % self.step == 0))
