"""Which objects are too dim beside the others to be judged, as the scene has them.

A hologram of 8 bits has noise, and light of other objects, out of focus, lies over an object that
stands before or behind them. How much of either is to be expected follows from the scene alone, so
an object that is missing from the picture is not excused.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from chrmc.optics.footprint import reach
from reconstruct.four_f_system import FourF
from reconstruct.target import Target

DIM = 0.003
"""Share of the frame's light below which an object is not judged: right pictures failed from 0.001
down."""
OUTSHONE = 0.6
"""Share of the light where it stands: right pictures failed from 0.56 down, and passed at 0.72."""


@dataclass(frozen=True)
class Shares:
    """An object's light as the scene has it.

    whole : of the frame's light; own : of the light where it stands; 1 where nothing is known
    """

    whole: float = 1.0
    own: float = 1.0

    @property
    def too_little(self) -> str:
        """Why it cannot be judged, in words; "" where it can."""
        if self.whole < DIM:
            return f"it has {self.whole:.1g} of the light"
        if self.own < OUTSHONE:
            return f"others have {1 - self.own:.0%} of the light where it stands"
        return ""


NOTHING = Shares()
"""Of an object of which the video tells no light."""


def shares_of(targets: Sequence[Target], system: FourF) -> list[Shares]:
    """Of each target; of all of them or of none."""
    powers = [target.power for target in targets]
    known = [power for power in powers if power is not None]
    total = sum(known)
    if len(known) < len(targets) or not total > 0:
        return [NOTHING] * len(targets)
    out = []
    for target, power in zip(targets, known, strict=True):
        others = sum(
            other_power * _over(other, target, system)
            for other, other_power in zip(targets, known, strict=True)
            if other is not target
        )
        own = power / (power + others) if power > 0 else 0.0
        out.append(Shares(power / total, own))
    return out


def _over(other: Target, target: Target, system: FourF) -> float:
    """Share of another's light that lies where a target stands, spread evenly over its box as wide
    as it is out of focus there."""
    away = abs(float(other.position[2] - target.position[2]))
    share = 1.0
    slm, band = system.slm, system.band
    for axis, (count, f_max) in enumerate(((slm.width, band.fx_max), (slm.height, band.fy_max))):
        widest = count * slm.pixel_pitch / 2 / float(other.position[2])
        blur = away * min(reach(system.wavelength, f_max), widest) + slm.pixel_pitch
        low, high = other.low[axis] - blur, other.high[axis] + blur
        inside = min(high, target.high[axis]) - max(low, target.low[axis])
        share *= float(np.clip(inside / (high - low), 0, 1))
    return share
