"""Focus where somebody clicked, and the focus curve of every object, step by step."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import ceil

import numpy as np
from numpy.typing import NDArray

from chrmc.optics.propagation import Patch
from reconstruct.focus import Focus, find_focus
from reconstruct.stack import FocalStack, focal_planes, patch_around
from reconstruct.viewer.pipeline import Decoded
from reconstruct.viewer.worker import Progress

REGION = 0.45e-3
"""Half the side of the region that a click focuses on, metres."""
_WIDE_STEP = 0.25e-3
_NEAR = 3e-3
_NEAR_COUNT = 41


@dataclass(frozen=True, eq=False)
class Found:
    """The focus around a pixel (row, column) of a frame."""

    number: int
    pixel: tuple[int, int]
    focus: Focus


@dataclass(frozen=True, eq=False)
class Curve:
    """The focus curve of an object of a frame."""

    number: int
    name: str
    focus: Focus


def focus_around(
    decoded: Decoded, pixel: tuple[int, int], depths: tuple[float, float]
) -> Iterator[Progress | Found | None]:
    """Focus on what is seen around a pixel: the whole range of depths, then finely where it is
    sharpest. Ends with `Found`; its curve is that of the whole range."""
    yield Progress("autofocus", 0.0)
    slm = decoded.system.slm
    p = slm.pixel_pitch
    side = _tile(decoded)
    tiles = max(2, ceil(2 * REGION / (side * p)))
    centre = (
        (pixel[0] - (slm.height - 1) / 2) * p,
        (pixel[1] - (slm.width - 1) / 2) * p,
    )
    patch = Patch(centre, (tiles * side, tiles * side), p)
    coarse = wide_depths(depths)
    every = len(coarse) + _NEAR_COUNT
    planes = []
    for plane in _planes(decoded, coarse, patch):
        planes.append(plane)
        yield Progress("autofocus", len(planes) / every)
    wide = find_focus(FocalStack(coarse, np.stack(planes), patch), side)
    best = float(coarse[int(np.argmax(wide.curve))])
    near = np.linspace(max(best - _NEAR, depths[0]), min(best + _NEAR, depths[1]), _NEAR_COUNT)
    planes = []
    for plane in _planes(decoded, near, patch):
        planes.append(plane)
        yield Progress("autofocus", (len(coarse) + len(planes)) / every)
    found = find_focus(FocalStack(near, np.stack(planes), patch), side)
    focus = replace(found, depths=wide.depths, curve=wide.curve)
    yield Found(decoded.frame.number, pixel, focus)


def curves_of_objects(
    decoded: Decoded, depths: tuple[float, float]
) -> Iterator[Progress | Curve | None]:
    """The focus curve of each object's surroundings over the range of depths."""
    side = _tile(decoded)
    z = wide_depths(depths)
    every = len(z) * max(len(decoded.targets), 1)
    done = 0
    for target in decoded.targets:
        pitch = decoded.system.slm.pixel_pitch
        patch = patch_around(target.low, target.high, pitch, decoded.scene_pitch, side)
        planes = []
        for plane in _planes(decoded, z, patch):
            planes.append(plane)
            done += 1
            yield Progress(f"focus curve of {target.name}", done / every)
        focus = find_focus(FocalStack(z, np.stack(planes), patch), side)
        yield Curve(decoded.frame.number, target.name, focus)


def wide_depths(depths: tuple[float, float]) -> NDArray[np.float64]:
    """Depths over a whole range, close enough not to miss a focus where that is affordable."""
    low, high = depths
    return np.linspace(low, high, int(np.clip((high - low) / _WIDE_STEP, 21, 160)))


def _tile(decoded: Decoded) -> int:
    return max(4, round(2 * decoded.scene_pitch / decoded.system.slm.pixel_pitch))


def _planes(
    decoded: Decoded, depths: NDArray[np.float64], patch: Patch
) -> Iterator[NDArray[np.float32]]:
    system = decoded.system
    return focal_planes(decoded.field, system.slm, system.wavelength, depths, patch, system.band)
