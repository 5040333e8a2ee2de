"""What every public door takes for a length or a count: ranges, and the likely meaning of a slip.

Lengths are metres. A value outside its range is refused with what was probably meant: 532 as a
wavelength with "532e-9 for 532 nm?". NumPy scalars of any precision become Python numbers here, so
that single precision goes no further than the value itself.
"""

import operator
from dataclasses import dataclass
from typing import Any, SupportsFloat

import numpy as np

_UNITS = (("mm", "e-3"), ("µm", "e-6"), ("nm", "e-9"))


@dataclass(frozen=True)
class Range:
    """A quantity's declared range, both ends included.

    name : in messages
    low, high : what is taken
    usual : (least, most) that people mean; a slip of units is guessed from it
    unit : "m", or "" for plain numbers
    """

    name: str
    low: float
    high: float
    usual: tuple[float, float] | None = None
    unit: str = "m"

    def of(self, value: Any) -> float:
        """The value as a Python float; ValueError when it is no number or out of range."""
        number = real(self.name, value)
        if self.low <= number <= self.high:
            return number
        unit = f" {self.unit}" if self.unit else ""
        raise ValueError(
            f"{self.name} {number:g}{unit} lies outside {self.low:g} to {self.high:g}{unit}"
            + self._meant(number)
        )

    def _meant(self, number: float) -> str:
        if self.usual is None:
            return ""
        for unit, exponent in _UNITS:
            text = f"{number:g}"
            if "e" not in text and self.usual[0] <= float(text + exponent) <= self.usual[1]:
                return f"; lengths are in metres: {text}{exponent} for {text} {unit}?"
        return "; lengths are in metres"


@dataclass(frozen=True)
class Count:
    """A whole number's declared range, both ends included."""

    name: str
    low: int
    high: int

    def of(self, value: Any) -> int:
        """The value as a Python int; ValueError when it is not whole or out of range."""
        try:
            if isinstance(value, bool | np.bool_):
                raise TypeError
            number = operator.index(value)
        except TypeError:
            raise ValueError(f"{self.name} must be a whole number, not {short(value)}") from None
        if not self.low <= number <= self.high:
            raise ValueError(
                f"{self.name} must lie between {self.low} and {self.high}, not {short(number)}"
            )
        return number


def real(name: str, value: Any) -> float:
    """A finite real number as a Python float; ValueError otherwise."""
    plain = isinstance(value, SupportsFloat) and not isinstance(value, str | bytes | bool)
    try:
        if not plain or np.ndim(value) or np.iscomplexobj(value):
            raise TypeError
        number = float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be a number, not {short(value)}") from None
    except OverflowError:
        number = np.inf
    if not np.isfinite(number):
        raise ValueError(f"{name} must be a finite number, not {short(value)}")
    return number


def short(value: Any) -> str:
    """A value for a message: at most 60 characters on one line."""
    text = " ".join(repr(value.item() if isinstance(value, np.generic) else value).split())
    return text if len(text) <= 60 else text[:57] + "…"


WAVELENGTH_RANGE = Range("wavelength", 1e-8, 1e-3, (150e-9, 20e-6))
PITCH_RANGE = Range("pixel_pitch", 1e-8, 1e-2, (0.2e-6, 1e-3))
DISTANCE_RANGE = Range("distance", 1e-6, 200.0, (1e-3, 10.0))
"""From the hologram plane to a point or to a focus."""
TOLERANCE_RANGE = Range("tolerance", 1e-15, 0.999999, unit="")
REFRESH_RANGE = Range("refresh", 1e-3, 1e6, unit="Hz")
FILL_RANGE = Range("fill_factor", 1e-6, 1.0, unit="")
SIDE = Count("SLM side in pixels", 1, 65_536)
PIXELS = Count("SLM pixels in all", 1, 1 << 30)
BITS = Count("bits", 1, 16)
