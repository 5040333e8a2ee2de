"""CH-RMC as published, over any CGH method: `--compensation ch-rmc --surface paper`.

Each moving object's hologram is carried from frame to frame on a cylinder around the centre of
its arc; what the previous frame can't give is filled by the CGH method, and points that differ
between the compensated and the actual object are corrected. Objects that stand still are computed
once. Stages: PE parameter extraction, PA position adjustment (OPH ↔ LPH), CON conversion, RMC
rotation, HC hologram calculation (key frames and blanks), EC error correction.

Measured on the LC-R 1080 at R = 14.5 cm, against recomputation: one step of 0.3° on its reused
columns 14 % for an object turning about itself, 11 % for the car at frame 1. Along `car-house` the
whole frame is 5 % wrong after one step and 13–21 % from the fifth on, its images at 39–54 dB;
along `car-house-deep`, far off the arcs' axes, up to 89 % and 23 dB. A radius near the arc's
depth does better (0.25 m on `car-house`: 7 % instead of 16 %). See `chrmc bench rmc`.

`points_computed` counts as the paper does: all points of a key frame, else only points added or
removed. The work on blanks is in `point_pixels`.
"""

import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh import Method
from chrmc.compensation.ch_rmc_paper.conversion import RADIUS, check_radius
from chrmc.compensation.ch_rmc_paper.error_correction import (
    SNR_THRESHOLD,
    rule_named,
)
from chrmc.compensation.ch_rmc_paper.image_measures import image_measures
from chrmc.compensation.ch_rmc_paper.plan import plan
from chrmc.compensation.ch_rmc_paper.track import Track, Work
from chrmc.compensation.frame import VideoFrame
from chrmc.compensation.held import PLANE_SPACING
from chrmc.encoding import Coding
from chrmc.record import FrameRecord
from chrmc.reference import relative_error
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import ObjectFrame, Scene, SceneFrame
from chrmc.slm import SLM

Measure = Callable[[NDArray[np.complex64], NDArray[np.complex64], SceneFrame], dict[str, Any]]
"""(compensated field, recomputed field, scene frame) → object name → measures ("psnr" in dB, …)."""


def frames(
    scene: Scene,
    slm: SLM,
    wavelength: float,
    cgh: str | Method,
    numbers: range,
    coding: Coding,
    *,
    radius: float = RADIUS,
    snr_threshold: float = SNR_THRESHOLD,
    matching: str = "strict",
    rekey_every: int | None = None,
    rekey_error: float | None = None,
    rekey_image: float | None = None,
    measure_reuse: bool = False,
    measure: Measure | bool | None = None,
    **options: Any,
) -> Iterator[VideoFrame]:
    """Frames of the published method.

    radius : of the curved hologram, metres
    snr_threshold : dB of Eq. 14 below which an object's points are corrected; inf corrects always
    matching : "strict" or "tolerant", see `error_correction`
    rekey_every : a key frame after so many frames
    rekey_error : a key frame where the field error against recomputation with the same CGH method
        would pass this
    rekey_image : a key frame where an object's PSNR in dB would fall below this
    measure_reuse : record `error_reuse` of each frame, and of each object alone in
        `record.objects` (a full recomputation, not booked)
    measure : image measures per object, recorded in `record.image`: True for those of
        `image_measures`, or a function, see `Measure`
    options : for the CGH method

    A frame's `error_predicted` is what the CGH method states of it, and `error_reuse` where light
    was carried; without that measurement a carried frame states none. Objects that are left with
    little light, and frames whose objects cancel, are computed afresh where the method's error
    would otherwise be more of the light than it promises.

    Where identity is unknown (RGB-D) a carried point and its freshly quantised twin have
    unrelated phases: `frame.shown` is then the points that the field stands for.
    """
    rule = rule_named(matching)
    check_radius(radius, slm, wavelength)
    _check_limits(rekey_every, rekey_error)
    if measure is True or (rekey_image is not None and not measure):
        measure = image_measures(slm, wavelength)
    planes = scene.planes
    work = Work(
        slm, wavelength, cgh, coding, options, radius, rule, snr_threshold,
        scene.pixel_pitch, planes.step if planes else PLANE_SPACING,
    )  # fmt: skip
    return _frames(
        scene, work, numbers, rekey_every, rekey_error, rekey_image, measure_reuse, measure or None
    )


def _check_limits(rekey_every: int | None, rekey_error: float | None) -> None:
    if rekey_every is not None and rekey_every < 1:
        raise ValueError(f"rekey_every counts frames from 1, not {rekey_every}")
    if rekey_error is not None and not rekey_error > 0:
        raise ValueError(f"rekey_error is a relative error above 0, not {rekey_error}")


def _frames(
    scene: Scene,
    work: Work,
    numbers: range,
    rekey_every: int | None,
    rekey_error: float | None,
    rekey_image: float | None,
    measure_reuse: bool,
    measure: Measure | None,
) -> Iterator[VideoFrame]:
    start = time.perf_counter()
    motions = plan(scene)
    extraction = (time.perf_counter() - start) / len(numbers)
    tracks: dict[str, Track] = {}
    last_key = numbers[0]
    for number in numbers:
        scene_frame = scene.frame(number)
        record = FrameRecord(number, key=False)
        record.stage_seconds["PE"] = extraction
        due = rekey_every is not None and number - last_key >= rekey_every
        before = tracks
        tracks, notes, moving = {}, {}, []
        for obj in scene_frame.objects:
            name = obj.name
            motion = motions[name].get(number) if name in motions else None
            track = before.get(name)
            unseen = track is None or len(track.cloud) == 0 or len(obj.cloud) == 0
            stale = track is not None and (track.carried or motion is not None)
            if track is None or unseen or (due and stale):
                tracks[name] = work.key(obj, record)
            else:
                track, notes[name] = work.advance(track, obj, motion, record)
                spoilt = work.spoilt([track], track.power)  # as where most of its light left
                tracks[name] = work.key(obj, record) if spoilt else track
                if motion is not None and not spoilt:
                    moving.append(name)
        shown = _shown(tracks, scene_frame)
        field, expected, afresh = work.together(tracks.values(), shown)
        record.key = number == numbers[0] or due or afresh
        if measure_reuse or rekey_error is not None or measure is not None:
            new, errors = _recomputed(tracks, scene_frame, work)
            again = field if afresh else work.together(new.values(), shown)[0]
            _judge(record, field, again, scene_frame, measure)
            if _too_wrong(record, rekey_error, rekey_image):
                for obj in scene_frame.objects:
                    if tracks[obj.name].carried:
                        tracks[obj.name] = work.key(obj, record)
                        errors[obj.name] = 0.0
                shown = _shown(tracks, scene_frame)
                field, expected, afresh = work.together(tracks.values(), shown)
                record.key, moving = True, []
                _judge(record, field, again, scene_frame, measure)
            for name, error in errors.items():
                notes.setdefault(name, {})["error_reuse"] = error
        if afresh or not any(track.carried for track in tracks.values()):
            record.error_predicted = expected
        elif expected is not None and record.error_reuse is not None:
            record.error_predicted = expected + record.error_reuse
        if record.key:
            last_key = number
        blanks = [tracks[name].blank for name in moving]
        record.blank_share = sum(blanks) / (len(blanks) * field.size) if blanks else 0.0

        def whole(field: NDArray[np.complex64] = field) -> NDArray[np.complex64]:
            return field

        frame = VideoFrame(scene_frame, record, whole, shown=shown)
        for entry in record.objects:
            entry.update(notes.get(entry["name"], {}))
        yield frame


def _too_wrong(record: FrameRecord, rekey_error: float | None, rekey_image: float | None) -> bool:
    error = record.error_reuse
    if rekey_error is not None and error is not None and error > rekey_error:
        return True
    if rekey_image is None:
        return False
    return any(entry["psnr"] < rekey_image for entry in record.image.values())


def _truth(track: Track, obj: ObjectFrame) -> PointCloud:
    """The points that the field should show: the scene's, or the carried ones (RGB-D)."""
    return track.cloud if obj.ids is None else obj.cloud


def _shown(tracks: dict[str, Track], scene_frame: SceneFrame) -> PointCloud:
    return PointCloud.concatenate(_truth(tracks[t.name], t) for t in scene_frame.objects)


def _recomputed(
    tracks: dict[str, Track], scene_frame: SceneFrame, work: Work
) -> tuple[dict[str, Track], dict[str, float]]:
    """The objects with all that was carried computed afresh by the same CGH method, and every
    object's own error against that."""
    new, errors = {}, {}
    for obj in scene_frame.objects:
        track = tracks[obj.name]
        new[obj.name] = work.fresh(_truth(track, obj)) if track.carried else track
        errors[obj.name] = relative_error(track.field, new[obj.name].field)
    return new, errors


def _judge(
    record: FrameRecord,
    field: NDArray[np.complex64],
    again: NDArray[np.complex64],
    scene_frame: SceneFrame,
    measure: Measure | None,
) -> None:
    """Book the field's error against its recomputation, and the image measures."""
    record.error_reuse = relative_error(field, again)
    if measure is not None:
        record.image = measure(field, again, scene_frame)
