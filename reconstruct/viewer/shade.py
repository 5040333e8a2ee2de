"""How complex values become colours; the window's shader does the same on the graphics card."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

MODES = ("intensity", "log", "phase")
COLOURS = ("grey", "green", "viridis", "magma", "inferno", "plasma", "cividis")
"""Grey, the laser's green, and matplotlib's maps whose lightness rises evenly."""
DIVERGING = "RdBu_r"
"""For differences: blue below zero, red above."""
DECADES = 4.0
"""Range of the logarithmic mode below white."""
ENTRIES = 256


@dataclass
class Look:
    """mode : one of MODES; colours : one of COLOURS; gamma : of intensity mode; stops : exposure,
    as powers of two against the automatic one."""

    mode: str = "intensity"
    colours: str = "grey"
    gamma: float = 2.2
    stops: float = 0.0

    @property
    def glows(self) -> bool:
        """Whether a video in colours is shown in them: maps, log and phase show its luminance."""
        return self.mode == "intensity" and self.colours == "grey"


@lru_cache
def colour_table(name: str) -> NDArray[np.float32]:
    """(ENTRIES, 3) colours in 0 … 1 from dark to bright."""
    level = np.linspace(0, 1, ENTRIES)
    if name == "grey":
        table = np.repeat(level[:, None], 3, axis=1)
    elif name == "green":  # towards 532 nm, white where it is brightest
        table = np.stack([level**3 * 0.85, level, level**3 * 0.6], axis=1)
    else:
        from matplotlib import colormaps

        table = colormaps[name](level)[:, :3]
    found = np.asarray(table, dtype=np.float32)
    found.setflags(write=False)
    return found


def coloured(level: NDArray[np.floating], name: str) -> NDArray[np.floating]:
    """(…, 3) in 0 … 1 of levels in 0 … 1, between a table's entries linearly."""
    table = colour_table(name)
    at = np.clip(np.asarray(level, dtype=np.float32), 0, 1) * (ENTRIES - 1)
    low = np.minimum(at.astype(np.intp), ENTRIES - 2)
    part = (at - low)[..., None]
    mixed: NDArray[np.floating] = table[low] * (1 - part) + table[low + 1] * part
    return mixed


def level_of(light: NDArray[np.floating], white: float, look: Look) -> NDArray[np.floating]:
    """Levels in 0 … 1 of intensities, in intensity or log mode."""
    share = light / max(white * 2.0**-look.stops, 1e-30)
    if look.mode == "log":
        return np.clip(1 + np.log10(np.maximum(share, 1e-30)) / DECADES, 0, 1)
    return np.clip(share, 0, 1) ** (1 / look.gamma)


def light_of(level: float, white: float, look: Look) -> float:
    """The intensity that is shown at a level: the inverse of `level_of`."""
    top = white * 2.0**-look.stops
    if look.mode == "log":
        return float(top * 10 ** (DECADES * (level - 1)))
    return float(top * level**look.gamma)


def shade(
    field: NDArray[np.complexfloating],
    white: float,
    look: Look,
    glow: NDArray[np.float32] | None = None,
) -> NDArray[np.uint8]:
    """(h, w, 3) colours.

    white : intensity shown as white before `stops`
    glow : (h, w, 3) linear sRGB of several lasers, in the unit of white
    Phase is a hue, as bright as the amplitude; 0 is red, +2π/3 green, −2π/3 blue.
    """
    if glow is not None and look.glows:
        return np.rint(255 * level_of(glow, white, look)).astype(np.uint8)
    level = level_of(field.real**2 + field.imag**2, white, look)
    if look.mode == "phase":
        colour = hues(np.angle(field)) * np.sqrt(level)[..., None]
    else:
        colour = coloured(level, look.colours)
    return np.rint(255 * colour).astype(np.uint8)


def hues(phase: NDArray[np.floating]) -> NDArray[np.floating]:
    """(…, 3) in 0 … 1 of phases in radians."""
    turn = phase / (2 * np.pi)
    hue = np.stack([turn, turn - 1 / 3, turn + 1 / 3], axis=-1)
    found: NDArray[np.floating] = np.clip(2 - np.abs(6 * (hue - np.rint(hue))), 0, 1)
    return found


def shade_difference(
    difference: NDArray[np.floating], white: float, look: Look
) -> NDArray[np.uint8]:
    """(h, w, 3) colours of signed intensities; ±white are the ends of the map."""
    share = difference / max(white * 2.0**-look.stops, 1e-30)
    return np.rint(255 * coloured(0.5 + 0.5 * np.clip(share, -1, 1), DIVERGING)).astype(np.uint8)
