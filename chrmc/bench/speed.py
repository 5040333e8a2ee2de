"""How fast the low-rank forms are on this machine, as ratios of things timed in turn."""

import os
import platform
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

import chrmc
from chrmc.bench.kept_scene import kept_scene
from chrmc.bench.rivals import corrected_signal
from chrmc.cgh import curved
from chrmc.cgh.curved.assembly import row_runs
from chrmc.encoding import Coding, coding_for
from chrmc.optics.footprint import reach
from chrmc.parallel import in_parallel
from chrmc.reference import reference_samples
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Scene
from chrmc.slm import SLM
from chrmc.threads import workers
from chrmc.window import Window

Encode = Callable[[NDArray[np.float32]], NDArray[np.uint8]]


def machine() -> str:
    """One line: cores, processor, NumPy."""
    return (
        f"{workers()} of {os.cpu_count()} cores, {platform.machine()}, "
        f"Python {platform.python_version()}, NumPy {np.__version__}"
    )


_SETTLE = 0.15  # seconds: the threads of a matrix product spin so long after it
_WARM, _TIMED = 3, 3  # calls in a burst, as a video makes them


def interleaved(jobs: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, list[float]]:
    """Seconds of every job in every round: the jobs in turn, each in a burst of calls.

    The first calls of a burst are not timed. What the job before left behind, threads that still
    spin, cold caches, a core that slept, is not its own and does not last in a video.
    """
    seconds: dict[str, list[float]] = {name: [] for name in jobs}
    for _ in range(rounds):
        for name, job in jobs.items():
            time.sleep(_SETTLE)
            for number in range(_WARM + _TIMED):
                start = time.perf_counter()
                job()
                if number >= _WARM:
                    seconds[name].append(time.perf_counter() - start)
    return seconds


def fresnel_signal(
    cloud: PointCloud, slm: SLM, wavelength: float, coding: Coding
) -> NDArray[np.float32]:
    """The rival: the coded signal by separable Fresnel tables and one real matrix product.

    Re Σ w·a/z·X_j(x)·Y_j(y)·carrier as [Re Y, −Im Y]·[Re X; Im X]: half the work of a complex
    product, phases reduced in float64, tables and soft footprint in float32.
    """
    x, y, z = (c[:, None] for c in cloud.positions.T)
    per = 1 / (2 * wavelength * z)
    tables = []
    for axis, place, f_max in (
        (slm.x(), x, coding.passband.fx_max), (slm.y(), y, coding.passband.fy_max)
    ):  # fmt: skip
        offset = axis - place
        share = offset.astype(np.float32)
        np.abs(share, out=share)
        share *= (10 / (z * reach(wavelength, f_max))).astype(np.float32)
        share -= np.float32(9)
        np.clip(share, 0, 1, out=share)
        share *= np.float32(pi / 2)
        np.cos(share, out=share)
        share *= share
        offset *= offset
        offset *= per
        if place is y:
            offset += coding.carrier * axis
            offset += z / wavelength + cloud.phase[:, None] / (2 * pi)
        offset -= np.rint(offset)
        turn = offset.astype(np.float32)
        turn *= np.float32(2 * pi)
        tables.append((np.cos(turn) * share, np.sin(turn) * share))
    across = np.concatenate(tables[0])
    scale = (cloud.amplitude[:, None] / z).astype(np.float32)
    down = np.concatenate([tables[1][0] * scale, tables[1][1] * -scale])
    return np.asarray(down.T @ across)


def fresnel_in_pieces(
    cloud: PointCloud, slm: SLM, wavelength: float, coding: Coding, most: int = 4000
) -> NDArray[np.float32]:
    """The same of so many points at a time: the tables of all would not fit."""
    out = fresnel_signal(cloud.select(slice(0, most)), slm, wavelength, coding)
    for first in range(most, len(cloud), most):
        out += fresnel_signal(cloud.select(slice(first, first + most)), slm, wavelength, coding)
    return out


def fresh_clouds(cloud: PointCloud, count: int) -> list[PointCloud]:
    """Clouds that differ a little, so that nothing can be kept from one to the next."""
    random = np.random.default_rng(1)
    return [
        PointCloud(
            cloud.positions + random.normal(0, 1e-6, 3), cloud.amplitude,
            random.uniform(0, 2 * pi, len(cloud)),
        )
        for _ in range(count)
    ]  # fmt: skip


def surface_cloud(count: int, slm: SLM) -> PointCloud:
    """Points on the faces of a car-sized box, 1.6 × 0.62 × 0.7 mm at 252 mm."""
    random = np.random.default_rng(count)
    size = np.array([1.6e-3, 0.62e-3, 0.7e-3])
    positions = (random.random((count, 3)) - 0.5) * size
    face = random.integers(0, 3, count)
    rows = np.arange(count)
    positions[rows, face] = np.sign(positions[rows, face]) * size[face] / 2
    place = np.array([0.12 * slm.width, 0.12 * slm.height, 0]) * slm.pixel_pitch
    return PointCloud(
        positions + place + [0, 0, 0.252],
        random.uniform(0.2, 1, count),
        random.uniform(0, 2 * pi, count),
    )


@dataclass(frozen=True)
class Timed:
    """A line of the table.

    seconds : median and smallest
    ratio : how many times faster than the rival, from the medians; None without one
    error : relative L2 error on sampled pixels
    note : what else there is to say
    """

    name: str
    median: float
    least: float
    ratio: float | None = None
    error: float | None = None
    note: str = ""


def _sampled_error(
    signal: NDArray[np.float32], cloud: PointCloud, slm: SLM, wavelength: float, coding: Coding
) -> float:
    random = np.random.default_rng(0)
    pixels = max(32, min(512, 4_000_000 // max(len(cloud), 1)))
    rows, columns = random.integers(0, slm.height, pixels), random.integers(0, slm.width, pixels)
    truth = reference_samples(cloud, slm, wavelength, rows, columns, passband=coding.passband)
    truth *= np.exp(2j * pi * coding.carrier * slm.y(rows))
    missed = np.linalg.norm(signal[rows, columns] - truth.real)
    return float(missed / np.linalg.norm(truth.real))


def single_frames(cloud: PointCloud, slm: SLM, wavelength: float, rounds: int = 9) -> list[Timed]:
    """The coded signal of one frame: `curved` at 1e-3 and 1e-5 against the rivals."""
    coding = coding_for("ssb", slm)
    window = Window.full(slm)
    clouds = fresh_clouds(cloud, rounds * (_WARM + _TIMED))
    turn = dict.fromkeys(("rival", "2", "3", "1e-3", "1e-5"), 0)

    def job(name: str) -> Callable[[], NDArray[np.float32]]:
        def run() -> NDArray[np.float32]:
            given = clouds[turn[name] % len(clouds)]
            turn[name] += 1
            if name == "rival":
                return fresnel_signal(given, slm, wavelength, coding)
            if name in ("2", "3"):
                return corrected_signal(given, slm, wavelength, coding, int(name))
            return curved.signal(given, slm, wavelength, window, coding, tolerance=float(name))

        return run

    jobs = {name: job(name) for name in turn}
    seconds = interleaved(jobs, rounds)
    rival = float(np.median(seconds["rival"]))
    out = []
    for name, label in (
        ("rival", "separable Fresnel, one product"), ("2", "separable products, 2 terms"),
        ("3", "separable products, 3 terms"), ("1e-3", "curved at 1e-3"),
        ("1e-5", "curved at 1e-5"),
    ):  # fmt: skip
        turn[name] = 0
        error = _sampled_error(jobs[name](), clouds[0], slm, wavelength, coding)
        median = float(np.median(seconds[name]))
        out.append(Timed(f"{label}, {len(cloud)} points", median, min(seconds[name]),
                         rival / median, error))  # fmt: skip
    return out


def many_points(count: int, slm: SLM, wavelength: float, rounds: int = 3) -> Timed:
    """The coded signal of many points in a car-sized object, at 1e-3."""
    coding, window = coding_for("ssb", slm), Window.full(slm)
    clouds = fresh_clouds(surface_cloud(count, slm), rounds)
    seconds = []
    for cloud in clouds:
        start = time.perf_counter()
        signal = curved.signal(cloud, slm, wavelength, window, coding)
        seconds.append(time.perf_counter() - start)
    error = _sampled_error(signal, clouds[-1], slm, wavelength, coding)
    return Timed(f"curved at 1e-3, {count} points", float(np.median(seconds)), min(seconds),
                 None, error, peak_memory())  # fmt: skip


def most_held() -> int:
    """Largest memory this process has held, bytes; 0 where the system does not tell."""
    try:
        import resource
    except ImportError:  # not on Windows
        return 0
    unit = 1 if platform.system() == "Darwin" else 1024
    return int(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit)


def peak_memory() -> str:
    """The same in words."""
    held = most_held()
    return f"{held / 2**30:.2f} GiB held at most" if held else ""


def videos(
    scene: Scene,
    slm: SLM,
    wavelength: float,
    encode: Encode,
    tolerance: float,
    last: int,
) -> Timed:
    """Whole frames of object-centred CH-RMC, from the scene's frame to grey levels.

    encode : signal to 8 bits
    """
    coding = coding_for("ssb", slm)
    kept = kept_scene(scene, range(1, last + 1))
    made = chrmc.video(
        kept, slm, wavelength, cgh="curved", compensation="ch-rmc", frames=(1, last),
        coding=coding, tolerance=tolerance,
    )  # fmt: skip
    seconds: list[float] = []
    rivals: list[float] = []
    errors, keys = [], 0
    start = time.perf_counter()
    for frame in made:
        signal = frame.signal
        assert signal is not None
        encode(signal)
        seconds.append(time.perf_counter() - start)
        keys += frame.record.key
        if len(seconds) % 8 == 1 or frame.number == last:
            errors.append(_sampled_error(signal, frame.cloud, slm, wavelength, coding))
            # In turn with the frames; once where it takes seconds.
            if not rivals or rivals[0] < 1:
                start = time.perf_counter()
                fresnel_in_pieces(frame.cloud, slm, wavelength, coding)
                rivals.append(time.perf_counter() - start)
        start = time.perf_counter()
    median, rival = float(np.median(seconds)), float(np.median(rivals))
    return Timed(
        f"ch-rmc object at {tolerance:g}, {scene.name}, whole frame", median, min(seconds),
        rival / median, max(errors),
        f"{keys} key of {len(seconds)}, the first took {1e3 * seconds[0]:.0f} ms",
    )  # fmt: skip


@dataclass(frozen=True)
class Rate:
    """Floating-point operations per second of the two products, and of a large plain one."""

    products: float
    peak: float

    @property
    def share(self) -> float:
        return self.products / self.peak


def product_rate(cloud: PointCloud, slm: SLM, wavelength: float, rounds: int = 15) -> Rate:
    """The two products A_y·(M·A_x) of one frame, against a 2048³ float32 product."""
    coding, window = coding_for("ssb", slm), Window.full(slm)
    made = curved.low_rank(cloud, slm, wavelength, window, coding.passband)
    random = np.random.default_rng(0)
    shapes = []
    for factor in made.factors:
        ny = 2 * factor.real.shape[0]
        for block in factor.axis_x.blocks:
            shapes.append((ny, 2 * block.node_count, block.target_count))
    # Factors that cover the same columns stand side by side in the products of a run of rows.
    for rows, covering in row_runs(made.factors, slm.height):
        deep: dict[int, int] = {}
        for number, block in covering:
            across = made.factors[number].axis_x.targets
            columns = across.stop - across.start
            deep[columns] = deep.get(columns, 0) + 2 * block.node_count
        shapes += [(rows.stop - rows.start, k, columns) for columns, k in deep.items()]
    work = [
        (random.random((m, k), dtype=np.float32), random.random((k, n), dtype=np.float32),
         np.empty((m, n), dtype=np.float32))
        for m, k, n in shapes
    ]  # fmt: skip
    square = random.random((2048, 2048), dtype=np.float32)
    out = np.empty_like(square)

    def one(piece: tuple[NDArray[np.float32], ...]) -> None:
        np.matmul(piece[0], piece[1], out=piece[2])

    def two() -> None:
        in_parallel(one, work)

    seconds = interleaved({"two": two, "plain": lambda: np.matmul(square, square, out=out)}, rounds)
    operations = sum(2.0 * m * k * n for m, k, n in shapes)
    return Rate(
        operations / float(np.median(seconds["two"])),
        2.0 * 2048**3 / float(np.median(seconds["plain"])),
    )
