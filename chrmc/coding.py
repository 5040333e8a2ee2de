"""What a generator must know of an amplitude encoding: the passband it leaves and its carrier."""

from dataclasses import dataclass
from math import inf

from chrmc.slm import SLM


@dataclass(frozen=True)
class Passband:
    """Largest local spatial frequency per axis that a field may carry, cycles per metre."""

    fx_max: float
    fy_max: float


UNLIMITED = Passband(inf, inf)
"""No limit: bare spherical waves without a footprint."""


def full_band(slm: SLM) -> Passband:
    """The Nyquist band of the pixels, (1/2p, 1/2p)."""
    return Passband(slm.nyquist, slm.nyquist)


@dataclass(frozen=True)
class Coding:
    """An encoding as the generator sees it.

    name : "ssb" or "real"
    passband : what the complex field may occupy before the carrier is put on
    carrier : frequency of exp(+2πi·carrier·y), cycles per metre; 0 for none
    """

    name: str
    passband: Passband
    carrier: float


CODINGS = ("ssb", "real")


def coding_for(name: str, slm: SLM) -> Coding:
    """The coding called `name` on `slm`.

    "ssb": single sideband across the motion: |f_y| < 1/4p, carrier 1/4p in y.
    "real": the plain in-line real part, full band, no carrier.
    """
    if name == "ssb":
        return Coding("ssb", Passband(slm.nyquist, slm.nyquist / 2), slm.nyquist / 2)
    if name == "real":
        return Coding("real", full_band(slm), 0.0)
    raise ValueError(f"unknown encoding {name!r}: choose one of {', '.join(CODINGS)}")
