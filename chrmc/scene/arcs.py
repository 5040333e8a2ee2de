"""Where a path in the x–z plane changes from one arc or straight line to the next.

Among all ways to cut a path into pieces the one is taken whose Σ residual²/noise² plus a price per
parameter is smallest: dynamic programming over the cuts, every piece fitted by a line and by a
circle. The price keeps noise from being explained by arcs of its own.
"""

from itertools import pairwise
from math import log

import numpy as np
from numpy.typing import NDArray

from chrmc.scene.circles import Circle, distances, geometric, line_fit

LINE_PARAMETERS = 3
ARC_PARAMETERS = 4
"""Those of the curve and the place of the cut."""
SHARPEST_TURN = 0.5
"""Radians from step to step that three or four positions alone may claim to be an arc."""
UNEVEN_STEPS = 3.0
"""Ratio of step lengths that three positions alone may have on an arc."""
BLOCK = 128
"""Ends tried at a time before a start is given up."""

Piece = tuple[int, int, tuple[int, ...]]
"""First and last row, and the rows between that do not belong."""

# Pratt's constraint B² + C² − 4AD, in which an algebraic residual is a distance.
_PRATT_INVERSE = np.linalg.inv(
    np.array([[0, 0, 0, -2], [0, 1, 0, 0], [0, 0, 1, 0], [-2, 0, 0, 0]], dtype=np.float64)
)


def parameter_price(count: int) -> float:
    """Σ residual²/noise² that one more parameter must save on a path of `count` positions: twice
    that of the Bayesian information criterion, since errors of neighbouring frames are alike."""
    return 2 * log(2 * count)


def pieces(path: NDArray[np.float64], noise: float) -> list[Piece]:
    """Cut a path of at least two positions; neighbouring pieces share their border row.

    path : (N, 2) x and z, metres; noise : standard deviation of the positions, metres
    """
    count = len(path)
    price = parameter_price(count)
    best = np.full(count, np.inf)
    best[0] = 0
    came_from = np.zeros(count, dtype=np.intp)
    for first in range(count - 1):
        for start in range(first + 1, count, BLOCK):
            stop = min(start + BLOCK, count)
            line, arc = _squares(path[first:stop], start - first)
            line, arc = line / noise**2, arc / noise**2
            total = best[first] + np.minimum(
                line + LINE_PARAMETERS * price, arc + ARC_PARAMETERS * price
            )
            better = np.flatnonzero(total < best[start:stop])
            best[start + better] = total[better]
            came_from[start + better] = first
            # A piece that is this bad is beaten by cutting it here, wherever it ends.
            if best[first] + min(line[-1], arc[-1]) > best[stop - 1] + price:
                break
    cuts = [count - 1]
    while cuts[-1] > 0:
        cuts.append(int(came_from[cuts[-1]]))
    cuts.reverse()
    found: list[Piece] = [(a, b, ()) for a, b in pairwise(cuts)]
    return _without_strays(path, found, noise, price)


def _squares(
    path: NDArray[np.float64], least: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Σ residual² of rows 0 … k by the best line and by the best circle (inf where it is no arc),
    for k = least … len(path) − 1."""
    local = path - path[0]
    rows = np.arange(1, len(path) + 1)[:, None, None]
    design = np.column_stack([(local**2).sum(axis=1), local, np.ones(len(local))])
    moments = (np.cumsum(design[:, :, None] * design[:, None, :], axis=0) / rows)[least:]
    # About each piece's own mean and in units of its spread, for the sake of rounding.
    mean = moments[:, 3, 1:3]
    shift = np.zeros((len(mean), 4, 4))
    shift[:, range(4), range(4)] = 1
    shift[:, 0, 1:3] = -2 * mean
    shift[:, 0, 3] = (mean**2).sum(axis=1)
    shift[:, 1:3, 3] = -mean
    moments = shift @ moments @ shift.transpose(0, 2, 1)
    spread = np.sqrt(np.trace(moments[:, 1:3, 1:3], axis1=1, axis2=2))
    spread = np.where(spread > 0, spread, 1)
    unit = np.stack([spread**-2, 1 / spread, 1 / spread, np.ones(len(spread))], axis=1)
    moments = moments * unit[:, :, None] * unit[:, None, :]
    line = np.maximum(np.linalg.eigvalsh(moments[:, 1:3, 1:3])[:, 0], 0)
    # One eigenvalue is negative; the smallest of the others is the mean squared distance.
    values = np.sort(np.linalg.eigvals(_PRATT_INVERSE @ moments).real, axis=1)
    arc = np.minimum(np.abs(values[:, 1]), line)
    size = spread**2 * rows[least:, 0, 0]
    arc = arc * size
    for k in range(least, min(4, len(path))):
        if k < 2 or not _bends_like_an_arc(path[: k + 1]):
            arc[k - least] = np.inf
    return line * size, arc


def _bends_like_an_arc(points: NDArray[np.float64]) -> bool:
    """Whether so few positions may be called an arc: a jump or a corner is none."""
    step = np.diff(points, axis=0)
    length = np.linalg.norm(step, axis=1)
    moving = length > 1e-3 * length.max()
    if moving.sum() < 2:
        return False
    heading = np.arctan2(step[moving, 0], step[moving, 1])
    turn = np.abs((np.diff(heading) + np.pi) % (2 * np.pi) - np.pi)
    # A reversal turns by π: what matters is how much it bends.
    if np.minimum(turn, np.pi - turn).max() > SHARPEST_TURN:
        return False
    return len(points) > 3 or bool(length[moving].max() <= UNEVEN_STEPS * length[moving].min())


def best_curve(
    points: NDArray[np.float64], noise: float, price: float
) -> tuple[Circle | None, float]:
    """The circle that explains positions better than a line does, or None, and what it costs."""
    if len(points) < 3:
        return None, LINE_PARAMETERS * price
    line = float((line_fit(points)[2] ** 2).sum()) / noise**2 + LINE_PARAMETERS * price
    circle = geometric(points)
    if circle.straight or (len(points) <= 4 and not _bends_like_an_arc(points)):
        return None, line
    arc = float((distances(circle, points) ** 2).sum()) / noise**2 + ARC_PARAMETERS * price
    return (circle, arc) if arc < line else (None, line)


def _without_strays(
    path: NDArray[np.float64], found: list[Piece], noise: float, price: float
) -> list[Piece]:
    """Join two pieces across one or two stray positions, where that is cheaper."""
    k = 0
    while k < len(found) - 2:
        joined = None
        for between in (1, 2, 3):
            if k + between + 1 >= len(found):
                break
            (a, b, strays), (c, d, more) = found[k], found[k + between + 1]
            if not 2 <= c - b <= 3 or min(b - a, d - c) < 2:
                continue
            now = strays + tuple(range(b + 1, c)) + more
            rows = [r for r in range(a, d + 1) if r not in now]
            paid = sum(
                best_curve(path[[r for r in range(x, y + 1) if r not in s]], noise, price)[1]
                for x, y, s in found[k : k + between + 2]
            )
            if best_curve(path[rows], noise, price)[1] + price * (c - b - 1) < paid:
                joined = (a, d, now), between
                break
        if joined:
            found = [*found[:k], joined[0], *found[k + joined[1] + 2 :]]
        else:
            k += 1
    return found
