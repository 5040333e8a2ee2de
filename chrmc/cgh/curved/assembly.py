"""From basebands at nodes to pixels: A_y·M·A_x, in real matrix products.

A_x and A_y hold the interpolation from the nodes and the phase of the reference wave; A_y also
holds the carrier, so that Re(field·carrier) comes out as float32 without a complex field.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.nodes import Axis, Block
from chrmc.cgh.curved.wave import Reference
from chrmc.parallel import in_parallel, run_all

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
_MINUS = np.float32(-1)  # np.negative skips rows of strided outputs in NumPy 2.4


@dataclass(frozen=True, eq=False)
class Factor:
    """A cluster's hologram in low-rank form.

    axis_x, axis_y : nodes and blocks; targets count from the window's first column and row
    reference : the wave that was taken out
    real, imag : (n_y, n_x) baseband at the nodes
    """

    axis_x: Axis
    axis_y: Axis
    reference: Reference
    real: Singles
    imag: Singles


def reference_cycles(t: Floats, centre: float, z: float, wavelength: float) -> Floats:
    """(r − z)/λ of the reference along one axis, without cancellation."""
    d2 = (t - centre) ** 2
    return d2 / ((np.sqrt(d2 + z * z) + z) * wavelength)


Phase = tuple[Floats, Floats]
"""cos and sin of what is put on along an axis, over all targets."""


def _interleaved(matrix: Floats, cos: Floats, sin: Floats) -> Singles:
    """matrix·cos and matrix·sin, column by column in turn: (targets, 2·nodes)."""
    out = np.empty((*matrix.shape, 2), dtype=np.float32)
    np.multiply(matrix, cos, out=out[:, :, 0], casting="same_kind")
    np.multiply(matrix, sin, out=out[:, :, 1], casting="same_kind")
    return out.reshape(len(matrix), -1)


def expand_columns(factor: Factor, x: Phase) -> tuple[Singles, list[Callable[[], None]]]:
    """M·A_x as (2·n_y, columns of axis_x.targets), and the pieces of work that fill it.

    Each node has its real, then its imaginary row.
    """
    ny, nx = factor.real.shape
    # (M_re, −M_im) meet the cosine and the sine for the real part, (M_im, M_re) for the other.
    left = np.empty((ny, 2, nx, 2), dtype=np.float32)
    left[:, 0, :, 0] = left[:, 1, :, 1] = factor.real
    np.multiply(factor.imag, _MINUS, out=left[:, 0, :, 1])
    left[:, 1, :, 0] = factor.imag
    flat = left.reshape(2 * ny, 2 * nx)
    blocks = factor.axis_x.blocks
    covered = factor.axis_x.targets
    width = covered.stop - covered.start
    whole = sum(block.target_count for block in blocks) == width
    out = (np.empty if whole else np.zeros)((2 * ny, width), dtype=np.float32)

    def expand(block: Block) -> None:
        place = slice(block.targets.start - covered.start, block.targets.stop - covered.start)
        cos, sin = x[0][block.targets], x[1][block.targets]
        part = flat[:, 2 * block.nodes.start : 2 * block.nodes.stop]
        if block.matrix is None:
            out[:, place] = part[:, 0::2] * cos.astype(np.float32)
            out[:, place] += part[:, 1::2] * sin.astype(np.float32)
            return
        right = np.empty((block.node_count, 2, block.target_count), dtype=np.float32)
        np.multiply(block.matrix.T, cos, out=right[:, 0], casting="same_kind")
        np.multiply(block.matrix.T, sin, out=right[:, 1], casting="same_kind")
        np.matmul(part, right.reshape(-1, block.target_count), out=out[:, place])

    return out, [partial(expand, block) for block in blocks]


@dataclass(frozen=True, eq=False)
class _Contribution:
    """What one factor gives to some rows: its block there, and which of the block's targets."""

    block: Block
    rows: slice
    wide: Singles
    columns: slice
    y: Phase

    def phase(self) -> Phase:
        """cos and sin along y, (rows, 1)."""
        first = self.block.targets.start
        targets = slice(first + self.rows.start, first + self.rows.stop)
        return self.y[0][targets, None], self.y[1][targets, None]

    def left(self) -> Singles:
        """(rows, 2·nodes) of A_y for the real part."""
        assert self.block.matrix is not None
        cos, sin = self.phase()
        return _interleaved(self.block.matrix[self.rows], cos, -sin)

    def right(self) -> Singles:
        """(2·nodes, columns) of the expanded rows."""
        return self.wide[2 * self.block.nodes.start : 2 * self.block.nodes.stop]

    def own(self) -> Singles:
        """(rows, columns) where the nodes are the targets."""
        cos, sin = (part.astype(np.float32) for part in self.phase())
        wide = self.right()
        values: Singles = wide[0::2][self.rows] * cos
        values -= wide[1::2][self.rows] * sin
        return values


def row_runs(factors: Sequence[Factor], height: int) -> list[tuple[slice, list[tuple[int, Block]]]]:
    """Runs of rows within which the blocks are the same: numbers of factors and their blocks."""
    blocks = [(number, block) for number, f in enumerate(factors) for block in f.axis_y.blocks]
    ends = {0, height}
    for _, block in blocks:
        ends |= {block.targets.start, block.targets.stop}
    return [
        (
            slice(start, stop),
            [
                (number, block)
                for number, block in blocks
                if block.targets.start <= start and stop <= block.targets.stop
            ],
        )
        for start, stop in pairwise(sorted(ends))
    ]


def sum_signals(
    shape: tuple[int, int],
    factors: Sequence[Factor],
    phases: Sequence[tuple[Phase, Phase]],
    base: Singles | None = None,
) -> Singles:
    """Re(Σ A_y·M·A_x) + base, factors side by side in one product for each run of rows.

    phases : what is put on each factor along x and along y
    """
    out = np.empty(shape, dtype=np.float32)
    expanded = [expand_columns(factor, x) for factor, (x, _) in zip(factors, phases, strict=True)]
    run_all([piece for _, pieces in expanded for piece in pieces])

    def put(run: tuple[slice, list[tuple[int, Block]]]) -> None:
        rows, covering = run
        contributions = []
        for number, block in covering:
            first = block.targets.start
            part = slice(rows.start - first, rows.stop - first)
            columns = factors[number].axis_x.targets
            contributions.append(
                _Contribution(block, part, expanded[number][0], columns, phases[number][1])
            )
        _put(out, rows, contributions, base)

    in_parallel(put, row_runs(factors, shape[0]))
    return out


def _put(
    out: Singles, rows: slice, contributions: Sequence[_Contribution], base: Singles | None
) -> None:
    """What each factor gives to some rows, and the base."""
    products: dict[tuple[int, int], list[_Contribution]] = {}
    others: list[_Contribution] = []
    for one in contributions:
        if one.block.matrix is None:
            others.append(one)
        else:
            products.setdefault((one.columns.start, one.columns.stop), []).append(one)
    whole = (0, out.shape[1])
    if whole not in products:
        out[rows] = 0 if base is None else base[rows]
    for columns, several in sorted(products.items(), key=lambda item: item[0] != whole):
        left, right = several[0].left(), several[0].right()
        if len(several) > 1:
            left = np.concatenate([one.left() for one in several], axis=1)
            right = np.concatenate([one.right() for one in several])
        if columns == whole:
            np.matmul(left, right, out=out[rows])
            if base is not None:
                out[rows] += base[rows]
        else:
            out[rows, slice(*columns)] += left @ right
    for one in others:
        out[rows, one.columns] += one.own()


def add_field(
    out: NDArray[np.complexfloating],
    factor: Factor,
    x: Phase,
    y: Phase,
) -> None:
    """Add A_y·M·A_x to the targets of `out`."""
    wide, pieces = expand_columns(factor, x)
    run_all(pieces)
    columns = factor.axis_x.targets

    def put(block: Block) -> None:
        n = block.node_count
        rows = np.empty((n, 2, wide.shape[1]), dtype=np.complex64)
        part = wide[2 * block.nodes.start : 2 * block.nodes.stop].reshape(n, 2, -1)
        rows[:, 0].real, rows[:, 0].imag = part[:, 0], part[:, 1]
        np.multiply(part[:, 1], _MINUS, out=rows[:, 1].real)
        rows[:, 1].imag = part[:, 0]
        cos, sin = y[0][block.targets, None], y[1][block.targets, None]
        if block.matrix is None:
            values = rows[:, 0] * cos.astype(np.float32) + rows[:, 1] * sin.astype(np.float32)
        else:
            # The interleaved real and imaginary columns are plain columns to sgemm.
            left = _interleaved(block.matrix, cos, sin)
            values = (left @ rows.reshape(2 * n, -1).view(np.float32)).view(np.complex64)
        out[block.targets, columns] += values

    in_parallel(put, factor.axis_y.blocks)
