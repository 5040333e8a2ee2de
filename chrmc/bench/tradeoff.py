"""Time against error: every CGH and video method, at every accuracy setting it has.

Methods take turns on the same fresh points. One whose time, reckoned from a few of the points,
passes the limit is left out and says so.
"""

import csv
import io
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

import chrmc
from chrmc.bench.speed import fresh_clouds, surface_cloud
from chrmc.cgh import METHODS, compute_field, curved, with_cache
from chrmc.coding import Coding
from chrmc.reference import reference_samples, relative_error
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import ObjectFrame, Scene, SceneFrame
from chrmc.slm import SLM
from chrmc.video import COMPENSATIONS
from chrmc.window import Window

Images = Callable[[NDArray[np.complex64], NDArray[np.complex64], SceneFrame], Mapping[str, float]]
"""(field, exact field, scene frame) → object name → PSNR in dB of its reconstruction."""
Watch = Callable[[Sequence[Any], str], Iterable[Any]]

TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
# Accuracy settings; a method that is not named here has one, its default.
CGH_SETTINGS: dict[str, list[dict[str, Any]]] = {
    "curved": [{"tolerance": t} for t in TOLERANCES],
    "wrp": [{"planes": n} for n in (1, 4, 12)],
    "nlut": [{"depth_step": s} for s in (1e-3, 1e-4, None)],
    "nlut-1d": [{"depth_step": s} for s in (1e-3, 1e-4, None)],
}
VIDEO_SETTINGS: dict[str, list[tuple[str, dict[str, Any]]]] = {
    "none": [("curved", {"tolerance": t}) for t in (1e-2, 1e-3, 1e-5)],
    "ch-rmc": [
        *(("curved", {"surface": "object", "tolerance": t}) for t in TOLERANCES),
        ("curved", {"surface": "paper"}),
    ],
}


@dataclass
class Entry:
    """One method at one setting on one scene.

    kind : "cgh", a single frame, or "video"
    seconds : of each frame; errors : relative L2 of each frame's field
    predicted : what the method itself expected, or None
    psnr : worst object's, dB, or None where no images were compared
    refused : why there is nothing
    front : nothing else is both faster and more exact
    """

    scene: str
    kind: str
    method: str
    setting: str
    points: int
    seconds: list[float] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)
    predicted: float | None = None
    psnr: float | None = None
    refused: str = ""
    front: bool = False

    @property
    def time(self) -> float:
        """Median seconds per frame."""
        return float(np.median(self.seconds)) if self.seconds else float("nan")

    @property
    def error(self) -> float:
        """Largest over the frames."""
        return max(self.errors, default=float("nan"))

    @property
    def label(self) -> str:
        return f"{self.method} {self.setting}".strip()


def cgh_entries(
    name: str,
    clouds: Sequence[PointCloud],
    slm: SLM,
    wavelength: float,
    coding: Coding,
    *,
    limit: float = 20.0,
    images: Images | None = None,
    watch: Watch = lambda items, _: items,
) -> list[Entry]:
    """Every CGH method at every setting, in turn, on each of some fresh clouds.

    limit : seconds per frame past which a method is left out
    images : compares reconstructions, on the first cloud
    """
    jobs = [
        (Entry(name, "cgh", method, _told(options), len(clouds[0])), method, options)
        for method in METHODS
        for options in CGH_SETTINGS.get(method, [{}])
    ]
    rows, columns = _pixels(slm, len(clouds[0]))
    window = Window.full(slm)
    exact = _exact(clouds[0], slm, wavelength, coding) if images is not None else None
    kept = {id(entry): with_cache(method, options) for entry, method, options in jobs}
    for entry, method, options in jobs:
        entry.refused = _too_slow(clouds[0], slm, wavelength, coding, method, options, limit)
    for number, cloud in enumerate(watch(clouds, name)):
        truth = reference_samples(cloud, slm, wavelength, rows, columns, passband=coding.passband)
        for entry, method, _ in jobs:
            if entry.refused:
                continue
            start = time.perf_counter()
            try:
                made = compute_field(
                    cloud, slm, wavelength, method, passband=coding.passband, **kept[id(entry)]
                )
            except ValueError as refusal:
                entry.refused = str(refusal)
                continue
            entry.seconds.append(time.perf_counter() - start)
            entry.errors.append(relative_error(made[rows, columns], truth))
            if number == 0:
                if exact is not None and images is not None:
                    entry.psnr = _worst(images, made, exact, cloud)
                if method == "curved":
                    entry.predicted = _expected(
                        cloud, slm, wavelength, coding, kept[id(entry)], window
                    )
    return [entry for entry, _, _ in jobs]


def video_entries(
    scene: Scene,
    slm: SLM,
    wavelength: float,
    coding: Coding,
    numbers: range,
    *,
    images: Images | None = None,
    limit: float = 20.0,
    watch: Watch = lambda items, _: items,
) -> list[Entry]:
    """Every video method at every setting, frame by frame in turn.

    images : compares reconstructions on the last frame
    """
    count = len(scene.frame(numbers[0]).cloud)
    jobs: list[tuple[Entry, Iterator[Any]]] = []
    for compensation in COMPENSATIONS:
        for cgh, options in VIDEO_SETTINGS.get(compensation, [("curved", {})]):
            entry = Entry(scene.name, "video", compensation, _told(options), count)
            try:
                made: Iterator[Any] = chrmc.video(
                    scene, slm, wavelength, cgh=cgh, compensation=compensation, coding=coding,
                    frames=(numbers[0], numbers[-1]), **options,
                )  # fmt: skip
            except (ValueError, ImportError) as refusal:
                entry.refused, made = str(refusal), iter(())
            jobs.append((entry, made))
    rows, columns = _pixels(slm, count)
    for number in watch(numbers, f"{scene.name}, videos"):
        cloud = scene.frame(number).cloud
        truth = reference_samples(cloud, slm, wavelength, rows, columns, passband=coding.passband)
        exact = None
        if images is not None and number == numbers[-1]:
            exact = _exact(cloud, slm, wavelength, coding)
        for entry, made in jobs:
            if entry.refused:
                continue
            start = time.perf_counter()
            try:
                frame = next(made)
                got = frame.field
            except ValueError as refusal:
                entry.refused = str(refusal)
                continue
            entry.seconds.append(time.perf_counter() - start)
            if len(entry.seconds) == 2 and entry.seconds[-1] > limit:
                entry.refused = f"left out: {entry.seconds[-1]:.0f} s a frame"
            entry.errors.append(relative_error(got[rows, columns], truth))
            if frame.record.error_predicted is not None:
                entry.predicted = max(entry.predicted or 0.0, frame.record.error_predicted)
            if exact is not None and images is not None:
                worst = images(got, exact, frame.scene_frame)
                entry.psnr = min(worst.values()) if worst else None
    return [entry for entry, _ in jobs]


def synthetic(count: int, slm: SLM, rounds: int) -> list[PointCloud]:
    """Fresh car-sized clouds of so many points."""
    return fresh_clouds(surface_cloud(count, slm), rounds)


def mark_front(entries: Iterable[Entry]) -> None:
    """Mark, among the entries of one scene and kind, those that no other beats in both."""
    groups: dict[tuple[str, str], list[Entry]] = {}
    for entry in entries:
        if entry.seconds and not entry.refused:
            groups.setdefault((entry.scene, entry.kind), []).append(entry)
    for group in groups.values():
        least = float("inf")
        for entry in sorted(group, key=lambda e: (e.time, e.error)):
            entry.front = entry.error < least
            least = min(least, entry.error)


COLUMNS = (
    "scene", "kind", "method", "setting", "points", "seconds", "error", "predicted", "psnr_db",
    "front", "refused",
)  # fmt: skip


def to_csv(entries: Iterable[Entry]) -> str:
    """The table as text, one line per entry."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for e in entries:
        writer.writerow(
            (e.scene, e.kind, e.method, e.setting, e.points, _number(e.time), _number(e.error),
             _number(e.predicted), _number(e.psnr), int(e.front), e.refused)
        )  # fmt: skip
    return out.getvalue()


def _number(value: float | None) -> str:
    return "" if value is None or np.isnan(value) else f"{value:.4g}"


def _told(options: Mapping[str, Any]) -> str:
    return ", ".join(
        f"{name} {value:g}" if isinstance(value, float) else f"{name} {value}"
        for name, value in options.items()
    )


def _pixels(slm: SLM, points: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Where errors are measured: fewer pixels for more points."""
    random = np.random.default_rng(0)
    count = max(32, min(512, 8_000_000 // max(points, 1)))
    return random.integers(0, slm.height, count), random.integers(0, slm.width, count)


def _too_slow(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    coding: Coding,
    method: str,
    options: Mapping[str, Any],
    limit: float,
) -> str:
    """Why a method is left out, from its time on a few of the points; "" if it is not."""
    few = min(len(cloud), 16)
    if method == "curved" or len(cloud) <= few:
        return ""
    times = []
    for count in (few // 4, few):
        part = cloud.select(np.linspace(0, len(cloud) - 1, count).astype(np.intp))
        start = time.perf_counter()
        try:
            compute_field(
                part, slm, wavelength, method, passband=coding.passband,
                **with_cache(method, dict(options)),
            )  # fmt: skip
        except ValueError as refusal:
            return str(refusal)
        times.append(time.perf_counter() - start)
    per_point = max(times[1] - times[0], 0.0) / (few - few // 4)
    reckoned = times[1] + per_point * (len(cloud) - few)
    return f"left out: about {reckoned:.0f} s a frame" if reckoned > limit else ""


def _exact(cloud: PointCloud, slm: SLM, wavelength: float, coding: Coding) -> NDArray[np.complex64]:
    return compute_field(cloud, slm, wavelength, "curved", passband=coding.passband, tolerance=2e-6)


def _worst(
    images: Images,
    made: NDArray[np.complex64],
    exact: NDArray[np.complex64],
    cloud: PointCloud,
) -> float | None:
    found = images(made, exact, SceneFrame(1, (ObjectFrame("cloud", cloud),)))
    return min(found.values()) if found else None


def _expected(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    coding: Coding,
    options: Mapping[str, Any],
    window: Window,
) -> float | None:
    if len(cloud) * window.size <= curved.SMALL:
        return None
    try:
        made = curved.low_rank(cloud, slm, wavelength, window, coding.passband, **options)
    except ValueError:  # the method took the exact sum instead
        return None
    return made.error_predicted
