"""Reading a wave of limited bandwidth off the few nearest places of an even grid.

The weights of least expected square error solve K·w = k with the covariance J0(2πFτ) (see
`chrmc.cgh.curved.band`); they are tabulated once over the fraction of a step.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import j0

Floats = NDArray[np.float64]

_ROWS = 1024  # of the table; between them weights are interpolated linearly: 5e-7
_BEYOND = 1.25  # of the band's end, up to which errors are known


@dataclass(frozen=True, eq=False)
class Taps:
    """Weights of neighbours on an even grid.

    count : neighbours used, half on either side
    oversampling : grid places for each that Nyquist asks for
    table : (rows + 1, count) weights at fractions 0 … 1 of a step
    errors : rms errors at frequencies 0 … 1.25 of the band's end
    """

    count: int
    oversampling: float
    table: NDArray[np.float32]
    errors: Floats

    def step(self, bandwidth: float) -> float:
        """Distance of places for frequencies up to `bandwidth`, in cycles per unit."""
        return 1 / (2 * max(bandwidth, 1e-9) * self.oversampling)

    def rms_error(self, frequency: Floats, bandwidth: float) -> Floats:
        """Relative rms error of waves of some frequencies on a grid for `bandwidth`."""
        at = np.abs(frequency) / max(bandwidth, 1e-9)
        known = np.linspace(0, _BEYOND, len(self.errors))
        return np.where(at <= _BEYOND, np.interp(at, known, self.errors), 1.0)

    def weights(self, place: Floats) -> tuple[NDArray[np.intp], NDArray[np.float32]]:
        """First neighbour (n,) and weights (n, count) at places in steps of the grid."""
        whole = np.floor(place)
        row = (place - whole) * (len(self.table) - 1)
        below = np.minimum(row.astype(np.intp), len(self.table) - 2)
        part = (row - below).astype(np.float32)[..., None]
        weight = np.take(self.table, below, axis=0)
        more = np.take(self.table, below + 1, axis=0)
        more -= weight
        more *= part
        weight += more
        return whole.astype(np.intp) - (self.count // 2 - 1), weight

    def matrix(self, place: Floats, count: int) -> Floats:
        """(n, count) from the values on a grid of `count` places to some between them."""
        first, weight = self.weights(place)
        out = np.zeros((len(place), count))
        np.put_along_axis(out, first[:, None] + np.arange(self.count), weight, axis=1)
        return out


def _solve(count: int, frequency: float, at: Floats, nugget: float) -> Floats:
    places = np.arange(count) - (count // 2 - 1.0)
    among = j0(2 * np.pi * frequency * (places[:, None] - places))
    among[np.diag_indices(count)] += nugget**2
    solved = np.linalg.solve(among, j0(2 * np.pi * frequency * (places[:, None] - at))).T
    return np.asarray(solved, dtype=np.float64)


def _errors(count: int, frequency: float, nugget: float) -> Floats:
    at = np.linspace(0.02, 0.98, 25)
    weight = _solve(count, frequency, at, nugget)
    places = np.arange(count) - (count // 2 - 1.0)
    waves = 2j * np.pi * frequency * np.linspace(0, _BEYOND, 51)[:, None]
    missed = np.exp(waves * at) - np.exp(waves * places) @ weight.T
    return np.asarray(np.sqrt(np.mean(np.abs(missed) ** 2, axis=1)))


@lru_cache(maxsize=64)
def taps_for(tolerance: float) -> Taps:
    """Neighbours and grid that read all frequencies up to the band's end at this rms error."""
    count = next(
        n for n, least in ((6, 4e-3), (8, 1e-3), (10, 1e-4), (14, 0.0)) if tolerance >= least
    )
    nugget = 0.1 * tolerance
    sparse, dense = 1.05, 6.0
    for _ in range(20):
        middle = (sparse + dense) / 2
        inside = _errors(count, 1 / (2 * middle), nugget)[:41]
        sparse, dense = (middle, dense) if inside.max() > tolerance else (sparse, middle)
    frequency = 1 / (2 * dense)
    table = _solve(count, frequency, np.linspace(0, 1, _ROWS + 1), nugget).astype(np.float32)
    table.flags.writeable = False
    return Taps(count, dense, table, _errors(count, frequency, nugget))
