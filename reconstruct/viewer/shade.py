"""How complex values become colours; the window's shader does the same on the graphics card."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MODES = ("intensity", "log", "phase")
TINTS = ("grey", "green", "heat")
DECADES = 4.0
"""Range of the logarithmic mode below white."""


@dataclass
class Look:
    """mode : one of MODES; tint : one of TINTS; gamma : of intensity mode; stops : exposure, as
    powers of two against the automatic one."""

    mode: str = "intensity"
    tint: str = "grey"
    gamma: float = 2.2
    stops: float = 0.0


def shade(field: NDArray[np.complexfloating], white: float, look: Look) -> NDArray[np.uint8]:
    """(h, w, 3) colours.

    white : intensity shown as white before `stops`
    Phase is a hue, as bright as the amplitude; 0 is red, +2π/3 green, −2π/3 blue.
    """
    light = (field.real**2 + field.imag**2) / max(white * 2.0**-look.stops, 1e-30)
    if look.mode == "log":
        level = 1 + np.log10(np.maximum(light, 1e-30)) / DECADES
    else:
        level = light ** (1 / look.gamma)
    level = np.clip(level, 0, 1)
    if look.mode == "phase":
        turn = np.angle(field) / (2 * np.pi)
        hue = np.stack([turn, turn - 1 / 3, turn + 1 / 3], axis=-1)
        part = np.clip(2 - np.abs(6 * (hue - np.rint(hue))), 0, 1)
        colour = part * np.sqrt(level)[..., None]
    else:
        colour = tinted(level, look.tint)
    return np.rint(255 * colour).astype(np.uint8)


def tinted(level: NDArray[np.floating], tint: str) -> NDArray[np.floating]:
    """(h, w, 3) in 0 … 1 of levels in 0 … 1."""
    if tint == "green":  # towards 532 nm, white where it is brightest
        return np.stack([level**3 * 0.85, level, level**3 * 0.6], axis=-1)
    if tint == "heat":
        return np.stack(
            [np.clip(2.2 * level, 0, 1), level**1.6, np.clip(1.8 * level - 0.9, 0, 1)], axis=-1
        )
    return np.repeat(np.asarray(level)[..., None], 3, axis=-1)
