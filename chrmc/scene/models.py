"""The car and the house: solids in body coordinates, metres, y down, the car's nose to −x."""

import numpy as np
from numpy.typing import NDArray

from chrmc.scene.shapes import Paint, Part, Solid, box, loft, plain

MM = 1e-3


def car() -> Solid:
    """1.6 × 0.62 × 0.7 mm (x, y, z) about the origin: body, cabin, wheels, lights.

    Nose and tail bulge: as the car turns, they come into view point by point, not all at once.
    """
    body = loft(
        [
            _plan(-0.770, 0.765, 0.330, 14.0, 0.210),
            _plan(-0.800, 0.800, 0.340, 15.0, 0.130),
            _plan(-0.795, 0.795, 0.335, 13.0, 0.000),
            _plan(-0.760, 0.780, 0.315, 16.0, -0.050),
        ]
    )
    cabin = loft(
        [
            _plan(-0.420, 0.600, 0.305, 13.0, -0.050),
            _plan(-0.180, 0.440, 0.255, 15.0, -0.265),
            _plan(-0.120, 0.380, 0.220, 13.0, -0.310),
        ]
    )
    parts = [Part(body * MM, _paint_body), Part(cabin * MM, _paint_cabin)]
    for x in (-0.490, 0.480):
        for outside in (-1.0, 1.0):
            parts.append(Part(_wheel(x, 0.180, outside) * MM, _wheel_paint(x * MM, 0.180 * MM)))
    return Solid(tuple(parts))


def house() -> Solid:
    """1.05 × 1.1 × 0.85 mm (x, y, z) about the origin: walls, gable roof, chimney."""
    # Roof slabs and walls share the slope: 0.45 mm up over 0.425 mm of half depth.
    wall = [(-0.385, -0.06), (0.0, -0.46), (0.385, -0.06), (0.385, 0.55), (-0.385, 0.55)]
    walls = loft([[(x, y, z) for z, y in wall] for x in (-0.480, 0.480)])
    parts = [Part(walls * MM, _paint_walls)]
    for side in (-1.0, 1.0):
        slab = [(0.0, -0.50), (side * 0.425, -0.055), (side * 0.425, 0.0), (0.0, -0.44)]
        roof = loft([[(x, y, z) for z, y in slab] for x in (-0.525, 0.525)])
        parts.append(Part(roof * MM, _paint_roof))
    parts.append(Part(box((0.18, -0.55, -0.20), (0.32, -0.20, -0.06)) * MM, plain(0.62)))
    return Solid(tuple(parts))


def _plan(
    x0: float, x1: float, half_width: float, bulge: float, y: float, facets: int = 40
) -> NDArray[np.float64]:
    """Ring at height y, seen from above: straight sides, ends that bulge by ±`bulge` degrees."""
    angle = np.radians(bulge)
    radius = half_width / np.sin(angle)
    turn = np.linspace(-angle, angle, facets + 1)
    nose = [(x0 + radius * (1 - np.cos(t)), radius * np.sin(t)) for t in turn]
    tail = [(x1 - radius * (1 - np.cos(t)), -radius * np.sin(t)) for t in turn]
    return np.array([(x, y, z) for x, z in nose + tail])


def _wheel(x: float, y: float, outside: float, facets: int = 20) -> NDArray[np.float64]:
    """Wheel with its axle along z, hub outwards, tread rounded."""
    around = np.linspace(0, 2 * np.pi, facets, endpoint=False)
    section = [(0.200, 0.115), (0.225, 0.126), (0.270, 0.130), (0.315, 0.126), (0.345, 0.112)]
    return loft(
        [[(x + r * np.cos(t), y + r * np.sin(t), outside * z) for t in around] for z, r in section]
    )


def _paint_body(p: NDArray[np.float64], n: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bright panels, dark sill and bumpers, lamps at both ends, a door line."""
    x, y, z = p.T / MM
    grey = np.full(len(p), 0.72)
    grey[y > 0.135] = 0.30
    grey[(np.abs(x - 0.02) < 0.022) & (np.abs(n[:, 2]) > 0.7) & (y < 0.135)] = 0.38
    ends = np.abs(n[:, 0]) > 0.7
    lamps = (np.abs(z) > 0.16) & (y > 0.0) & (y < 0.11)
    grey[ends & lamps & (x < 0)] = 1.0
    grey[ends & lamps & (x > 0)] = 0.45
    grey[(x < -0.68) & (y > 0.0) & (y < 0.09) & ~ends] = 1.0
    grey[(x > 0.70) & (y > 0.0) & (y < 0.09) & ~ends] = 0.45
    return grey


def _paint_cabin(p: NDArray[np.float64], n: NDArray[np.float64]) -> NDArray[np.float64]:
    """Dark glass between bright pillars under a bright roof."""
    x, y, z = p.T / MM
    grey = np.full(len(p), 0.80)
    glass = (y > -0.245) & (y < -0.085)
    # The pillars lean with the screens: 0.24 mm over 0.215 mm of height at the front.
    up = (-0.05 - y) / 0.215
    front, back = -0.42 + 0.24 * up, 0.60 - 0.16 * up
    side = np.abs(n[:, 2]) > 0.7
    pane = (x > front + 0.075) & (x < back - 0.09) & (np.abs(x - 0.10) > 0.028)
    grey[glass & side & pane] = 0.14
    grey[glass & ~side & (np.abs(z) < 0.21)] = 0.14
    return grey


def _wheel_paint(x0: float, y0: float) -> Paint:
    """Dark tyre, bright hub."""

    def paint(p: NDArray[np.float64], n: NDArray[np.float64]) -> NDArray[np.float64]:
        hub = np.hypot(p[:, 0] - x0, p[:, 1] - y0) < 0.062 * MM
        return np.where(hub & (np.abs(n[:, 2]) > 0.9), 0.90, 0.20)

    return paint


def _paint_walls(p: NDArray[np.float64], n: NDArray[np.float64]) -> NDArray[np.float64]:
    """Long walls with a door and two windows, lighter gables with one window."""
    x, y, z = p.T / MM
    gable = np.abs(n[:, 0]) > 0.5
    grey = np.where(gable, 0.55, 0.85)
    long_wall = ~gable
    for centre in (-0.30, 0.30):
        grey[long_wall & (np.abs(x - centre) < 0.105) & (y > 0.09) & (y < 0.33)] = 0.16
        grey[long_wall & (np.abs(x - centre) < 0.018) & (y > 0.09) & (y < 0.33)] = 0.85
    grey[long_wall & (np.abs(x) < 0.085) & (y > 0.15)] = 0.28
    grey[gable & (np.abs(z) < 0.14) & (y > 0.04) & (y < 0.28)] = 0.14
    return grey


def _paint_roof(p: NDArray[np.float64], n: NDArray[np.float64]) -> NDArray[np.float64]:
    """Dark tiles, a bright verge at both ends."""
    return np.where(np.abs(p[:, 0]) > 0.523 * MM, 0.70, 0.36)
