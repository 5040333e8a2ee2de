"""Files of other programs as scenes: one reader per kind, one line here for each."""

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chrmc.scene.sources.model import Model

READERS = {
    **dict.fromkeys((".glb", ".gltf", ".obj", ".ply", ".stl"), "mesh:read_mesh"),
    **dict.fromkeys((".xyz", ".csv"), "cloud:read_cloud"),
    ".npz": "cloud:read_npz",
    **dict.fromkeys((".png", ".jpg", ".jpeg", ".tif", ".tiff"), "picture:read_picture"),
}
"""Ending of a file to the module and function that read it as a `Model`."""
TEXT = "text:"
"""What a source that is words begins with."""


def readable(source: str) -> bool:
    """Whether a source is of a kind that `read_model` knows."""
    return source.startswith(TEXT) or Path(source).suffix.lower() in READERS


def read_model(source: str) -> "Model":
    """What a file holds, or `text:WORDS` as a picture; OSError or ValueError in one line."""
    if source.startswith(TEXT):
        from chrmc.scene.sources.picture import text_picture

        return text_picture(source.removeprefix(TEXT))
    path = Path(source)
    if not path.exists():
        raise FileNotFoundError(f"{path} is missing")
    if path.is_dir():
        from chrmc.scene.sources.recording import recorded_model

        return recorded_model(path)
    if not path.is_file():
        raise ValueError(f"{path} is no file")
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise ValueError(f"{path}: no reader for {path.suffix or 'a file without an ending'}; "
                         f"known are {', '.join(READERS)}")  # fmt: skip
    module, function = reader.split(":")
    found: Model = getattr(import_module(f"chrmc.scene.sources.{module}"), function)(path)
    return found
