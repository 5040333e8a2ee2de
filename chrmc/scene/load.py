"""Scenes by name or by folder."""

from pathlib import Path

from chrmc.scene.car_house import HEADINGS, car_house, car_house_rgbd
from chrmc.scene.scene import Scene

DENSE = "car-house-dense"
BUILT_IN = (*HEADINGS, DENSE)
"""Names of the scenes that come with the package."""


def load_scene(name_or_folder: str | Path, form: str = "points") -> Scene:
    """A built-in scene or a folder of RGB-D frames.

    name_or_folder : `car-house`, `car-house-deep`, `car-house-dense`, or a folder with a
        scene.json and OpenEXR frames of any tool (see `chrmc.scene.scene_json`)
    form : "points" (body-fixed, exact) or "rgbd" (320 × 240 images, depth in planes) of a built-in
        scene; a folder is always rgbd

    Raises ValueError or OSError, in one line, for a scene that is not there or makes no sense.
    """
    if form not in ("points", "rgbd"):
        raise ValueError(f"unknown form {form!r} of a scene: choose points or rgbd")
    name = str(name_or_folder)
    if name == DENSE:
        from chrmc.scene.dense import car_house_dense, car_house_dense_rgbd

        return car_house_dense() if form == "points" else car_house_dense_rgbd()
    if name in BUILT_IN:
        return car_house(name) if form == "points" else car_house_rgbd(name)
    folder = Path(name_or_folder)
    if folder.is_dir():
        from chrmc.scene.read_folder import read_scene

        return read_scene(folder)
    if folder.exists():
        raise ValueError(
            f"{folder} is a file, not a scene: name the folder with scene.json and the frames"
        )
    raise ValueError(
        f"there is no scene {name!r}: name a built-in one ({', '.join(BUILT_IN)}) or a folder of "
        "RGB-D frames"
    )
