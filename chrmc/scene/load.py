"""Scenes by name or by folder."""

from chrmc.scene.car_house import HEADINGS, car_house
from chrmc.scene.scene import Scene


def load_scene(name_or_folder: str, form: str = "points") -> Scene:
    """A built-in scene or a folder of RGB-D frames."""
    if form not in ("points", "rgbd"):
        raise ValueError(f"unknown form {form!r} of a scene: choose points or rgbd")
    if name_or_folder in HEADINGS and form == "points":
        return car_house(name_or_folder)
    raise ValueError(f"unknown scene {name_or_folder!r}: choose one of {', '.join(HEADINGS)}")
