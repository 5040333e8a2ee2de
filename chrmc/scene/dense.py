"""`car-house-dense`: the car and the house as shaded, textured, opaque surfaces.

Shapes, motion and places are those of `car-house`; the paint is finer, and a hundred thousand
points stand where twelve hundred stood.
"""

import numpy as np
from numpy.typing import NDArray

from chrmc.scene import models
from chrmc.scene.car_house import PITCH, SHAPE, actors
from chrmc.scene.models import MM
from chrmc.scene.rgbd import PLANES
from chrmc.scene.rgbd_scene import RGBDScene
from chrmc.scene.scene import Scene
from chrmc.scene.shapes import Paint, Part, Solid
from chrmc.scene.surface.cast import Cast
from chrmc.scene.surface.shading import Lamp
from chrmc.scene.surface.surface import from_solid
from chrmc.slm import WAVELENGTH

NAME = "car-house-dense"
SPACING = 4.4e-6
"""Metres between points: about 100,000 of them are visible."""
BRICK, COURSE, MORTAR = 0.150, 0.075, 0.016
"""Length and height of a brick with its joint, and the joint, millimetres."""
TILE, ROW = 0.105, 0.070
"""Width and visible height of a roof tile, millimetres."""


def cast() -> Cast:
    """Car and house with their motion."""
    return Cast(
        name=NAME,
        bodies={"car": from_solid(_car()), "house": from_solid(_house())},
        poses={name: actor.poses for name, actor in actors("car-house").items()},
        spacing=SPACING,
        lamp=Lamp(),
        pixel_pitch=PITCH,
        wavelength=WAVELENGTH,
    )


def car_house_dense() -> Scene:
    """The scene as body-fixed points."""
    return cast().points()


def car_house_dense_rgbd() -> RGBDScene:
    """The scene as 320 × 240 pictures with 256 depth planes."""
    return cast().pictures(SHAPE, PLANES)


def _painted(solid: Solid, *paints: Paint) -> Solid:
    return Solid(tuple(Part(p.triangles, new) for p, new in zip(solid.parts, paints, strict=True)))


def _car() -> Solid:
    wheels = [_wheel(x, 0.180) for x in (-0.490, 0.480) for _ in range(2)]
    return _painted(models.car(), _body, _cabin, *wheels)


def _house() -> Solid:
    return _painted(models.house(), _walls, _tiles, _tiles, _chimney)


def _scatter(*index: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N,) a number in 0 … 1 for each brick or tile, the same for the same one."""
    mixed = sum(np.floor(i) * k for i, k in zip(index, (12.9898, 78.233), strict=False))
    return (np.sin(mixed) * 43758.5453) % 1


def _body(p: NDArray[np.float64], n: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bright panels, doors, handles, trim, dark sill, lamps, grille and bumpers."""
    x, y, z = p.T / MM
    side, end = np.abs(n[:, 2]) > 0.7, np.abs(n[:, 0]) > 0.7
    grey = np.full(len(p), 0.78)
    grey[side & (np.abs(y - 0.062) < 0.010)] = 0.95
    for line in (-0.300, 0.035, 0.345):
        grey[side & (np.abs(x - line) < 0.010) & (y < 0.135)] = 0.12
    for handle in (-0.02, 0.290):
        grey[side & (np.abs(x - handle) < 0.030) & (np.abs(y - 0.015) < 0.010)] = 0.15
    for wheel in (-0.490, 0.480):
        grey[side & (np.hypot(x - wheel, y - 0.180) < 0.150)] = 0.04
    grey[y > 0.150] = 0.10
    bumper = (np.abs(x) > 0.70) & (y > 0.105) & (y < 0.165)
    grey[bumper] = 0.35
    grey[end & (x < 0) & (np.abs(z) < 0.16) & (y > 0.02) & (y < 0.09)] = 0.08
    lamp = (y > 0.005) & (y < 0.080)
    grey[lamp & ((end & (np.abs(z) > 0.18)) | (side & (np.abs(x) > 0.715)))] = 1.0
    grey[lamp & (x > 0) & ((end & (np.abs(z) > 0.18)) | (side & (x > 0.715)))] = 0.30
    return grey


def _cabin(p: NDArray[np.float64], n: NDArray[np.float64]) -> NDArray[np.float64]:
    """Dark glass with a sheen towards the top, bright pillars, a bright roof."""
    x, y, z = p.T / MM
    grey = np.full(len(p), 0.82)
    up = (-0.05 - y) / 0.215
    front, back = -0.42 + 0.24 * up, 0.60 - 0.16 * up
    side = np.abs(n[:, 2]) > 0.7
    pane = (x > front + 0.060) & (x < back - 0.075) & (np.abs(x - 0.090) > 0.022)
    glass = (y > -0.250) & (y < -0.075)
    sheen = 0.03 + 0.10 * np.clip(up, 0, 1) ** 2
    sheen = np.where(np.abs((x - 0.35 * up) % 0.30 - 0.10) < 0.028, sheen + 0.12, sheen)
    shown = glass & ((side & pane) | (~side & (np.abs(z) < 0.22)))
    grey[shown] = sheen[shown]
    return grey


def _wheel(x0: float, y0: float) -> Paint:
    """Black tyre, bright rim of five spokes."""

    def paint(p: NDArray[np.float64], n: NDArray[np.float64]) -> NDArray[np.float64]:
        x, y, _ = p.T / MM
        radius, angle = np.hypot(x - x0, y - y0), np.arctan2(y - y0, x - x0)
        spoke = np.cos(5 * angle) > 0.1
        grey = np.full(len(p), 0.05)
        hub = (radius < 0.082) & (np.abs(n[:, 2]) > 0.7)
        grey[hub] = np.where(spoke | (radius > 0.068) | (radius < 0.025), 0.85, 0.10)[hub]
        return grey

    return paint


def _bricks(along: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bricks in stretcher bond, each its own grey, with bright joints."""
    row = np.floor(y / COURSE)
    shifted = along / BRICK + 0.5 * (row % 2)
    joint = (y % COURSE < MORTAR) | ((shifted % 1) * BRICK < MORTAR)
    return np.where(joint, 0.90, 0.30 + 0.30 * _scatter(shifted, row))


def _walls(p: NDArray[np.float64], n: NDArray[np.float64]) -> NDArray[np.float64]:
    """Brick walls with a door, framed windows on the long sides, one in each gable."""
    x, y, z = p.T / MM
    gable = np.abs(n[:, 0]) > 0.5
    grey = _bricks(np.where(gable, z, x), y)

    def window(along: NDArray[np.float64], middle: float, here: NDArray[np.bool_]) -> None:
        across, down = np.abs(along - middle), np.abs(y - 0.205)
        grey[here & (across < 0.120) & (down < 0.140)] = 0.95
        pane = (across > 0.014) & (across < 0.096) & (down > 0.014) & (down < 0.118)
        grey[here & pane] = 0.04

    for middle in (-0.30, 0.30):
        window(x, middle, ~gable)
    window(z, 0.0, gable)
    door = ~gable & (np.abs(x) < 0.100) & (y > 0.130)
    grey[door] = 0.95
    grey[door & (np.abs(x) < 0.080) & (y > 0.150)] = 0.22
    panel = (np.abs(np.abs(x) - 0.038) < 0.024) & (np.abs((y - 0.150) % 0.190 - 0.1) < 0.065)
    grey[door & panel & (y > 0.150)] = 0.10
    return grey


def _tiles(p: NDArray[np.float64], n: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rows of tiles with dark lower edges, a bright verge at both ends."""
    x, _, z = p.T / MM
    down = np.abs(z) * 1.45
    row = np.floor(down / ROW)
    shifted = x / TILE + 0.5 * (row % 2)
    edge = (down % ROW > ROW - 0.016) | ((shifted % 1) * TILE < 0.012)
    grey = np.where(edge, 0.05, 0.20 + 0.25 * _scatter(shifted, row))
    return np.where(np.abs(x) > 0.505, 0.85, grey)


def _chimney(p: NDArray[np.float64], n: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bricks under a bright rim."""
    x, y, z = p.T / MM
    return np.where(y < -0.515, 0.90, _bricks(x + z, y))
