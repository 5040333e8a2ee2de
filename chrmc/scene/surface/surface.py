"""A painted triangle mesh: what an opaque body is made of."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from chrmc.scene.shapes import Solid

Paint = Callable[[NDArray[np.intp], NDArray[np.float64]], NDArray[np.float64]]
"""(N,) face indices and (N, 3) barycentric weights to reflectances in 0 … 1, linear: (N,) of a grey
body, (N, 3) sRGB of a coloured one."""
CREASE = np.cos(np.radians(40.0))
"""A corner is shaded smoothly where its normal is within this angle of the face's."""


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles in body coordinates with their paint.

    vertices : (V, 3) metres
    faces : (F, 3) vertex indices, none of zero area
    paint : reflectance anywhere on them
    normals : (V, 3) for smooth shading, or None for flat faces
    closed : whether the faces enclose a body and look outward, so that backs are never seen
    opaque : whether it hides what is behind it
    shape : of a surface that bends, frame 0, 1, … to its (V, 3) vertices; those of frame 0 are
        `vertices`, and `normals` is None
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.intp]
    paint: Paint
    normals: NDArray[np.float64] | None = None
    closed: bool = True
    opaque: bool = True
    shape: Callable[[int], NDArray[np.float64]] | None = None

    @cached_property
    def _crossed(self) -> NDArray[np.float64]:
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        return np.cross(b - a, c - a)

    @cached_property
    def areas(self) -> NDArray[np.float64]:
        """(F,) square metres."""
        return np.linalg.norm(self._crossed, axis=1) / 2

    @cached_property
    def face_normals(self) -> NDArray[np.float64]:
        """(F, 3) unit normals by the right-hand rule."""
        return self._crossed / (2 * self.areas[:, None])

    def at(self, face: NDArray[np.intp], weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) body positions of barycentric places."""
        return np.einsum("nk,nkx->nx", weights, self.vertices[self.faces[face]])

    def normal_at(
        self, face: NDArray[np.intp], weights: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """(N, 3) unit normals for shading: interpolated over smooth parts, flat at creases."""
        flat = self.face_normals[face]
        if self.normals is None:
            return flat
        corner = self.normals[self.faces[face]]
        smooth = np.einsum("nkx,nx->nk", corner, flat) > CREASE
        corner = np.where(smooth[:, :, None], corner, flat[:, None, :])
        normal = np.einsum("nk,nkx->nx", weights, corner)
        return normal / np.linalg.norm(normal, axis=1, keepdims=True)

    def moved(self, scale: float, centre: NDArray[np.float64]) -> "Surface":
        """The same surface about another origin and in another size: scale·(vertex − centre)."""
        shape = self.shape
        return replace(
            self,
            vertices=scale * (self.vertices - centre),
            shape=None if shape is None else lambda frame: scale * (shape(frame) - centre),
        )

    def in_frame(self, frame: int) -> "Surface":
        """As it is bent in frame 0, 1, …; itself when it is rigid."""
        return self if self.shape is None else replace(self, vertices=self.shape(frame))


def from_solid(solid: Solid) -> Surface:
    """The surface of a built-in solid; corners in between its parts stay inside it, unseen."""
    triangles = solid.triangles
    surface: Surface

    def paint(face: NDArray[np.intp], weights: NDArray[np.float64]) -> NDArray[np.float64]:
        return solid.paint(surface.at(face, weights), face)

    surface = Surface(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), paint)
    return surface


def join(surfaces: Sequence[Surface]) -> Surface:
    """Several surfaces as one rigid body; closed when all of them are."""
    if len(surfaces) == 1:
        return surfaces[0]
    vertex = np.cumsum([0, *(len(s.vertices) for s in surfaces)])
    first = np.cumsum([0, *(len(s.faces) for s in surfaces)])

    def paint(face: NDArray[np.intp], weights: NDArray[np.float64]) -> NDArray[np.float64]:
        shown = np.zeros((len(face), 3))
        owner = np.searchsorted(first, face, side="right") - 1
        for k in np.unique(owner):
            mine = owner == k
            part = surfaces[k].paint(face[mine] - first[k], weights[mine])
            shown[mine] = part if part.ndim == 2 else part[:, None]
        return shown

    def bent(frame: int) -> NDArray[np.float64]:
        return np.concatenate([s.in_frame(frame).vertices for s in surfaces])

    # Flat parts say so by normals that agree with no face.
    normals = [np.zeros_like(s.vertices) if s.normals is None else s.normals for s in surfaces]
    return Surface(
        np.concatenate([s.vertices for s in surfaces]),
        np.concatenate([s.faces + n for s, n in zip(surfaces, vertex, strict=False)]),
        paint,
        np.concatenate(normals),
        all(s.closed for s in surfaces),
        surfaces[0].opaque,
        bent if any(s.shape for s in surfaces) else None,
    )
