"""A scene written as a folder of OpenEXR frames and a scene.json (see `scene_json`)."""

import re
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

from chrmc.files import read_json, still_there, sweep, write_json
from chrmc.scene.exr import write_exr
from chrmc.scene.rgbd_scene import RGBDScene, rasterised
from chrmc.scene.scene import Scene, frame_range
from chrmc.scene.scene_json import SCENE_FILE, describe

Watch = Callable[[Iterable[int]], Iterable[int]]


def frame_name(number: int) -> str:
    """File of a frame: frame_0001.exr."""
    return f"frame_{number:04d}.exr"


def write_scene(
    scene: Scene,
    folder: str | Path,
    *,
    frames: tuple[int, int] | None = None,
    force: bool = False,
    watch: Watch | None = None,
) -> list[Path]:
    """Write a scene as frame_0001.exr … and scene.json; frames already there are kept.

    scene : its RGB-D form; other forms are rasterised first, see `rasterised`
    frames : (first, last) of the scene; the folder's own numbers start at 1, and `scene_frames`
        in scene.json says which they were
    force : replace another scene that is in the folder
    watch : wraps the frame numbers, for a progress bar

    Returns the files, in order. Raises ValueError when the folder holds something else.
    """
    folder = Path(folder)
    images = scene if isinstance(scene, RGBDScene) else rasterised(scene)
    numbers = frame_range(images, frames)
    before = numbers[0] - 1
    poses = {
        name: list(each) if len(each) == 1 else each[before : before + len(numbers)]
        for name, each in images.poses.items()
    }
    content = describe(replace(images, frame_count=len(numbers), poses=poses))
    content["scene_frames"] = [numbers[0], numbers[-1]]
    _make_room(folder, content, force)
    sweep(folder)
    write_json(folder / SCENE_FILE, content)
    paths = []
    for number in numbers if watch is None else watch(numbers):
        path = folder / frame_name(number - before)
        if not path.is_file():
            picture = images.rgbd(number)
            still_there(folder)
            write_exr(path, picture)
        paths.append(path)
    return paths


def _make_room(folder: Path, content: dict[str, Any], force: bool) -> None:
    """Keep frames of the same scene, remove others when forced, else refuse."""
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"{folder} is a file: name a folder")
    pictures = sorted(folder.glob("*.exr")) if folder.is_dir() else []
    found: Any = None
    if (folder / SCENE_FILE).is_file():
        try:
            found = read_json(folder / SCENE_FILE, "scene folder")
        except ValueError:
            found = {}
    elif not pictures:
        return
    if _continued_by(found, content) and len(pictures) <= content["frame_count"]:
        return
    if not force:
        raise ValueError(
            f"{folder} holds another scene, or other frames of it: choose another folder, or "
            "replace it with --force"
        )
    for path in pictures:
        if re.fullmatch(r"frame_\d+\.exr", path.name):
            path.unlink()


def _continued_by(found: Any, content: dict[str, Any]) -> bool:
    """Whether the folder's scene is this one from its first frame on, of whatever length."""
    if not isinstance(found, dict):
        return False

    def fixed(description: dict[str, Any]) -> dict[str, Any]:
        open_ended = ("frame_count", "scene_frames", "poses")
        return {k: v for k, v in description.items() if k not in open_ended}

    try:
        if found["scene_frames"][0] != content["scene_frames"][0]:
            return False
        poses = content.get("poses", {})
        before = found.get("poses", {})
        same_poses = set(poses) == set(before) and all(
            a == b for name in poses for a, b in zip(poses[name], before[name], strict=False)
        )
    except (KeyError, TypeError, IndexError):
        return False
    return same_poses and fixed(found) == fixed(content)
