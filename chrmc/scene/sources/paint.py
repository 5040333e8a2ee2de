"""Colours of a mesh: of its corners, of its faces, or of a texture."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.colour import linear
from chrmc.pictures import MOST_PIXELS
from chrmc.scene.sources.model import only_line
from chrmc.scene.surface.surface import Paint

GREY = 0.8
"""Reflectance of a surface without any colour."""
MOST_TEXELS = MOST_PIXELS // 3
_ONE_AT_A_TIME = threading.Lock()


@contextmanager
def pictures_of_any_size() -> Iterator[None]:
    """While trimesh opens textures: it leaves out silently what Pillow refuses, and Pillow warns
    the user. Their size is looked at before they are unpacked."""
    from PIL import Image

    with _ONE_AT_A_TIME:
        before, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
        try:
            yield
        finally:
            Image.MAX_IMAGE_PIXELS = before


def _colours(colours: Any) -> NDArray[np.float64]:
    """(N, 3) linear light of (N, 3 or 4) 8-bit colours."""
    return linear(np.asarray(colours)[:, :3] / 255)


def paint_of(geometry: Any, index: NDArray[np.intp]) -> Paint:
    """The paint of a trimesh geometry whose faces `index` are kept."""
    visual = geometry.visual
    faces = np.asarray(geometry.faces, dtype=np.intp)[index]
    if visual.kind == "texture" and visual.material is not None:
        return _textured(visual, faces)
    if visual.kind == "vertex":
        corners = _colours(visual.vertex_colors)
        return lambda face, weights: np.einsum("nk,nkc->nc", weights, corners[faces[face]])
    if visual.kind == "face":
        flat = _colours(visual.face_colors)[index]
        return lambda face, weights: flat[face]
    return lambda face, weights: np.full(len(face), GREY)


def _textured(visual: Any, faces: NDArray[np.intp]) -> Paint:
    """Base colour times texture; a texture that is absent is the base colour alone."""
    material = visual.material
    image = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
    factor = getattr(material, "baseColorFactor", None)
    base = np.full(3, GREY)
    if factor is not None:
        # glTF's factor is linear; trimesh keeps it as 8 bits.
        base = np.asarray(factor, dtype=np.float64)[:3] / 255
    elif image is not None:
        base = np.ones(3)
    elif getattr(material, "diffuse", None) is not None:
        base = _colours(np.asarray(material.diffuse)[None])[0]
    if image is None or visual.uv is None or len(visual.uv) == 0:
        return lambda face, weights: np.tile(base, (len(face), 1))
    levels = _levels(image)
    uv = np.nan_to_num(np.asarray(visual.uv, dtype=np.float64)[:, :2], posinf=0, neginf=0)

    def paint(face: NDArray[np.intp], weights: NDArray[np.float64]) -> NDArray[np.float64]:
        u, v = np.einsum("nk,nkx->xn", weights, uv[faces[face]])
        height, width = levels.shape[:2]
        column = np.floor(u % 1 * width).astype(np.intp) % width
        row = np.floor((1 - v) % 1 * height).astype(np.intp) % height
        return linear(levels[row, column] / 255) * base

    return paint


def _levels(image: Any) -> NDArray[np.uint8]:
    """(h, w, 3) of a texture; OSError for one that is too large or damaged."""
    width, height = image.size
    if width * height > MOST_TEXELS:
        raise OSError(
            f"a texture of {width} × {height} pixels is larger than {MOST_TEXELS / 1e6:.0f} "
            "million: make it smaller"
        )
    try:
        return np.asarray(image.convert("RGB"))
    except Exception as error:  # whatever a decoder makes of a stranger's bytes
        raise OSError(f"a texture cannot be read: {only_line(error)}") from None
