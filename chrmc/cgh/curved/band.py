"""Even nodes for waves of limited bandwidth, and the matrices that interpolate from them.

Of all ways to read a value off its neighbours the one of least expected square error solves
K·w = k, K and k the covariances between the nodes and with the target (kriging; Stein,
Interpolation of Spatial Data, 1999). Frequencies that crowd towards the ends of the band |f| ≤ F
have the covariance J0(2πFτ), which makes the error nearly the same for all of them; where a
footprint ends, the variogram γ of its cos² edge is added. Nodes a few spacings beyond a block
take part, so that neighbouring blocks share theirs: 1.2 to 1.4 nodes for each that Nyquist asks
for, where Chebyshev nodes take π/2 and more.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from math import ceil, log, log10, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.special import j0

Floats = NDArray[np.float64]

_EDGE = 0.66  # rms error of a unit edge over step³, both in widths of the edge: measured
_EDGE_MARGIN = 2
_BAND_OF_EDGE = 1.5  # error of waves away from edges, of the tolerance
_LEAST = 0.1  # Nyquist's count that a block is taken to have at least
_MORE = 16  # spacings past the fit that are tried
_ROUNDING = 2.0**-24  # of single precision, which values at nodes are kept in
_NUGGET = 0.1  # noise the weights are made for, in shares of the tolerance


@dataclass(frozen=True)
class Grid:
    """Even nodes of a run of even targets.

    blocks : how many the run is cut into
    targets : of a block, the last may have fewer
    spacings : between nodes, over a block's length
    margin : nodes beyond either end of a block that it uses
    """

    blocks: int
    targets: int
    spacings: int
    margin: int

    def nodes(self, targets: int) -> int:
        """Nodes that a block of so many targets uses."""
        return ceil(self.spacings * targets / self.targets - 1e-9) + 2 * self.margin

    def before(self, targets: int) -> int:
        """Nodes more, on its lower side, that a last block of so few targets reads from: a short
        one with few nodes around would be the worst of all."""
        return self.nodes(self.targets) - self.nodes(targets)

    def count(self, targets: int) -> int:
        """Nodes in all, for a run of so many targets."""
        last = targets - (self.blocks - 1) * self.targets
        return (self.blocks - 1) * self.spacings + self.nodes(last)


def _spacings(nyquist: float, margin: int, slack: float) -> int:
    """Fewest spacings s with s ≥ nyquist·(1 + slack/(s + 2·margin))."""
    half = (nyquist - 2 * margin) / 2
    return max(1, ceil(half + sqrt(half * half + nyquist * (2 * margin + slack)) - 1e-9))


def _slack(tolerance: float, alone: bool, spacings: float) -> tuple[int, float]:
    """Margin and slack, fitted to blocks of 4 to 64 spacings and tolerances of 1e-1 to 1e-7."""
    digits = max(1.0, -log10(tolerance))
    long = 1 + 0.13 * max(0.0, log(spacings / 16) / log(2)) if spacings > 16 else 1.0
    if alone:
        return max(1, round(digits) - 2), min(3.3 * digits - 1.4, 2.4 * digits + 1.5) * long
    return max(1, round(digits)), (2.4 * digits - 1.3) * long


def band_grid(targets: int, nyquist: float, tolerance: float, block: float) -> Grid | None:
    """Nodes for a run of targets, or None where they would be no fewer than the targets.

    nyquist : 2·F·(distance of targets), the nodes per target that Nyquist asks for
    tolerance : rms error for a unit wave of frequency up to F
    block : spacings that a block should have, about
    """
    whole = nyquist * targets
    margin, slack = _slack(tolerance, True, whole)
    best = Grid(1, targets, _spacings(whole + _LEAST, margin, slack), margin)
    blocks = round(whole * 1.25 / block)
    if blocks > 1:
        each = -(-targets // blocks)
        margin, slack = _slack(tolerance, False, nyquist * each)
        best = Grid(-(-targets // each), each, _spacings(nyquist * each, margin, slack), margin)
    # The fit is one node off here and there, and a node is a factor of three in the error.
    return _enough(
        best, targets, targets,
        lambda grid: _band_error(grid, _frequency(grid, nyquist), tolerance), tolerance,
    )  # fmt: skip


def _enough(
    best: Grid, most: float, targets: int, error: Callable[[Grid], float], tolerance: float
) -> Grid | None:
    """The grid, or with more nodes, whose error is within tolerance; None with `most` nodes, or
    where more do not bring it about: that is past double precision."""
    for more in range(_MORE):
        grid = replace(best, spacings=best.spacings + more)
        if grid.count(targets) >= most:
            return None
        try:
            if error(grid) <= tolerance:
                return grid
        except np.linalg.LinAlgError:  # nodes that tell double precision one thing twice
            return None
    return None


def _frequency(grid: Grid, nyquist: float) -> float:
    """The band's end in cycles per spacing; rounded, so that the next frame finds its matrix."""
    return _rounded(nyquist / 2 * grid.targets / grid.spacings)


@lru_cache(maxsize=2048)
def _band_error(grid: Grid, frequency: float, tolerance: float) -> float:
    """rms error for frequencies up to the band's end, on some targets of a block."""
    return _missed(grid, frequency, _band_matrix(grid, grid.targets, frequency, tolerance))


@lru_cache(maxsize=2048)
def _edge_error(
    grid: Grid, frequency: float, width: float, length: float, tolerance: float
) -> float:
    """The same of waves away from the edges."""
    matrix = _edge_matrix(grid, grid.targets, frequency, width, length, tolerance)
    return _missed(grid, frequency, matrix)


def _missed(grid: Grid, frequency: float, whole: Floats) -> float:
    some = np.unique(np.linspace(0, grid.targets - 1, 48).astype(int))
    matrix = whole[some]
    waves = 2j * np.pi * np.linspace(0.02, 0.98, 13)[:, None] * frequency
    exact = np.exp(waves * ((some + 0.5) * (grid.spacings / grid.targets)))
    nodes = np.arange(matrix.shape[1]) - grid.margin + 0.5
    missed = exact - np.exp(waves * nodes) @ matrix.T
    # Large weights of either sign, as of few nodes near a block's ends, make much of rounding;
    # those of the other axis make as much more.
    rounding = _ROUNDING * np.mean(np.sum(matrix**2, axis=1))
    return float(np.hypot(np.sqrt(np.mean(np.abs(missed) ** 2)), rounding))


def edge_grid(
    targets: int, nyquist: float, width: float, lit: float, tolerance: float, block: float
) -> Grid | None:
    """The same for a run in which footprints end.

    width : of a soft edge, in distances of targets
    lit : targets that the light falls on, here and elsewhere; the error is relative to it
    """
    # An axis has two such runs, whose errors add up.
    aim = tolerance / sqrt(2)
    step = width * (aim / (_EDGE * sqrt(width / max(lit, width)))) ** (1 / 3)
    margin, slack = _slack(aim, False, block)
    banded = nyquist * (1 + slack / (block + 2 * margin))
    per_target = sqrt(1 / step**2 + banded**2)
    # A smooth edge needs few neighbours, a band that is nearly full as many as without an edge.
    margin = max(_EDGE_MARGIN, round(margin * (banded / per_target) ** 2))
    blocks = max(1, round(per_target * targets / block))
    each = -(-targets // blocks)
    best = Grid(-(-targets // each), each, ceil(per_target * each), margin)
    # Of an edge that is wide against its run little is left but the band, which may need more.
    return _enough(
        best, 0.9 * targets, targets,
        lambda grid: _edge_error(grid, *_edge_shape(grid, nyquist, width), tolerance),
        _BAND_OF_EDGE * tolerance,
    )  # fmt: skip


def band_matrix(grid: Grid, targets: int, nyquist: float, tolerance: float) -> Floats:
    """(targets, nodes) from a block's nodes to its targets. Read-only.

    Targets lie in the middle of cells of spacings/grid.targets, nodes in the middle of cells of 1.
    """
    return _band_matrix(grid, targets, _frequency(grid, nyquist), tolerance)


@lru_cache(maxsize=512)
def _band_matrix(grid: Grid, targets: int, frequency: float, tolerance: float) -> Floats:
    def covariance(tau: Floats) -> Floats:
        return np.asarray(j0(2 * np.pi * frequency * tau))

    return _weights(grid, targets, covariance, tolerance)


def edge_matrix(grid: Grid, targets: int, nyquist: float, width: float, tolerance: float) -> Floats:
    """The same where footprints end.

    nyquist, width : as for `edge_grid`
    """
    return _edge_matrix(grid, targets, *_edge_shape(grid, nyquist, width), tolerance)


def _edge_shape(grid: Grid, nyquist: float, width: float) -> tuple[float, float, float]:
    """The band's end, the width of the edge and the length that edges lie in, in spacings."""
    per = grid.spacings / grid.targets
    return (
        _rounded(nyquist / 2 / per), _rounded(width * per),
        _rounded(max(1.5, 1.2 * grid.targets / width)),
    )  # fmt: skip


def _rounded(value: float) -> float:
    return float(1.02 ** ceil(log(max(value, 1e-3)) / log(1.02)))


@lru_cache(maxsize=512)
def _edge_matrix(
    grid: Grid, targets: int, frequency: float, width: float, length: float, tolerance: float
) -> Floats:
    def covariance(tau: Floats) -> Floats:
        return np.asarray((1 - variogram(tau / width) / length) * j0(2 * np.pi * frequency * tau))

    return _weights(grid, targets, covariance, tolerance)


def _weights(
    grid: Grid, targets: int, covariance: Callable[[Floats], Floats], tolerance: float
) -> Floats:
    first = 0.5 - grid.margin - grid.before(targets)
    nodes = first + np.arange(grid.nodes(grid.targets), dtype=np.float64)
    places = (np.arange(targets, dtype=np.float64) + 0.5) * (grid.spacings / grid.targets)
    among = covariance(nodes[:, None] - nodes)
    among[np.diag_indices_from(among)] += (_NUGGET * tolerance) ** 2
    solved = np.linalg.solve(among, covariance(nodes[:, None] - places))
    matrix: Floats = np.array(solved.T, dtype=np.float64)
    matrix.flags.writeable = False
    return matrix


def variogram(lag: Floats) -> Floats:
    """γ(τ) = ½∫(w(s) − w(s + τ))² ds of the edge w: 1 before 0, cos²(πs/2) to 1, then 0."""
    whole = np.abs(lag)
    t = np.minimum(whole, 1.0)
    turn = np.pi * t
    ends = (1.5 * t - 2 * np.sin(turn) / np.pi + np.sin(2 * turn) / (4 * np.pi)) / 4
    ramp = np.sin(turn / 2) ** 2 * ((1 - t) / 2 + np.sin(turn) / (2 * np.pi))
    return np.asarray(ends + ramp / 2 + (whole - t) / 2)
