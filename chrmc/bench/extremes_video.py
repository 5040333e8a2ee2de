"""The videos of the sweep over extremes: a body that turns, approaches, flickers, leaves the panel,
goes and comes back, or meets its own negative."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

import chrmc
from chrmc.bench.extremes_cases import FRAMES, OBJECT, Case, cloud_of, passband_of
from chrmc.cgh import DEFAULT_METHOD
from chrmc.compensation import DEFAULT_TOLERANCE
from chrmc.compensation.frame import VideoFrame
from chrmc.compensation.held import showable
from chrmc.scene.point_scene import PointScene
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Pose

BODIES = ("box", "coincident", "regular", "grazing", "deep", "ratio")
IN_PARTS = ("tr-nlut", "mc-nlut", "mpeg-nlut", "3dmc-nlut")
NLUT_ERROR = 2e-5
"""What the methods that correct the frame before promise with `rt`: its own error, and as much."""
_ROTATION = (1e-12, np.pi)
_ACROSS, _WIDEST = 30, 0.01  # scene pixels to a body; metres


def promised_of(case: Case) -> float:
    """The largest error of a frame that is no fault; infinite for methods that promise none."""
    if case.video in (OBJECT, "none"):
        return case.tolerance
    if case.video == "ch-rmc-paper":  # against recomputation, which has an error of its own
        return case.tolerance + DEFAULT_TOLERANCE
    return float("inf") if case.video == "3dmc-nlut" else NLUT_ERROR


def frames_of(case: Case) -> Iterator[VideoFrame]:
    """Its frames; none where no point can be shown."""
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
    frames = frames if case.video == OBJECT else min(frames, FRAMES)
    back = random.random() < 0.3
    near = 0.01 if frames < 12 else 0.001
    poses = []
    for k in range(frames):
        step = k % 3 if back else k
        place = middle * (1 + near * step * random.random())
        poses.append(Pose.from_rotvec(axis * angle * step, place))
    level = random.random(len(cloud))
    flicker = random.choice([0.0, 0.02, 0.5])

    def seen(name: str, number: int) -> NDArray[np.bool_]:
        body = bodies[name]
        place = PointCloud(poses[number - 1].apply(body.positions), body.amplitude, body.phase)
        lit = showable(place, case.slm, case.wavelength, passband_of(case))
        return lit & ((level + flicker * number) % 1 < 0.8) if flicker and name == "body" else lit

    wide = float(np.ptp(cloud.positions[:, :2], axis=0).max())
    pitch = float(np.clip(wide / _ACROSS, case.slm.pixel_pitch, _WIDEST))
    visible = {name: partial(seen, name) for name in bodies}
    scene = PointScene("extreme", bodies, dict.fromkeys(bodies, poses), visible, pixel_pitch=pitch)
    options: dict[str, Any] = {}
    if case.video == "ch-rmc-paper":
        options["rekey_error"] = case.tolerance
    elif case.method == DEFAULT_METHOD:
        options["tolerance"] = case.tolerance
    yield from chrmc.video(
        scene, case.slm, case.wavelength, cgh=case.method, compensation=case.video,
        coding=case.band, **options,
    )  # fmt: skip
