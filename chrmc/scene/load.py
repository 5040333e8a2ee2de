"""Scenes by name or by folder."""

from chrmc.scene.scene import Scene


def load_scene(name_or_folder: str, form: str = "points") -> Scene:
    """A built-in scene or a folder of RGB-D frames."""
    raise ValueError(f"unknown scene {name_or_folder!r}")
