"""A cluster's nodes along one axis: runs of even nodes, cut into blocks that read from them.

Where no footprint ends the nodes are as dense as the baseband's bandwidth asks; in the strips
where the soft edges fall, as dense as the edges ask. Nodes of a run without edges that lie past
its end hold the light without its footprint, so that the run stays smooth throughout.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import ceil

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.band import Grid, band_grid, band_matrix, edge_grid, edge_matrix
from chrmc.cgh.curved.bandwidth import Needs, bandwidth
from chrmc.optics.footprint import SOFT_SHARE, taper

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Line:
    """Evenly spaced places: first, first + step, …, metres."""

    first: float
    step: float
    count: int

    @property
    def last(self) -> float:
        """Metres."""
        return self.first + self.step * (self.count - 1)

    @property
    def places(self) -> Floats:
        """(count,) metres, ascending."""
        return self.first + self.step * np.arange(self.count, dtype=np.float64)

    def part(self, start: int, stop: int) -> "Line":
        """Places start … stop − 1 of it."""
        return Line(self.first + start * self.step, self.step, stop - start)


@dataclass(frozen=True, eq=False)
class Block:
    """A run of targets interpolated from a run of nodes, some of which its neighbours use too.

    targets, nodes : slices
    matrix : (targets, nodes), or None where the nodes are the targets themselves
    """

    targets: slice
    nodes: slice
    matrix: Floats | None

    @property
    def target_count(self) -> int:
        return int(self.targets.stop - self.targets.start)

    @property
    def node_count(self) -> int:
        return int(self.nodes.stop - self.nodes.start)


@dataclass(frozen=True, eq=False)
class Run:
    """Nodes of one kind.

    nodes : slice of the axis's nodes
    line : their places
    tapered : the footprint is in their values
    weight : (n,) targets that each stands for; 0 for those beyond the targets
    """

    nodes: slice
    line: Line
    tapered: bool
    weight: Floats

    def moved(self, by: int) -> "Run":
        """The same with other nodes before it."""
        return Run(_moved(self.nodes, by), self.line, self.tapered, self.weight)


@dataclass(frozen=True, eq=False)
class Axis:
    """The nodes of a cluster along x or y.

    nodes : (n,) metres, ascending within a run
    runs, blocks : in order; targets outside all blocks see none of the cluster's light
    """

    nodes: Floats
    runs: tuple[Run, ...]
    blocks: tuple[Block, ...]

    @property
    def targets(self) -> slice:
        """From the first block's first target to the last block's last."""
        if not self.blocks:
            return slice(0, 0)
        return slice(self.blocks[0].targets.start, self.blocks[-1].targets.stop)

    @property
    def span(self) -> tuple[float, float]:
        """Lowest and highest node."""
        return float(self.nodes.min()), float(self.nodes.max())

    def blocks_of(self, run: Run) -> list[Block]:
        """The blocks that read from a run, in order."""
        return [p for p in self.blocks if run.nodes.start <= p.nodes.start < run.nodes.stop]

    def weights(self, x: Floats, z: Floats, reach: float) -> Floats:
        """(N, n) soft footprint of points at x, z in the nodes' values."""
        out = np.ones((len(x), len(self.nodes)))
        for run in self.runs:
            if run.tapered:
                places = self.nodes[run.nodes]
                out[:, run.nodes] = taper(places - x[:, None], (z * reach)[:, None])
        return out


def joined(axes: Sequence[tuple[Axis, int]]) -> Axis:
    """Axes one after the other, each with the number of its first target."""
    runs: list[Run] = []
    blocks: list[Block] = []
    count = 0
    for axis, first in axes:
        runs += [run.moved(count) for run in axis.runs]
        for block in axis.blocks:
            blocks.append(
                Block(_moved(block.targets, first), _moved(block.nodes, count), block.matrix)
            )
        count += len(axis.nodes)
    nodes = np.concatenate([axis.nodes for axis, _ in axes]) if axes else np.zeros(0)
    return Axis(nodes, tuple(runs), tuple(blocks))


def _moved(part: slice, by: int) -> slice:
    return slice(part.start + by, part.stop + by)


def part_of(axis: Axis, tapered: bool) -> tuple[Axis, NDArray[np.intp]]:
    """The runs with the footprint in them, or the others, and their nodes' places in `axis`.

    Its blocks are left out: it is for sums at the nodes.
    """
    runs: list[Run] = []
    places: list[NDArray[np.intp]] = [np.zeros(0, dtype=np.intp)]
    count = 0
    for run in axis.runs:
        if run.tapered == tapered:
            size = run.nodes.stop - run.nodes.start
            runs.append(run.moved(count - run.nodes.start))
            places.append(np.arange(run.nodes.start, run.nodes.stop))
            count += size
    place = np.concatenate(places)
    return Axis(axis.nodes[place], tuple(runs), ()), place


def make_axis(line: Line, x: Floats, z: Floats, needs: Needs) -> Axis:
    """Nodes and blocks of a cluster's baseband for even targets.

    x, z : (N,) the points' coordinate on this axis and depth
    """
    if not np.isfinite(needs.reach):
        return _smooth_run(line, needs)
    half = z * needs.reach
    low, flat_low = float(np.min(x - half)), float(np.max(x - (1 - SOFT_SHARE) * half))
    high, flat_high = float(np.max(x + half)), float(np.min(x + (1 - SOFT_SHARE) * half))
    targets = line.places
    first, last = np.searchsorted(targets, low, "right"), np.searchsorted(targets, high, "left")
    parts: list[tuple[int, int, bool]] = [(int(first), int(last), True)]
    if flat_low < flat_high:
        a, b = np.clip(np.searchsorted(targets, [flat_low, flat_high]), first, last)
        parts = [(int(first), int(a), True), (int(a), int(b), False), (int(b), int(last), True)]
    pieces = []
    for start, stop, tapered in parts:
        if stop > start:
            part = line.part(start, stop)
            edge = SOFT_SHARE * float(half.min()), low, high
            own = _edge_run(part, needs, edge) if tapered else _smooth_run(part, needs)
            pieces.append((own, start))
    return joined(pieces)


def axis_behind(axis: Axis, x: Floats, z: Floats, needs: Needs) -> Axis:
    """Nodes whose targets are the nodes of another axis, run by run."""
    return joined(
        [
            (
                make_axis(run.line, x, z, needs) if run.tapered else _smooth_run(run.line, needs),
                run.nodes.start,
            )
            for run in axis.runs
        ]
    )


def _on_targets(line: Line, tapered: bool) -> Axis:
    """Nodes that are the targets."""
    every = slice(0, line.count)
    run = Run(every, line, tapered, np.ones(line.count))
    return Axis(line.places, (run,), (Block(every, every, None),))


def _smooth_run(line: Line, needs: Needs) -> Axis:
    """One run over all targets of a line, without a footprint."""
    count, step = line.count, line.step
    margin = 0.0
    grid: Grid | None = None
    nyquist = 0.0
    for _ in range(2):
        # The waves' frequency where the outermost nodes lie, those of the other axis about as far
        # beyond: few nodes, as of a single point, may span many times the panel.
        low, high = line.first - margin, line.first + step * (count - 1) + margin
        across, beside = needs.extent.across, needs.extent.beside
        more = (across - beside) * 2 * margin / (step * count)
        extent = replace(needs.extent, across=across + more, beside=max(beside - more, 0.0))
        wide = bandwidth(low, high, replace(needs, extent=extent))
        if 2 * wide * step <= 1.02 * nyquist:
            break
        nyquist = 2 * wide * step
        grid = band_grid(count, nyquist, needs.tolerance, needs.block)
        if grid is None:
            break
        margin = grid.margin * step * grid.targets / grid.spacings
    if grid is None:
        return _on_targets(line, False)
    return _even_run(
        line, grid, lambda targets: band_matrix(grid, targets, nyquist, needs.tolerance), None
    )


def _edge_run(line: Line, needs: Needs, edge: tuple[float, float, float]) -> Axis:
    """One run over all targets of a line, in which footprints end.

    edge : width of the soft edges, and where the light begins and ends
    """
    count, step = line.count, line.step
    nyquist = 2 * bandwidth(line.first, line.last, needs) * step
    width, lit = edge[0] / step, needs.lit / step
    tolerance = needs.tolerance
    grid = edge_grid(count, nyquist, width, lit, tolerance, needs.block)
    if grid is None:
        return _on_targets(line, True)
    return _even_run(
        line, grid, lambda targets: edge_matrix(grid, targets, nyquist, width, tolerance),
        edge[1:],
    )  # fmt: skip


def _even_run(
    line: Line,
    grid: Grid,
    matrix: Callable[[int], Floats],
    light: tuple[float, float] | None,
) -> Axis:
    """The nodes and blocks of a grid.

    matrix : number of targets to a block's matrix
    light : where it begins and ends, in a tapered run
    """
    spacing = line.step * grid.targets / grid.spacings
    first = line.first - line.step / 2 + spacing * (0.5 - grid.margin)
    total = grid.count(line.count)
    below = above = 0
    if light is not None:
        # Nodes that no light falls on hold zeros.
        dark = light[0] - first, first + spacing * (total - 1) - light[1]
        below, above = (int(min(max(ceil(d / spacing), 0), grid.margin)) for d in dark)
    nodes = Line(first + below * spacing, spacing, total - below - above)
    blocks = []
    for number in range(grid.blocks):
        start = number * grid.targets
        stop = min(start + grid.targets, line.count)
        whole = matrix(stop - start)
        low = number * grid.spacings - below - grid.before(stop - start)
        high = low + whole.shape[1]
        part = whole[:, max(0, -low) : whole.shape[1] - max(0, high - nodes.count)]
        blocks.append(Block(slice(start, stop), slice(max(0, low), min(high, nodes.count)), part))
    weight = np.zeros(nodes.count)
    weight[grid.margin - below : total - grid.margin - below] = grid.targets / grid.spacings
    run = Run(slice(0, nodes.count), nodes, light is not None, weight)
    return Axis(nodes.places, (run,), tuple(blocks))
