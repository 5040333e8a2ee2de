"""A folder of RGB-D frames from any tool, read and checked frame by frame."""

import re
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np

from chrmc.files import inside
from chrmc.scene.exr import read_exr
from chrmc.scene.rgbd import RGBDFrame
from chrmc.scene.rgbd_scene import RGBDScene
from chrmc.scene.scene_json import Description, read_description
from chrmc.threads import workers

WHOLE_SCENE = "scene"
"""Name of the only object of frames without ids."""


def read_scene(folder: str | Path) -> RGBDScene:
    """A folder of OpenEXR frames with a scene.json (see `scene_json`) as a scene.

    Every frame is read once, so that bad input is refused now and not in the middle of long work;
    later they are read again when asked for. Objects are those of scene.json, then those that
    only the id channel knows, as "object N"; frames without ids are one object called "scene".

    Raises OSError for missing or damaged files and ValueError for content that makes no sense,
    in one line.
    """
    folder = Path(folder)
    description = read_description(folder)
    files = _frame_files(folder, description)

    def survey(path: Path) -> tuple[tuple[int, int], bool, list[int]]:
        frame, has_ids = _read_frame(path, description)
        return frame.shape, has_ids, frame.ids.tolist()

    with ThreadPoolExecutor(workers()) as pool:
        found = list(pool.map(survey, files))
    shape = description.shape or found[0][0]
    for path, (size, has_ids, _) in zip(files, found, strict=True):
        if size != shape:
            said = "scene.json says" if description.shape else f"{files[0].name} has"
            raise ValueError(
                f"{path} has {size[1]} × {size[0]} pixels, but {said} {shape[1]} × {shape[0]}: "
                "all frames must be of one size"
            )
        if has_ids != found[0][1]:
            raise ValueError(
                f"{path} has {'an' if has_ids else 'no'} id channel, unlike {files[0].name}: "
                "write it in all frames or in none"
            )
    if found[0][1]:
        objects = dict(description.objects)
        for identity in sorted({i for _, _, ids in found for i in ids}):
            objects.setdefault(identity, f"object {identity}")
    else:
        objects = {0: WHOLE_SCENE}
    poses = {name: p for name, p in description.poses.items() if name in objects.values()}
    for name, each in poses.items():
        if len(each) not in (1, len(files)):
            raise ValueError(f"{folder}: {len(each)} poses of {name!r} for {len(files)} frames")
    return RGBDScene(
        name=description.name,
        read=lambda number: _read_frame(files[number - 1], description)[0],
        frame_count=len(files),
        shape=shape,
        pixel_pitch=description.pixel_pitch,
        objects=objects,
        planes=description.planes,
        wavelength=description.wavelength,
        poses=poses,
        phase_seed=description.phase_seed,
    )


def _read_frame(path: Path, description: Description) -> tuple[RGBDFrame, bool]:
    """One frame, its depths in range and snapped to the planes."""
    frame, has_ids = read_exr(path)
    lit = frame.lit
    try:
        _check_range(frame, description)
        if description.planes is not None:
            depth = np.zeros(frame.shape)
            depth[lit] = description.planes.snap(frame.depth[lit])
            frame = replace(frame, depth=depth)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    return frame, has_ids


def _check_range(frame: RGBDFrame, description: Description) -> None:
    if description.depth_range is None:
        return
    near, far = description.depth_range
    # Depths are stored in single precision.
    slack = 1e-6 * abs(far)
    bad = frame.lit & ((frame.depth < near - slack) | (frame.depth > far + slack))
    if bad.any():
        depth = frame.depth[bad]
        raise ValueError(
            f"{np.count_nonzero(bad)} lit pixels at {depth.min() * 1e3:.6g} to "
            f"{depth.max() * 1e3:.6g} mm lie outside the depth range {near * 1e3:.6g} to "
            f"{far * 1e3:.6g} mm: move them or widen depth_range"
        )


def _frame_files(folder: Path, description: Description) -> list[Path]:
    """Files of all frames in order; ValueError for a gap."""
    if description.files is not None:
        files = [folder / name for name in description.files]
    else:
        files = numbered(folder)
    files = [inside(folder, path) for path in files]
    count = description.frame_count
    if count is not None and len(files) < count:
        raise ValueError(
            f"{folder} has {len(files)} of the {count} frames that scene.json announces, "
            f"{files[0].name} to {files[-1].name}: write the others, or mend frame_count"
        )
    if count is not None and len(files) > count:
        raise ValueError(
            f"{folder} has {len(files)} frames, but scene.json announces {count}: remove the "
            "others, or mend frame_count"
        )
    return files


def numbered(folder: Path) -> list[Path]:
    """The .exr files of a folder by the number that ends their names."""
    numbered: dict[int, Path] = {}
    series: dict[str, Path] = {}
    for path in sorted(folder.iterdir()):
        if path.suffix.lower() != ".exr" or path.name.startswith("."):
            continue
        match = re.fullmatch(r"(.*?)(\d+)(\D*)", path.stem)
        if match is None:
            raise ValueError(
                f"{path} has no number in its name: number the frames (frame_0001.exr), or list "
                "them as frames in scene.json"
            )
        series.setdefault(match[1] + "#" + match[3], path)
        number = int(match[2])
        if len(series) > 1 or number in numbered:
            other = numbered.get(number) or next(iter(series.values()))
            raise ValueError(
                f"{folder} holds two series of frames, such as {other.name} and {path.name}: "
                "list the right files as frames in scene.json"
            )
        numbered[number] = path
    if not numbered:
        raise FileNotFoundError(
            f"{folder} holds no .exr frames: put frame_0001.exr and so on beside scene.json"
        )
    first, last = min(numbered), max(numbered)
    # A number may be of any size: the first gaps are found within as many as there are files.
    missing = list(islice((n for n in range(first, last + 1) if n not in numbered), 6))
    if missing:
        names = ", ".join(str(n) for n in missing[:5]) + (" …" if len(missing) > 5 else "")
        raise ValueError(
            f"{folder} has a gap: frame {names} of {first} to {last} is missing; write it, or "
            "list the files as frames in scene.json"
        )
    return [numbered[n] for n in sorted(numbered)]
