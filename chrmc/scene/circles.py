"""Circles through positions in the x–z plane, and the angles between positions on them.

Angles are those of a right-handed rotation about +y, the same as `rotation_y`: positive carries
+z towards +x. In the x–z plane, seen with x to the right and z upwards, that is clockwise.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class Circle:
    """centre (x, z) and radius in metres; a straight line has radius inf and centre NaN.

    rms : root mean square distance of the fitted positions from it, metres
    """

    centre: tuple[float, float]
    radius: float
    rms: float = 0.0

    @property
    def straight(self) -> bool:
        """Whether it is a line."""
        return not np.isfinite(self.radius)


LINE = (float("nan"), float("nan"))
_CENTRED = 1e-14  # square of a centre's distance from the positions' mean, in radii, at least


def geometric(positions: ArrayLike, iterations: int = 50) -> Circle:
    """Least squares of the distance to the circle: Gauss–Newton from the
    algebraic fit without bias, see `_hyper`.

    positions : (N, 2) x and z, N ≥ 3
    The circle is A(x² + z²) + Bx + Cz + D = 0 with B² + C² − 4AD = 1, so that lines are ordinary
    members (A = 0) and a point of value P lies at the distance d with P = d + A·d².
    """
    points, middle, scale = _normalised(positions)
    start = _hyper(points)
    a, d = start[0], start[3]
    if 1 + 4 * a * d < _CENTRED:  # else no direction leads to the centre
        d = (_CENTRED - 1) / (4 * a)
    turn = np.arctan2(start[2], start[1])
    x, z = points.T
    square = x**2 + z**2
    distance, slope, along, e = _distances(a, d, turn, x, z, square)
    for _ in range(iterations):
        jacobian = np.column_stack(
            [
                square + 2 * d / e * along - distance**2,
                e * (z * np.cos(turn) - x * np.sin(turn)),
                1 + 2 * a / e * along,
            ]
        )
        change = np.linalg.lstsq(jacobian / slope[:, None], -distance, rcond=1e-14)[0]
        # Halve a step that makes it worse: far from the arc the quadratic model fails.
        for _ in range(12):
            trial = (a + change[0], d + change[2], turn + change[1])
            if 1 + 4 * trial[0] * trial[1] > 0:
                tried = _distances(*trial, x, z, square)
                if tried[0] @ tried[0] <= distance @ distance:
                    break
            change = change / 2
        else:
            break
        (a, d, turn), (distance, slope, along, e) = trial, tried
        if np.abs(change).max() < 1e-15:
            break
    algebraic = np.array([a, e * np.cos(turn), e * np.sin(turn), d])
    return _from_algebraic(algebraic, points, middle, scale)


def paper_circle(first: ArrayLike, second: ArrayLike, third: ArrayLike) -> Circle:
    """The circle through three positions (x, z): how the paper finds an arc (its section 2.2.2).

    A line when they are collinear or two of them coincide. Short steps make it ill-conditioned;
    `geometric` over many frames is the better answer.
    """
    a, b, c = (np.asarray(p, dtype=np.float64) for p in (first, second, third))
    u, v = b - a, c - a
    cross = u[0] * v[1] - u[1] * v[0]
    size = np.linalg.norm(u) * np.linalg.norm(v)
    if abs(cross) <= 1e-14 * size or size == 0:
        return Circle(LINE, np.inf)
    offset = np.array([v[1] * (u @ u) - u[1] * (v @ v), u[0] * (v @ v) - v[0] * (u @ u)])
    offset /= 2 * cross
    centre = a + offset
    return Circle((float(centre[0]), float(centre[1])), float(np.linalg.norm(offset)))


def paper_angle(centre: ArrayLike, first: ArrayLike, second: ArrayLike) -> float:
    """Unsigned angle at `centre` between two positions by the paper's Eqs. 2–4, radians.

    θ = arccos(h/|OP₁|) + arccos(h/|OP₂|) with h the height of the triangle O P₁ P₂ over P₁P₂.
    Near θ = 0 both cosines are near 1 and half of the digits are lost, and the sum is only right
    when the foot of h lies between the points: compare `turn_angle`.
    """
    o, a, b = (np.asarray(p, dtype=np.float64) for p in (centre, first, second))
    u, v = a - o, b - o
    chord = np.linalg.norm(b - a)
    if chord == 0:
        return 0.0
    height = abs(u[0] * v[1] - u[1] * v[0]) / chord
    halves = [np.arccos(min(height / np.linalg.norm(w), 1.0)) for w in (u, v)]
    return float(sum(halves))


def turn_angle(centre: ArrayLike, first: ArrayLike, second: ArrayLike) -> NDArray[np.float64]:
    """Signed angle about +y that carries `first` to the direction of `second`, radians.

    first, second : (…, 2) x and z. atan2(cross, dot): exact to rounding at every angle.
    """
    u = np.asarray(first, dtype=np.float64) - np.asarray(centre, dtype=np.float64)
    v = np.asarray(second, dtype=np.float64) - np.asarray(centre, dtype=np.float64)
    cross = u[..., 1] * v[..., 0] - u[..., 0] * v[..., 1]
    return np.arctan2(cross, (u * v).sum(axis=-1))


def line_fit(
    positions: ArrayLike,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Middle (2,), unit direction (2,) and (N,) signed distances of the best line, metres."""
    points = np.asarray(positions, dtype=np.float64)
    middle = points.mean(axis=0)
    offset = points - middle
    direction = np.linalg.svd(offset, full_matrices=False)[2][0]
    return middle, direction, offset @ np.array([-direction[1], direction[0]])


def distances(circle: Circle, positions: ArrayLike) -> NDArray[np.float64]:
    """(N,) signed distances from a circle (positive outside), metres; NaN for a line."""
    offset = np.asarray(positions, dtype=np.float64) - np.array(circle.centre)
    return np.hypot(offset[:, 0], offset[:, 1]) - circle.radius


def _normalised(
    positions: ArrayLike,
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Positions about their mean in units of their spread, the mean, the spread."""
    points = np.asarray(positions, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 3:
        raise ValueError(f"a circle needs (N, 2) positions with N ≥ 3, not {points.shape}")
    if not np.isfinite(points).all():
        raise ValueError("positions must be finite: leave out the frames without the object")
    middle = points.mean(axis=0)
    scale = float(np.sqrt(((points - middle) ** 2).sum(axis=1).mean()))
    scale = scale if scale > 0 else 1.0
    return (points - middle) / scale, middle, scale


def _hyper(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(A, B, C, D) of normalised points, B² + C² − 4AD = 1."""
    square = (points**2).sum(axis=1)
    z = np.column_stack([square, points, np.ones(len(points))])
    moments = z.T @ z / len(z)
    mean = square.mean()
    constraint = np.array(
        [[8 * mean, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [2, 0, 0, 0]], dtype=np.float64
    )
    # M v = η N v with the smallest η ≥ 0. N is invertible and M may not be, so solve N⁻¹M.
    fits = scipy.linalg.eig(np.linalg.solve(constraint, moments))[1].real.T
    level = np.einsum("ki,ij,kj->k", fits, constraint, fits)
    usable = level > 1e-14
    if not usable.any():
        return np.array([0.0, 1.0, 0.0, 0.0])
    residual = np.einsum("ki,ij,kj->k", fits, moments, fits)
    best = int(np.argmin(np.where(usable, residual / np.where(usable, level, 1), np.inf)))
    a, b, c, d = fits[best]
    norm = b * b + c * c - 4 * a * d
    if norm <= 0:
        return np.array([0.0, 1.0, 0.0, 0.0])
    return fits[best] / np.sqrt(norm)


def _distances(
    a: float,
    d: float,
    turn: float,
    x: NDArray[np.float64],
    z: NDArray[np.float64],
    square: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], float]:
    """Signed distances, √(1 + 4AP), x cos + z sin, √(1 + 4AD)."""
    e = float(np.sqrt(1 + 4 * a * d))
    along = x * np.cos(turn) + z * np.sin(turn)
    value = a * square + e * along + d
    slope = np.sqrt(np.maximum(1 + 4 * a * value, 1e-12))
    return 2 * value / (1 + slope), slope, along, e


def _from_algebraic(
    fit: NDArray[np.float64],
    points: NDArray[np.float64],
    middle: NDArray[np.float64],
    scale: float,
) -> Circle:
    a, b, c, _ = fit
    # Below rounding the curvature of these points cannot be told from none.
    if abs(a) < 1e-12:
        return Circle(LINE, np.inf, _line_rms(points) * scale)
    return _circle(np.array([-b, -c]) / (2 * a), 1 / (2 * abs(a)), points, middle, scale)


def _circle(
    centre: NDArray[np.float64],
    radius: float,
    points: NDArray[np.float64],
    middle: NDArray[np.float64],
    scale: float,
) -> Circle:
    """In metres again, with its rms residual."""
    miss = np.hypot(*(points - centre).T) - radius
    x, z = middle + scale * centre
    rms = float(np.sqrt((miss**2).mean()) * scale)
    return Circle((float(x), float(z)), float(radius * scale), rms)


def _line_rms(points: NDArray[np.float64]) -> float:
    return float(np.sqrt((line_fit(points)[2] ** 2).mean()))
