"""The motion between two known poses: nothing, a translation, a turn about y, or any rigid one."""

from dataclasses import dataclass
from math import atan2, hypot, tan
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from chrmc.scene.scene import Pose

Kind = Literal["none", "translation", "rotation", "rigid"]

SMALLEST_ANGLE = 1e-10
"""Radians below which a turn is rounding: over 1 m it moves nothing by a wavelength's 5000th."""
SMALLEST_SHIFT = 1e-12
"""Metres below which a displacement is rounding."""


@dataclass(frozen=True, eq=False)
class RelativeMotion:
    """What carries the world position of every body point from one pose to another.

    kind : "none"; "translation"; "rotation" about a vertical axis; "rigid" for everything else
    rotation : (3, 3), and shift : (3,) metres, so that after = rotation @ before + shift
    displacement : (3,) metres, of the body's origin
    angle : radians; signed about +y (as `rotation_y`) for a rotation, ≥ 0 about `axis` else
    axis : (3,) unit vector of the turn, +y for a rotation; zeros without a turn
    centre : (x, z) in metres that a rotation leaves where it is; None else
    rise : metres along +y that a rotation adds (its axis is a screw), 0 on flat ground
    """

    kind: Kind
    rotation: NDArray[np.float64]
    shift: NDArray[np.float64]
    displacement: NDArray[np.float64]
    angle: float
    axis: NDArray[np.float64]
    centre: tuple[float, float] | None
    rise: float

    def apply(self, positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) world positions after the motion."""
        return positions @ self.rotation.T + self.shift


def relative_motion(before: Pose, after: Pose) -> RelativeMotion:
    """The motion of a body that was at pose `before` and is at pose `after`."""
    rotation = after.rotation @ before.rotation.T
    displacement = after.translation - before.translation
    shift = after.translation - rotation @ before.translation
    turn = Rotation.from_matrix(rotation).as_rotvec()
    size = float(np.linalg.norm(turn))
    if before.same_as(after) or size <= SMALLEST_ANGLE:
        moved = float(np.abs(displacement).max()) > SMALLEST_SHIFT and not before.same_as(after)
        return RelativeMotion(
            kind="translation" if moved else "none",
            rotation=np.eye(3),
            shift=displacement if moved else np.zeros(3),
            displacement=displacement,
            angle=0.0,
            axis=np.zeros(3),
            centre=None,
            rise=0.0,
        )
    if hypot(turn[0], turn[2]) > SMALLEST_ANGLE:
        return RelativeMotion("rigid", rotation, shift, displacement, size, turn / size, None, 0.0)
    angle = atan2(rotation[0, 2] - rotation[2, 0], rotation[0, 0] + rotation[2, 2])
    # The centre sees the chord from the side: half a chord away times cot(θ/2).
    middle = before.translation + displacement / 2
    reach = 0.5 / tan(angle / 2)
    centre = (
        float(middle[0] + reach * displacement[2]),
        float(middle[2] - reach * displacement[0]),
    )
    return RelativeMotion(
        "rotation",
        rotation,
        shift,
        displacement,
        angle,
        np.array([0.0, 1.0, 0.0]),
        centre,
        float(displacement[1]),
    )
