"""The spatial light modulator: its grid, what it can diffract, and the preset of the paper."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from chrmc.ranges import BITS, FILL_RANGE, PITCH_RANGE, PIXELS, REFRESH_RANGE, SIDE, short

KINDS = ("amplitude", "binary", "phase")
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
    kind : what a pixel does to light, one of KINDS: dims it, lets it through or not (1 bit), or
        shifts its phase; None where nobody said, and then every encoding is taken
    """

    name: str
    width: int
    height: int
    pixel_pitch: float
    bits: int = 8
    refresh: float = 60.0
    fill_factor: float = 1.0
    kind: str | None = None

    def __post_init__(self) -> None:
        checked: dict[str, int | float] = {
            "width": SIDE.of(self.width),
            "height": SIDE.of(self.height),
            "pixel_pitch": PITCH_RANGE.of(self.pixel_pitch),
            "bits": BITS.of(self.bits),
            "refresh": REFRESH_RANGE.of(self.refresh),
            "fill_factor": FILL_RANGE.of(self.fill_factor),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        PIXELS.of(self.width * self.height)
        if self.kind is not None and self.kind not in KINDS:
            raise ValueError(f"kind is {', '.join(KINDS)}, not {short(self.kind)}")
        if self.kind == "binary" and self.bits != 1:
            raise ValueError(f"a binary panel has 1 bit, not {self.bits}")

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


LC_R_1080 = SLM("HOLOEYE LC-R 1080", width=1920, height=1200, pixel_pitch=8.1e-6, kind="amplitude")
"""The reflective amplitude SLM of the paper: 1920 × 1200 pixels of 8.1 µm, 8 bit."""
