"""`scene.json`: what a folder of RGB-D frames does not say in its pictures.

pixel_pitch : metres between neighbouring pixels; the only key that must be there
name : of the scene; default the folder's
frames : list of file names, default every .exr file of the folder by number
frame_count : how many frames there must be
shape : [rows, columns] that every frame must have
depth_min, depth_step : metres; plane k lies at depth_min + k·depth_step, and depths are snapped to
    the nearest plane; without depth_step they are taken as they are
depth_planes : number of planes, default 256
depth_range : [nearest, farthest] in metres that no lit pixel may leave
wavelength : metres; without it the user picks
objects : list of {"id": number in the id channel, "name": text}
poses : object name to a list of {"rotation": 3 × 3, "translation": [x, y, z] in metres}, body to
    world, one per frame or a single one; for objects whose motion is known
phase_seed : whole number, of the pixels' random phases
form : "rgbd"

Other keys are ignored.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from chrmc.files import read_json
from chrmc.ranges import PITCH_RANGE, WAVELENGTH_RANGE, real, short
from chrmc.scene.points import FARTHEST
from chrmc.scene.rgbd import DepthPlanes
from chrmc.scene.rgbd_scene import PHASE_SEED, RGBDScene
from chrmc.scene.scene import Pose

SCENE_FILE = "scene.json"


@dataclass(frozen=True)
class Description:
    """The checked content of a scene.json; see the module for units."""

    name: str
    pixel_pitch: float
    files: Sequence[str] | None = None
    frame_count: int | None = None
    shape: tuple[int, int] | None = None
    planes: DepthPlanes | None = None
    depth_range: tuple[float, float] | None = None
    wavelength: float | None = None
    objects: Mapping[int, str] = field(default_factory=dict)
    poses: Mapping[str, Sequence[Pose]] = field(default_factory=dict)
    phase_seed: int = PHASE_SEED


def describe(scene: RGBDScene) -> dict[str, Any]:
    """The scene.json of a scene."""
    content: dict[str, Any] = {
        "form": "rgbd",
        "name": scene.name,
        "frame_count": scene.frame_count,
        "shape": list(scene.shape),
        "pixel_pitch": scene.pixel_pitch,
    }
    if scene.planes is not None:
        content["depth_min"] = scene.planes.first
        content["depth_step"] = scene.planes.step
        content["depth_planes"] = scene.planes.count
    if scene.wavelength is not None:
        content["wavelength"] = scene.wavelength
    content["phase_seed"] = scene.phase_seed
    content["objects"] = [{"id": int(i), "name": name} for i, name in scene.objects.items()]
    if scene.poses:
        content["poses"] = {
            name: [
                {"rotation": p.rotation.tolist(), "translation": p.translation.tolist()}
                for p in poses
            ]
            for name, poses in scene.poses.items()
        }
    return content


def read_description(folder: Path) -> Description:
    """The scene.json of a folder; OSError or ValueError in one line."""
    path = folder / SCENE_FILE
    if not path.is_file():
        raise FileNotFoundError(
            f"{folder} has no {SCENE_FILE}: write one that says at least "
            '{"pixel_pitch": metres per pixel}'
        )
    content = read_json(path, "scene folder")
    try:
        return _check(content, folder.resolve().name)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def _check(content: Any, folder_name: str) -> Description:
    if not isinstance(content, dict):
        raise ValueError('the file must be an object, such as {"pixel_pitch": 40.5e-6}')
    if content.get("form", "rgbd") != "rgbd":
        raise ValueError(f"unknown form {content['form']!r}; folders hold form rgbd")
    if "pixel_pitch" not in content:
        raise ValueError("pixel_pitch is missing; say how many metres one pixel spans")
    count, wavelength = content.get("frame_count"), content.get("wavelength")
    return Description(
        name=str(content.get("name", folder_name)),
        pixel_pitch=PITCH_RANGE.of(content["pixel_pitch"]),
        files=_files(content.get("frames")),
        frame_count=None if count is None else _whole(count, "frame_count", 1),
        shape=_shape(content.get("shape")),
        planes=_planes(content),
        depth_range=_depth_range(content.get("depth_range")),
        wavelength=None if wavelength is None else WAVELENGTH_RANGE.of(wavelength),
        objects=_objects(content.get("objects", [])),
        poses=_poses(content.get("poses", {}), count),
        phase_seed=_whole(content.get("phase_seed", PHASE_SEED), "phase_seed", 0),
    )


def _whole(value: Any, key: str, least: int) -> int:
    number = real(key, value)
    if number != int(number) or number < least:
        raise ValueError(f"{key} must be a whole number from {least} on, not {short(value)}")
    return int(number)


def _files(value: Any) -> list[str] | None:
    if value is None:
        return None
    if not isinstance(value, list) or not value or not all(isinstance(v, str) for v in value):
        raise ValueError(f"frames must be a list of file names, not {short(value)}")
    for name in value:
        if "\0" in name or Path(name).is_absolute() or ".." in Path(name).parts:
            raise ValueError(f"frames: {short(name)} leads out of the folder; name files in it")
    return value


def _shape(value: Any) -> tuple[int, int] | None:
    if value is None:
        return None
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError(f"shape must be [rows, columns], not {value!r}")
    return _whole(value[0], "shape", 1), _whole(value[1], "shape", 1)


def _planes(content: Mapping[str, Any]) -> DepthPlanes | None:
    if content.get("depth_step") is None:
        return None
    if content.get("depth_min") is None:
        raise ValueError("depth_step without depth_min; say where the first plane lies, in metres")
    return DepthPlanes(
        real("depth_min", content["depth_min"]),
        real("depth_step", content["depth_step"]),
        _whole(content.get("depth_planes", 256), "depth_planes", 1),
    )


def _depth_range(value: Any) -> tuple[float, float] | None:
    if value is None:
        return None
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError(f"depth_range must be [nearest, farthest] in metres, not {value!r}")
    low, high = real("depth_range", value[0]), real("depth_range", value[1])
    if not low <= high:
        raise ValueError(f"depth_range runs backwards: [{low}, {high}]; write the nearest first")
    return low, high


def _objects(value: Any) -> dict[int, str]:
    if not isinstance(value, list):
        raise ValueError(f'objects must be a list of {{"id": …, "name": …}}, not {value!r}')
    objects: dict[int, str] = {}
    for entry in value:
        if not isinstance(entry, dict) or "id" not in entry:
            raise ValueError(f'objects must be a list of {{"id": …, "name": …}}; one is {entry!r}')
        identity = _whole(entry["id"], "id of an object", 0)
        name = str(entry.get("name", f"object {identity}"))
        if identity in objects or name in objects.values():
            raise ValueError(f"object {name!r} with id {identity} is listed twice")
        objects[identity] = name
    return objects


def _poses(value: Any, frame_count: Any) -> dict[str, list[Pose]]:
    if not isinstance(value, dict):
        raise ValueError("poses must be an object that maps names to lists")
    poses: dict[str, list[Pose]] = {}
    for name, entries in value.items():
        if not isinstance(entries, list) or (
            frame_count is not None and len(entries) not in (1, frame_count)
        ):
            raise ValueError(f"poses of {name!r} must be a list of one per frame, or of one")
        poses[name] = [_pose(entry, name, k) for k, entry in enumerate(entries, 1)]
    return poses


def _pose(entry: Any, name: str, number: int) -> Pose:
    try:
        rotation = np.array(entry["rotation"], dtype=np.float64)
        translation = np.array(entry["translation"], dtype=np.float64)
        right = rotation.shape == (3, 3) and translation.shape == (3,)
        right = right and np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-6)
        right = (
            right and np.linalg.det(rotation) > 0 and bool((np.abs(translation) <= FARTHEST).all())
        )
    except (TypeError, KeyError, ValueError):
        right = False
    if not right:
        raise ValueError(
            f"pose {number} of {name!r} needs a 3 × 3 rotation and a translation of 3 metres"
        )
    return Pose(rotation, translation)
