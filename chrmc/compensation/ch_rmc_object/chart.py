"""Directions around an object, written as direction cosines, and what of them a hologram needs.

A chart has axes of its own: seen from a place b of the object, the hologram's place q lies in the
direction (α, β, −γ), γ = √(1 − α² − β²), at the range r. The path from a point b + Δ,

    |q − b − Δ| − r = √(r² − 2r·(Δ_1 α + Δ_2 β − Δ_3 γ) + Δ²) − r,

is nearly linear in α and β, so that sums over points are nearly products of tables.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot

import numpy as np
from numpy.typing import NDArray

from chrmc.scene.scene import Pose

Floats = NDArray[np.float64]
Span = tuple[float, float]
Place = tuple[Floats, Floats, Floats]

FARTHEST = 0.62
"""Sine of the angle up to which a chart reaches."""
STEEPEST = 1.0
"""Slope |dα/dβ| up to which the hologram's columns may lean."""
_SIDE = 5  # samples along the hologram's sides


@dataclass(frozen=True)
class View:
    """Ranges of α, β and 1/r that some frames need, and the steepest |dα/dβ| of their columns."""

    alpha: Span
    beta: Span
    s: Span
    tilt: float

    @property
    def whole(self) -> bool:
        """A chart can hold it."""
        far = hypot(max(-self.alpha[0], self.alpha[1]), max(-self.beta[0], self.beta[1]))
        return far < FARTHEST and self.tilt < STEEPEST


@dataclass(frozen=True, eq=False)
class Views:
    """The same of each of K frames, (K,) arrays."""

    alpha: tuple[Floats, Floats]
    beta: tuple[Floats, Floats]
    s: tuple[Floats, Floats]
    tilt: Floats

    def until(self, count: int) -> View:
        """All of the first `count` frames."""
        return View(
            _hull(self.alpha, count), _hull(self.beta, count), _hull(self.s, count),
            float(self.tilt[:count].max()),
        )  # fmt: skip


def _hull(span: tuple[Floats, Floats], count: int) -> Span:
    return float(span[0][:count].min()), float(span[1][:count].max())


def path(alpha: Floats, beta: Floats, place: Place, r: float) -> Floats:
    """|q − Δ| − r for Δ = place, without cancellation; metres."""
    x, y, z = place
    gamma = np.sqrt(1 - alpha * alpha - beta * beta)
    change = x * x + y * y + z * z - 2 * r * (x * alpha + y * beta - z * gamma)
    return np.asarray(change / (np.sqrt(r * r + change) + r), dtype=np.float64)


def slopes(alpha: Floats, beta: Floats, place: Place, r: float) -> tuple[Floats, Floats]:
    """∂path/∂α and ∂path/∂β; metres."""
    x, y, z = place
    gamma = np.sqrt(1 - alpha * alpha - beta * beta)
    turn = -r / (path(alpha, beta, place, r) + r)
    return turn * (x + z * alpha / gamma), turn * (y + z * beta / gamma)


def mean_rotation(poses: Sequence[Pose]) -> Floats:
    """The rotation nearest to the mean of some (polar decomposition)."""
    left, _, right = np.linalg.svd(np.mean([pose.rotation for pose in poses], axis=0))
    left[:, -1] *= np.sign(np.linalg.det(left @ right))
    return np.asarray(left @ right)


def views_of(
    poses: Sequence[Pose],
    middle: Floats,
    to_chart: Floats,
    sides: tuple[tuple[Floats, Floats], tuple[Floats, Floats]],
) -> Views:
    """What each pose needs of the chart.

    middle : (3,) the body's centre, in body coordinates
    to_chart : (3, 3) body to chart
    sides : (K,) lowest and highest x, and y, of the hologram that each is seen on, metres
    """
    turn = np.stack([to_chart @ pose.rotation.T for pose in poses])
    centre = np.stack([pose.rotation @ middle + pose.translation for pose in poses])
    (x0, x1), (y0, y1) = ((low[:, None], high[:, None]) for low, high in sides)
    t = np.linspace(0, 1, _SIDE)
    along_x, along_y = x0 + t * (x1 - x0), y0 + t * (y1 - y0)
    still = np.ones(_SIDE)
    # The nearest place is the foot of the perpendicular, or on a side.
    foot = [np.clip(centre[:, i, None], *ends) for i, ends in enumerate(((x0, x1), (y0, y1)))]
    x = np.concatenate([along_x, along_x, x0 * still, x1 * still, foot[0]], axis=1)
    y = np.concatenate([y0 * still, y1 * still, along_y, along_y, foot[1]], axis=1)
    q = np.stack([x, y, np.zeros_like(x)])
    q = np.einsum("kij,jkn->ikn", turn, q - centre.T[:, :, None])
    r = np.sqrt(np.sum(q * q, axis=0))
    alpha, beta, gamma = q / r
    # Along a column q moves by turn[:, 1].
    along = turn[:, :, 1].T[:, :, None]
    forth = alpha * along[0] + beta * along[1] + gamma * along[2]
    slope = np.abs(along[0] - alpha * forth), along[1] - beta * forth
    tilt = np.where(slope[1] > 0, slope[0] / np.maximum(slope[1], 1e-9), np.inf)
    tilt = np.where(gamma < 0, tilt, np.inf).max(axis=1)
    return Views(_spans(alpha), _spans(beta), _spans(1 / r), 1.02 * tilt)


def _spans(values: Floats) -> tuple[Floats, Floats]:
    """Lowest and highest of each frame, with room for what lies between the samples."""
    low, high = values.min(axis=1), values.max(axis=1)
    slack = 0.02 * (high - low)
    return low - slack, high + slack
