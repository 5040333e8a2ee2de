"""Moving a hologram: by whole pixels, and in depth by a thin lens; and the points with it.

A fringe is shift-invariant: moving the hologram by whole SLM pixels moves its points by as much,
exactly, soft footprint included. What enters from outside the panel was never computed: those
strips are left to the caller.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.pfp import excess
from chrmc.optics.propagation import cycles_to_phasor
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM
from chrmc.window import Window


@dataclass(frozen=True)
class Move:
    """A compensated motion.

    rows, columns : SLM pixels, down and to the right
    depth : metres away from the hologram
    """

    rows: int = 0
    columns: int = 0
    depth: float = 0.0

    def __bool__(self) -> bool:
        return bool(self.rows or self.columns or self.depth)


def to_pixels(dx: float, dy: float, slm: SLM, depth: float = 0.0) -> Move:
    """The move nearest to a motion in metres."""
    return Move(round(dy / slm.pixel_pitch), round(dx / slm.pixel_pitch), float(depth))


def shift_into(target: NDArray[np.complex64], field: NDArray[np.complex64], move: Move) -> None:
    """Add the shifted field to a target of the same shape; what leaves the panel is dropped."""
    height, width = field.shape
    (to_r, from_r), (to_c, from_c) = _overlap(move.rows, height), _overlap(move.columns, width)
    target[to_r, to_c] += field[from_r, from_c]


def _overlap(step: int, count: int) -> tuple[slice, slice]:
    step = int(np.clip(step, -count, count))
    if step >= 0:
        return slice(step, count), slice(0, count - step)
    return slice(0, count + step), slice(-step, count)


def strips(move: Move, slm: SLM) -> list[Window]:
    """The windows that a shift leaves blank: none, one or two, without overlap."""
    (rows, _), (columns, _) = _overlap(move.rows, slm.height), _overlap(move.columns, slm.width)
    candidates = [
        Window(0, rows.start, 0, slm.width),
        Window(rows.stop, slm.height, 0, slm.width),
        Window(rows.start, rows.stop, 0, columns.start),
        Window(rows.start, rows.stop, columns.stop, slm.width),
    ]
    return [window for window in candidates if window.size]


def lens(
    slm: SLM, wavelength: float, centre: tuple[float, float], z: float, dz: float
) -> tuple[NDArray[np.complex64], NDArray[np.complex64]]:
    """Phasors of rows and columns whose product turns depth z into z + dz.

    centre : (x, y) metres; the lens has no phase there

    The thin-lens property of fringe patterns, exp[(ik/2)(x² + y²)(1/(z + dz) − 1/z)], with the
    spherical instead of the quadratic path along each axis.
    """
    out = []
    for coordinate, middle in ((slm.y(), centre[1]), (slm.x(), centre[0])):
        d = coordinate - middle
        path = excess(d, z + dz, "spherical") - excess(d, z, "spherical")
        out.append(cycles_to_phasor(path / wavelength))
    return out[0], out[1]


def moved(cloud: PointCloud, move: Move, slm: SLM, wavelength: float) -> PointCloud:
    """The points that a moved hologram shows.

    A lens about the cloud's centroid images each point: 1/z' = 1/z + 1/(z0 + dz) − 1/z0, its
    distance from the lens's axis scaled by z'/z, its phase on that axis unchanged.
    """
    positions = cloud.positions + np.array([move.columns, move.rows, 0.0]) * slm.pixel_pitch
    if not move.depth or len(cloud) == 0:
        return PointCloud(positions, cloud.amplitude, cloud.phase)
    x0, y0, z0 = lens_axis(cloud, move, slm)
    z = 1 / (1 / positions[:, 2] + 1 / (z0 + move.depth) - 1 / z0)
    axis = np.array([x0, y0])
    imaged = np.empty_like(positions)
    imaged[:, 2] = z
    imaged[:, :2] = axis + (positions[:, :2] - axis) * (z / positions[:, 2])[:, None]
    on_axis = np.array([x0, y0, 0.0])
    before = np.linalg.norm(positions - on_axis, axis=1)
    after = np.linalg.norm(imaged - on_axis, axis=1)
    return PointCloud(
        imaged,
        cloud.amplitude * after / before,
        cloud.phase + 2 * np.pi / wavelength * (before - after),
    )


def lens_axis(cloud: PointCloud, move: Move, slm: SLM) -> tuple[float, float, float]:
    """(x, y) of the lens's axis after the shift, and the depth that it acts on, metres."""
    x, y, z = cloud.centroid if np.isfinite(cloud.centroid).all() else cloud.positions.mean(axis=0)
    p = slm.pixel_pitch
    return float(x) + move.columns * p, float(y) + move.rows * p, float(z)
