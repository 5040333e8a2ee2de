"""Promises at the extremes: random scenes at the ends of every range, against the float64 truth.

A case is decided by its seed alone. `curved` and the object surface promise a tolerance, `rt` an
error of 1e-5; the other methods promise to end, with finite numbers.
"""

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import chrmc
from chrmc.cgh import DEFAULT_METHOD, METHODS, field_and_error, method_named
from chrmc.encoding import coding_for
from chrmc.optics.footprint import coverage, reach
from chrmc.optics.passband import UNLIMITED, Passband
from chrmc.reference import reference_samples
from chrmc.scene.point_scene import PointScene
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Pose
from chrmc.slm import SLM

RT_ERROR = 1e-5
"""What `rt` promises."""
PATIENCE, PER_MILLION = 40.0, 12.0
"""Processor seconds that a case may take, and for each million points more: past that refusing
would have done, and it counts as a fault."""
KINDS = (
    "box", "coincident", "regular", "cancelling", "grazing", "apart", "deep", "ratio", "video",
)  # fmt: skip
BODIES = ("box", "coincident", "regular", "grazing", "deep", "ratio")
"""Of videos."""
_WAVES = 3_000_000  # of the truth, in a case
_RT_WAVES = 3e8  # points times pixels up to which slow methods are tried
_ROTATION = (1e-12, np.pi)


@dataclass(frozen=True)
class Case:
    """One scene on one panel, and what to compute it with.

    kind : of the points, see KINDS
    band : "ssb" or "real", or "unlimited" for bare waves
    """

    seed: int
    kind: str
    method: str
    slm: SLM
    wavelength: float
    band: str
    depth: float
    count: int
    tolerance: float


@dataclass
class Outcome:
    """What became of a case.

    error, expected : relative L2, NaN where there is none
    seconds, cpu : by the clock, and of all processors
    refused : in which words, or ""
    fault : what promise is broken, or ""
    """

    case: Case
    seconds: float = 0.0
    cpu: float = 0.0
    error: float = float("nan")
    expected: float = float("nan")
    refused: str = ""
    fault: str = ""

    @property
    def ratio(self) -> float:
        """Error over what is promised."""
        return self.error / promised(self.case)

    def row(self) -> dict[str, Any]:
        """For a table: plain numbers and words."""
        case = self.case
        return {
            "seed": case.seed, "kind": case.kind, "method": case.method, "band": case.band,
            "width": case.slm.width, "height": case.slm.height,
            "pitch": case.slm.pixel_pitch, "wavelength": case.wavelength, "depth": case.depth,
            "points": case.count, "tolerance": case.tolerance, "error": self.error,
            "expected": self.expected, "seconds": round(self.seconds, 4),
            "cpu": round(self.cpu, 4), "limit": limit(case),
            "refused": self.refused, "fault": self.fault,
        }  # fmt: skip


def promised(case: Case) -> float:
    """The largest error that is no fault; infinite for methods that promise none."""
    if case.method == DEFAULT_METHOD or case.kind == "video":
        return case.tolerance
    return RT_ERROR if case.method == "rt" else float("inf")


def limit(case: Case) -> float:
    """Processor seconds that a case may take."""
    return round(PATIENCE + PER_MILLION * case.count / 1e6, 1)


def case_of(seed: int) -> Case:
    """The case of a seed."""
    random = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return float(np.exp(random.uniform(np.log(low), np.log(high))))

    kind = KINDS[int(random.integers(len(KINDS)))]
    width, height = (round(between(30, 2500)) for _ in range(2))
    shape = random.random()
    if shape < 0.05:
        width, height = 1, 1
    elif shape < 0.12:
        width = 1
    elif shape < 0.19:
        height = 1
    elif shape > 0.99:
        width = height = 8192
    slm = SLM("panel", width, height, float(between(0.5e-6, 100e-6)))
    many = random.random()
    count = round(between(1, 1e5 if many < 0.9 else 1e6 if many < 0.99 else 1e7))
    if kind == "video":
        slm = SLM("panel", min(width, 640), min(height, 480), slm.pixel_pitch)
        count = min(count, 2000)
    method = DEFAULT_METHOD
    if random.random() < 0.25 and kind != "video":
        method = list(METHODS)[int(random.integers(len(METHODS)))]
        if method != DEFAULT_METHOD:
            count = max(1, min(count, int(_RT_WAVES / (slm.width * slm.height))))
    band = ("ssb", "real", "unlimited")[int(random.choice(3, p=(0.45, 0.45, 0.1)))]
    if kind == "video" and band == "unlimited":
        band = "real"
    return Case(
        seed, kind, method, slm, between(200e-9, 10.6e-6), band, between(1e-3, 100),
        count, between(1e-6, 1e-1),
    )  # fmt: skip


def cloud_of(case: Case) -> PointCloud:
    """The case's points, all of which some pixel can show."""
    random = np.random.default_rng([case.seed, 1])
    n, z0 = case.count, case.depth
    size = z0 * 10 ** random.uniform(-4, -0.5, 3)
    passband = _passband(case)
    ends = [c * case.slm.pixel_pitch / 2 for c in (case.slm.width, case.slm.height)]
    reaches = [min(reach(case.wavelength, f), 3.0) for f in (passband.fx_max, passband.fy_max)]
    room = np.array([end + 0.6 * z0 * r for end, r in zip(ends, reaches, strict=True)])
    middle = np.append(random.uniform(-0.5, 0.5, 2) * room, z0)
    places = random.random((n, 3)) - 0.5
    amplitude, phase = random.uniform(0.2, 1, n), random.uniform(0, 2 * np.pi, n)
    if case.kind == "coincident":
        places *= 0
        phase = phase if random.random() < 0.5 else np.zeros(n)
    elif case.kind == "regular":
        side = max(1, round(n ** (1 / 2)))
        places = np.stack([np.arange(n) % side, np.arange(n) // side, np.zeros(n)], 1) / side - 0.5
        phase = np.zeros(n)
    elif case.kind == "cancelling":
        places[n // 2 :] = places[: n - n // 2]
        phase[n // 2 :] = phase[: n - n // 2] + np.pi * (1 + 10 ** random.uniform(-9, -3))
        amplitude[n // 2 :] = amplitude[: n - n // 2]
    elif case.kind == "grazing":
        away = np.array(ends) + z0 * np.array(reaches) * random.uniform(0.9, 0.999)
        middle[:2] = away * random.choice([-1, 1], 2) * (random.random(2) < 0.7)
        size = size * 1e-2
    elif case.kind == "apart":
        places[: n // 2] += random.uniform(-20, 20, 3) * (1, 1, 0.02)
    elif case.kind == "deep":
        places[:, 2] *= 10
    elif case.kind == "ratio":
        amplitude *= 10 ** random.uniform(-12, 12, n)
    positions = places * size + middle
    positions[:, 2] = np.maximum(positions[:, 2], 0.2 * z0)
    cloud = PointCloud(positions, amplitude, phase)
    shown = coverage(cloud, case.slm, case.wavelength, passband) > 0
    gap = np.abs(positions[:, :2]) - np.array(ends) + case.slm.pixel_pitch
    shown &= np.all(gap < positions[:, 2:] * reaches, axis=1)
    return cloud.select(shown)


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
    if not out.fault and out.cpu > limit(out.case):
        out.fault = f"took {out.cpu:.0f} processor seconds"
    if "\n" in out.refused:
        out.fault = "refused in more than one line"
    return out


def _passband(case: Case) -> Passband:
    return UNLIMITED if case.band == "unlimited" else coding_for(case.band, case.slm).passband


def _frame(case: Case, cloud: PointCloud, out: Outcome) -> None:
    passband = _passband(case)
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
    out.error = sampled_error(made, cloud, case.slm, case.wavelength, passband)


def sampled_error(
    made: NDArray[np.complexfloating],
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    passband: Passband,
) -> float:
    """Relative L2 error estimated on pixels drawn half by their light, half from the lit ones."""
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
    count = int(np.clip(_WAVES // len(cloud), 60, 2000))
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
    """A body that turns, approaches, flickers, goes and comes back, or meets its own negative; the
    worst of its frames."""
    random = np.random.default_rng([case.seed, 2])
    cloud = cloud_of(replace(case, kind=str(random.choice(BODIES))))
    if len(cloud) == 0:
        return
    middle = cloud.positions.mean(axis=0)
    bodies = {"body": PointCloud(cloud.positions - middle, cloud.amplitude, cloud.phase)}
    if random.random() < 0.15:
        against = cloud.phase + np.pi * (1 + 10 ** random.uniform(-9, -1))
        bodies["against"] = PointCloud(cloud.positions - middle, cloud.amplitude, against)
    angle = float(np.exp(random.uniform(*np.log(_ROTATION))))
    axis = random.standard_normal(3)
    axis /= np.linalg.norm(axis)
    frames = int(random.integers(30, 90)) if random.random() < 0.1 else int(random.integers(2, 12))
    back = random.random() < 0.3
    near = 0.01 if frames < 12 else 0.001
    poses = []
    for k in range(frames):
        step = k % 3 if back else k
        place = middle * (1 + near * step * random.random())
        poses.append(Pose.from_rotvec(axis * angle * step, place))
    level = random.random(len(cloud))
    flicker = random.choice([0.0, 0.02, 0.5])
    seen = {"body": lambda n: (level + flicker * n) % 1 < 0.8} if flicker else {}
    scene = PointScene("extreme", bodies, dict.fromkeys(bodies, poses), seen)
    made = chrmc.video(
        scene, case.slm, case.wavelength, cgh=DEFAULT_METHOD, compensation="ch-rmc-object",
        coding=case.band, tolerance=case.tolerance,
    )  # fmt: skip
    out.error = out.expected = 0.0
    start = time.perf_counter(), time.process_time()
    for frame in made:
        field = frame.field
        out.seconds += time.perf_counter() - start[0]
        out.cpu += time.process_time() - start[1]
        error = sampled_error(field, frame.cloud, case.slm, case.wavelength, _passband(case))
        out.error = max(out.error, error)
        out.expected = max(out.expected, frame.record.error_predicted or 0.0)
        start = time.perf_counter(), time.process_time()
