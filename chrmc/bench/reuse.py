"""What reuse on the object surface saves: frames looked up, and the same computed afresh."""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import chrmc
from chrmc.bench.kept_scene import kept_scene
from chrmc.compensation.frame import VideoFrame
from chrmc.encoding import coding_for
from chrmc.reference import reference_samples, relative_error
from chrmc.scene.point_scene import PointScene
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Pose
from chrmc.slm import SLM


@dataclass(frozen=True)
class Case:
    """A body that turns.

    size : metres along x, y, z; an ellipsoid, of which the side towards the hologram is seen
    points : that are seen, about
    depth : of its middle, metres
    degrees : turned per frame
    frames : how many
    """

    size: tuple[float, float, float]
    points: int
    depth: float
    degrees: float
    frames: int = 60

    @property
    def name(self) -> str:
        """In words."""
        return (
            f"{1e3 * self.size[0]:.2g} mm, {self.points} points, {self.degrees:g}° per frame, "
            f"at {1e3 * self.depth:.0f} mm"
        )


CASES = (
    Case((1.6e-3,) * 3, 1_000, 0.25, 6.0),
    Case((3e-3,) * 3, 5_000, 0.25, 1.0),
    Case((5e-3,) * 3, 5_000, 0.25, 1.0),
    Case((3e-3,) * 3, 2_000, 0.5, 1.0),
    Case((1.6e-3, 0.7e-3, 0.8e-3), 1_200, 0.25, 0.3),
    Case((1.6e-3, 0.7e-3, 0.8e-3), 20_000, 0.25, 1.0),
    Case((1.6e-3, 0.7e-3, 0.8e-3), 100_000, 0.25, 0.3),
)
"""Small and large, sparse and dense, near and far, slow and fast."""


@dataclass(frozen=True)
class Reuse:
    """What came of a case.

    later : median seconds of a frame after the first, looked up
    fresh : the same, computed afresh
    first : seconds of the first frame
    ratio : all frames, the first included, over the same afresh
    work : the same of the processor's time, which other programs disturb less
    error : largest relative error of the frames that were looked at
    how : what the record of the first and of the last frame says
    """

    name: str
    later: float
    fresh: float
    first: float
    ratio: float
    work: float
    error: float
    how: tuple[str, str]


def ellipsoid_scene(case: Case, seed: int = 1) -> PointScene:
    """Points on an ellipsoid of random phases that turns about y; hidden ones left out."""
    random = np.random.default_rng(seed)
    way = random.normal(size=(2 * case.points, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    half = np.array(case.size) / 2
    normal = way / half
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    body = PointCloud(
        way * half, random.uniform(0.5, 1, len(way)), random.uniform(0, 2 * np.pi, len(way))
    )
    middle = np.array([1e-3, 5e-4, case.depth])
    poses, seen = [], []
    for k in range(case.frames):
        turn = Rotation.from_rotvec([0, np.deg2rad(case.degrees) * k, 0]).as_matrix()
        poses.append(Pose(turn, middle))
        seen.append((normal @ turn.T)[:, 2] < 0)  # towards the hologram, z = 0
    return PointScene("ellipsoid", {"body": body}, {"body": poses}, {"body": seen})


def reuse(
    case: Case,
    slm: SLM,
    wavelength: float,
    tolerance: float = 1e-3,
    always: bool = False,
) -> Reuse:
    """Time a case's coded signals looked up and afresh, frame by frame in turn.

    always : look up whether it pays or not
    """
    scene = kept_scene(ellipsoid_scene(case), range(1, case.frames + 1))
    coding = coding_for("ssb", slm)

    def video(name: str, **options: str) -> Iterator[VideoFrame]:
        given: dict[str, Any] = {**options, "tolerance": tolerance, "coding": coding}
        return chrmc.video(scene, slm, wavelength, compensation=name, **given)

    videos = {
        "object": video("ch-rmc-object", reuse="always" if always else "auto"),
        "none": video("none"),
    }
    seconds: dict[str, list[float]] = {name: [] for name in videos}
    work = dict.fromkeys(videos, 0.0)
    rows, columns = _pixels(slm)
    how: list[str] = []
    error = 0.0
    for number in range(1, case.frames + 1):
        # By turns: what the first has worked out of a frame's shapes is there for the second.
        turns = list(videos.items())
        for name, frames in turns if number % 2 else reversed(turns):
            start, busy = time.perf_counter(), time.process_time()
            frame = next(frames)
            signal = frame.signal
            seconds[name].append(time.perf_counter() - start)
            work[name] += time.process_time() - busy
            assert signal is not None
            if name != "none":
                how.append(frame.record.reuse.get("body", ""))
                if number in (1, 2, case.frames // 2, case.frames):
                    truth = reference_samples(
                        frame.cloud, slm, wavelength, rows, columns, passband=coding.passband
                    )
                    error = max(error, relative_error(frame.field[rows, columns], truth))
    looked_up, afresh = seconds["object"], seconds["none"]
    return Reuse(
        case.name, float(np.median(looked_up[1:])), float(np.median(afresh[1:])), looked_up[0],
        sum(looked_up) / sum(afresh), work["object"] / work["none"], error, (how[0], how[-1]),
    )  # fmt: skip


def _pixels(slm: SLM) -> tuple[NDArray[np.integer], NDArray[np.integer]]:
    random = np.random.default_rng(0)
    return random.integers(0, slm.height, 100), random.integers(0, slm.width, 100)
