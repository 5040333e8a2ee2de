"""What error a factor will have, before a single pixel is computed.

Interpolation along x and along y is tried out on a few of the cluster's points, one axis at a
time, at a few targets of each panel; the series' left-out terms are known; rounding was measured.
Errors of points with unrelated phases add in power. The light they are relative to is read from
the baseband at the nodes.
"""

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.assembly import Factor
from chrmc.cgh.curved.nodes import Axis, chebyshev
from chrmc.cgh.curved.tables import Series, axis_cycles, phasors, residual
from chrmc.footprint import taper
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]

_POINTS = 24  # points that are tried
_TARGETS = 5  # targets of each panel that are tried
ROUNDING = 5e-7
"""Relative error that single-precision products and pixels leave."""


@dataclass(frozen=True)
class Budget:
    """Powers summed over targets: of the expected error, and of the light itself."""

    error: float
    light: float

    def __add__(self, other: "Budget") -> "Budget":
        return Budget(self.error + other.error, self.light + other.light)

    @property
    def relative(self) -> float:
        """Expected relative L2 error."""
        if self.light <= 0:
            return 0.0 if self.error <= 0 else float("inf")
        return sqrt(self.error / self.light)


def axis_powers(
    axis: Axis,
    targets: Floats,
    x: Floats,
    z: Floats,
    centre: float,
    z_centre: float,
    across: Floats,
    wavelength: float,
    reach: float,
) -> tuple[Floats, Floats]:
    """(N,) power of each point along one axis, and of its interpolation error, over targets.

    across : (N,) each point's distance, along the other axis, from the line that is tried
    """

    def wave(t: Floats) -> NDArray[np.complex128]:
        cycles = axis_cycles(t, x, z, centre, z_centre, wavelength)
        out = phasors(2 * pi * (cycles - np.rint(cycles)))
        out *= residual(t - x[:, None], across[:, None], z[:, None], wavelength)
        if np.isfinite(reach):
            out *= taper(t - x[:, None], (z * reach)[:, None])
        return out

    at_nodes = wave(axis.nodes)
    # A low-discrepancy choice of targets: fractions of the golden section.
    picks, guesses, shares = [], [], []
    for panel in axis.panels:
        n = min(_TARGETS, panel.target_count)
        index = ((np.arange(n) + 0.618) / n * panel.target_count).astype(np.intp)
        index = np.minimum(index, panel.target_count - 1)
        picks.append(targets[panel.targets][index])
        values = at_nodes[:, panel.nodes]
        guesses.append(values[:, index] if panel.matrix is None else values @ panel.matrix[index].T)
        shares.append(np.full(n, panel.target_count / n))
    exact = wave(np.concatenate(picks))
    share = np.concatenate(shares)
    missed = np.abs(np.concatenate(guesses, axis=1) - exact) ** 2
    return np.abs(exact) ** 2 @ share, missed @ share


def light_of(factor: Factor) -> float:
    """Σ|field|² over the targets, from the baseband: Gauss–Chebyshev weights on each panel."""
    weights = []
    for axis in (factor.axis_y, factor.axis_x):
        parts = [
            np.ones(p.node_count)
            if p.matrix is None
            else pi / 2 / p.node_count * p.target_count * np.sqrt(1 - chebyshev(p.node_count) ** 2)
            for p in axis.panels
        ]
        weights.append(np.concatenate(parts) if parts else np.zeros(0))
    power = factor.real.astype(np.float64) ** 2 + factor.imag.astype(np.float64) ** 2
    return float(weights[0] @ power @ weights[1])


def budget_of(
    factor: Factor,
    cloud: PointCloud,
    targets: tuple[Floats, Floats],
    wavelength: float,
    reach: tuple[float, float],
    series: Series | float,
) -> Budget:
    """Expected error and light of one cluster's factor.

    cloud : the points it was made from
    targets : x and y of the pixels
    series : the series in use, or the relative rms that several of them leave out
    """
    if not factor.real.size:
        return Budget(0.0, 0.0)
    strength = (cloud.amplitude / cloud.positions[:, 2]) ** 2
    chosen, share = _sample(strength)
    x, y, z = cloud.positions[chosen].T
    its = factor.reference
    light_x, miss_x = axis_powers(
        factor.axis_x,
        targets[0],
        x,
        z,
        its.x,
        its.z,
        _lines(factor.axis_y, y),
        wavelength,
        reach[0],
    )
    light_y, miss_y = axis_powers(
        factor.axis_y,
        targets[1],
        y,
        z,
        its.y,
        its.z,
        _lines(factor.axis_x, x),
        wavelength,
        reach[1],
    )
    if isinstance(series, Series):
        dropped = series.missed(cloud.positions[chosen], wavelength, reach)
    else:
        dropped = np.full(len(chosen), series**2)
    error = miss_x * light_y + light_x * miss_y + (dropped + ROUNDING**2) * light_x * light_y
    return Budget(float(share @ error), light_of(factor))


def _lines(axis: Axis, x: Floats) -> Floats:
    """(N,) distances to the first, middle and last node by turns."""
    lines = axis.nodes[[0, len(axis.nodes) // 2, -1]]
    return np.resize(lines, len(x)) - x


def _sample(strength: Floats) -> tuple[NDArray[np.intp], Floats]:
    """Points to try, and the strength that each stands for: the strongest, and some others."""
    count = len(strength)
    if count <= _POINTS:
        return np.arange(count), strength
    strongest = np.argpartition(strength, count - _POINTS // 2)[count - _POINTS // 2 :]
    rest = np.setdiff1d(np.linspace(0, count - 1, _POINTS // 2).astype(np.intp), strongest)
    share = strength[rest]
    if share.any():
        share = share * (strength.sum() - strength[strongest].sum()) / share.sum()
    return np.concatenate([strongest, rest]), np.concatenate([strength[strongest], share])
