"""Scenes by name, by folder, or from a Python file."""

from inspect import isclass, isroutine
from pathlib import Path

from chrmc.python_file import from_python_file, is_python_name, one_line
from chrmc.scene.car_house import HEADINGS, car_house, car_house_rgbd
from chrmc.scene.scene import Scene, as_scene

DENSE = "car-house-dense"
BUILT_IN = (*HEADINGS, DENSE)
"""Names of the scenes that come with the package."""


def load_scene(name_or_folder: str | Path, form: str = "points") -> Scene:
    """A built-in scene or a folder of RGB-D frames.

    name_or_folder : `car-house`, `car-house-deep`, `car-house-dense`, a folder with a scene.json
        and OpenEXR frames of any tool (see `chrmc.scene.scene_json`), or FILE.py:NAME, a scene in
        a Python file or a function without arguments that returns one
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
    if is_python_name(name):
        return python_scene(name)
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
        "RGB-D frames, or one of your own as FILE.py:NAME"
    )


def python_scene(text: str) -> Scene:
    """The scene that FILE.py:NAME names, or that the function of that name returns."""
    found = from_python_file(text)
    with one_line(text):
        return as_scene(found() if isroutine(found) or isclass(found) else found)
