"""A scene's points in one .npz, for other programs and back again without loss.

`positions` (N, 3), `amplitude` and `phase` (N,) hold all points. Of a scene of bodies they are in
body coordinates, `object` (N,) says whose they are (an index into `names`), `rotation`
(O, F, 3, 3) and `translation` (O, F, 3) are the poses and `visible` (F, ⌈N/8⌉) the packed bits of
who is seen in each frame. Of a scene of unknown identity they are in the world, frame after frame,
and `frame` (N,) says of which.
"""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.files import replacing
from chrmc.progress import progress
from chrmc.scene.point_scene import PointScene
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Pose, Scene
from chrmc.scene.sources.cloud import load_arrays
from chrmc.scene.sources.frames import CloudScene

FORMAT = "chrmc points 1"


def is_export(path: Path) -> bool:
    """Whether a file is an .npz that `write_export` made."""
    if path.suffix.lower() != ".npz" or not path.is_file():
        return False
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
            return "format" in stored.files
    except Exception:  # said in one line by whoever reads it
        return False


def write_export(scene: Scene, path: Path) -> int:
    """Write all frames of a scene; the number of points."""
    if path.suffix.lower() != ".npz":
        raise ValueError(f"{path}: points are exported to an .npz file")
    first = scene.frame(1)
    content: dict[str, Any] = {
        "format": FORMAT,
        "name": scene.name,
        "names": np.array(list(scene.object_names)),
        "pixel_pitch": scene.pixel_pitch,
        "wavelength": np.nan if scene.wavelength is None else scene.wavelength,
        "form": scene.form,
    }
    known = all(o.body is not None and o.pose is not None for o in first.objects)
    content |= _bodies(scene) if known else _frames(scene)
    with replacing(path) as partial, partial.open("wb") as file:
        np.savez_compressed(file, **content)
    return len(content["positions"])


def _arrays(cloud: PointCloud) -> dict[str, NDArray[Any]]:
    arrays = {"positions": cloud.positions, "amplitude": cloud.amplitude, "phase": cloud.phase}
    return arrays if cloud.colour is None else {**arrays, "colour": cloud.colour}


def _bodies(scene: Scene) -> dict[str, NDArray[Any]]:
    count = scene.frame_count
    objects = scene.frame(1).objects
    bodies = [o.body for o in objects if o.body is not None]
    rotation = np.zeros((len(bodies), count, 3, 3))
    translation = np.zeros((len(bodies), count, 3))
    start = np.cumsum([0, *(len(b) for b in bodies)])
    visible = []
    for n in progress(range(1, count + 1), "export"):
        mask = np.zeros(start[-1], dtype=bool)
        for k, obj in enumerate(scene.frame(n).objects):
            if obj.pose is None or obj.ids is None:
                raise ValueError(f"frame {n}: {obj.name} has lost its identity")
            rotation[k, n - 1] = obj.pose.rotation
            translation[k, n - 1] = obj.pose.translation
            mask[start[k] + obj.ids] = True
        visible.append(np.packbits(mask))
    return {
        **_arrays(PointCloud.concatenate(bodies)),
        "object": np.repeat(np.arange(len(bodies)), np.diff(start)),
        "rotation": rotation,
        "translation": translation,
        "visible": np.array(visible),
    }


def _frames(scene: Scene) -> dict[str, NDArray[Any]]:
    clouds, owner, frame = [], [], []
    for n in progress(range(1, scene.frame_count + 1), "export"):
        for k, obj in enumerate(scene.frame(n).objects):
            clouds.append(obj.cloud)
            owner.append(np.full(len(obj.cloud), k))
            frame.append(np.full(len(obj.cloud), n))
    return {
        **_arrays(PointCloud.concatenate(clouds)),
        "object": np.concatenate(owner),
        "frame": np.concatenate(frame),
        "frame_count": np.array(scene.frame_count),
    }


def read_export(path: Path) -> Scene:
    """The scene that `write_export` wrote: the same points in the same frames."""
    stored = load_arrays(path)
    try:
        if str(stored["format"]) != FORMAT:
            raise ValueError(f"format {stored['format']}, not {FORMAT!r}")
        return _scene(stored)
    except (KeyError, ValueError, IndexError) as error:
        raise ValueError(f"{path} is no scene of points: {' '.join(str(error).split())}") from None


def _scene(stored: dict[str, NDArray[Any]]) -> Scene:
    light = stored["amplitude"], stored["phase"], stored.get("colour")
    cloud = PointCloud(stored["positions"], *light)
    names = [str(n) for n in stored["names"]]
    owner = stored["object"]
    wavelength = float(stored["wavelength"])
    common: dict[str, Any] = {
        "name": str(stored["name"]),
        "pixel_pitch": float(stored["pixel_pitch"]),
        "wavelength": None if np.isnan(wavelength) else wavelength,
    }
    if "frame" in stored:
        frame = stored["frame"]

        def read(number: int) -> dict[str, PointCloud]:
            return {n: cloud.select((frame == number) & (owner == k)) for k, n in enumerate(names)}

        return CloudScene(
            read=read, frame_count=int(stored["frame_count"]), object_names=tuple(names), **common
        )
    rotation, translation = stored["rotation"], stored["translation"]
    packed, count = stored["visible"], len(cloud)

    def visible(k: int) -> Any:
        mine = np.flatnonzero(owner == k)
        return lambda number: np.unpackbits(packed[number - 1], count=count).astype(bool)[mine]

    return PointScene(
        bodies={n: cloud.select(owner == k) for k, n in enumerate(names)},
        poses={
            n: [Pose(r, t) for r, t in zip(rotation[k], translation[k], strict=True)]
            for k, n in enumerate(names)
        },
        visible={n: visible(k) for k, n in enumerate(names)},
        **common,
    )
