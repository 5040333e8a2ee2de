"""How bright a point of a surface is: reflectance times the light that a lamp throws on it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chrmc.colour import LUMINANCE, hue
from chrmc.scene.surface.surface import Surface


@dataclass(frozen=True)
class Lamp:
    """A distant, large lamp.

    towards : (x, y, z) direction to it in the axes of the scene (y down), any length
    ambient : share of the light that comes from everywhere
    """

    towards: tuple[float, float, float] = (-0.5, -1.0, -0.8)
    ambient: float = 0.15

    def __post_init__(self) -> None:
        length = float(np.linalg.norm(self.towards))
        if not (np.isfinite(length) and length > 0):
            raise ValueError(f"a lamp needs a direction, not {list(self.towards)}")
        if not 0 <= self.ambient <= 1:
            raise ValueError(f"ambient light is a share from 0 to 1, not {self.ambient}")

    def shade(self, normals: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N,) light on surfaces of (N, 3) unit normals, 0 … 1.

        The lamp is as large as the sky's half: ((1 + n·l)/2)², so that no part is black.
        """
        facing = normals @ (np.asarray(self.towards) / np.linalg.norm(self.towards))
        return self.ambient + (1 - self.ambient) * ((1 + facing) / 2) ** 2


def brightness(
    surface: Surface,
    face: NDArray[np.intp],
    weights: NDArray[np.float64],
    lamp: Lamp | None,
    rotation: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """(N,) luminance of the paint · shading at barycentric places, and (N, 3) its colour or None.

    lamp : None for unlit
    rotation : (3, 3) body to scene in the pose in which the lamp's light is fixed to the body
    """
    paint = np.clip(surface.paint(face, weights), 0, None)
    grey: NDArray[np.float64] = paint @ LUMINANCE if paint.ndim == 2 else paint
    colour = hue(paint) if paint.ndim == 2 else None
    if lamp is None:
        return grey, colour
    return grey * lamp.shade(surface.normal_at(face, weights) @ rotation.T), colour
