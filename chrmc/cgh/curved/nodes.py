"""Chebyshev nodes on panels of an axis, and the matrices that interpolate from them.

A baseband whose local frequency stays below f over a panel of length D needs
n = κ + a·κ^(1/3) Chebyshev nodes there, κ = π·f·D; a grows by 0.93 with each decimal digit.
Several short panels need a few more nodes in all than one long one, but each target then
depends on the nodes of its own panel alone, which makes the two GEMMs several times smaller.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import ceil, hypot, log10, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.footprint import SOFT_SHARE

Floats = NDArray[np.float64]
_TAPER = 1.2  # measured: twice as much lowers no error, half as much doubles it


@lru_cache(maxsize=256)
def chebyshev(count: int) -> Floats:
    """(count,) Chebyshev nodes of the first kind on [−1, 1], ascending. Read-only."""
    nodes = -np.cos(pi * (np.arange(count) + 0.5) / count)
    nodes.flags.writeable = False
    return nodes


def interpolation(count: int, targets: Floats) -> Floats:
    """(len(targets), count) matrix from values at `chebyshev(count)` to targets in [−1, 1].

    Second (true) barycentric form: Berrut and Trefethen, SIAM Review 46, 501 (2004).
    """
    index = np.arange(count)
    weights = (-1.0) ** index * np.sin(pi * (index + 0.5) / count)
    gap = np.asarray(targets, dtype=np.float64)[:, None] - chebyshev(count)
    exact = np.abs(gap) < 1e-15
    terms = weights / np.where(exact, 1.0, gap)
    matrix = terms / terms.sum(axis=1, keepdims=True)
    on_node = exact.any(axis=1)
    matrix[on_node] = exact[on_node]
    return matrix


@lru_cache(maxsize=512)
def pixel_interpolation(count: int, pixels: int) -> Floats:
    """(pixels, count) matrix to the centres of `pixels` equal cells of [−1, 1]. Read-only."""
    matrix = interpolation(count, (2 * np.arange(pixels) + 1 - pixels) / pixels)
    matrix.flags.writeable = False
    return matrix


def node_count(kappa: float, tolerance: float) -> int:
    """Nodes for exp(iκu), |κ| ≤ kappa, on [−1, 1] at an rms error of `tolerance`."""
    digits = max(1.0, -log10(tolerance))
    return max(1, ceil(kappa + (0.93 * digits - 0.35) * max(kappa, 3.0) ** (1 / 3)))


def taper_frequency(half_width: float, tolerance: float) -> float:
    """Extra bandwidth, cycles per metre, that resolves a cos² edge to `tolerance`.

    The edge has a jump in its second derivative: its spectrum falls as f⁻³, so the energy left
    out beyond f falls as f⁻⁵ and the frequency needed grows as tolerance^(−2/5), here with a
    margin for where panels happen to end.
    """
    return _TAPER * (1e-3 / tolerance) ** 0.45 / (SOFT_SHARE * half_width)


@dataclass(frozen=True, eq=False)
class Panel:
    """A run of targets interpolated from a run of nodes.

    targets, nodes : slices
    matrix : (targets, nodes), or None where the nodes are the targets themselves
    tapered : a footprint ends in it
    """

    targets: slice
    nodes: slice
    matrix: Floats | None
    tapered: bool

    @property
    def target_count(self) -> int:
        return int(self.targets.stop - self.targets.start)

    @property
    def node_count(self) -> int:
        return int(self.nodes.stop - self.nodes.start)


@dataclass(frozen=True, eq=False)
class Axis:
    """The nodes of a cluster along x or y.

    nodes : (n,) metres, ascending
    panels : in order; targets outside all of them see none of the cluster's light
    """

    nodes: Floats
    panels: tuple[Panel, ...]

    @property
    def targets(self) -> slice:
        """From the first panel's first target to the last panel's last."""
        if not self.panels:
            return slice(0, 0)
        return slice(self.panels[0].targets.start, self.panels[-1].targets.stop)

    @property
    def widest(self) -> int:
        """Nodes of the largest panel."""
        return max((p.node_count for p in self.panels), default=0)


def part_of(axis: Axis, tapered: bool) -> tuple[Axis, NDArray[np.intp]]:
    """The panels in which a footprint ends, or the others, and their nodes' places in `axis`."""
    panels: list[Panel] = []
    places: list[NDArray[np.intp]] = [np.zeros(0, dtype=np.intp)]
    count = 0
    for panel in axis.panels:
        if panel.tapered == tapered:
            nodes = slice(count, count + panel.node_count)
            panels.append(Panel(panel.targets, nodes, panel.matrix, tapered))
            places.append(np.arange(panel.nodes.start, panel.nodes.stop))
            count = nodes.stop
    place = np.concatenate(places)
    return Axis(axis.nodes[place], tuple(panels)), place


@dataclass(frozen=True)
class Extent:
    """A cluster along one axis: lateral and depth range, reference centre, farthest offset across.

    across : largest distance of a target from a point along the other axis, metres
    """

    low: float
    high: float
    z_low: float
    z_high: float
    centre: float
    z_centre: float
    across: float


def local_frequency(targets: Iterable[float], extent: Extent, wavelength: float) -> float:
    """Largest |∂phase/∂t|/2π at targets t, of a wave in the extent against the reference."""
    largest = 0.0
    for t in targets:
        own = t - extent.centre
        reference = own / hypot(own, extent.z_centre)
        for x in (extent.low, extent.high):
            for z in (extent.z_low, extent.z_high):
                for across in (0.0, extent.across):
                    sine = (t - x) / sqrt((t - x) ** 2 + across**2 + z**2)
                    largest = max(largest, abs(sine - reference))
    return largest / wavelength


def make_axis(
    targets: Floats,
    pitch: float | None,
    x: Floats,
    z: Floats,
    extent: Extent,
    wavelength: float,
    reach: float,
    tolerance: float,
    panel_kappa: float,
) -> Axis:
    """Nodes and panels of a cluster's baseband along one axis.

    targets : (T,) ascending, metres
    pitch : spacing of equally spaced targets, else None
    x, z : (N,) the points' coordinate on this axis and depth
    reach : footprint half-width per depth, inf for none
    panel_kappa : κ that a panel should have, about
    """
    if np.isfinite(reach):
        half = z * reach
        low, flat_low = float(np.min(x - half)), float(np.max(x - (1 - SOFT_SHARE) * half))
        high, flat_high = float(np.max(x + half)), float(np.min(x + (1 - SOFT_SHARE) * half))
        edge = taper_frequency(float(half.min()), tolerance)
        first, last = np.searchsorted(targets, low, "right"), np.searchsorted(targets, high, "left")
        if flat_low < flat_high:
            a, b = np.clip(np.searchsorted(targets, [flat_low, flat_high]), first, last)
            parts = [(first, a, True), (a, b, False), (b, last, True)]
        else:
            parts = [(first, last, True)]
    else:
        edge = 0.0
        parts = [(0, len(targets), False)]
    nodes: list[Floats] = []
    panels: list[Panel] = []
    count = 0
    for start, stop, tapered in parts:
        if stop <= start:
            continue
        low, high = float(targets[start]), float(targets[stop - 1])
        span = (low, (low + high) / 2, high)
        frequency = local_frequency(span, extent, wavelength) + (edge if tapered else 0.0)
        length = high - low + (pitch or 0.0)
        pieces = max(1, min(stop - start, round(pi * frequency * length / panel_kappa)))
        # Where the pixels are no finer than the nodes would be, they are the nodes.
        if node_count(pi * frequency * length / pieces, tolerance) * pieces >= stop - start:
            pieces = 1
        cuts = np.linspace(start, stop, pieces + 1).round().astype(int)
        for c0, c1 in pairwise(cuts):
            here, matrix = _panel(targets[c0:c1], pitch, frequency, tolerance)
            panels.append(
                Panel(slice(c0, c1), slice(count, count + len(here)), matrix, bool(tapered))
            )
            nodes.append(here)
            count += len(here)
    return Axis(np.concatenate(nodes) if nodes else np.zeros(0), tuple(panels))


def _panel(
    targets: Floats, pitch: float | None, frequency: float, tolerance: float
) -> tuple[Floats, Floats | None]:
    margin = 0.0 if pitch is None else pitch / 2
    low, high = targets[0] - margin, targets[-1] + margin
    n = node_count(pi * frequency * (high - low), tolerance)
    if n >= len(targets):
        return targets, None
    nodes = (low + high) / 2 + (high - low) / 2 * chebyshev(n)
    if pitch is not None:
        return nodes, pixel_interpolation(n, len(targets))
    return nodes, interpolation(n, (2 * targets - low - high) / (high - low))
