"""What the object surface takes, object by object, counted before anything is summed."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil, log2

import numpy as np

from chrmc.cgh.counts import OperationCounts
from chrmc.cgh.curved.interface import (
    bounding_box,
    cost_of,
    pixels_from,
    plane_of,
    some_of,
    split,
    waves_looked_at,
)
from chrmc.compensation.ch_rmc_object.choice import Choice, choose, poses_ahead
from chrmc.compensation.ch_rmc_object.plan import outline_of, planned, same_light
from chrmc.compensation.ch_rmc_object.promise import AIM, LOOKED, SOMETIMES
from chrmc.encoding import Coding
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import ObjectFrame, Scene
from chrmc.slm import SLM
from chrmc.window import Window

_CHOSEN = 2  # moving objects whose choice is worked out; it stands for the others
_SOME = 5000  # points of a body that stand for its outline
_KEY = 8.0  # what a key frame takes beyond later ones, in frames' worth of sums afresh, at most
_LATER = 0.3  # of what a frame takes on the average, that later ones take at least
_FEW = 1500  # points that no choice is worked out for
_CHOOSE = 3.5e4  # steps of Python of the choice itself, for each number of frames that it tries
_FOUND_OUT = 1e6  # and that of an object that one reference wave does not fit
_LOOK_UP = 8000.0  # steps of Python of an object that is looked up
_WAVE = 8.0  # of a look at some pixels, in phasors


@dataclass(frozen=True)
class ObjectCost:
    """Of one object.

    key, later : of a key frame, and of the others
    serves : frames that a key frame serves
    how : what is done with it, and why
    """

    name: str
    key: OperationCounts
    later: OperationCounts
    serves: int
    how: str

    def mean(self, frames: int) -> OperationCounts:
        """Of a frame on the average of so many."""
        keys = ceil(frames / self.serves) / frames
        return self.key.times(keys) + self.later.times(1 - keys)


def cost(
    scene: Scene,
    objects: Sequence[ObjectFrame],
    later: range,
    slm: SLM,
    wavelength: float,
    coding: Coding,
    *,
    tolerance: float = 1e-3,
    **_: object,
) -> list[ObjectCost]:
    """Of each object over some frames.

    objects : the objects of the first frame; later : the numbers of the others
    """
    window = Window.full(slm)
    plane = plane_of(slm, wavelength, window, coding.passband)
    always = 1 + len(later)
    choosing = _CHOOSE * (1 + log2(max(always, 4) / 4))
    known: dict[tuple[float, ...], tuple[int, OperationCounts]] = {}
    out: list[ObjectCost] = []
    chosen: list[tuple[int, Choice]] = []
    for obj in sorted(objects, key=lambda obj: -len(obj.cloud)):
        if not len(obj.cloud):
            continue
        own = replace(plane, points=len(obj.cloud))
        alike = _size(obj.cloud)
        if alike not in known:
            some, each = some_of(obj.cloud)
            parts = split(some, own, each)
            counts = cost_of(obj.cloud, own, tolerance, parts, each)
            known[alike] = len(parts), counts
        waves, fresh = known[alike]

        def afresh(
            how: str, steps: float = 0.0, frames: int = always, name: str = obj.name,
            fresh: OperationCounts = fresh,
        ) -> None:  # fmt: skip
            key = fresh + OperationCounts(calls=steps)
            out.append(ObjectCost(name, key, fresh, frames, how))

        how = rest(scene, obj, later)
        if how:
            out.append(ObjectCost(obj.name, fresh, OperationCounts(), always, how))
            continue
        if obj.body is None or obj.ids is None or obj.pose is None:
            afresh("afresh: its points are not known again")
            continue
        if waves > 1:
            # So deep or wide that one wave does not fit it: a sphere of its light would hardly pay,
            # and finding that out takes long.
            how = f"afresh, most likely: its light takes {waves} reference waves"
            afresh(how, _FOUND_OUT)
            continue
        if len(obj.cloud) <= _FEW:
            # Both ways take about as long, and finding out which is less takes longer.
            afresh("afresh, or from its sphere where that takes less", choosing)
            continue
        aim = AIM * tolerance
        body = obj.body
        outline = outline_of(body.select(slice(None, None, max(1, len(body) // _SOME))))
        plan = planned(obj, outline, own, aim)
        if len(chosen) < _CHOSEN:
            poses = [obj.pose, *poses_ahead(scene, obj, later)]
            choice = choose(plan, outline, poses, plane, aim)
            chosen.append((len(obj.cloud), choice))
        else:
            # The smallest of them: the others have fewer points still.
            count, choice = chosen[-1]
            choice = replace(choice, why=f"as for a body of {count} points: {choice.why}")
        if not choice.pays:
            afresh(f"afresh: {choice.why}", choosing, choice.frames)
            continue
        shown = pixels_from(plan.axes)
        # Looked up, it takes the counted share of what summing its points would, on the average of
        # the frames that a key frame serves; that one's part of it is in the key frame.
        sums = sums_of(fresh, shown)
        part = choice.reused / choice.fresh
        later_part = max(part - _KEY / choice.frames, _LATER * part)
        key_part = (part - later_part) * choice.frames
        look = OperationCounts(phasors=_WAVE * looked_at(len(obj.cloud), tolerance), calls=_LOOK_UP)
        others = sums.times(later_part) + shown + look
        key = others + sums.times(key_part) + OperationCounts(calls=choosing)
        out.append(ObjectCost(obj.name, key, others, choice.frames, choice.why))
    return out


def _size(cloud: PointCloud) -> tuple[float, ...]:
    """What clouds of about the same cost have in common: points, extent, depth, to some 10 %."""
    box = bounding_box(cloud.positions)
    lengths = np.concatenate([box[:, 1] - box[:, 0], box[2]])
    return len(cloud), *np.rint(8 * np.log(np.maximum(lengths, 1e-9))).tolist()


def sums_of(fresh: OperationCounts, shown: OperationCounts) -> OperationCounts:
    """What is left of a frame afresh without its pixels."""
    return OperationCounts(
        products=max(fresh.products - shown.products, 0.0),
        phasors=fresh.phasors,
        bytes=max(fresh.bytes - shown.bytes, 0.0),
        calls=max(fresh.calls - shown.calls, 0.0),
        memory=fresh.memory,
    )


def looked_at(points: int, tolerance: float) -> float:
    """Waves of the look at a frame that was looked up; of many points now and then."""
    return waves_looked_at(points, tolerance) * (1.0 if points <= LOOKED else 1 / SOMETIMES)


def rest(scene: Scene, obj: ObjectFrame, later: range) -> str:
    """Words for an object that does the same in all frames to come; none for another."""
    if not len(later):
        return ""
    if obj.pose is not None and obj.body is not None:
        ahead = poses_ahead(scene, obj, later)
        return "it rests" if ahead and all(pose.same_as(obj.pose) for pose in ahead) else ""
    after = next((o for o in scene.frame(later[0]).objects if o.name == obj.name), None)
    return "it rests" if after is not None and same_light(obj, after) else ""
