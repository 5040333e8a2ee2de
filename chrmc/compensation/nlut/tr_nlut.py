"""TR-NLUT: only the points that changed since the frame before are computed.

Temporal redundancy-based NLUT (reference 27 of the CH-RMC paper): the hologram of a
frame is that of the frame before, less the fringes of points that are gone, plus those of points
that are new. Nothing is moved, so a moving object is taken out and put in again, at twice the
cost of computing it.
"""

from collections.abc import Iterator
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
from chrmc.encoding import Coding
from chrmc.record import FrameRecord
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Scene
from chrmc.slm import SLM


def frames(
    scene: Scene,
    slm: SLM,
    wavelength: float,
    cgh: str | Method,
    numbers: range,
    coding: Coding,
    *,
    matching: str | None = None,
    **options: Any,
) -> Iterator[VideoFrame]:
    """Frames by temporal redundancy, with any CGH method.

    matching : which points count as unchanged: "exact", "strict" or "tolerant"; default "exact"
        for points of known identity, "strict" (same pixel, same plane, intensity within 2/255)
        for RGB-D
    options : for the CGH method

    With "exact" the field is that of `none` within the rounding of the sum: 1e-5 with rt or nlut,
    of the light that the points have one by one, which is more where waves cancel; a CGH method's
    own error enters twice for each point that was removed (wrp: 1e-2). A hologram that far more
    light was taken out of than it shows is computed whole: what is gone leaves its rounding.
    `frame.shown` are the points that the field is the sum of.
    """
    matcher = Matcher.of(scene, matching)
    computer = Computer(slm, wavelength, cgh, coding.passband, options)
    held: dict[str, Held] = {}
    taken = 0.0
    chain = Chain(np.zeros(slm.shape, dtype=np.complex64))
    for number in numbers:
        record = FrameRecord(number, key=not held)
        corrections = []
        with record.stage("PE"):
            scene_frame = scene.frame(number)
            for obj in objects_of(scene_frame, held):
                before = held.get(obj.name, Held.empty(obj))
                held[obj.name], correction = correct(before, obj, matcher)
                corrections.append(correction)
            shown = PointCloud.concatenate(held[obj.name].cloud for obj in scene_frame.objects)
            taken += sum(computer.light(correction.removed) for correction in corrections)
            if taken > WORN * computer.light(shown):
                taken, record.key = 0.0, True
                corrections = [Correction(PointCloud.empty(), shown)]
            for correction in corrections:
                computer.book(record, correction)
        stage = "HC" if record.key else "EC"
        make = chain.then(
            partial(
                _update, corrections=corrections, computer=computer, record=record, stage=stage
            ),
            partial(_rendered, computer=computer, shown=shown, record=record),
            partial(computer.compute, shown, record, stage),
        )
        yield VideoFrame(scene_frame, record, make, shown=shown)


def _update(
    field: NDArray[np.complex64],
    corrections: list[Correction],
    computer: Computer,
    record: FrameRecord,
    stage: str,
) -> NDArray[np.complex64]:
    change = PointCloud.concatenate(c.signed for c in corrections)
    if record.key:
        return computer.compute(change, record, stage)
    if len(change):
        field += computer.change(change, record, stage)
    return field


def _rendered(
    field: NDArray[np.complex64], computer: Computer, shown: PointCloud, record: FrameRecord
) -> NDArray[np.complex64]:
    return computer.settled(field.copy(), shown, record)
