"""What `chrmc plan` promises against what is measured: ten kinds of scenes, three tolerances.

Processor time of one core, so that other programs matter little: `CHRMC_THREADS` is 1 meanwhile.
"""

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from chrmc.bench.kept import KeptRows
from chrmc.bench.kept_scene import kept_scene
from chrmc.compensation import COUNTED_WHOLE
from chrmc.compensation.frame import VideoFrame
from chrmc.generation.recipe import Recipe, recipe_for
from chrmc.grey_levels import encode, encode_signal
from chrmc.planning.choice import Choice
from chrmc.planning.choices import Plan, plan
from chrmc.planning.rates import BRIEF, Rates, measured
from chrmc.reference import reference_samples, relative_error
from chrmc.scene.load import load_scene
from chrmc.scene.point_scene import PointScene
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Pose, Scene
from chrmc.slm import LC_R_1080, SLM
from chrmc.threads import THREADS

TOLERANCES = (1e-2, 1e-3, 1e-4)
BUDGET = "budget"
_RIVAL, _RIVALS = 2.0, 2  # how much longer another way may be expected to take, to be measured
_PIXELS = 200
_ROOM = 1.3  # of the time measured at one tolerance, given as a budget
_ROUNDS, _LONG = 3, 6.0  # of the frames, and seconds after which there is no further one
_BRIEF = 0.2  # seconds that a plan may take, and one frame's time


@dataclass(frozen=True)
class Case:
    """A kind of scene; `frames` of it are made, so that they take seconds.

    published : the video methods of others are measured, too
    """

    name: str
    make: Callable[[], Scene]
    slm: SLM = LC_R_1080
    frames: int = 4
    published: bool = False


@dataclass(frozen=True)
class Row:
    """What came of a scene at a tolerance, with a budget, or by a published video method.

    what : "tolerance", "budget", or the method; asked : the tolerance or the seconds
    expected, measured : seconds per frame of the way that was taken, on the average
    first, middle : of the first frame, and of the median one
    best : on the average by the quickest of all ways that were measured
    planning : seconds that the plan took
    error : relative L2 error on some pixels of the last frame
    """

    scene: str
    what: str
    asked: float
    taken: str
    expected: float
    measured: float
    first: float
    middle: float
    best: float
    planning: float
    error_expected: float
    error: float

    @property
    def key(self) -> tuple[str, str]:
        """Scene and what was asked for."""
        return self.scene, self.what if self.what != "tolerance" else f"{self.asked:.0e}"

    @property
    def met(self) -> bool:
        """Whether the budget was, by the median frame, or the tolerance."""
        return (self.middle if self.what == BUDGET else self.error) <= self.asked

    @property
    def close(self) -> bool:
        """Whether the time was expected within a factor of two."""
        return 0.5 <= self.expected / self.measured <= 2

    @property
    def good(self) -> bool:
        """Whether nothing that was measured is much quicker."""
        return self.measured <= 1.5 * self.best

    @property
    def brief(self) -> bool:
        """Whether the plan took no longer than the first frame, and 0.2 s."""
        return self.planning <= min(_BRIEF, self.first)


@dataclass(frozen=True)
class Timed:
    """Seconds of a few frames: on the average, the first, the median one; error of the last."""

    mean: float
    first: float
    middle: float
    error: float


def bodies(
    number: int, points: int, size: tuple[float, float, float], turn: float, depth: float = 0.25,
    apart: float = 0.0, frames: int = 96,
) -> Scene:  # fmt: skip
    """Boxes full of points that turn by so many radians per frame, side by side."""
    objects, poses = {}, {}
    for k in range(number):
        random = np.random.default_rng(k)
        body = PointCloud(
            random.uniform(-0.5, 0.5, (points, 3)) * size,
            random.uniform(0.3, 1, points),
            random.uniform(0, 2 * np.pi, points),
        )
        place = [apart * (k - (number - 1) / 2), 0.0, depth + 2 * apart * k]
        objects[f"body {k + 1}"] = body
        poses[f"body {k + 1}"] = [
            Pose.from_rotvec([0.0, turn * n, 0.0], place) for n in range(frames)
        ]
    return PointScene(f"{number} × {points}", objects, poses)


MM = 1e-3
CASES = (
    Case("1 point", lambda: bodies(1, 1, (MM, MM, MM), 0.005)),
    Case("50 points", lambda: bodies(1, 50, (3 * MM, 2 * MM, 2 * MM), 0.005), published=True),
    Case("car-house", lambda: load_scene("car-house"), published=True),
    Case("deep", lambda: bodies(1, 1000, (6 * MM, 4 * MM, 80 * MM), 0.0005)),
    Case("dense", lambda: load_scene("car-house-dense")),
    Case("1,000,000 points", lambda: bodies(1, 1_000_000, (2 * MM, MM, MM), 0.005), frames=2),
    Case("RGB-D", lambda: load_scene("car-house", form="rgbd")),
    Case("ten bodies", lambda: bodies(10, 150, (0.5 * MM, 0.5 * MM, 0.5 * MM), 0.005,
                                      apart=MM)),
    Case("still", lambda: bodies(1, 3000, (2 * MM, 2 * MM, 2 * MM), 0.0), frames=6),
    Case("4096 × 4096", lambda: load_scene("car-house"), SLM("large", 4096, 4096, 8.1e-6)),
)  # fmt: skip


@contextmanager
def one_core() -> Iterator[None]:
    """This process on one thread."""
    before = os.environ.get(THREADS)
    os.environ[THREADS] = "1"
    try:
        with threadpool_limits(limits=1):
            yield
    finally:
        os.environ.pop(THREADS) if before is None else os.environ.update({THREADS: before})


def rows(case: Case, kept: KeptRows[Row]) -> Iterator[Row]:
    """A scene at each tolerance, then with a budget, then by published video methods; those that
    are kept as they are.

    Rates are measured anew beside each: other programs slow all down, now less and now more.
    """
    keys = [f"{tolerance:.0e}" for tolerance in TOLERANCES] + [BUDGET]
    keys += list(COUNTED_WHOLE) if case.published else []
    scene: Any = None
    for key in keys:
        row = kept.of(case.name, key)
        if row is None:
            if scene is None:
                made = case.make()
                numbers = range(1, min(case.frames, made.frame_count) + 1)
                scene = kept_scene(made, numbers)
                times = _Times(scene, case.slm, numbers)
            rates = measured(BRIEF)
            if key == BUDGET:
                at = kept.of(case.name, f"{TOLERANCES[1]:.0e}")
                assert at is not None
                row = _row(case, times, rates, BUDGET, _ROOM * at.measured)
            elif key in COUNTED_WHOLE:
                row = _published(case, times, rates, key)
            else:
                row = _row(case, times, rates, "tolerance", float(key))
            kept.take(row)
        yield row


def _row(case: Case, times: "_Times", rates: Rates, what: str, asked: float) -> Row:
    """By the way that is taken, beside the next best ones where a tolerance was asked for."""
    found, planning = min(
        (_planned(times, rates, what, asked) for _ in range(2)), key=lambda one: one[1]
    )
    timed = times.of(found.taken)
    others = [timed.mean]
    if what != BUDGET:
        fit = [c for c in found.choices if c.meets(asked) and c is not found.taken]
        rivals = [c for c in fit if c.mean <= _RIVAL * found.taken.mean]
        others += [times.of(c).mean for c in sorted(rivals, key=lambda c: c.mean)[:_RIVALS]]
    return Row(
        case.name, what, asked, str(found.taken), found.taken.mean, timed.mean, timed.first,
        timed.middle, min(others), planning, found.taken.error or 0.0, timed.error,
    )  # fmt: skip


def _published(case: Case, times: "_Times", rates: Rates, name: str) -> Row:
    """By a video method of others, whatever it takes."""
    found = plan(times.scene, times.slm, tolerance=TOLERANCES[1], frames=times.frames, rates=rates)
    (way,) = (choice for choice in found.choices if choice.compensation == name)
    timed = times.of(way)
    return Row(
        case.name, name, 0.0, str(way), way.mean, timed.mean, timed.first, timed.middle,
        timed.mean, 0.0, way.error or 0.0, timed.error,
    )  # fmt: skip


def _planned(times: "_Times", rates: Rates, what: str, asked: float) -> tuple[Plan, float]:
    start = time.process_time()
    found = plan(
        times.scene,
        times.slm,
        tolerance=None if what == BUDGET else asked,
        budget=asked if what == BUDGET else None,
        frames=times.frames,
        rates=rates,
        every=False,
    )
    return found, time.process_time() - start


class _Times:
    """Times of ways to make a scene's frames, each measured once."""

    def __init__(self, scene: Scene, slm: SLM, numbers: range) -> None:
        self.scene, self.slm = scene, slm
        self.frames = numbers[0], numbers[-1]
        self._known: dict[tuple[str, str, str], Timed] = {}

    def of(self, choice: Choice) -> Timed:
        """Of a way."""
        key = choice.cgh, choice.compensation, str(sorted(choice.options.items()))
        if key not in self._known:
            self._known[key] = self._measured(choice)
        return self._known[key]

    def _measured(self, choice: Choice) -> Timed:
        """The quickest of some rounds, the scene's own time aside."""
        recipe = recipe_for(
            self.scene, self.slm, cgh=choice.cgh, compensation=choice.compensation,
            settings=dict(choice.options), check_pixels=0,
        )  # fmt: skip
        best: list[float] = []
        spent, error = 0.0, None
        for _ in range(_ROUNDS):
            seconds = []
            start = time.process_time()
            for frame in recipe.video(*self.frames):
                signal = frame.signal
                if signal is None:
                    encode(frame.field, self.slm, recipe.encoding, 1.0, band_limited=True)
                else:
                    encode_signal(signal, 1.0, None)
                now = time.process_time()
                seconds.append(now - start)
                start = now
            if error is None:
                error = _error(recipe, frame)
            best = min(best or seconds, seconds, key=sum)
            spent += sum(seconds)
            if spent > _LONG:
                break
        assert error is not None
        return Timed(float(np.mean(best)), best[0], float(np.median(best)), error)


def _error(recipe: Recipe, frame: VideoFrame) -> float:
    slm = recipe.slm
    random = np.random.default_rng(0)
    pixels = max(100, min(_PIXELS, 10_000_000 // max(1, len(frame.shown))))  # fewer tell little
    at = random.integers(0, slm.height, pixels), random.integers(0, slm.width, pixels)
    truth = reference_samples(
        frame.shown, slm, recipe.wavelength, *at, passband=recipe.coding.passband
    )
    if frame.signal is None:
        return relative_error(frame.field[at], truth)
    real = (truth * np.exp(2j * np.pi * recipe.coding.carrier * slm.y(at[0]))).real
    return relative_error(frame.signal[at].astype(complex), real + 0j)
