"""Arcs, straight lines and stops in the x–z positions of an object over many frames.

Three neighbouring positions cannot fix a circle when the steps are short, so arcs are fitted to
as many frames as agree with one circle within the noise (`arcs`). Angles are
right-handed about +y, see `circles`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from chrmc.scene.arcs import Piece, best_curve, parameter_price, pieces
from chrmc.scene.circles import Circle, distances, line_fit, turn_angle

Kind = Literal["arc", "translation", "still"]

TOLERANCE = 4.0
"""An object whose positions stay within this many times the noise stands still."""
NOISE_FLOOR = 1e-9
"""Metres; exact positions differ from their arcs by rounding only, but never ask for less."""


@dataclass(frozen=True, eq=False)
class Segment:
    """Frames first … last of one motion; the next segment starts at frame `last`.

    kind : "arc", "translation" (straight or too short to say) or "still"
    centre : (x, z) of the arc, metres; None unless an arc
    radius : metres; None unless an arc
    angles : (last − first,) signed rotation of every step about the centre, radians; zero unless
        an arc
    steps : (last − first, 2) displacement (x, z) of every step, metres
    rms : of the positions' distances from the arc, line or point, metres
    outliers : frames whose positions do not fit but lie between frames that do
    """

    kind: Kind
    first: int
    last: int
    centre: tuple[float, float] | None
    radius: float | None
    angles: NDArray[np.float64]
    steps: NDArray[np.float64]
    rms: float
    outliers: tuple[int, ...] = ()


@dataclass(frozen=True)
class Motion:
    """All segments of an object, and the noise of its positions that they assume, metres."""

    segments: tuple[Segment, ...]
    noise: float

    def at(self, number: int) -> Segment | None:
        """The segment of the step that leads to frame `number`; None when there is none: the
        first frame, or a frame beside one without the object."""
        for segment in self.segments:
            if segment.first < number <= segment.last:
                return segment
        return None

    def angle(self, number: int) -> float:
        """Signed rotation of the step that leads to frame `number`, radians; 0 off arcs."""
        segment = self.at(number)
        return 0.0 if segment is None else float(segment.angles[number - segment.first - 1])


def find_motion(
    positions: ArrayLike, *, first_frame: int = 1, noise: float | None = None
) -> Motion:
    """Split a path into arcs, straight lines and stops.

    positions : (N, 2) x and z in metres, one row per frame; NaN for frames without the object
    first_frame : number of the first row
    noise : standard deviation of the positions in metres, default `position_noise` of them

    Stops are found first; `arcs.pieces` cuts the rest where the residuals, against the noise, ask
    for it, and leaves single stray positions out. Any number of frames, repeated positions,
    reversals, stops and straight lines are legal.
    """
    path = np.asarray(positions, dtype=np.float64)
    if path.size == 0:
        path = path.reshape(0, 2)
    if path.ndim != 2 or path.shape[1] != 2:
        raise ValueError(f"positions must be (N, 2) x and z, not {path.shape}")
    if noise is not None and not (np.isfinite(noise) and noise >= 0):
        raise ValueError(f"noise must be a length in metres, not {noise}")
    there: NDArray[np.bool_] = np.all(np.isfinite(path), axis=1)
    extent = float(np.ptp(path[there], axis=0).max()) if there.any() else 0.0
    floor = max(NOISE_FLOOR, 1e-7 * extent)
    sigma = max(position_noise(path) if noise is None else noise, floor)
    segments: list[Segment] = []
    for start, stop in _runs(there):
        run = path[start:stop]
        segments += [
            _segment(run, first, last, strays, sigma, first_frame + start)
            for first, last, strays in _pieces(run, sigma)
        ]
    return Motion(tuple(segments), sigma)


def position_noise(positions: ArrayLike) -> float:
    """Standard deviation across the path, metres, from third differences; 0 below 7 positions.

    Third differences of smooth motion nearly vanish; of independent noise they have 20 times its
    variance. Their median is not moved by corners. Slow errors, such as a body showing other
    sides, are not seen: pass a larger noise where there are such.
    """
    path = np.asarray(positions, dtype=np.float64)
    path = path[np.isfinite(path).all(axis=1)]
    if len(path) < 7:
        return 0.0
    chord = path[3:] - path[:-3]
    length = np.linalg.norm(chord, axis=1)
    third = np.diff(path, n=3, axis=0)
    across = np.where(
        length > 0,
        np.abs(third[:, 0] * chord[:, 1] - third[:, 1] * chord[:, 0])
        / np.where(length > 0, length, 1),
        np.linalg.norm(third, axis=1) / sqrt(2),
    )
    return float(np.median(across) * 1.4826 / sqrt(20))


def local_offsets(
    centre: Sequence[float], curved_radius: float, width: float
) -> tuple[float, float]:
    """(d, l) of the paper's section 3.3: how far the local planar hologram of an arc lies from the
    original one, along z and x, metres.

    centre : (x, z) of the arc; curved_radius : R of the local curved hologram; width : of the
    hologram. d = z_O − R + z0 with z0 = R − √(R² − (width/2)²) (Eq. 9), l = x_O.
    """
    if not curved_radius >= width / 2:
        raise ValueError(
            f"no circle of radius {curved_radius * 1e3:.4g} mm spans a hologram "
            f"{width * 1e3:.4g} mm wide: use at least {width * 500:.4g} mm"
        )
    sagitta = curved_radius - sqrt(curved_radius**2 - (width / 2) ** 2)
    return centre[1] - curved_radius + sagitta, centre[0]


def _runs(there: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """(start, stop) of unbroken stretches of at least two frames."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], there, [False]]).astype(int)))
    pairs = edges.reshape(-1, 2)
    return [(int(a), int(b)) for a, b in pairs if b - a >= 2]


def _pieces(path: NDArray[np.float64], noise: float) -> list[Piece]:
    """Stops, and what lies between them cut into arcs and lines; rows of `path`."""
    found: list[Piece] = []
    at = 0
    for first, last in [*_stops(path, TOLERANCE * noise), (len(path) - 1, len(path) - 1)]:
        if first > at:
            found += [
                (a + at, b + at, tuple(s + at for s in strays))
                for a, b, strays in pieces(path[at : first + 1], noise)
            ]
        if last > first:
            found.append((first, last, ()))
        at = last
    return found


def _stops(path: NDArray[np.float64], tolerance: float) -> list[tuple[int, int]]:
    """(first, last) rows of stretches in which the object does not move.

    Repeated positions are a stop from one step on; noisy ones from four steps on, when they drift
    by less than half of what the median speed would have carried them.
    """
    count = len(path)
    if np.linalg.norm(path - path.mean(axis=0), axis=1).max() <= tolerance:
        return [(0, count - 1)]
    reach = max(1, min(4, count // 2))
    speed = np.median(np.linalg.norm(path[reach:] - path[:-reach], axis=1)) / reach
    stops: list[tuple[int, int]] = []
    at = 0
    while at < count - 1:
        last = at
        while last < count - 1 and _still(path[at : last + 2], tolerance):
            last += 1
        steps = last - at
        exact = steps >= 1 and bool((np.abs(np.diff(path[at : last + 1], axis=0)) == 0).all())
        if exact or (steps >= 4 and _drift(path[at : last + 1]) < 0.5 * speed * steps / 2):
            stops.append((at, last))
            at = last
        elif steps >= 1 and np.array_equal(path[at], path[at + 1]):
            same = at + 1
            while same < count - 1 and np.array_equal(path[same], path[same + 1]):
                same += 1
            stops.append((at, same))
            at = same
        else:
            at += 1
    return stops


def _still(points: NDArray[np.float64], tolerance: float) -> bool:
    return bool(np.linalg.norm(points - points.mean(axis=0), axis=1).max() <= tolerance)


def _drift(points: NDArray[np.float64]) -> float:
    """Distance between the means of the first and the last half."""
    half = len(points) // 2
    return float(np.linalg.norm(points[-half:].mean(axis=0) - points[:half].mean(axis=0)))


def _segment(
    path: NDArray[np.float64],
    first: int,
    last: int,
    strays: tuple[int, ...],
    noise: float,
    offset: int,
) -> Segment:
    """The simplest motion that explains rows first … last."""
    rows = [k for k in range(first, last + 1) if k not in strays]
    points = path[rows]
    steps = np.diff(path[first : last + 1], axis=0)
    away = np.linalg.norm(points - points.mean(axis=0), axis=1)
    circle: Circle | None = None
    if away.max() <= TOLERANCE * noise and (len(points) > 2 or not steps.any()):
        kind: Kind = "still"
        miss = away
    else:
        circle = best_curve(points, noise, parameter_price(len(path)))[0]
        kind = "translation" if circle is None else "arc"
        miss = line_fit(points)[2] if circle is None else distances(circle, points)
    angles = np.zeros(last - first)
    if circle is not None:
        angles = turn_angle(circle.centre, path[first:last], path[first + 1 : last + 1])
    return Segment(
        kind=kind,
        first=first + offset,
        last=last + offset,
        centre=None if circle is None else circle.centre,
        radius=None if circle is None else circle.radius,
        angles=angles,
        steps=steps,
        rms=float(np.sqrt((miss**2).mean())),
        outliers=tuple(s + offset for s in strays),
    )
