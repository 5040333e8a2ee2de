"""What a scene was loaded from, for a video's manifest, and the same scene again from there."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from chrmc.python_file import is_python_name
from chrmc.scene.load import BUILT_IN, SIZED, load_scene
from chrmc.scene.scene import Scene
from chrmc.slm import SLM

MADE_OF = "made_of"
"""Key of a manifest's scene."""


@dataclass(frozen=True)
class Origin:
    """Files and text, and how they were read.

    sources : words as `load_scene` takes them, none of them a built-in name or a Python file
    form : "points" or "rgbd"; options : density, points and fit, as `load_scene` takes them
    notes : what was understood, a sentence each
    """

    sources: tuple[str, ...]
    form: str
    options: Mapping[str, Any]
    notes: tuple[str, ...] = ()

    def described(self) -> dict[str, Any]:
        """For the manifest: every source's place on this machine and the SHA-256 of its content."""
        return {
            "things": [_recorded(words) for words in self.sources],
            "form": self.form,
            "options": {name: self.options.get(name, value) for name, value in SIZED.items()},
            "notes": list(self.notes),
        }


def opened(
    scene: Scene | str | PathLike[str], slm: SLM, wavelength: float | None
) -> tuple[Scene, Origin | str | None]:
    """A scene, loaded where it is not yet, and what it came from; see `origin_of`."""
    if not isinstance(scene, str | PathLike):
        return scene, None
    found = load_scene(fspath(scene), slm=slm, wavelength=wavelength)
    return found, origin_of((fspath(scene),), "points", {}, found)


def origin_of(
    sources: Sequence[str], form: str, options: Mapping[str, Any], scene: Scene
) -> Origin | str | None:
    """What a scene was made of: files, or FILE.py:NAME; None where its name says all."""
    if is_python_name(sources[0]):
        return sources[0]
    if sources[0] in BUILT_IN:
        return None
    notes = tuple(str(note) for note in getattr(scene, "notes", ()))
    return Origin(tuple(sources), form, options, notes)


def scene_made_of(
    record: Mapping[str, Any], slm: SLM, wavelength: float, sources: Sequence[str] = ()
) -> Scene:
    """The scene that a manifest's `made_of` speaks of.

    sources : where its files are by now, default where they were; ones that were found by the
        record must have the content that they had, so that a manifest opens nothing else

    Raises ValueError or OSError in one line.
    """
    try:
        words = list(sources) or [_found(entry) for entry in record["things"]]
        options = {name: record["options"][name] for name in SIZED}
        form = str(record["form"])
    except (KeyError, TypeError) as error:
        raise ValueError(
            f"the manifest does not say what the scene was made of ({error}): name it, --scene"
        ) from None
    named = words[0] if len(words) == 1 else words
    return load_scene(named, form, slm=slm, wavelength=wavelength, **options)


def _found(entry: Mapping[str, Any]) -> str:
    """A source where it was, unchanged."""
    words = str(entry["thing"])
    if entry.get("path") is None:
        if _place(words)[0] is not None:
            raise ValueError(f"the manifest holds no hash of {words}: name it, --scene {words}")
        return words
    path = Path(str(entry["path"]))
    if not path.exists():
        raise FileNotFoundError(f"the scene came from {path}, which is missing: name it, --scene")
    if path.suffix.lower() == ".py" or content_hash(path) != entry["sha256"]:
        raise ValueError(
            f"{path} has changed since the video was made: make the video again, or name another "
            "copy, --scene"
        )
    return str(path) + _place(words)[1]


def _recorded(words: str) -> dict[str, Any]:
    path, _ = _place(words)
    if path is None:
        return {"thing": words, "path": None, "sha256": None}
    return {"thing": words, "path": str(path.resolve()), "sha256": content_hash(path)}


def _place(words: str) -> tuple[Path | None, str]:
    """The file or folder that a word names, and what it says behind that."""
    from chrmc.scene.sources.world import split_depth

    if Path(words).exists():
        return Path(words), ""
    source, _ = split_depth(words)
    if source.startswith("text:"):
        return None, ""
    return Path(source), words.removeprefix(source)


def _files(path: Path) -> list[Path]:
    """A file or folder with all that belongs to it, in a fixed order."""
    from chrmc.scene.sources.beside import beside
    from chrmc.scene.sources.world_toml import read_world

    if path.is_dir():
        return sorted(p for p in path.rglob("*") if p.is_file() and not p.name.startswith("."))
    if path.suffix.lower() != ".toml":
        return [path, *beside(path)]
    inner = read_world(path).files
    # A scene.toml cannot hold another one, whatever it says.
    return [path, *(p for f in inner for p in (_files(f) if f.suffix.lower() != ".toml" else [f]))]


def content_hash(path: Path) -> str:
    """SHA-256 of a file; with their names, of a folder's files, of a scene.toml with its files, of
    a mesh with the materials, textures and buffers beside it."""
    files = _files(path)
    digest = hashlib.sha256()
    for file in files:
        if len(files) > 1:
            digest.update(file.name.encode() + b"\0")
        with file.open("rb") as stream:
            digest.update(hashlib.file_digest(stream, "sha256").digest())
    return digest.hexdigest()
