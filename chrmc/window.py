"""A rectangle of SLM pixels: the part of a hologram that a method is asked to compute."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chrmc.slm import SLM


@dataclass(frozen=True)
class Window:
    """Rows row0 … row1 − 1 and columns column0 … column1 − 1 of an SLM."""

    row0: int
    row1: int
    column0: int
    column1: int

    def __post_init__(self) -> None:
        if not (0 <= self.row0 <= self.row1 and 0 <= self.column0 <= self.column1):
            raise ValueError(
                f"window rows {self.row0}:{self.row1}, columns {self.column0}:{self.column1} "
                "must not be negative or reversed"
            )

    @classmethod
    def full(cls, slm: SLM) -> "Window":
        """The whole SLM."""
        return cls(0, slm.height, 0, slm.width)

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns) in the window."""
        return self.row1 - self.row0, self.column1 - self.column0

    @property
    def size(self) -> int:
        """Number of pixels."""
        return self.shape[0] * self.shape[1]

    @property
    def rows(self) -> NDArray[np.intp]:
        """Row indices on the SLM."""
        return np.arange(self.row0, self.row1)

    @property
    def columns(self) -> NDArray[np.intp]:
        """Column indices on the SLM."""
        return np.arange(self.column0, self.column1)

    @property
    def slices(self) -> tuple[slice, slice]:
        """Index of the window in an (H, W) array of the SLM."""
        return slice(self.row0, self.row1), slice(self.column0, self.column1)

    def check(self, slm: SLM) -> "Window":
        """Itself, or ValueError when it reaches past the SLM."""
        if self.row1 > slm.height or self.column1 > slm.width:
            raise ValueError(
                f"window up to row {self.row1}, column {self.column1} reaches past the "
                f"{slm.width} × {slm.height} pixels of {slm.name}"
            )
        return self
