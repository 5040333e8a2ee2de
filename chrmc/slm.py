"""The spatial light modulator: its grid, what it can diffract, and the preset of the paper."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

WAVELENGTH = 532e-9
"""Default wavelength in metres: the green laser of the CH-RMC paper."""


@dataclass(frozen=True)
class SLM:
    """A pixelated modulator in the plane z = 0, centred on the origin.

    Row index grows with +y (down), column index with +x (right); pixel centres are at
    x = (column − (width − 1)/2)·pixel_pitch, and likewise y.

    name : what messages and manifests call it
    width, height : pixels
    pixel_pitch : metres
    bits : grey-level depth of the panel
    refresh : frames per second the panel is driven at
    fill_factor : active share of a pixel's area, 0 < fill_factor ≤ 1
    """

    name: str
    width: int
    height: int
    pixel_pitch: float
    bits: int = 8
    refresh: float = 60.0
    fill_factor: float = 1.0

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise ValueError(
                f"an SLM needs at least 1 × 1 pixels, not {self.width} × {self.height}"
            )
        if not (np.isfinite(self.pixel_pitch) and self.pixel_pitch > 0):
            raise ValueError(f"pixel_pitch must be a positive length, not {self.pixel_pitch} m")
        if not 0 < self.fill_factor <= 1:
            raise ValueError(f"fill_factor must lie in (0, 1], not {self.fill_factor}")

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns)."""
        return self.height, self.width

    @property
    def nyquist(self) -> float:
        """Highest frequency the pixels can show, 1/(2·pixel_pitch), cycles per metre."""
        return 0.5 / self.pixel_pitch

    def x(self, columns: ArrayLike | None = None) -> NDArray[np.float64]:
        """Centres of the given columns (default all), metres, float64."""
        index = np.asarray(np.arange(self.width) if columns is None else columns, dtype=np.float64)
        return (index - (self.width - 1) / 2) * self.pixel_pitch

    def y(self, rows: ArrayLike | None = None) -> NDArray[np.float64]:
        """Centres of the given rows (default all), metres, float64."""
        index = np.asarray(np.arange(self.height) if rows is None else rows, dtype=np.float64)
        return (index - (self.height - 1) / 2) * self.pixel_pitch


LC_R_1080 = SLM("HOLOEYE LC-R 1080", width=1920, height=1200, pixel_pitch=8.1e-6)
"""The reflective amplitude SLM of the paper: 1920 × 1200 pixels of 8.1 µm, 8 bit."""
