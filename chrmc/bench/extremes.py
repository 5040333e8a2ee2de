"""Promises at the extremes: random scenes at the ends of every range, against the float64 truth.

A case is decided by its seed alone. `curved` and the object surface promise a tolerance, `rt` an
error of 1e-5; the other methods promise to end, with finite numbers.
"""

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.bench.extremes_cases import FRAMES, KINDS, Case, case_of, cloud_of, passband_of
from chrmc.bench.extremes_video import IN_PARTS, frames_of, promised_of
from chrmc.cgh import DEFAULT_METHOD, field_and_error, method_named, rt
from chrmc.optics.footprint import expected_power, reach
from chrmc.optics.passband import Passband
from chrmc.reference import reference_samples
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM

__all__ = ["KINDS", "Case", "Outcome", "case_of", "cloud_of", "judged", "measured", "run"]

PATIENCE, PER_MILLION = 40.0, 12.0
"""Processor seconds that a case may take, and for each million points more: past that refusing
would have done, and it counts as a fault."""
PER_FRAME = 8.0
"""The same for each frame of a video: where waves all but cancel an exact sum in each is borne."""
_WAVES, _CONFIRMING = 3_000_000, 100_000_000  # of the truth, in a case; before a fault is called


@dataclass
class Outcome:
    """What became of a case.

    error, expected : relative L2, NaN where there is none
    seconds, cpu : by the clock, and of all processors
    refused : in which words, or ""
    frames : of a video, that were made
    fault : what promise is broken, or ""
    """

    case: Case
    seconds: float = 0.0
    cpu: float = 0.0
    error: float = float("nan")
    expected: float = float("nan")
    refused: str = ""
    frames: int = 0
    fault: str = ""

    @property
    def ratio(self) -> float:
        """Error over what is promised."""
        return self.error / promised(self.case)

    def row(self) -> dict[str, Any]:
        """For a table: plain numbers and words."""
        case = self.case
        return {
            "seed": case.seed, "kind": case.kind, "method": case.method, "video": case.video,
            "band": case.band, "promised": promised(case),
            "width": case.slm.width, "height": case.slm.height,
            "pitch": case.slm.pixel_pitch, "wavelength": case.wavelength, "depth": case.depth,
            "points": case.count, "tolerance": case.tolerance, "error": self.error,
            "expected": self.expected, "seconds": round(self.seconds, 4),
            "cpu": round(self.cpu, 4), "limit": limit(case, self.frames),
            "refused": self.refused, "fault": self.fault,
        }  # fmt: skip


def promised(case: Case) -> float:
    """The largest error that is no fault; infinite for methods that promise none."""
    if case.video:
        return promised_of(case)
    if case.method == DEFAULT_METHOD:
        return case.tolerance
    return rt.PROMISED if case.method == "rt" else float("inf")


def limit(case: Case, frames: int = 0) -> float:
    """Processor seconds that a case may take.

    frames : of a video, known once they are made
    """
    frames = max(frames, FRAMES) if case.kind == "video" else 0
    return round(PATIENCE + PER_MILLION * case.count / 1e6 + PER_FRAME * frames, 1)


def run(case: Case) -> Outcome:
    """Compute a case and judge it, in this process, however long it takes."""
    return judged(measured(case))


def measured(case: Case) -> Outcome:
    """Compute a case and measure it."""
    out = Outcome(case)
    start = time.perf_counter(), time.process_time()
    try:
        with np.errstate(all="raise", under="ignore"):
            if case.kind == "video":
                _video(case, out)
            else:
                _frame(case, cloud_of(case), out)
    except ValueError as refusal:
        out.refused = str(refusal)
    except Exception as error:  # a fault of any kind is what is looked for
        out.fault = f"{type(error).__name__}: {error}"
    out.seconds = out.seconds or time.perf_counter() - start[0]
    out.cpu = out.cpu or time.process_time() - start[1]
    return out


def judged(out: Outcome) -> Outcome:
    """The same, its fault named if a promise is broken."""
    if not out.fault and not out.refused and not out.ratio <= 1 and out.error > 0:
        out.fault = f"error {out.error:.3g}, {out.ratio:.3g} times what is promised"
    if not out.fault and out.cpu > limit(out.case, out.frames):
        out.fault = f"took {out.cpu:.0f} processor seconds"
    if "\n" in out.refused:
        out.fault = "refused in more than one line"
    return out


def _frame(case: Case, cloud: PointCloud, out: Outcome) -> None:
    passband = passband_of(case)
    options: Any = (
        {"tolerance": case.tolerance} if method_named(case.method).takes("tolerance") else {}
    )
    start = time.perf_counter(), time.process_time()
    made, expected = field_and_error(
        cloud, case.slm, case.wavelength, case.method, passband=passband, **options
    )
    out.seconds, out.cpu = time.perf_counter() - start[0], time.process_time() - start[1]
    if expected is not None:
        out.expected = expected
    if not np.isfinite(made).all():
        out.fault = "not finite"
        return
    given = cloud, case.slm, case.wavelength, passband
    out.error = sampled_error(made, *given, promised(case))


def sampled_error(
    made: NDArray[np.complexfloating],
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    passband: Passband,
    promised: float = float("inf"),
) -> float:
    """Relative L2 error estimated on pixels drawn half by their light, half from the lit ones.

    promised : the error past which many more pixels are asked: where a footprint or a run of nodes
        ends, a few may hold most of the error, and one of them among hundreds drawn says too much
    """
    error = _sampled(made, cloud, slm, wavelength, passband, _WAVES)
    if error > promised:
        error = _sampled(made, cloud, slm, wavelength, passband, _CONFIRMING)
    return error


def _sampled(
    made: NDArray[np.complexfloating],
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    passband: Passband,
    waves: int,
) -> float:
    if len(cloud) == 0:
        return 0.0 if not made.any() else float("inf")
    lit = []
    for axis, (pixels, f_max) in enumerate(
        ((slm.x(), passband.fx_max), (slm.y(), passband.fy_max))
    ):
        far = cloud.positions[:, 2] * reach(wavelength, f_max)
        low, high = np.min(cloud.positions[:, axis] - far), np.max(cloud.positions[:, axis] + far)
        lit.append(slice(*np.searchsorted(pixels, [low, high])))
    part = made[lit[1], lit[0]]
    if part.size == 0:
        return 0.0 if not made.any() else float("inf")
    largest = float(np.abs(part).max())
    power = (np.abs(part, dtype=np.float64) / (largest or 1.0)) ** 2
    share = (
        0.5 / part.size + 0.5 * power / power.sum()
        if largest
        else np.full(part.shape, 1 / part.size)
    )
    count = int(np.clip(waves // len(cloud), 60, 2000 * waves / _WAVES))
    if part.size <= count:
        drawn, weight = np.arange(part.size), np.ones(part.size)
    else:
        random = np.random.default_rng(len(cloud))
        cumulative = np.cumsum(share.ravel())
        at = (np.arange(count) + random.random(count)) / count * cumulative[-1]
        drawn = np.minimum(np.searchsorted(cumulative, at, "right"), part.size - 1)
        weight = 1 / share.ravel()[drawn]
    row, column = np.unravel_index(drawn, part.shape)
    truth = reference_samples(
        cloud, slm, wavelength, row + lit[1].start, column + lit[0].start, passband=passband
    )
    scale = np.abs(truth).max() or 1.0
    missed = weight @ np.abs((part[row, column] - truth) / scale) ** 2
    light = weight @ np.abs(truth / scale) ** 2
    if light == 0:
        return 0.0 if missed == 0 else float("inf")
    return float(np.sqrt(missed / light))


def _video(case: Case, out: Outcome) -> None:
    """The worst of a video's frames, against the points that each stands for.

    Methods that add and take out points promise an error of the light that a frame's points have
    one by one.
    """
    out.error = out.expected = 0.0
    start = time.perf_counter(), time.process_time()
    for frame in frames_of(case):
        field = frame.field
        out.frames += 1
        out.seconds += time.perf_counter() - start[0]
        out.cpu += time.process_time() - start[1]
        given = frame.shown, case.slm, case.wavelength, passband_of(case)
        error = sampled_error(field, *given, promised(case))
        if case.video in IN_PARTS:
            optics = case.slm, case.wavelength, passband_of(case)
            parts = field.size * float(expected_power(frame.shown, *optics).sum())
            error *= (
                min(1.0, float(np.linalg.norm(field.astype(np.complex128))) / np.sqrt(parts))
                if parts
                else 1.0
            )
        out.error = max(out.error, error)
        out.expected = max(out.expected, frame.record.error_predicted or 0.0)
        start = time.perf_counter(), time.process_time()
