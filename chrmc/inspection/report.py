"""What an SLM will show of a scene: sizes, resolution, points, motion, speckle, cost."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.encoding import coding_for
from chrmc.optics.footprint import coverage, reach
from chrmc.optics.passband import Passband
from chrmc.panels import encoding_for
from chrmc.planning.choice import spell
from chrmc.planning.choices import plan
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import ObjectFrame, Scene
from chrmc.slm import SLM

MOST_FRAMES = 200
"""Frames looked at for the motion; of longer scenes as many, evenly spread."""
MM, UM = 1e3, 1e6


@dataclass(frozen=True)
class Optics:
    """What the panel does at a depth, metres.

    resolution : λz/W in x and λz/H in y; focus : depth of focus 2λ(z/W)² and 2λ(z/H)²
    half_view : |x| and |y| beyond which no pixel shows a point, with the encoding's passband
    """

    depth: float
    resolution: tuple[float, float]
    focus: tuple[float, float]
    half_view: tuple[float, float]

    @classmethod
    def at(cls, depth: float, slm: SLM, wavelength: float, passband: Passband) -> "Optics":
        """Of a panel at a depth."""
        sides = slm.width * slm.pixel_pitch, slm.height * slm.pixel_pitch
        bands = passband.fx_max, passband.fy_max
        # A narrower passband than the pixels' own resolves less where it cuts the aperture.
        apertures = [
            min(side, 2 * depth * reach(wavelength, band))
            for side, band in zip(sides, bands, strict=True)
        ]
        x, y = (wavelength * depth / a for a in apertures)
        fx, fy = (2 * wavelength * (depth / a) ** 2 for a in apertures)
        half = [s / 2 + depth * reach(wavelength, b) for s, b in zip(sides, bands, strict=True)]
        return cls(depth, (x, y), (fx, fy), (half[0], half[1]))


def points_per_cell(cloud: PointCloud, resolution: tuple[float, float]) -> float:
    """Mean number of points in the resolution cells that hold any."""
    if not len(cloud):
        return 0.0
    cells = np.floor(cloud.positions[:, :2] / np.array(resolution)).astype(np.int64)
    return len(cloud) / len(np.unique(cells, axis=0))


def speckle_contrast(per_cell: float) -> float:
    """Standard deviation over mean of the intensity where N points of random phase share a cell.

    N unit phasors of independent phases: ⟨I²⟩/⟨I⟩² − 1 = 1 − 1/N (Goodman, Speckle Phenomena).
    """
    return sqrt(max(0.0, 1 - 1 / per_cell)) if per_cell > 1 else 0.0


@dataclass(frozen=True)
class Motion:
    """Between neighbouring frames, over a scene: median and largest.

    shift : metres of the body's middle; turn : radians; changed : share of the visible points that
    appear or vanish
    """

    shift: tuple[float, float]
    turn: tuple[float, float]
    changed: tuple[float, float]


def motion_of(scene: Scene, name: str) -> Motion | None:
    """How an object moves; None where nobody knows, or where there is one frame."""
    count = scene.frame_count
    if count < 2:
        return None
    starts = np.unique(np.linspace(1, count - 1, min(MOST_FRAMES, count - 1)).astype(int))
    shifts, turns, changes = [], [], []
    for number in starts:
        before, after = (_object(scene, int(n), name) for n in (number, number + 1))
        if before.pose is None or after.pose is None or before.ids is None or after.ids is None:
            return None
        shifts.append(float(np.linalg.norm(after.pose.translation - before.pose.translation)))
        cosine = (np.trace(after.pose.rotation @ before.pose.rotation.T) - 1) / 2
        turns.append(float(np.arccos(np.clip(cosine, -1, 1))))
        changes.append(len(np.setxor1d(before.ids, after.ids)) / max(len(before.ids), 1))
    pairs = [(float(np.median(v)), float(np.max(v))) for v in (shifts, turns, changes)]
    return Motion(*pairs)


def _object(scene: Scene, number: int, name: str) -> ObjectFrame:
    return next(o for o in scene.frame(number).objects if o.name == name)


def sentences(scene: Scene, slm: SLM, wavelength: float) -> Iterator[str]:
    """What will be seen of a scene's first frame, and how it moves, line by line."""
    encoding = encoding_for(slm)
    passband = coding_for(encoding, slm).passband
    frame = scene.frame(1)
    yield f"{scene.name}: {scene.frame_count} frames, on {slm.name} at {wavelength * 1e9:.0f} nm"
    for obj in frame.objects:
        yield from _of_object(scene, obj, slm, wavelength, passband)
    if not len(frame.cloud):
        return
    yield ""
    yield from _ways(scene, slm, wavelength, encoding)


def _ways(scene: Scene, slm: SLM, wavelength: float, encoding: str) -> Iterator[str]:
    """What each way to make the holograms takes, how wrong it is, and which one to take."""
    try:
        found = plan(scene, slm, wavelength=wavelength, encoding=encoding)
    except ValueError as refusal:
        yield f"no hologram can be made: {refusal}"
        return
    yield f"  {'way':<38} {'per frame':>10} {'field error':>12}"
    for way in sorted(found.choices, key=lambda way: way.mean):
        error = "unknown" if way.error is None else f"{way.error:.1e}"
        mark = "→" if way is found.taken else " "
        yield f"{mark} {way!s:<38} {spell(way.mean):>10} {error:>12}"
    yield f"{found.why}."


def _of_object(
    scene: Scene, obj: ObjectFrame, slm: SLM, wavelength: float, passband: Passband
) -> Iterator[str]:
    cloud = obj.cloud
    yield ""
    if not len(cloud):
        yield f"{obj.name}: nothing of it is visible in frame 1"
        return
    size = np.ptp(cloud.positions, axis=0)
    near, far = cloud.positions[:, 2].min(), cloud.positions[:, 2].max()
    optics = Optics.at(obj.depth, slm, wavelength, passband)
    x, y = optics.resolution
    yield (
        f"{obj.name}: {size[0] * MM:.3g} × {size[1] * MM:.3g} mm, from {near * MM:.5g} to "
        f"{far * MM:.5g} mm deep"
    )
    yield (
        f"  field of view there ±{optics.half_view[0] * MM:.3g} × "
        f"±{optics.half_view[1] * MM:.3g} mm; resolution {x * UM:.3g} × {y * UM:.3g} µm: "
        f"{size[0] / x:.0f} × {size[1] / y:.0f} cells"
    )
    yield (
        f"  depth of focus {optics.focus[0] * MM:.2g} mm across, {optics.focus[1] * MM:.2g} mm "
        f"up and down: it is {(far - near) / optics.focus[0]:.2g} and "
        f"{(far - near) / optics.focus[1]:.2g} times as deep"
    )
    per_cell = points_per_cell(cloud, optics.resolution)
    contrast = speckle_contrast(per_cell)
    yield (
        f"  {len(cloud)} points, {per_cell:.2g} per resolution cell; speckle contrast about "
        f"{contrast:.2f}, over 20 looks {contrast / sqrt(20):.2f}"
    )
    share = coverage(cloud, slm, wavelength, passband)
    hidden = (
        f"{1 - len(cloud) / len(obj.body):.0%} of its points hidden or lost; "
        if (obj.body is not None and len(obj.body))
        else ""
    )
    lost = _lost(obj, slm, wavelength, passband)
    yield (
        f"  {hidden}{lost:.0%} beyond the field of view; fringes cover {share.mean():.0%} of the "
        f"panel ({(share < 0.5).mean():.0%} of the points less than half)"
    )
    motion = motion_of(scene, obj.name)
    if motion is not None:
        yield (
            f"  moves {motion.shift[0] * UM:.3g} µm and turns {np.degrees(motion.turn[0]):.3g}° "
            f"per frame (at most {motion.shift[1] * UM:.3g} µm, "
            f"{np.degrees(motion.turn[1]):.3g}°); {motion.changed[0]:.1%} of its points change "
            f"(at most {motion.changed[1]:.1%})"
        )


def _lost(obj: ObjectFrame, slm: SLM, wavelength: float, passband: Passband) -> float:
    """Share of all the points that stand where no pixel shows them, hidden or not."""
    cloud = obj.cloud
    if obj.body is not None and obj.pose is not None:
        body = obj.body
        cloud = PointCloud(obj.pose.apply(body.positions), body.amplitude, body.phase)
    return float((coverage(cloud, slm, wavelength, passband) <= 0).mean())


def occupied(clouds: list[PointCloud]) -> NDArray[np.float64]:
    """(2, 3) bounds of all points."""
    positions = np.concatenate([c.positions for c in clouds if len(c)])
    return np.stack([positions.min(axis=0), positions.max(axis=0)])
