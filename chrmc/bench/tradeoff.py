"""Time against error: every CGH and video method, at every accuracy setting it has.

Methods take turns on the same fresh points. One whose time, reckoned from runs on fewer points,
passes the limit is left out and says so.
"""

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import chrmc
from chrmc.bench.reckon import reckon
from chrmc.bench.speed import fresh_clouds, surface_cloud
from chrmc.bench.tradeoff_table import Entry
from chrmc.cgh import DEFAULT_METHOD, METHODS, field_and_error, method_named
from chrmc.compensation import COMPENSATIONS
from chrmc.encoding import Coding
from chrmc.reference import reference_samples, relative_error
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import ObjectFrame, Scene, SceneFrame
from chrmc.slm import SLM

Images = Callable[[NDArray[np.complex64], NDArray[np.complex64], SceneFrame], Mapping[str, float]]
"""(field, exact field, scene frame) → object name → PSNR in dB of its reconstruction."""
Watch = Callable[[Sequence[Any], str], Iterable[Any]]

TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
# CGH method and options; a method that is not named here has one setting, its default.
VIDEO_SETTINGS: dict[str, list[tuple[str, dict[str, Any]]]] = {
    "none": [(DEFAULT_METHOD, {"tolerance": t}) for t in (1e-2, 1e-3, 1e-5)],
    "ch-rmc-object": [(DEFAULT_METHOD, {"tolerance": t}) for t in TOLERANCES],
}
LIMIT = 10.0
"""Seconds per frame past which a method is left out."""
_ONCE = 0.25  # of the limit: what takes longer is run once
_EXACT_POINTS = 200_000  # a more exact field for the images is made up to here


@dataclass(frozen=True)
class _Job:
    """A CGH method at one setting; `options` hold its cache, `setting` does not."""

    entry: Entry
    method: str
    setting: dict[str, Any]
    options: dict[str, Any]


@dataclass(frozen=True)
class Optics:
    """What every field is computed for.

    wavelength : metres
    """

    slm: SLM
    wavelength: float
    coding: Coding

    def field(
        self, cloud: PointCloud, method: str, options: Mapping[str, Any]
    ) -> tuple[NDArray[np.complex64], float | None]:
        """(H, W) field by a CGH method, and the error it expects where it says so."""
        return field_and_error(
            cloud, self.slm, self.wavelength, method, passband=self.coding.passband, **options
        )

    def pixels(self, points: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Rows and columns where errors are measured: fewer pixels for more points."""
        random = np.random.default_rng(0)
        count = max(160, min(512, 8_000_000 // max(points, 1)))
        return (
            random.integers(0, self.slm.height, count),
            random.integers(0, self.slm.width, count),
        )

    def truth(
        self, cloud: PointCloud, pixels: tuple[NDArray[np.int64], NDArray[np.int64]]
    ) -> NDArray[np.complex128]:
        """The float64 truth at pixels."""
        return reference_samples(
            cloud, self.slm, self.wavelength, *pixels, passband=self.coding.passband
        )


def cgh_labels() -> list[str]:
    """What `cgh_entries` measures, in its order."""
    return [e.label for e, _, _ in _cgh_jobs("", 0)]


def video_labels() -> list[str]:
    """What `video_entries` measures, in its order."""
    return [e.label for e, _, _ in _video_jobs("", 0)]


def cgh_entries(
    name: str,
    clouds: Sequence[PointCloud],
    optics: Optics,
    *,
    limit: float = LIMIT,
    images: Images | None = None,
    smaller: Sequence[Entry] = (),
    watch: Watch = lambda items, _: items,
) -> list[Entry]:
    """Every CGH method at every setting, in turn, on each of some fresh clouds.

    limit : seconds per frame past which a method is left out, all but the default one; one that
        takes more than a quarter of it is run on the first cloud only
    images : compares reconstructions, on the first cloud. The exact field is the default method's
        at 2e-6; past 200,000 points the one that its finest setting just made
    smaller : entries of smaller clouds of the same kind, from which times are reckoned; without
        them parts of the cloud are run
    """
    count = len(clouds[0])
    jobs = [
        _Job(entry, method, setting, method_named(method).with_cache(setting))
        for entry, method, setting in _cgh_jobs(name, count)
    ]
    pixels = optics.pixels(count)
    truth, exact, note = None, None, ""
    if images is not None and count <= _EXACT_POINTS:
        exact, note = _exact(clouds[0], optics)
    # The finest first: what it makes may serve as the exact field of the others' images.
    finest = [job for job in jobs if job.method == DEFAULT_METHOD][-1]
    turns = [finest, *(job for job in jobs if job is not finest)]
    steps = [(number, job) for number in range(len(clouds)) for job in turns]
    for number, job in watch(steps, name):
        entry, cloud = job.entry, clouds[number]
        if job is finest:
            truth = None
        if number == 0 and job.method != DEFAULT_METHOD:
            _leave_out_slow(job, cloud, optics, limit, smaller)
        if entry.refused or (number > 0 and entry.time > _ONCE * limit):
            continue
        if truth is None:
            truth = optics.truth(cloud, pixels)
        try:
            field = _run(job, cloud, optics)
        except ValueError as refusal:
            entry.refused = str(refusal)
            continue
        entry.errors.append(relative_error(field[pixels], truth))
        entry.pixels = len(truth)
        if number or images is None:
            continue
        if exact is not None:
            found = images(field, exact, SceneFrame(1, (ObjectFrame("cloud", cloud),)))
            entry.psnr = min(found.values(), default=None)
        elif job is finest and count > _EXACT_POINTS:
            exact, entry.note = field, "exact field of the images"
        else:
            entry.note = note or "no PSNR: too many points for an exact field"
    return [job.entry for job in jobs]


def video_entries(
    scene: Scene,
    optics: Optics,
    numbers: range,
    *,
    images: Images | None = None,
    limit: float = LIMIT,
    watch: Watch = lambda items, _: items,
) -> list[Entry]:
    """Every video method at every setting, frame by frame in turn.

    images : compares reconstructions on the last frame, up to 200,000 points
    limit : seconds past which a frame, the first excepted, is the method's last

    A method that carries points whose identity is unknown is measured against those it says it
    shows: freshly quantised ones have unrelated phases.
    """
    count = len(scene.frame(numbers[0]).cloud)
    jobs: list[tuple[Entry, Iterator[Any]]] = []
    for entry, cgh, options in _video_jobs(scene.name, count):
        frames: Iterator[Any] = iter(())
        try:
            frames = chrmc.video(
                scene, optics.slm, optics.wavelength, cgh=cgh, compensation=entry.method,
                coding=optics.coding, frames=(numbers[0], numbers[-1]), **options,
            )  # fmt: skip
        except (ValueError, ImportError) as refusal:
            entry.refused = str(refusal)
        jobs.append((entry, frames))
    pixels = optics.pixels(count)
    steps = [(number, job) for number in numbers for job in jobs]
    reached, exact, note = 0, None, ""
    for number, (entry, frames) in watch(steps, f"{scene.name}, videos"):
        if number != reached:
            cloud, reached = scene.frame(number).cloud, number
            truth = optics.truth(cloud, pixels)
            if images is not None and number == numbers[-1]:
                exact, note = _exact(cloud, optics)
        if entry.refused:
            continue
        start = time.perf_counter()
        try:
            frame = next(frames)
            got = frame.field
        except ValueError as refusal:
            entry.refused = str(refusal)
            continue
        entry.seconds.append(time.perf_counter() - start)
        if len(entry.seconds) > 1 and entry.seconds[-1] > limit:
            entry.leave_out(entry.seconds[-1], about="")
        own_truth, own_exact, entry.note = truth, exact, entry.note or note
        if not frame.shown.same_as(cloud):
            own_truth, entry.note = optics.truth(frame.shown, pixels), "against the points it shows"
            if exact is not None:
                own_exact, _ = _exact(frame.shown, optics)
        entry.errors.append(relative_error(got[pixels], own_truth))
        entry.pixels = len(truth)
        if frame.record.error_predicted is not None:
            entry.predicted = max(entry.predicted or 0.0, frame.record.error_predicted)
        if own_exact is not None and images is not None:
            entry.psnr = min(images(got, own_exact, frame.scene_frame).values(), default=None)
    return [entry for entry, _ in jobs]


def synthetic(count: int, slm: SLM, rounds: int) -> list[PointCloud]:
    """Fresh car-sized clouds of so many points."""
    return fresh_clouds(surface_cloud(count, slm), rounds)


def cloud_name(count: int) -> str:
    """What the synthetic cloud of so many points is called."""
    return f"{count} point{'s' * (count > 1)}"


def _cgh_jobs(name: str, points: int) -> list[tuple[Entry, str, dict[str, Any]]]:
    return [
        (Entry(name, "cgh", method, _told(setting), points), method, dict(setting))
        for method in METHODS
        for setting in method_named(method).settings
    ]


def _video_jobs(name: str, points: int) -> list[tuple[Entry, str, dict[str, Any]]]:
    return [
        (Entry(name, "video", compensation, _told(options), points), cgh, options)
        for compensation in COMPENSATIONS
        for cgh, options in VIDEO_SETTINGS.get(compensation, [(DEFAULT_METHOD, {})])
    ]


def _told(options: Mapping[str, Any]) -> str:
    return ", ".join(
        f"{name} {value:g}" if isinstance(value, float) else f"{name} {value}"
        for name, value in options.items()
    )


def _run(job: _Job, cloud: PointCloud, optics: Optics) -> NDArray[np.complex64]:
    """One timed run, and what the method itself expects of it where it says so."""
    start = time.perf_counter()
    field, expected = optics.field(cloud, job.method, job.options)
    job.entry.seconds.append(time.perf_counter() - start)
    if expected is not None:
        job.entry.predicted = max(job.entry.predicted or 0.0, expected)
    return field


def _leave_out_slow(
    job: _Job, cloud: PointCloud, optics: Optics, limit: float, smaller: Sequence[Entry]
) -> None:
    """Refuse a method whose reckoned time passes the limit."""

    def seconds_of(count: int) -> float:
        part = cloud.select(np.linspace(0, len(cloud) - 1, count).astype(np.intp))
        options = method_named(job.method).with_cache(job.setting)
        start = time.perf_counter()
        optics.field(part, job.method, options)
        return time.perf_counter() - start

    before = [
        e
        for e in sorted(smaller, key=lambda e: e.points)
        if e.kind == "cgh" and e.label == job.entry.label and e.points < len(cloud)
    ]
    if before and before[-1].reckoned is not None:
        reckoned = before[-1].reckoned * len(cloud) / before[-1].points
    else:
        known = [(e.points, e.time) for e in before if e.seconds and not e.refused]
        try:
            reckoned = reckon(seconds_of, len(cloud), limit, known)
        except ValueError as refusal:
            job.entry.refused = str(refusal)
            return
    if reckoned > limit:
        job.entry.leave_out(reckoned)


def _exact(cloud: PointCloud, optics: Optics) -> tuple[NDArray[np.complex64] | None, str]:
    """The field that images are compared with, or None and why there is none."""
    if len(cloud) > _EXACT_POINTS:
        return None, "no PSNR: too many points for an exact field"
    try:
        return optics.field(cloud, DEFAULT_METHOD, {"tolerance": 2e-6})[0], ""
    except ValueError as refusal:
        return None, f"no PSNR: {refusal}"
