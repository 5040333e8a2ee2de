"""From a world of files to bodies of the right size, at their places, moving."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Pose
from chrmc.scene.sources import read_model
from chrmc.scene.sources.model import MOST_FRAMES, UP, Model, body_positions
from chrmc.scene.sources.poses import poses_from_csv
from chrmc.scene.sources.volume import BODY_SHARE, DEPTH, box, cell, outside
from chrmc.scene.sources.world import Entry, World
from chrmc.scene.surface.cast import Cast
from chrmc.scene.surface.recorded import FINEST, Recorded
from chrmc.scene.surface.surface import Surface
from chrmc.slm import SLM, WAVELENGTH

DENSITY = 0.5
"""Resolution cells per point, unless told otherwise: a little denser than the SLM resolves."""
TINY = 1e-30
"""Size in a file's unit that counts as none: what it would have to be enlarged by is no number."""
RATE = 60.0
"""Frames per second at which tracks are taken, unless told otherwise."""
MM = 1e3


@dataclass(frozen=True, eq=False)
class Built:
    """A world put in its place.

    cast : bodies and poses; world : the same with every default written out
    """

    cast: Cast
    world: World

    @property
    def notes(self) -> tuple[str, ...]:
        """What was done, a sentence each."""
        return self.world.notes


def build(world: World, slm: SLM, wavelength: float | None = None, fit: bool = False) -> Built:
    """Read all files of a world and place what is in them.

    fit : scale and shift everything so that no frame leaves the SLM's box
    """
    wavelength = wavelength or world.wavelength or WAVELENGTH
    bodies: dict[str, Surface | PointCloud] = {}
    poses: dict[str, list[Pose]] = {}
    entries: list[Entry] = []
    notes: list[str] = list(world.notes)
    for entry in world.entries:
        model = read_model(entry.source)
        notes += model.notes
        placed, entry = _placed(entry, model, world, slm, wavelength)
        entries.append(entry)
        notes.append(_said(entry, model))
        for key, (body, motion) in placed.items():
            name = str(entry.name) if len(placed) == 1 else f"{entry.name} {key}"
            bodies[name], poses[name] = body, motion
    frames = world.frames or max(len(p) for p in poses.values())
    poses = {name: _over(p, frames) for name, p in poses.items()}
    if fit:
        bodies, poses, entries, note = _fitted(bodies, poses, entries, slm, wavelength)
        notes += note
    notes += _leaving(bodies, poses, slm, wavelength)
    spacing = _spacing(world, bodies, poses, slm, wavelength)
    cast = Cast(
        name=world.name,
        bodies=bodies,
        poses=poses,
        spacing=spacing,
        lamp=world.lamp if world.shading == "diffuse" else None,
        shown=lambda world_positions: outside(world_positions, slm, wavelength) < 0,
        wavelength=world.wavelength,
        notes=tuple(notes),
    )
    return Built(cast, replace(world, entries=tuple(entries), frames=frames, notes=tuple(notes)))


Placed = dict[str, tuple[Surface | PointCloud, list[Pose]]]


def _placed(
    entry: Entry, model: Model, world: World, slm: SLM, wavelength: float
) -> tuple[Placed, Entry]:
    """An entry's bodies about their own middles, in metres, with their poses over the frames."""
    up = entry.up or model.up
    turn = Rotation.from_euler("xyz", entry.turn, degrees=True).as_matrix() @ UP[up]
    corners = model.corners() @ turn.T
    low, high = corners.min(axis=0), corners.max(axis=0)
    largest = float((high - low).max())
    x, y, z = entry.place
    z = DEPTH if z is None else z
    if entry.scale is not None:
        scale = entry.scale
    elif entry.size is not None:
        scale = entry.size / largest if largest > TINY else 1.0
    else:
        scale = _fitting(high - low, box(slm, wavelength, z), model.flat)
    place = np.array([x or 0.0, y or 0.0, z])
    # The middle in the file's axes: where the first frame's bounds have theirs.
    middle = turn.T @ ((low + high) / 2)
    count = max([model.frames, *(len(p) for p in model.poses.values())])
    own = count if entry.motion.kind == "own" else 1
    if own > 1 and world.rate and model.rate:
        own = max(1, int((own - 1) * world.rate / model.rate) + 1)
    motion = _motion(entry, world, scale, turn, place)
    frames = world.frames or max(own, len(motion))

    def frame_of(n: int) -> int:
        """The file's own frame that is shown in frame n, from 0."""
        if own == 1:
            return 0
        k = round(n * model.rate / world.rate) if world.rate and model.rate else n
        return min(k, count - 1)

    placed: Placed = {}
    for name, body in model.bodies.items():
        positions = body_positions(body)
        centre = (positions.min(axis=0) + positions.max(axis=0)) / 2
        poses = []
        for n in range(frames if max(own, len(motion)) > 1 else 1):
            pose = model.pose(name, frame_of(n))
            offset = pose.rotation @ centre + pose.translation - middle
            poses.append(
                compose(
                    motion[min(n, len(motion) - 1)],
                    Pose(turn @ pose.rotation, place + scale * turn @ offset),
                )
            )
        if isinstance(body, Surface):
            placed[name] = _timed(body, frame_of).moved(scale, centre), poses
        elif isinstance(body, Recorded):
            finest = sqrt((world.density or FINEST) * np.prod(cell(slm, wavelength, z)))
            filmed = body.moved(scale, centre).filmed(frame_of, finest, world.points)
            placed[name] = filmed, poses
        else:
            placed[name] = replace(body, positions=scale * (positions - centre)), poses
    resolved = replace(entry, size=None, scale=scale, up=up, place=tuple(place))
    return placed, resolved


def _timed(surface: Surface, frame_of: Callable[[int], int]) -> Surface:
    """A surface that bends in the frames of the scene, not of its file."""
    shape = surface.shape
    if shape is None:
        return surface
    return replace(surface, shape=lambda n: shape(frame_of(n)))


def compose(after: Pose, before: Pose) -> Pose:
    """First one motion, then the other."""
    return Pose(
        after.rotation @ before.rotation, after.rotation @ before.translation + after.translation
    )


def _fitting(size: NDArray[np.float64], shown: tuple[float, float], flat: bool) -> float:
    """Metres per unit at which something fills its share of what is shown."""
    if flat:
        return min(side / s for side, s in zip(shown, size, strict=False) if s > TINY)
    largest = float(size.max())
    return BODY_SHARE * min(shown) / largest if largest > TINY else 1.0


def _motion(
    entry: Entry,
    world: World,
    scale: float,
    turn: NDArray[np.float64],
    place: NDArray[np.float64],
) -> list[Pose]:
    """Motions of the whole entry in the scene, from where it stands in frame 1."""
    motion = entry.motion
    if motion.kind == "turntable":
        axis = np.array(motion.axis) / np.linalg.norm(motion.axis)
        whole = abs(360 / motion.degrees) if motion.degrees else 1
        frames = world.frames or max(1, min(round(whole), MOST_FRAMES))
        turns = Rotation.from_rotvec(
            np.radians(motion.degrees) * np.arange(frames)[:, None] * axis
        ).as_matrix()
        return [Pose(r, place - r @ place) for r in turns]
    if motion.kind == "poses" and motion.file is not None:
        track = poses_from_csv(motion.file, world.rate or RATE)
        first, size = track[0], motion.scale or scale
        found = []
        for pose in track:
            rotation = turn @ pose.rotation @ first.rotation.T @ turn.T
            shift = size * turn @ (pose.translation - first.translation)
            found.append(Pose(rotation, place - rotation @ place + shift))
        return found
    return [Pose(np.eye(3), np.zeros(3))]


def _over(poses: list[Pose], frames: int) -> list[Pose]:
    """One pose, or one per frame: longer motions are cut, shorter ones stay where they end."""
    if len(poses) == 1:
        return poses
    return [poses[min(k, len(poses) - 1)] for k in range(frames)]


def _said(entry: Entry, model: Model) -> str:
    """Size in the file, and size and depth shown."""
    turn = Rotation.from_euler("xyz", entry.turn, degrees=True).as_matrix() @ UP[str(entry.up)]
    size = np.ptp(model.corners() @ turn.T, axis=0)
    shown = size * float(entry.scale or 1) * MM
    depth = float(entry.place[2] or 0) * MM
    name = f"{entry.name}: "
    if model.flat:
        return f"{name}{size[0]:.0f} × {size[1]:.0f} pixels, shown {shown[0]:.3g} × " + (
            f"{shown[1]:.3g} mm at {depth:.4g} mm"
        )
    was = " × ".join(f"{s:.3g}" for s in size)
    now = " × ".join(f"{s:.2g}" for s in shown)
    return (
        f"{name}{was} units wide, tall and deep with {entry.up} up, shown {now} mm at "
        f"{depth:.4g} mm"
    )


def _hull(body: Surface | PointCloud) -> NDArray[np.float64]:
    """(8, 3) corners of a body's bounds."""
    positions = body_positions(body)
    low, high = positions.min(axis=0), positions.max(axis=0)
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1])
                     for z in (low[2], high[2])])  # fmt: skip


def _fitted(
    bodies: dict[str, Surface | PointCloud],
    poses: dict[str, list[Pose]],
    entries: list[Entry],
    slm: SLM,
    wavelength: float,
) -> tuple[dict[str, Surface | PointCloud], dict[str, list[Pose]], list[Entry], list[str]]:
    """Everything scaled about its middle so that all frames lie within the box."""
    corners = np.concatenate(
        [p.apply(_hull(bodies[name])) for name, each in poses.items() for p in each]
    )
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle, size = (low + high) / 2, high - low
    width, height = box(slm, wavelength, float(max(middle[2], 1e-6)))
    inside = (np.abs(np.stack([low, high])[:, :2]) <= np.array([width, height]) / 2).all()
    if inside and low[2] > 0:
        return bodies, poses, entries, []
    factor = min(1.0, width / max(size[0], 1e-12), height / max(size[1], 1e-12),
                 float(middle[2] / max(size[2], 1e-12)))  # fmt: skip
    centre = np.array([0.0, 0.0, middle[2]])

    def pose(p: Pose) -> Pose:
        return Pose(p.rotation, factor * (p.translation - middle) + centre)

    scaled: dict[str, Surface | PointCloud] = {}
    for name, body in bodies.items():
        if isinstance(body, Surface | Recorded):
            scaled[name] = body.moved(factor, np.zeros(3))
        else:
            scaled[name] = replace(body, positions=factor * body.positions)
    note = (
        f"--fit: everything is shown {factor:.3g} times as large, its middle moved by "
        f"{np.linalg.norm(middle - centre) * MM:.2g} mm to the axis, so that all frames lie within "
        f"{width * MM:.3g} × {height * MM:.3g} mm"
    )
    moved = {name: [pose(p) for p in each] for name, each in poses.items()}
    return scaled, moved, [_scaled(t, factor, middle, centre) for t in entries], [note]


def _scaled(
    entry: Entry, factor: float, middle: NDArray[np.float64], centre: NDArray[np.float64]
) -> Entry:
    """The description of an entry that was scaled about a middle and moved to a centre."""
    place = factor * (np.array(entry.place, dtype=np.float64) - middle) + centre
    motion = entry.motion
    if motion.scale is not None:
        motion = replace(motion, scale=factor * motion.scale)
    return replace(
        entry, scale=factor * (entry.scale or 1.0), place=tuple(place.tolist()), motion=motion
    )


def _leaving(
    bodies: dict[str, Surface | PointCloud],
    poses: dict[str, list[Pose]],
    slm: SLM,
    wavelength: float,
) -> list[str]:
    """A sentence for each body that leaves what the SLM shows; ValueError behind it."""
    notes = []
    for name, each in poses.items():
        hull = _hull(bodies[name])
        far: dict[int, float] = {}
        for k, pose in enumerate(each, 1):
            if outside(pose.apply(hull), slm, wavelength).max() < 0:
                continue
            world = pose.apply(body_positions(bodies[name]))
            if world[:, 2].min() <= 0:
                raise ValueError(
                    f"{name}, frame {k}: reaches to z = {world[:, 2].min() * MM:.4g} mm, at or "
                    "behind the hologram; make it smaller or place it farther away (--fit does)"
                )
            beyond = float(outside(world, slm, wavelength).max())
            if beyond >= 0:
                far[k] = beyond
        if far:
            worst = max(far, key=lambda k: far[k])
            notes.append(
                f"{name}: leaves what the SLM can show in {_frames(sorted(far))}, by up to "
                f"{far[worst] * MM:.3g} mm (frame {worst}); those points are left out, --fit "
                "keeps all inside"
            )
    return notes


def _frames(numbers: Sequence[int]) -> str:
    if len(numbers) == 1:
        return f"frame {numbers[0]}"
    return f"{len(numbers)} frames from {numbers[0]} to {numbers[-1]}"


def _spacing(
    world: World,
    bodies: dict[str, Surface | PointCloud],
    poses: dict[str, list[Pose]],
    slm: SLM,
    wavelength: float,
) -> float:
    """Metres between points."""
    area = sum(float(b.areas.sum()) for b in bodies.values() if isinstance(b, Surface))
    if world.points is not None and world.density is not None:
        raise ValueError("density and points both say how many points there are; keep one")
    if world.points is not None and area > 0:
        return sqrt(area / world.points)
    depth = float(np.median([each[0].translation[2] for each in poses.values()]))
    x, y = cell(slm, wavelength, depth)
    return sqrt((world.density or DENSITY) * x * y)
