"""Files that a mesh file names beside itself: materials, textures, buffers."""

import json
import re
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from chrmc.files import inside

MAPS = rb"(?:map_\w+|bump|norm|disp|decal|refl)"
"""Words of an .mtl before a picture."""
HEAD = 1 << 20
"""Bytes of a .ply that may be its header."""


def beside(path: Path) -> list[Path]:
    """Those that are there, in a fixed order; none for files that name none.

    Only names are read: what is wrong with a file its reader says.
    """
    kind = path.suffix.lower()
    if kind == ".obj":
        materials = _there(path, _named(path, rb"mtllib"))
        return materials + [p for m in materials for p in _there(path, _named(m, MAPS))]
    if kind == ".ply":
        return _there(path, _named(path, rb"comment\s+TextureFile", HEAD))
    if kind in (".gltf", ".glb"):
        return _there(path, _addresses(path))
    return []


def _named(path: Path, word: bytes, most: int = -1) -> list[str]:
    """What follows a word at the beginning of a line; after options also its last part."""
    with path.open("rb") as file:
        found = re.findall(rb"^[ \t]*" + word + rb"[ \t]+(.+?)[ \t]*\r?$", file.read(most), re.M)
    names = [name.decode("utf-8", "replace") for name in found]
    return [part for name in names for part in dict.fromkeys((name, name.split()[-1]))]


def _addresses(path: Path) -> list[str]:
    """Of a glTF's buffers and pictures, in its JSON."""
    try:
        gltf = gltf_json(path)
        parts = [*gltf.get("buffers", ()), *gltf.get("images", ())]
        names = [p["uri"] for p in parts if not p.get("uri", "data:").startswith("data:")]
        return [each for name in names for each in (name, unquote(name))]
    except (ValueError, AttributeError, TypeError):
        return []


def gltf_json(path: Path) -> Any:
    """The JSON of a .gltf or .glb; ValueError where it is none."""
    content = path.read_bytes()
    if content[:4] == b"glTF":  # header of 12 bytes, length and kind of the first chunk
        content = content[20 : 20 + int.from_bytes(content[12:16], "little")]
    try:
        return json.loads(content)
    except RecursionError:
        raise ValueError("its JSON is too deep") from None


def check_tree(path: Path) -> None:
    """OSError where a glTF's nodes are no trees: who walks them would come to no end."""
    try:
        nodes = enumerate(gltf_json(path).get("nodes", ()))
        pairs = [(child, k) for k, node in nodes for child in node.get("children", ())]
        parents = dict(pairs)
        if len(parents) < len(pairs):
            raise OSError(f"{path} is damaged: a node has two parents; export it again")
        rooted: set[int] = set()
        for node in parents:
            way = {}  # in order
            while node in parents and node not in rooted:
                if node in way:
                    raise OSError(f"{path} is damaged: a node is its own ancestor; export it again")
                way[node] = True
                node = parents[node]
            rooted.update(way)
    except (ValueError, AttributeError, TypeError):
        return  # its reader says what is wrong


def _there(path: Path, names: list[str]) -> list[Path]:
    """Files among names, as the mesh's reader looks for them."""
    files = (file_beside(path.parent, name) for name in names)
    return list(dict.fromkeys(file for file in files if file is not None))


def file_beside(folder: Path, name: str) -> Path | None:
    """The file that a mesh in a folder names, also as Windows does; None where it is absent.

    A stranger's mesh reads nothing else: a name that leads out of the folder (`..`, absolute, a
    link) is looked for without its path.
    """
    plain = name.strip().replace("\\", "/")
    for each in (plain, Path(plain).name):
        with suppress(ValueError, OSError):  # no name at all, or one too long
            if inside(folder, folder / each).is_file():  # a device or a pipe never ends
                return folder / each
    return None
