"""The cases of the sweep over extremes: random scenes at the ends of every range, by seed."""

from dataclasses import dataclass

import numpy as np

from chrmc.bench.extremes_mixed import mixed
from chrmc.cgh import DEFAULT_METHOD, METHODS
from chrmc.encoding import coding_for
from chrmc.optics.footprint import coverage, reach
from chrmc.optics.passband import UNLIMITED, Passband
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM

_DRAWN = (
    "box", "coincident", "regular", "cancelling", "grazing", "apart", "deep", "ratio", "video",
)  # fmt: skip
KINDS = (*_DRAWN, "mixed")
_INSTEAD, _MIXED = ("box", "deep", "ratio"), 9312  # instead of these by half, drawn apart: seeds
# that found faults before there were mixed ones still find them
OBJECT = "ch-rmc-object"
VIDEOS = {
    "none": DEFAULT_METHOD, "ch-rmc-paper": DEFAULT_METHOD, "tr-nlut": "rt", "mc-nlut": "rt",
    "mpeg-nlut": "rt", "3dmc-nlut": "rt",
}  # fmt: skip
"""Video methods besides the object surface, and the CGH method that they are tried with."""
FRAMES = 12
"""Of a video, that these are tried with."""
_RT_WAVES = 3e8  # points times pixels up to which slow methods are tried
_AGAIN = 8  # times as much: points are taken out and put in, in double precision if need be


@dataclass(frozen=True)
class Case:
    """One scene on one panel, and what to compute it with.

    kind : of the points, see KINDS
    band : "ssb" or "real", or "unlimited" for bare waves
    video : the video method, of a video
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
    video: str = ""


def case_of(seed: int) -> Case:
    """The case of a seed."""
    random = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return float(np.exp(random.uniform(np.log(low), np.log(high))))

    kind = _DRAWN[int(random.integers(len(_DRAWN)))]
    if kind in _INSTEAD and np.random.default_rng([seed, _MIXED]).random() < 0.5:
        kind = "mixed"
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
    wavelength, depth, tolerance = between(200e-9, 10.6e-6), between(1e-3, 100), between(1e-6, 0.1)
    video = ""
    if kind == "video":
        band = "real" if band == "unlimited" else band
        own = np.random.default_rng([seed, 3])
        video = OBJECT if own.random() < 0.6 else str(own.choice(list(VIDEOS)))
        method = VIDEOS.get(video, method)
        if method != DEFAULT_METHOD:
            waves = _AGAIN * FRAMES * slm.width * slm.height
            count = max(1, min(count, int(_RT_WAVES / waves)))
    return Case(
        seed, kind, method, slm, wavelength, band, depth, count, tolerance, video
    )  # fmt: skip


def cloud_of(case: Case) -> PointCloud:
    """The case's points, all of which some pixel can show."""
    random = np.random.default_rng([case.seed, 1])
    n, z0 = case.count, case.depth
    size = z0 * 10 ** random.uniform(-4, -0.5, 3)
    passband = passband_of(case)
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
    if case.kind == "mixed":
        where = random.random()
        if where < 0.4:  # at the edge of what the panel shows, or on its middle
            middle[:2] = (np.array(ends) + z0 * np.array(reaches)) * random.integers(-1, 2, 2)
        if where < 0.2:
            middle[:2] *= random.uniform(0.9, 1)
            size = size * 10 ** random.uniform(-3, 0)
        sine = np.sin(np.arctan(reaches))
        positions, amplitude, phase = mixed(
            random, n, size, middle, case.slm.pixel_pitch, case.wavelength, sine
        )
    positions[:, 2] = np.maximum(positions[:, 2], 0.2 * z0)
    cloud = PointCloud(positions, amplitude, phase)
    shown = coverage(cloud, case.slm, case.wavelength, passband) > 0
    gap = np.abs(positions[:, :2]) - np.array(ends) + case.slm.pixel_pitch
    shown &= np.all(gap < positions[:, 2:] * reaches, axis=1)
    return cloud.select(shown)


def passband_of(case: Case) -> Passband:
    return UNLIMITED if case.band == "unlimited" else coding_for(case.band, case.slm).passband
