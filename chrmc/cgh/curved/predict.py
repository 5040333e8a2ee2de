"""What error a factor will have, before a single pixel is computed.

Interpolation along x and along y is tried out on a few of the cluster's points, one axis at a
time, at a few targets of each block; the series' left-out terms are known; rounding was measured.
Errors of points with unrelated phases add in power. The light they are relative to is read from
the baseband at the nodes; where points shine brighter together than each by itself, so do their
errors, and it is that of each.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot, sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.along import Along, waves_along
from chrmc.cgh.curved.assembly import Factor
from chrmc.cgh.curved.clusters import bounding_box
from chrmc.cgh.curved.nodes import Axis, Block
from chrmc.cgh.curved.series import Remainder
from chrmc.cgh.curved.wave import Wave, by_curvature
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]

_POINTS = 4  # strongest, outermost in x and outermost in y that are tried
_OTHERS = 20  # that stand for the rest
_TARGETS = 5  # targets of each block that are tried, more at the ends of runs or of few blocks
_BLOCKS = 200  # of a run with edges, times points, that are tried; three at least
ROUNDING = 5e-7
"""Relative error that single-precision products and pixels leave."""
FEW_POINTS = 8
"""Up to which errors have shapes of their own."""
_SHARE_OF_FEW, _SHARE = 0.4, 0.65  # of the tolerance, at most, that may be expected: few frames'
# errors lie past either, but a run's end may hold one of its own


@dataclass(frozen=True)
class Budget:
    """Powers summed over targets: of the expected error, and of the light itself.

    rounding : of the error, what single precision leaves however many nodes there are
    """

    error: float
    light: float
    rounding: float = 0.0

    def __add__(self, other: "Budget") -> "Budget":
        return Budget(
            self.error + other.error, self.light + other.light, self.rounding + other.rounding
        )

    @property
    def relative(self) -> float:
        """Expected relative L2 error."""
        if self.light <= 0:
            return 0.0 if self.error <= 0 else float("inf")
        return sqrt(self.error / self.light)

    @property
    def least(self) -> float:
        """Expected relative L2 error at any number of nodes."""
        return sqrt(self.rounding / self.light) if self.light > 0 else 0.0


def draws_of(cloud: PointCloud) -> int:
    """Phases that are drawn: as many as points, where these are random, one where they are alike.

    Whose errors, like their light, add up in some places.
    """
    together = np.hypot(*(cloud.amplitude @ turn(cloud.phase) for turn in (np.cos, np.sin)))
    if not together > 0:
        return len(cloud)
    return int(min(len(cloud), max(1.0, (cloud.amplitude.sum() / together) ** 2)))


def error_allowed(factors: Sequence[Factor], tolerance: float, points: int) -> float:
    """The expected error up to which the measured one is sure to stay within the tolerance.

    points : or phases of these, see `draws_of`

    Light on few nodes, or of few points, sees few draws of the phases, whose error may lie far from
    the mean: three deviations of its power are left room for, of an error on a quarter of them.
    """
    share = _SHARE_OF_FEW
    if points >= FEW_POINTS:
        draws = max(1.0, min(_draws(factors), points) / 4)
        share = min(_SHARE, 1 / sqrt(1 + 3 / sqrt(draws)))
    return min(0.8, hypot(share, ROUNDING / tolerance)) * tolerance


def _draws(factors: Sequence[Factor]) -> float:
    """Nodes that the light is spread over, about."""
    powers = [_powers(factor) for factor in factors]
    light = sum(power for power, _ in powers)
    squares = sum(square for _, square in powers)
    return light**2 / squares if squares > 0 else 1.0


def _powers(factor: Factor) -> tuple[float, float]:
    """Σ|field|² over the targets, from the baseband at the nodes among them; and the sum of the
    squares of each node's share."""
    weights = []
    for axis in (factor.axis_y, factor.axis_x):
        weight = np.zeros(len(axis.nodes))
        for run in axis.runs:
            weight[run.nodes] = run.weight
        weights.append(weight)
    power = factor.real.astype(np.float64) ** 2 + factor.imag.astype(np.float64) ** 2
    light = float(weights[0] @ power @ weights[1])
    return light, float(weights[0] ** 2 @ power**2 @ weights[1] ** 2)


def promise_kept(factors: Sequence[Factor], budget: Budget, tolerance: float, points: int) -> bool:
    """Whether factors may be shown as within a tolerance."""
    return budget.relative <= error_allowed(factors, tolerance, points)


def axis_powers(axis: Axis, targets: Floats, along: Along) -> tuple[Floats, Floats]:
    """(N,) power of each point along one axis, and of its interpolation error, over targets.

    along : the points' waves; their weights count only where a footprint ends
    """
    # Blocks of a run are alike but for its ends, and for where few points' footprints end.
    chosen: list[tuple[Block, bool, float, tuple[bool, bool]]] = []
    for run in axis.runs:
        own = axis.blocks_of(run)
        count = max(3, _BLOCKS // len(along.x)) if run.tapered else 3
        tried = np.unique(np.linspace(0, len(own) - 1, min(count, len(own))).astype(int))
        inner = sum(block.target_count for block in own[1:-1])
        inside = sum(own[i].target_count for i in tried[1:-1])
        for i in tried:
            ends = i == 0, i == len(own) - 1
            times = 1.0 if any(ends) else inner / inside
            chosen.append((own[i], run.tapered, times, ends))
    if not chosen:
        nothing = np.zeros(len(along.x))
        return nothing, nothing
    at_nodes = along.waves(np.concatenate([axis.nodes[block.nodes] for block, *_ in chosen]))
    at_least = 120 // len(at_nodes)  # the edge of a single point is easily missed
    picks, guesses, weights = [], [], []
    start = 0
    for number, (block, tapered, times, ends) in enumerate(chosen):
        # Other places in each block, the error being small near its nodes.
        count = max(_TARGETS, 16 // len(chosen), at_least)
        index, weight = _tried(block.target_count, count, 0.618 * (number + 1) % 1, ends)
        picks.append(targets[block.targets][index])
        values = at_nodes[:, start : start + block.node_count]
        start += block.node_count
        if tapered:
            values = values * along.weights(axis.nodes[block.nodes])
        guesses.append(values[:, index] if block.matrix is None else values @ block.matrix[index].T)
        weights.append(times * weight)
    exact = along.waves(np.concatenate(picks))
    first = 0
    for (_, tapered, *_), places in zip(chosen, picks, strict=True):
        if tapered:
            exact[:, first : first + len(places)] *= along.weights(places)
        first += len(places)
    weight = np.concatenate(weights)
    missed = np.abs(np.concatenate(guesses, axis=1) - exact) ** 2
    return np.abs(exact) ** 2 @ weight, missed @ weight


def _tried(
    targets: int, count: int, shift: float, ends: tuple[bool, bool]
) -> tuple[NDArray[np.intp], Floats]:
    """Some of a block's targets, and how many each stands for.

    shift : of each in its share, 0 to 1; the others are as for `finer_at_ends`
    """
    bounds = finer_at_ends(targets, count, ends)
    sizes = np.diff(bounds)
    return bounds[:-1] + (shift * sizes).astype(np.intp), sizes.astype(np.float64)


def finer_at_ends(
    targets: int, count: int, ends: tuple[bool, bool], between: bool = False
) -> NDArray[np.intp]:
    """Bounds of shares of a run of targets.

    count : of them, evenly spread
    between : smaller ones are one and a half times as large as each other by turns, not twice
    ends : which get smaller ones beside these, down to one target: where a run of nodes ends the
        error may grow a hundredfold over the last few targets
    """
    count = min(count, targets)
    cuts = {targets * i // count for i in range(count + 1)}
    steps = [2**i for i in range(targets.bit_length())]
    steps += [3 * step for step in steps] if between else []
    finer = [step for step in steps if step < targets // count]
    if ends[0]:
        cuts.update(finer)
    if ends[1]:
        cuts.update(targets - n for n in finer)
    return np.array(sorted(cuts))


def budget_of(
    factor: Factor,
    cloud: PointCloud,
    targets: tuple[Floats, Floats],
    wave: Wave,
    missed: Remainder,
    scale: float = 1.0,
) -> Budget:
    """Expected error and light of one cluster's factor.

    cloud : the points it was made from, or some of them
    targets : x and y of the pixels
    missed : what the sums at the nodes miss
    scale : power of all the points over that of the cloud
    """
    if not factor.real.size:
        return Budget(0.0, 0.0)
    apart = expected_error((factor.axis_x, factor.axis_y), cloud, targets, wave, missed)
    return together(
        Budget(scale * apart.error, scale * apart.light, scale * apart.rounding), factor
    )


def together(apart: Budget, factor: Factor) -> Budget:
    """The budget of a factor, from that of its points each for itself."""
    return replace(apart, light=min(apart.light, _powers(factor)[0]))


def expected_error(
    axes: tuple[Axis, Axis],
    cloud: PointCloud,
    targets: tuple[Floats, Floats],
    wave: Wave,
    missed: Remainder,
) -> Budget:
    """Of points each for itself, known before the baseband is."""
    reference = wave.reference
    strength = (cloud.amplitude * reference.modulus(cloud.positions[:, 2])) ** 2
    chosen, weight = sample_points(strength, cloud.positions)
    points = cloud.positions[chosen].T
    spots = [spots_of(axes[i], points[i], wave.reach[i] * points[2]) for i in range(2)]
    # Near the axis the rest varies too slowly along one axis to matter for many nodes.
    steep = np.abs(np.array(spots) - points[:2]) / points[2] > 0.05
    aslant = min(len(axis.nodes) for axis in axes) < 16 or bool(steep.any())
    light_x, miss_x = axis_powers(
        axes[0], targets[0], waves_along(wave, 0, points, spots[1] if aslant else None)
    )
    light_y, miss_y = axis_powers(
        axes[1], targets[1], waves_along(wave, 1, points, spots[0] if aslant else None)
    )
    dropped = np.full(len(chosen), missed.relative**2)
    if missed.series is not None:
        places = by_curvature(cloud.positions[chosen])
        dropped += missed.series.missed(places, reference.kernel(wave.wavelength), wave.reach)
    light = light_x * light_y
    rounding = ROUNDING**2 * light
    error = miss_x * light_y + light_x * miss_y + dropped * light + rounding
    return Budget(float(weight @ error), float(weight @ light), float(weight @ rounding))


def spots_of(axis: Axis, points: Floats, half: Floats) -> Floats:
    """(N,) the first, middle and last node by turns, for points to be looked at across.

    half : of the points' footprints, outside which a point has no light, and waves are too steep
        for the nodes
    """
    ends = np.resize(axis.nodes[[0, len(axis.nodes) // 2, -1]], len(points))
    return np.clip(ends, points - half, points + half)


def sample_points(strength: Floats, positions: Floats) -> tuple[NDArray[np.intp], Floats]:
    """Points to try, and the strength that each stands for.

    The strongest, the outermost, whose error is by far the largest, and some for all the others.
    """
    count = len(strength)
    if count <= 3 * _POINTS + _OTHERS:
        return np.arange(count), strength
    middle = bounding_box(positions).mean(axis=1)
    rank = np.stack([strength, *np.abs(positions - middle)[:, :2].T])
    other = np.ones(count, dtype=bool)
    other[np.argpartition(rank, count - _POINTS, axis=1)[:, count - _POINTS :]] = False
    special = np.flatnonzero(~other)
    rest = np.linspace(0, count - 1, _OTHERS).astype(np.intp)
    rest = rest[other[rest]]
    others = strength[rest]
    if others.any():
        others = others * (strength.sum() - strength[special].sum()) / others.sum()
    return np.concatenate([special, rest]), np.concatenate([strength[special], others])
