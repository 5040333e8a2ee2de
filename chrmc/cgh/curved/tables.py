"""The baseband of a cluster at its nodes: separable tables times a short separable series.

The separable part of a spherical wave (see `wave`) is two small tables and one matrix product.
The rest depends weakly on where in the cluster the point is; each term of its series is one
matrix product more.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import pi

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.assembly import reference_cycles
from chrmc.cgh.curved.direct import weighted_waves
from chrmc.cgh.curved.nodes import Axis
from chrmc.cgh.curved.series import OnNodes, Series
from chrmc.cgh.curved.wave import Wave, by_curvature, phase_table, phasor
from chrmc.optics.footprint import taper
from chrmc.parallel import run_all
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Reals = NDArray[np.floating]

MOST_AT_ONCE = 4096
"""Points whose tables are held at once."""

Table = tuple[Reals, Reals, Reals]
"""cos, sin and cos + sin of phases, (N, nodes) each."""

_MOST_VALUES = 1 << 25  # of all terms at all nodes: they are held together, and then added up
_ROWS = 64  # of nodes, that are summed at once where there are more
_BLOCK = 128_000  # entries of a table that are made at once: they fit the second cache


def phasor_table(
    cycles: Callable[[slice], Floats],
    shape: tuple[int, int],
    precision: type[np.floating],
    weigh: Callable[[slice, Reals, Reals], None] | None = None,
) -> Table:
    """cos, sin and their sum of 2π·cycles, reduced in float64: a complex product is three real.

    cycles : points to (points, nodes)
    weigh : puts weights on the cos and sin of some points
    """
    out = np.empty((3, *shape), dtype=precision)
    step = max(1, _BLOCK // max(1, shape[1]))
    for start in range(0, shape[0], step):
        some = slice(start, min(start + step, shape[0]))
        turns = cycles(some)
        turns -= np.rint(turns)
        turns *= 2 * pi  # single precision's 2π is too long by 3e-8: all cosines would be less
        turn = turns.astype(precision, copy=False)
        cos, sin, both = out[:, some]
        np.cos(turn, out=cos)
        np.sin(turn, out=sin)
        if weigh is not None:
            weigh(some, cos, sin)
        np.add(cos, sin, out=both)
    return out[0], out[1], out[2]


def _products(
    across: Table, down: Table, scale: Reals, weights: OnNodes
) -> tuple[list[Callable[[], None]], Callable[[], tuple[Reals, Reals]]]:
    """Work that forms Σ_l F_l·Σ_j scale_lj·down_j·across_j piece by piece, and what adds it up.

    across, down : tables (N, n_x) and (N, n_y)
    scale : (L, N) real
    weights : F_l

    Real and imaginary parts, (n_y, n_x) each. A complex product is three real ones: sgemm runs
    several times faster than cgemm here.
    """
    terms, n = scale.shape
    ny, nx = down[0].shape[1], across[0].shape[1]
    # Of very many nodes all terms are added up as they come, or they would fill the memory.
    together = terms if terms * ny * nx > _MOST_VALUES else 1
    number = ny // _ROWS if together > 1 else 4 if terms < 3 else 1
    cuts = np.linspace(0, ny, max(number, 1) + 1).astype(int)
    out = np.empty((terms // together, 2, ny, nx), dtype=scale.dtype)

    def multiply(term: int, rows: slice, target: Reals) -> None:
        scaled = np.empty((n, rows.stop - rows.start), dtype=scale.dtype)
        three = []
        for table, other in zip(down, across, strict=True):
            np.multiply(table[:, rows], scale[term][:, None], out=scaled)
            three.append(scaled.T @ other)
        both, sine, imag = three
        imag -= both
        imag -= sine
        both -= sine
        _weigh(weights.of(term, rows), (both, imag), target)

    def piece(first: int, rows: slice) -> Callable[[], None]:
        def work() -> None:
            target = out[first // together, :, rows]
            multiply(first, rows, target)
            for term in range(first + 1, first + together):
                one = np.empty_like(target)
                multiply(term, rows, one)
                target += one

        return work

    pieces = [
        piece(term, slice(int(low), int(high)))
        for term in range(0, terms, together)
        for low, high in pairwise(cuts)
    ]

    def total() -> tuple[Reals, Reals]:
        # In a fixed order, so that the same points give the same numbers.
        whole = out[0]
        for more in out[1:]:
            whole += more
        return whole[0], whole[1]

    return pieces, total


def _weigh(weight: tuple[Reals, Reals], sums: tuple[Reals, Reals], out: Reals) -> None:
    """out = weight·sums, complex, from and to real and imaginary parts; `sums` is overwritten."""
    real, imag = sums
    np.multiply(weight[0], real, out=out[0])
    np.multiply(weight[1], real, out=out[1])
    out[1] += weight[0] * imag
    imag *= weight[1]
    out[0] -= imag


@dataclass(frozen=True, eq=False)
class Level:
    """Terms of a series that are summed at the same nodes.

    precision : of the tables and sums; float32 adds about 5e-7 of noise
    """

    axis_x: Axis
    axis_y: Axis
    terms: slice
    precision: type[np.floating]


@dataclass(eq=False)
class Tables:
    """Of points' separable phases along x, (N, n_x), and along y, (N, n_y)."""

    across: Table | None = None
    down: Table | None = None


def table_pieces(
    cloud: PointCloud,
    axes: tuple[Axis, Axis],
    wave: Wave,
    precision: type[np.floating],
    out: Tables,
) -> list[Callable[[], None]]:
    """What fills `out` for a cloud at some nodes."""
    reference, wavelength = wave.reference, wave.wavelength
    x, y, z = cloud.positions.T

    def make(
        axis: Axis, t: Floats, reach: float, product: tuple[Floats, Floats | None], start: Floats
    ) -> Table:
        values, matrix = product

        def cycles(some: slice) -> Floats:
            own = values[some] if matrix is None else values[some] @ matrix
            return np.asarray(own + start[some, None], dtype=np.float64)

        def weigh(some: slice, cos: Reals, sin: Reals) -> None:
            for run in axis.runs:
                if run.tapered:
                    offset = (axis.nodes[run.nodes] - t[some, None]).astype(cos.dtype)
                    weight = taper(offset, (z[some] * reach)[:, None])
                    cos[:, run.nodes] *= weight
                    sin[:, run.nodes] *= weight

        return phasor_table(cycles, (len(t), len(axis.nodes)), precision, weigh)

    def across() -> None:
        z_x = reference.along_x(z)
        product = phase_table(axes[0], x, z_x, reference.x, reference.z_x, wavelength)
        out.across = make(axes[0], x, wave.reach[0], product, np.zeros(len(x)))

    def down() -> None:
        z_y = reference.along_y(z)
        product = phase_table(axes[1], y, z_y, reference.y, reference.z_y, wavelength)
        start = reference.start(z, wavelength) + cloud.phase / (2 * pi)
        out.down = make(axes[1], y, wave.reach[1], product, start)

    return [across, down]


def sum_levels(
    cloud: PointCloud,
    levels: Sequence[Level],
    wave: Wave,
    series: Series,
    first: Tables | None = None,
    beside: Callable[[], None] | None = None,
) -> list[tuple[Reals, Reals]]:
    """Real and imaginary parts (n_y, n_x) of Σ_j w·a/r·exp(i(kr + φ)) over the reference wave.

    For each level the part that its terms make, at its nodes.

    first : the first level's tables, if they are there already
    beside : work of many small operations, which holds Python's lock and leaves the other cores
        to the products
    """
    out: list[tuple[Reals, Reals]] = []
    for start in range(0, len(cloud), MOST_AT_ONCE):
        part = cloud.select(slice(start, start + MOST_AT_ONCE))
        sums = _some_points(part, levels, wave, series, first, beside)
        first = beside = None
        if not out:
            out = sums
        else:
            for total, more in zip(out, sums, strict=True):
                for old, new in zip(total, more, strict=True):
                    old += new
    return out


def _some_points(
    cloud: PointCloud,
    levels: Sequence[Level],
    wave: Wave,
    series: Series,
    first: Tables | None,
    beside: Callable[[], None] | None,
) -> list[tuple[Reals, Reals]]:
    scale = series.at_points(by_curvature(cloud.positions))
    scale *= cloud.amplitude * wave.reference.modulus(cloud.positions[:, 2])
    tables = [first or Tables(), *(Tables() for _ in levels[1:])]
    missing = [
        piece
        for level, own in zip(levels, tables, strict=True)
        if own.across is None
        for piece in table_pieces(cloud, (level.axis_x, level.axis_y), wave, level.precision, own)
    ]
    if missing:
        run_all(missing)
    sums = []
    pieces: list[Callable[[], None]] = []
    for level, own in zip(levels, tables, strict=True):
        assert own.across is not None and own.down is not None
        weights = series.on_nodes(
            level.axis_x.nodes, level.axis_y.nodes, level.precision, level.terms
        )
        products, total = _products(
            own.across, own.down, scale[level.terms].astype(level.precision), weights
        )
        pieces += products
        sums.append(total)
    if beside is not None:
        pieces.insert(1, beside)
    run_all(pieces)
    return [total() for total in sums]


def exact_baseband(
    cloud: PointCloud,
    axis_x: Axis,
    axis_y: Axis,
    wave: Wave,
) -> tuple[Singles, Singles]:
    """The same point by point, for geometry that no short series fits, or where that is quicker."""
    reference, wavelength = wave.reference, wave.wavelength
    x, y, z = cloud.positions.T
    total = weighted_waves(
        cloud, axis_x.nodes, axis_y.nodes, wavelength,
        lambda some: axis_x.weights(x[some], z[some], wave.reach[0]),
        lambda some: axis_y.weights(y[some], z[some], wave.reach[1]),
    )  # fmt: skip
    for axis, centre, depth, turned in (
        (axis_x, reference.x, reference.z_x, total.T), (axis_y, reference.y, reference.z_y, total)
    ):  # fmt: skip
        cos, sin = phasor(reference_cycles(axis.nodes, centre, depth, wavelength))
        turned *= (cos - 1j * sin)[:, None]
    return total.real.astype(np.float32), total.imag.astype(np.float32)
