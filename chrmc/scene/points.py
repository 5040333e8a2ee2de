"""A cloud of coherent point sources: what every hologram here is computed from."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Points of light.

    positions : (N, 3) metres, x right, y down, z > 0 in front of the hologram
    amplitude : (N,) at 1 m distance, so a point's wave is amplitude/r·exp(i(kr + phase))
    phase : (N,) radians

    The arrays are converted to float64 and must be finite.
    """

    positions: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    phase: NDArray[np.float64]

    def __post_init__(self) -> None:
        positions = np.asarray(self.positions, dtype=np.float64)
        if positions.size == 0:
            positions = positions.reshape(0, 3)
        amplitude = np.asarray(self.amplitude, dtype=np.float64).reshape(-1)
        phase = np.asarray(self.phase, dtype=np.float64).reshape(-1)
        if positions.ndim != 2 or positions.shape[1] != 3:
            raise ValueError(f"positions must be (N, 3), not {positions.shape}")
        for name, values in (("amplitude", amplitude), ("phase", phase)):
            if len(values) != len(positions):
                raise ValueError(f"{len(positions)} positions but {len(values)} values of {name}")
        for name, values in (("positions", positions), ("amplitude", amplitude), ("phase", phase)):
            bad = np.count_nonzero(~np.isfinite(values))
            if bad:
                raise ValueError(f"{name}: {bad} values are NaN or infinite; all must be finite")
        object.__setattr__(self, "positions", positions)
        object.__setattr__(self, "amplitude", amplitude)
        object.__setattr__(self, "phase", phase)

    def __len__(self) -> int:
        return len(self.positions)

    @classmethod
    def empty(cls) -> "PointCloud":
        """A cloud of no points."""
        return cls(np.zeros((0, 3)), np.zeros(0), np.zeros(0))

    @classmethod
    def concatenate(cls, clouds: Iterable["PointCloud"]) -> "PointCloud":
        """All points of several clouds, in order."""
        parts = list(clouds)
        if not parts:
            return cls.empty()
        return cls(
            np.concatenate([c.positions for c in parts]),
            np.concatenate([c.amplitude for c in parts]),
            np.concatenate([c.phase for c in parts]),
        )

    def select(self, index: NDArray[np.bool_] | NDArray[np.intp] | slice) -> "PointCloud":
        """The points that a mask, index array or slice picks."""
        return PointCloud(self.positions[index], self.amplitude[index], self.phase[index])

    @property
    def intensity(self) -> NDArray[np.float64]:
        """(N,) amplitude²."""
        return self.amplitude**2

    @property
    def centroid(self) -> NDArray[np.float64]:
        """(3,) intensity-weighted mean position, metres; NaN for no light."""
        total = self.intensity.sum()
        if not total > 0:
            return np.full(3, np.nan)
        return self.intensity @ self.positions / total
