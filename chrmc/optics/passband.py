"""The spatial frequencies that a field may occupy."""

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
