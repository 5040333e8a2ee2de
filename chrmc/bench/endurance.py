"""Long turns and many bodies on the object surface: every frame's error, and the memory held."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

import chrmc
from chrmc.bench.speed import most_held
from chrmc.compensation.frame import VideoFrame
from chrmc.encoding import Coding, coding_for
from chrmc.reference import reference_samples, relative_error
from chrmc.scene.point_scene import PointScene
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Pose, Scene
from chrmc.slm import SLM

GROUP = 60
"""Frames that are made from one key frame on, as a stored video's groups are."""
_PIXELS = 60
_FEW = 3e6  # waves that a frame is looked at with, at most
_UNSURE = 0.9
"""Of the tolerance: what so few pixels say beyond it, more are asked."""
_CONFIRMING = 2000


@dataclass(frozen=True)
class Endured:
    """What came of some frames.

    error : the largest, over the tolerance
    early, late : MiB that the process held at most, in a tenth of the frames and in all
    keys : frames in which some object was computed from its points
    """

    name: str
    tolerance: float
    frames: int
    error: float
    early: float
    late: float
    keys: int

    @property
    def key(self) -> tuple[str, float]:
        """Scene and tolerance."""
        return self.name, self.tolerance


def _ellipsoid(points: int, size: tuple[float, float, float], seed: int) -> PointCloud:
    """Twice so many points on an ellipsoid: half of them are seen."""
    random = np.random.default_rng(seed)
    way = random.normal(size=(2 * points, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    return PointCloud(
        way * (np.array(size) / 2),
        random.uniform(0.5, 1, len(way)),
        random.uniform(0, 2 * np.pi, len(way)),
    )


def spinning(points: int, frames: int) -> Scene:
    """A body the size of the car that turns about all three axes, each at its own pace."""
    body = _ellipsoid(points, (1.6e-3, 7e-4, 8e-4), 1)
    angles = np.deg2rad(np.outer(np.arange(frames), (0.3, 0.23, 0.11)))
    turns = Rotation.from_euler("yxz", angles).as_matrix()
    poses = [Pose(turn, np.array([1e-3, 5e-4, 0.25])) for turn in turns]
    normal = body.positions / np.array([1.6e-3, 7e-4, 8e-4]) ** 2
    return PointScene("spin", {"body": body}, {"body": poses}, {"body": _Facing(normal, poses).of})


def crossing(points: int, frames: int, bodies: int = 10) -> Scene:
    """Bodies with motions of their own that pass in front of one another: those behind are hid."""
    random = np.random.default_rng(2)
    clouds, poses, seen = {}, {}, {}
    size = np.array([8e-4, 6e-4, 6e-4])
    ways: list[list[Pose]] = []
    for number in range(bodies):
        start = random.uniform([-5e-3, -2.5e-3, 0], [5e-3, 2.5e-3, 0])
        place = np.linspace(start, -start, frames) + np.array([0, 0, 0.24 + 3e-3 * number])
        axis = random.normal(size=3)
        axis *= np.deg2rad(0.4) / np.linalg.norm(axis)
        ways.append(
            [Pose(Rotation.from_rotvec(axis * k).as_matrix(), at) for k, at in enumerate(place)]
        )
    for number, own in enumerate(ways):
        name = f"body {number}"
        clouds[name] = _ellipsoid(points, (size[0], size[1], size[2]), number)
        poses[name] = own
        normal = clouds[name].positions / size**2
        seen[name] = _Facing(normal, own, clouds[name].positions, ways[:number], size).of
    return PointScene("crossing", clouds, poses, seen)


@dataclass(frozen=True, eq=False)
class _Facing:
    """Points towards the hologram, and not behind a body that stands before them."""

    normal: np.ndarray
    poses: list[Pose]
    positions: np.ndarray | None = None
    before: list[list[Pose]] | None = None
    size: np.ndarray | None = None

    def of(self, number: int) -> np.ndarray:
        """(N,) which are seen in a frame."""
        pose = self.poses[number - 1]
        out = (self.normal @ pose.rotation.T)[:, 2] < 0
        if self.positions is not None and self.before is not None and self.size is not None:
            world = pose.apply(self.positions)
            for other in self.before:
                near = other[number - 1]
                half = np.sqrt((near.rotation**2) @ (self.size / 2) ** 2)[:2]
                off = (world[:, :2] - near.translation[:2]) / half
                out &= np.sum(off * off, axis=1) > 1
        return np.asarray(out)


def endured(
    scene: Scene,
    slm: SLM,
    wavelength: float,
    tolerance: float = 1e-3,
    before: Endured | None = None,
) -> Iterator[Endured]:
    """Frame after frame, what came of all until then; group by group, as a video is generated.

    before : what came of the groups that there have been; it goes on behind them
    """
    coding = coding_for("ssb", slm)
    worst, early, late, keys, done = 0.0, 0.0, 0.0, 0, 0
    if before is not None:
        worst, early, late = before.error, before.early, before.late
        keys, done = before.keys, before.frames
    for start in range(done + 1, scene.frame_count + 1, GROUP):
        random = np.random.default_rng(start)
        frames = chrmc.video(
            scene, slm, wavelength, compensation="ch-rmc-object", coding=coding,
            tolerance=tolerance, frames=(start, min(start + GROUP - 1, scene.frame_count)),
        )  # fmt: skip
        for frame in frames:
            pixels = int(np.clip(_FEW / max(len(frame.cloud), 1), 24, _PIXELS))
            error = _error(frame, slm, wavelength, coding, random, pixels) / tolerance
            if error > _UNSURE:
                error = _error(frame, slm, wavelength, coding, random, _CONFIRMING) / tolerance
            worst = max(worst, error)
            keys += frame.record.key
            late = max(late, most_held() / 2**20)
            if frame.number <= max(1, scene.frame_count // 10):
                early = late
            yield Endured(scene.name, tolerance, frame.number, worst, early, late, keys)


def _error(
    frame: VideoFrame,
    slm: SLM,
    wavelength: float,
    coding: Coding,
    random: np.random.Generator,
    pixels: int,
) -> float:
    """Of a frame's field, relative, on so many pixels."""
    rows = random.integers(0, slm.height, pixels)
    columns = random.integers(0, slm.width, pixels)
    truth = reference_samples(frame.cloud, slm, wavelength, rows, columns, passband=coding.passband)
    return relative_error(frame.field[rows, columns], truth)
