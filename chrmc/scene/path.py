"""A path in the x–z plane made of arcs that continue each other's tangent."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from chrmc.scene.scene import Pose


def rotation_y(angle: float) -> NDArray[np.float64]:
    """(3, 3) rotation by `angle` radians about +y, right-handed: it carries z towards x."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def arc_path(
    heading: float, step: float, arcs: Sequence[tuple[float, int]]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Frames on arcs that turn by the same angle at every step.

    heading : ψ of frame 1, radians; the velocity is along (−cos ψ, sin ψ) in (x, z)
    step : growth of ψ from frame to frame, radians
    arcs : (radius in metres, number of steps) of each; its centre lies at P + radius·(sin ψ, cos ψ)

    Returns (N, 2) positions (x, z) that start at the origin, (N,) headings, (A, 2) centres;
    N = 1 + all steps. The frame where two arcs meet lies on both.
    """
    positions = [np.zeros(2)]
    headings = [heading]
    centres = []
    for radius, steps in arcs:
        psi = headings[-1]
        centre = positions[-1] + radius * np.array([np.sin(psi), np.cos(psi)])
        centres.append(centre)
        for k in range(1, steps + 1):
            turned = psi + k * step
            positions.append(centre - radius * np.array([np.sin(turned), np.cos(turned)]))
            headings.append(turned)
    return np.array(positions), np.array(headings), np.array(centres)


def poses_along(
    positions: NDArray[np.float64], headings: NDArray[np.float64], y: float
) -> tuple[Pose, ...]:
    """Poses of a body whose nose points to −x, its origin at (x, y, z), its nose along the path."""
    return tuple(
        Pose(rotation_y(psi), np.array([x, y, z]))
        for (x, z), psi in zip(positions, headings, strict=True)
    )
