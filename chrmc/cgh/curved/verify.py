"""Some pixels of a hologram against the exact sum, before it is handed over.

The expected error takes points for unrelated and light for spread out. Where they are not, as on
coherent lattices, at grazing footprints, and where waves cancel, only a look at the result tells.
"""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise
from math import hypot, log10, sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.assembly import Factor, reference_cycles
from chrmc.cgh.curved.clusters import Plane
from chrmc.cgh.curved.direct import field_at
from chrmc.cgh.curved.nodes import Axis
from chrmc.cgh.curved.predict import FEW_POINTS, ROUNDING, draws_of, finer_at_ends
from chrmc.cgh.curved.wave import phasor
from chrmc.parallel import alone, in_parallel
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

# Rows, and columns, of the lattice that pixels are drawn from, about; and how many at least in each
# run of an axis: edges are narrow. There are more at the ends of runs.
_LINES = 20, 4
_FEW_LINES = 10, 2  # the same where only lights are compared
_CLOSE_LINES = 80, 16  # and of few draws, whose errors keep to a few places
_MOST = 128  # pixels that are drawn: few where points are many
_FOR_DIGIT = 3, 6  # of them at least for each digit asked for: such frames take longer
_TIGHT = 4.5  # digits from which the second counts
_WAVES = 50_000  # points times pixels, about
_MORE = 4  # times as many pixels, where few leave it open
_ALIKE = 4  # times as many of few draws; or so many, if they take no more waves
_MOST_ALIKE, _WAVES_ALIKE = 1000, 1_000_000
_OPEN = 0.75  # of the tolerance: where it is left open
_DOUBT = 0.5, 1.5  # of the tolerance, of what was expected: where more pixels are to confirm it
_CLEAR, _AGAIN = 1.2, 1e7  # where it is not open any more; waves that a third draw may take
SURE, SURE_OF_FEW = 0.85, 0.7
"""Shares of the tolerance up to which the error on some pixels is taken as kept on all, the second
of few draws."""


def _pixels_for(points: int, tolerance: float) -> int:
    digits = -log10(tolerance)
    least = max(4, round(_FOR_DIGIT[digits >= _TIGHT] * digits))
    return int(np.clip(_WAVES // max(points, 1), least, _MOST))


def waves_looked_at(points: int, tolerance: float) -> int:
    """Waves that a look takes, where its first pixels settle it."""
    return points * _pixels_for(points, tolerance)


class Lattice:
    """Rows and columns that stand for a window, and the field there.

    rows, columns : targets; weight : (R, C) pixels that each crossing stands for
    values : (R, C) complex128
    """

    def __init__(
        self,
        rows: tuple[NDArray[np.intp], Floats],
        columns: tuple[NDArray[np.intp], Floats],
        values: Complexes,
    ) -> None:
        self.rows, self.columns = rows[0], columns[0]
        self.weight = rows[1][:, None] * columns[1]
        self.values = values
        self.power = self.weight * np.abs(values) ** 2

    def error(
        self,
        exact: Callable[[Floats, Floats], Complexes],
        plane: Plane,
        points: int,
        tolerance: float,
        expected: float,
        few: bool = False,
    ) -> float:
        """Relative L2 error, estimated on crossings drawn by their light and evenly.

        exact : x, y (K,) → the truth there; points : how many waves that takes each
        expected : what was worked out beforehand; more pixels are drawn where few contradict it,
            and more again where many leave open whether it is the tolerance
        few : draws of the light: more from the beginning
        """
        total = float(self.power.sum())
        # A quarter evenly from the crossings, many of which are at ends of runs: few pixels, whose
        # error may be ten times that of the others.
        chance = 0.25 * self.weight / self.weight.sum() + 0.25 / self.weight.size
        chance += 0.5 * self.power / total if total > 0 else chance
        cumulative = np.cumsum(chance.ravel())
        random = np.random.default_rng(0)
        count = _pixels_for(points, tolerance)
        if few:
            count = max(_ALIKE * count, min(_MOST_ALIKE, _WAVES_ALIKE // max(points, 1)))
        waves = points * count
        squares = np.zeros(0)
        for number, more in enumerate((count, (_MORE - 1) * count, (_MORE - 1) * _MORE * count)):
            # Even steps through them: less left to luck than independent draws.
            at = (np.arange(more) + random.random(more)) / more * cumulative[-1]
            drawn = np.minimum(np.searchsorted(cumulative, at, "right"), len(cumulative) - 1)
            row, column = np.unravel_index(drawn, self.weight.shape)
            truth = exact(plane.x.places[self.columns[column]], plane.y.places[self.rows[row]])
            missed = np.abs(self.values[row, column] - truth) ** 2
            squares = np.append(squares, self.weight[row, column] * missed / chance[row, column])
            error = float(np.mean(squares))
            relative = float(np.sqrt(error / total)) if total > 0 else float(error > 0) * np.inf
            if number == 0 and relative < min(_DOUBT[0] * tolerance, _DOUBT[1] * expected):
                break
            clear = not _OPEN * tolerance <= relative <= _CLEAR * tolerance
            if number == 1 and (clear or _MORE**2 * waves > _AGAIN):
                break
        return relative


def measured_error(
    factors: Sequence[Factor],
    cloud: PointCloud,
    plane: Plane,
    tolerance: float,
    expected: float,
) -> float:
    """Relative L2 error of the sum of some factors in single precision, see `look`."""
    return hypot(*look(factors, cloud, plane, tolerance, expected))


@alone
def look(
    factors: Sequence[Factor],
    cloud: PointCloud,
    plane: Plane,
    tolerance: float,
    expected: float,
    draws: int | None = None,
) -> tuple[float, float]:
    """Relative L2 error of the sum of some factors, estimated on some pixels in float64; and what
    forming that sum in single precision will add, however many nodes there are.

    cloud : the points they were made from
    plane : the window's pixels and the wave
    expected : the error worked out beforehand
    draws : of their light, default those of the points' phases
    """
    few = (draws or draws_of(cloud)) < FEW_POINTS
    lattice, parts = _lattice(factors, plane, _CLOSE_LINES if few else _LINES)
    if not lattice.weight.size:  # footprints end between the pixels
        return 0.0, 0.0
    # Factors that cancel each other round as what they are, not as what they leave.
    total = float(lattice.power.sum())
    least = ROUNDING * sqrt(parts / total) if total > 0 else 0.0

    def exact(x: Floats, y: Floats) -> Complexes:
        def some(part: slice) -> Complexes:
            return field_at(cloud, x[part], y[part], plane.wavelength, plane.reach)

        half = len(x) // 2
        return np.concatenate(in_parallel(some, [slice(half), slice(half, None)]))

    return lattice.error(exact, plane, len(cloud), tolerance, expected, few), least


@alone
def light_kept(factors: Sequence[Factor], plane: Plane) -> float:
    """Light of the sum of some factors over the sum of their lights, on some pixels: far below 1
    where they cancel."""
    lattice, parts = _lattice(factors, plane, _FEW_LINES)
    return float(lattice.power.sum()) / parts if parts > 0 else 1.0


def _lattice(
    factors: Sequence[Factor],
    plane: Plane,
    count: tuple[int, int] = _LINES,
) -> tuple[Lattice, float]:
    """The sum of some factors on a lattice, and the sum of their lights there.

    count : of its lines, in all and at least in each run
    """
    random = np.random.default_rng(0)
    columns = _picked([factor.axis_x for factor in factors], random, count)
    rows = _picked([factor.axis_y for factor in factors], random, count)
    read = partial(_read, rows=rows[0], columns=columns[0], plane=plane)
    values = in_parallel(read, factors)
    lattice = Lattice(rows, columns, np.sum(values, axis=0))
    return lattice, sum(float((lattice.weight * np.abs(one) ** 2).sum()) for one in values)


def field_error(
    field: NDArray[np.complex64],
    cloud: PointCloud,
    plane: Plane,
    tolerance: float,
) -> float:
    """The same of a field on the window."""
    rows, columns = (
        (np.unique(np.linspace(0, n - 1, min(n, 160)).astype(np.intp)), n) for n in field.shape
    )
    weights = [np.full(len(t), n / len(t)) for t, n in (rows, columns)]
    values = field[np.ix_(rows[0], columns[0])].astype(np.complex128)

    def exact(x: Floats, y: Floats) -> Complexes:
        return field_at(cloud, x, y, plane.wavelength, plane.reach)

    lattice = Lattice((rows[0], weights[0]), (columns[0], weights[1]), values)
    return lattice.error(exact, plane, len(cloud), tolerance, 0.0)


def _picked(
    axes: Sequence[Axis], random: np.random.Generator, lines: tuple[int, int] = _LINES
) -> tuple[NDArray[np.intp], Floats]:
    """Targets, some from every run of every axis, and how many each stands for."""
    spans = [
        (blocks[0].targets.start, blocks[-1].targets.stop)
        for axis in axes
        for run in axis.runs
        if (blocks := axis.blocks_of(run))
    ]
    ends = sorted({end for span in spans for end in span})
    lit = [
        (start, stop)
        for start, stop in pairwise(ends)
        if any(first <= start and stop <= last for first, last in spans)
    ]
    total = sum(stop - start for start, stop in lit)
    picks, weights = [np.zeros(0, dtype=np.intp)], [np.zeros(0)]
    for start, stop in lit:
        size = stop - start
        count = max(lines[1], round(lines[0] * size / total))
        bounds = finer_at_ends(size, count, (True, True), between=True)
        sizes = np.diff(bounds)
        picks.append(start + bounds[:-1] + (random.random(len(sizes)) * sizes).astype(np.intp))
        weights.append(sizes.astype(np.float64))
    return np.concatenate(picks), np.concatenate(weights)


def _read(
    factor: Factor,
    rows: NDArray[np.intp],
    columns: NDArray[np.intp],
    plane: Plane,
) -> Complexes:
    """(R, C) A_y·M·A_x at some rows and columns."""
    reference = factor.reference
    # Real and imaginary parts side by side: real products.
    nodes = np.concatenate([factor.real.T, factor.imag.T], axis=1, dtype=np.float64)
    real, imag = np.split(_interpolated(factor.axis_x, columns, nodes), 2, axis=1)
    nodes = np.concatenate([real.T, imag.T], axis=1)
    real, imag = np.split(_interpolated(factor.axis_y, rows, nodes), 2, axis=1)
    both = real + 1j * imag
    cos_x, sin_x = phasor(
        reference_cycles(plane.x.places[columns], reference.x, reference.z_x, plane.wavelength)
    )
    cos_y, sin_y = phasor(
        reference_cycles(plane.y.places[rows], reference.y, reference.z_y, plane.wavelength)
    )
    return both * (cos_x + 1j * sin_x) * (cos_y + 1j * sin_y)[:, None]


def _interpolated(axis: Axis, targets: NDArray[np.intp], values: Floats) -> Floats:
    """(targets, k) from values (nodes, k); zero outside all blocks."""
    out = np.zeros((len(targets), values.shape[1]))
    for block in axis.blocks:
        here = np.flatnonzero((block.targets.start <= targets) & (targets < block.targets.stop))
        if len(here):
            own = targets[here] - block.targets.start
            nodes = values[block.nodes]
            out[here] = nodes[own] if block.matrix is None else block.matrix[own] @ nodes
    return out
