"""A cloud of coherent point sources: what every hologram here is computed from."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from chrmc.ranges import short

if TYPE_CHECKING:
    from pathlib import Path

    from chrmc.slm import SLM


def numbers(
    name: str, values: ArrayLike, shape: tuple[int, ...] | None = None
) -> NDArray[np.float64]:
    """Values as a float64 array; ValueError unless real, finite, and of the shape if one is given.

    An array that is float64 already is taken as it is, not copied.
    """
    try:
        plain = np.asarray(values)
        if plain.dtype.kind not in "fiub":
            raise TypeError
        array = plain.astype(np.float64, copy=False)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be an array of real numbers, not {short(values)}") from None
    if shape is not None and array.shape != shape:
        raise ValueError(f"{name} must be {shape}, not {array.shape}")
    bad = np.count_nonzero(~np.isfinite(array))
    if bad:
        raise ValueError(f"{name}: {bad} values are NaN or infinite; all must be finite")
    return array


MANY_TURNS = 1e6
"""Radians beyond which phases are taken modulo a turn."""
BRIGHTEST = 1e30
"""Of amplitudes: what they make on the hologram, and its square, must stay a number."""
FARTHEST = 1e12
"""Metres that a position may hold, be it a renderer's background; far beyond what can be shown."""


@dataclass(frozen=True, eq=False, repr=False)
class PointCloud:
    """Points of light.

    positions : (N, 3) metres, x right, y down, z > 0 in front of the hologram
    amplitude : (N,) at 1 m distance, so a point's wave is amplitude/r·exp(i(kr + phase))
    phase : (N,) radians
    colour : (N, 3) linear sRGB of the light, relative to white (1, 1, 1), or None for white:
        lasers of several wavelengths share a point's light by it (`chrmc.scene.light`)

    The arrays are converted to float64 and must be finite.
    """

    positions: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    phase: NDArray[np.float64]
    colour: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        positions = numbers("positions", self.positions)
        if positions.size == 0:
            positions = positions.reshape(0, 3)
        if positions.ndim != 2 or positions.shape[1] != 3:
            raise ValueError(f"positions must be (N, 3), not {positions.shape}")
        if positions.size and np.abs(positions).max() > FARTHEST:
            raise ValueError(
                f"positions reach {np.abs(positions).max():.3g} m; they are metres, at most "
                f"{FARTHEST:g}"
            )
        object.__setattr__(self, "positions", positions)
        for name in ("amplitude", "phase"):
            values = numbers(name, getattr(self, name)).reshape(-1)
            if len(values) != len(positions):
                raise ValueError(f"{len(positions)} positions but {len(values)} values of {name}")
            object.__setattr__(self, name, values)
        brightest = float(np.abs(self.amplitude).max(initial=0))
        if brightest > BRIGHTEST:
            raise ValueError(
                f"amplitudes reach {brightest:.3g}; single precision holds them up to "
                f"{BRIGHTEST:g}: scale the amplitudes"
            )
        if len(self.phase) and np.abs(self.phase).max() > MANY_TURNS:
            # Else the sum with k·r would lose what is left of a turn.
            turned = np.arctan2(np.sin(self.phase), np.cos(self.phase))
            object.__setattr__(self, "phase", turned)
        if self.colour is not None:
            colour = numbers("colour", self.colour, (len(positions), 3))
            if colour.size and colour.min() < 0:
                raise ValueError(f"colour must not be negative, as {colour.min():.3g} is")
            object.__setattr__(self, "colour", colour)

    def __repr__(self) -> str:
        if len(self) == 0:
            return "PointCloud(no points)"
        low, high = 1e3 * self.positions.min(axis=0), 1e3 * self.positions.max(axis=0)
        sides = (f"{axis} {a:.4g}…{b:.4g}" for axis, a, b in zip("xyz", low, high, strict=True))
        return f"PointCloud({len(self)} points, {', '.join(sides)} mm)"

    def __len__(self) -> int:
        return len(self.positions)

    @classmethod
    def from_file(
        cls, path: "str | Path", fit: "SLM | None" = None, points: int | None = None
    ) -> "PointCloud":
        """The points of a mesh, a cloud or a picture, as seen in its first frame.

        fit : the SLM in front of which it is scaled and placed, 250 mm away; None leaves a
            cloud's positions as they are in the file, in metres, and places others for the
            LC-R 1080
        points : on the whole surface of a mesh, default what the SLM resolves
        """
        from chrmc.scene.sources.files import cloud_from_file

        return cloud_from_file(path, fit, points)

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
        colour = None
        if any(c.colour is not None for c in parts):
            colour = np.concatenate(
                [np.ones((len(c), 3)) if c.colour is None else c.colour for c in parts]
            )
        return cls(
            np.concatenate([c.positions for c in parts]),
            np.concatenate([c.amplitude for c in parts]),
            np.concatenate([c.phase for c in parts]),
            colour,
        )

    def select(self, index: NDArray[np.bool_] | NDArray[np.intp] | slice) -> "PointCloud":
        """The points that a mask, index array or slice picks."""
        colour = None if self.colour is None else self.colour[index]
        return PointCloud(self.positions[index], self.amplitude[index], self.phase[index], colour)

    def same_as(self, other: "PointCloud") -> bool:
        """Equal in every number, in the same order."""
        return self is other or (
            np.array_equal(self.positions, other.positions)
            and np.array_equal(self.amplitude, other.amplitude)
            and np.array_equal(self.phase, other.phase)
        )

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
