"""MC-NLUT: each object's hologram follows its motion in x and y; the difference is computed.

Motion compensation-based NLUT (reference 28 of the CH-RMC paper). Between successive frames an
object gets one motion vector; its hologram is shifted by it (shift-invariance), the strips that
come in from outside are computed, and points that then differ from the frame's are taken out
and put in. A rotating object changes depth and outline under a shift, so most points differ.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh import Method
from chrmc.compensation.frame import VideoFrame
from chrmc.compensation.held import (
    WORN,
    Chain,
    Computer,
    Correction,
    Held,
    Matcher,
    correct,
    objects_of,
)
from chrmc.compensation.nlut.blocks import grid_offset, image_of, lateral_vector
from chrmc.compensation.shift import Move, moved, shift_into, strips, to_pixels
from chrmc.encoding import Coding
from chrmc.record import FrameRecord
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import ObjectFrame, Scene
from chrmc.slm import SLM

Fields = dict[str, NDArray[np.complex64]]


@dataclass(frozen=True, eq=False)
class Update:
    """What happens to one object's hologram between two frames.

    carried : its points after the move; correction : what is changed in them then
    whole : computed afresh instead, from the points that `correction` adds
    """

    name: str
    move: Move
    carried: PointCloud
    correction: Correction
    whole: bool = False


def frames(
    scene: Scene,
    slm: SLM,
    wavelength: float,
    cgh: str | Method,
    numbers: range,
    coding: Coding,
    *,
    search: int = 8,
    measure: str = "sad",
    matching: str | None = None,
    **options: Any,
) -> Iterator[VideoFrame]:
    """Frames by motion compensation of whole objects in x and y, with any CGH method.

    search : longest vector per axis and frame, scene pixels
    measure : "sad" or "mse" of intensities, whose least value decides (full search)
    matching : as in `chrmc.compensation.nlut.tr_nlut`
    options : for the CGH method

    The publications give no search range and no criterion: these are choices. Points of known
    identity need no search: their vector is the median of their displacements, in SLM pixels.
    With "exact" the field is that of `none` within 1e-5 with rt or nlut, 1e-2 with wrp, of the
    light that the points have one by one, which is more where waves cancel. An object that far more
    light was taken out of than the frame shows is computed whole: what is gone leaves its rounding.
    `frame.shown` are the points that the field is the sum of: compensated points keep their
    phases. One field is kept per object.
    """
    matcher = Matcher.of(scene, matching)
    computer = Computer(slm, wavelength, cgh, coding.passband, options)
    held: dict[str, Held] = {}
    taken: dict[str, float] = {}
    chain: Chain[Fields] = Chain({})
    for number in numbers:
        record = FrameRecord(number, key=not held)
        updates = []
        with record.stage("PE"):
            scene_frame = scene.frame(number)
            for obj in objects_of(scene_frame, held):
                before = held.get(obj.name, Held.empty(obj))
                move = _vector(before, obj, matcher, slm, search, measure)
                after = Held(moved(before.cloud, move, slm, wavelength), before.ids)
                after = computer.visible(after)
                held[obj.name], correction = correct(after, obj, matcher)
                taken[obj.name] = taken.get(obj.name, 0.0) + computer.light(correction.removed)
                updates.append(Update(obj.name, move, after.cloud, correction))
            shown = PointCloud.concatenate(held[obj.name].cloud for obj in scene_frame.objects)
            most = WORN * computer.light(shown) / len(held) if held else 0.0
            for i, update in enumerate(updates):
                if taken[update.name] > most:
                    taken[update.name] = 0.0
                    everything = Correction(PointCloud.empty(), held[update.name].cloud)
                    update = updates[i] = Update(
                        update.name, Move(), PointCloud.empty(), everything, whole=True
                    )
                computer.book(record, update.correction)
                blank = sum(window.size for window in strips(update.move, slm))
                record.point_pixels += len(update.carried) * blank
                record.blank_share += blank / (slm.width * slm.height * len(updates))
        make = chain.then(
            partial(_update, updates=updates, computer=computer, record=record),
            partial(_total, computer=computer, shown=shown, record=record),
            partial(computer.compute, shown, record, "HC"),
        )
        yield VideoFrame(scene_frame, record, make, shown=shown)


def _vector(
    held: Held, obj: ObjectFrame, matcher: Matcher, slm: SLM, search: int, measure: str
) -> Move:
    """How an object moved since the frame before."""
    if len(held) == 0 or len(obj.cloud) == 0:
        return Move()
    if held.ids is not None and obj.ids is not None:
        _, i, j = np.intersect1d(held.ids, obj.ids, return_indices=True)
        if len(i) == 0:
            return Move()
        apart = obj.cloud.positions[j] - held.cloud.positions[i]
        dx, dy, _ = np.median(apart, axis=0)
        return to_pixels(dx, dy, slm)
    pitch, spacing = matcher.pixel_pitch, matcher.plane_spacing
    offset = grid_offset(obj.cloud, matcher.pixel_pitch)
    before = image_of(held.cloud, pitch, spacing, offset)
    after = image_of(obj.cloud, pitch, spacing, offset)
    rows, columns = lateral_vector(before.intensity, before.origin, after, search, measure)
    return to_pixels(columns * pitch, rows * pitch, slm)


def _update(
    fields: Fields, updates: list[Update], computer: Computer, record: FrameRecord
) -> Fields:
    for update in updates:
        field = fields.get(update.name)
        if field is None or update.whole:
            stage = "HC" if record.key or update.whole else "EC"
            fields[update.name] = computer.change(update.correction.added, record, stage)
            continue
        if update.move:
            with record.stage("RMC"):
                still = field
                field = np.zeros_like(still)
                shift_into(field, still, update.move)
            for window in strips(update.move, computer.slm):
                field[window.slices] = computer.change(update.carried, record, "HC", window)
        if len(update.correction):
            field += computer.change(update.correction.signed, record, "EC")
        fields[update.name] = field
    return fields


def _total(
    fields: Fields, computer: Computer, shown: PointCloud, record: FrameRecord
) -> NDArray[np.complex64]:
    total = np.zeros(computer.slm.shape, dtype=np.complex64)
    for field in fields.values():
        total += field
    return computer.settled(total, shown, record)
