"""Systems side by side on one scene: points, times and errors of every frame, interleaved."""

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.bench.kept_scene import kept_scene
from chrmc.cgh import DEFAULT_METHOD, compute_field, method_named
from chrmc.compensation import video
from chrmc.compensation.ch_rmc_paper.error_correction import match, rule_named, snr
from chrmc.compensation.frame import VideoFrame
from chrmc.compensation.held import Matcher
from chrmc.encoding import Coding
from chrmc.record import FrameRecord
from chrmc.reference import reference_samples, relative_error
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Scene, SceneFrame, frame_range
from chrmc.slm import SLM
from chrmc.window import Window

Field = NDArray[np.complex64]
Images = Callable[[Field, Field, SceneFrame], Mapping[str, float]]
"""(field, exact field, scene frame) → object name → PSNR in dB of its reconstruction."""


@dataclass(frozen=True)
class System:
    """A CGH method with a video method.

    label : what tables call it
    options : of both methods
    """

    label: str
    cgh: str
    compensation: str = "none"
    options: tuple[tuple[str, Any], ...] = ()


@dataclass
class Measured:
    """What was measured of one system, one entry per frame.

    seconds : the whole frame, from the scene's points to the complex field
    points_moving : computed points without those of objects that stand still
    error_shown : relative L2 field error against the points that the method says it shows
    error_scene : the same against the scene's points; about 1.2 and no fault where compensated
        points have phases of their own (RGB-D)
    psnr_shown : PSNR in dB of the frame's worst object, reconstructed, against the exact field of
        the points shown, or None where images were not compared
    psnr_scene : the same against the exact field of the scene's points; some 20 dB where phases
        are the method's own, since then the speckle is another
    snr_images : Eq. 14 in dB, the points shown against the scene's; inf for the same points, NaN
        for points that lie on no pixel grid
    cache : what the CGH method keeps from frame to frame, or None; str() of it tells its size
    refused : why there is nothing, in the method's words
    """

    system: System
    records: list[FrameRecord] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    points_moving: list[int] = field(default_factory=list)
    error_shown: list[float] = field(default_factory=list)
    error_scene: list[float] = field(default_factory=list)
    psnr_shown: list[float | None] = field(default_factory=list)
    psnr_scene: list[float | None] = field(default_factory=list)
    snr_images: list[float] = field(default_factory=list)
    cache: Any = None
    refused: str = ""

    def mean(self, name: str) -> float:
        """Mean over the frames of `seconds`, or of a number in the records."""
        values = getattr(self, name, None)
        if values is None:
            values = [getattr(record, name) for record in self.records]
        values = [v for v in values if v is not None]
        return float(np.mean(values)) if values else float("nan")

    def rms(self, name: str) -> float:
        """Root mean square over the frames of one of the errors."""
        values = np.array(getattr(self, name), dtype=float)
        return float(np.sqrt(np.mean(values**2))) if len(values) else float("nan")

    @property
    def median_seconds(self) -> float:
        """Median over the frames."""
        return float(np.median(self.seconds)) if self.seconds else float("nan")

    def worst(self, name: str) -> float:
        """Smallest over the frames, dB; NaN where no images were compared."""
        values = [v for v in getattr(self, name) if v is not None and not np.isnan(v)]
        return float(min(values)) if values else float("nan")

    @property
    def corrections(self) -> float:
        """Mean points computed on frames that are not computed whole: the paper's counting."""
        values = [r.points_computed for r in self.records if not r.key]
        return float(np.mean(values)) if values else float("nan")

    def stage(self, name: str) -> float:
        """Mean seconds of a stage; 0 where the method has none."""
        return float(np.mean([r.stage_seconds.get(name, 0.0) for r in self.records] or [np.nan]))


def no_field(
    cloud: PointCloud, slm: SLM, wavelength: float, window: Window, passband: Any
) -> Field:
    """A CGH method that computes nothing: for counting points."""
    return np.zeros(window.shape, dtype=np.complex64)


def count_points(
    system: System, scene: Scene, slm: SLM, wavelength: float, numbers: range, coding: Coding
) -> list[FrameRecord]:
    """The ledgers of a video without computing it; the CGH method has no say in points."""
    made = video(
        scene,
        slm,
        wavelength,
        cgh=no_field,
        compensation=system.compensation,
        frames=(numbers[0], numbers[-1]),
        coding=coding,
        **dict(system.options),
    )
    return [frame.record for frame in made]


def still_objects(scene: Scene, numbers: range) -> set[str]:
    """Names of the objects that show the same points in all these frames."""
    first = scene.frame(numbers[0])
    still = {obj.name: obj for obj in first.objects}
    for number in numbers[1:]:
        for obj in scene.frame(number).objects:
            before = still.get(obj.name)
            if before is not None and not before.cloud.same_as(obj.cloud):
                del still[obj.name]
    return set(still)


def measure(
    systems: list[System],
    scene: Scene,
    slm: SLM,
    wavelength: float,
    coding: Coding,
    *,
    frames: tuple[int, int] | None = None,
    pixels: int = 256,
    images: Images | None = None,
    image_every: int = 10,
    watch: Callable[[range], Iterable[int]] = iter,
) -> list[Measured]:
    """Every system on every frame, in turn, so that a busy machine is fair to all.

    frames : (first, last), inclusive; pixels : on which field errors are measured
    images : compares reconstructions with those of the exact field, every `image_every` frames
    watch : wraps the frame numbers, as a progress bar does

    A system that refuses has its reason in `refused` and nothing else.
    """
    kept = kept_scene(scene, range(1, scene.frame_count + 1))
    numbers = frame_range(kept, frames)
    still = still_objects(kept, numbers)
    rng = np.random.default_rng(20180917)
    rows, columns = rng.integers(0, slm.height, pixels), rng.integers(0, slm.width, pixels)
    out = [Measured(system) for system in systems]
    running = [_start(m, kept, slm, wavelength, numbers, coding) for m in out]
    for number in watch(numbers):
        scene_frame = kept.frame(number)
        compare = images is not None and (number - numbers[0]) % image_every == 0
        exact = _exact(scene_frame.cloud, slm, wavelength, coding) if compare else None
        truths: dict[bytes, NDArray[np.complex128]] = {}

        def truth(cloud: PointCloud, known: dict[bytes, Any] = truths) -> NDArray[np.complex128]:
            key = cloud.positions.tobytes() + cloud.phase.tobytes()
            if key not in known:
                known[key] = reference_samples(
                    cloud, slm, wavelength, rows, columns, passband=coding.passband
                )
            result: NDArray[np.complex128] = known[key]
            return result

        for measured, made in zip(out, running, strict=True):
            frame = None if measured.refused else _next(measured, made)
            if frame is None:
                continue
            sampled = frame.field[rows, columns]
            measured.error_shown.append(relative_error(sampled, truth(frame.shown)))
            measured.error_scene.append(relative_error(sampled, truth(frame.cloud)))
            measured.points_moving.append(_moving(frame, still))
            measured.snr_images.append(_snr(frame, kept))
            worst: list[float | None] = [None, None]
            if images is not None and exact is not None:
                own = exact
                if frame.shown is not frame.cloud:
                    own = _exact(frame.shown, slm, wavelength, coding)
                for k, target in enumerate((own, exact)):
                    found = images(frame.field, target, scene_frame)
                    worst[k] = min(found.values()) if found else None
            measured.psnr_shown.append(worst[0])
            measured.psnr_scene.append(worst[1])
    return out


def _start(
    measured: Measured, scene: Scene, slm: SLM, wavelength: float, numbers: range, coding: Coding
) -> Iterator[VideoFrame]:
    system = measured.system
    options = method_named(system.cgh).with_cache(dict(system.options))
    measured.cache = options.get("cache")
    try:
        return video(
            scene,
            slm,
            wavelength,
            cgh=system.cgh,
            compensation=system.compensation,
            frames=(numbers[0], numbers[-1]),
            coding=coding,
            **options,
        )
    except (ValueError, ImportError) as error:
        measured.refused = str(error)
        return iter(())


def _next(measured: Measured, made: Iterator[VideoFrame]) -> VideoFrame | None:
    """The next frame with its field made and its time taken, or None when it is refused."""
    start = time.perf_counter()
    try:
        frame = next(made)
        _ = frame.field
    except ValueError as error:
        measured.refused = str(error)
        return None
    measured.seconds.append(time.perf_counter() - start)
    measured.records.append(frame.record)
    return frame


def _moving(frame: VideoFrame, still: set[str]) -> int:
    """Points computed for what moves: of a frame computed whole, less what stands still."""
    computed = frame.record.points_computed
    if computed < len(frame.cloud) or not frame.record.key:
        return computed
    return computed - sum(len(o.cloud) for o in frame.scene_frame.objects if o.name in still)


def _snr(frame: VideoFrame, scene: Scene) -> float:
    """Eq. 14 of the points shown, strict matching."""
    shown, cloud = frame.shown, frame.cloud
    if shown is cloud or shown.same_as(cloud):
        return float("inf")
    if scene.form != "rgbd":
        return float("nan")
    matcher = Matcher.of(scene, "strict")
    found = match(shown, cloud, rule_named("strict"), matcher.pixel_pitch, matcher.plane_spacing)
    return snr(shown, cloud, found)


def _exact(cloud: PointCloud, slm: SLM, wavelength: float, coding: Coding) -> Field:
    """The exact field for images: right to 1e-4."""
    return compute_field(
        cloud, slm, wavelength, DEFAULT_METHOD, passband=coding.passband, tolerance=1e-4
    )
