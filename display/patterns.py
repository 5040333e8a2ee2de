"""Test pictures for setting up a bench: grey levels (H, W) uint8 on an SLM's pixels.

All but `point` are plain grey levels, whatever the panel makes of them: they are what its response
is measured with. Positions count from the top left pixel.
"""

from math import cos, sin

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh import compute_field
from chrmc.encoding import coding_for
from chrmc.grey_levels import encode
from chrmc.panels import encoding_for
from chrmc.response import GreyResponse
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM

Frame = NDArray[np.uint8]


def uniform(slm: SLM, level: int = 128) -> Frame:
    """One grey level everywhere."""
    return np.full(slm.shape, _level(level), dtype=np.uint8)


def point(
    slm: SLM,
    wavelength: float,
    depth: float,
    x: float = 0.0,
    y: float = 0.0,
    encoding: str | None = None,
    response: GreyResponse | None = None,
) -> Frame:
    """The hologram of one point of light at (x, y, depth), metres: what a camera is focused on.

    The fringe uses the whole grey range. encoding : default the usual one of the panel's kind
    """
    if not (np.isfinite(depth) and depth > 0):
        raise ValueError(f"depth must be a positive length in metres, not {depth:g}")
    encoding = encoding_for(slm, encoding)
    coding = coding_for(encoding, slm)
    cloud = PointCloud(np.array([[x, y, depth]]), np.ones(1), np.zeros(1))
    field = compute_field(cloud, slm, wavelength, "rt", passband=coding.passband)
    return encode(field, slm, encoding, 1 / depth, response=response, band_limited=True)


def grating(
    slm: SLM,
    period: float = 16.0,
    angle: float = 0.0,
    low: int = 0,
    high: int = 255,
    shape: str = "binary",
) -> Frame:
    """Lines `period` pixels apart between two grey levels.

    angle : radians of the direction across the lines, from +x towards +y; 0 gives upright lines
    shape : "binary", half of each, or "sine"
    """
    if not period >= 2:
        raise ValueError(f"a grating needs a period of at least 2 pixels, not {period:g}")
    rows, columns = np.arange(slm.height)[:, None], np.arange(slm.width)[None, :]
    # A hair's breadth off the pixel, so that rounding does not decide where a line begins.
    cycles = (columns * cos(angle) + rows * sin(angle) + 1e-6) / period
    if shape == "binary":
        return np.where(cycles % 1 < 0.5, np.uint8(_level(high)), np.uint8(_level(low)))
    if shape == "sine":
        middle, swing = (_level(high) + _level(low)) / 2, (_level(high) - _level(low)) / 2
        return np.rint(middle + swing * np.cos(2 * np.pi * cycles)).astype(np.uint8)
    raise ValueError(f"a grating is binary or sine, not {shape!r}")


def checkerboard(slm: SLM, size: int = 100, low: int = 0, high: int = 255) -> Frame:
    """Squares of `size` pixels, `high` in the top left corner."""
    if size < 1:
        raise ValueError(f"a checkerboard needs squares of at least 1 pixel, not {size}")
    rows, columns = np.arange(slm.height)[:, None] // size, np.arange(slm.width)[None, :] // size
    return np.where((rows + columns) % 2 == 0, np.uint8(_level(high)), np.uint8(_level(low)))


def ramp(slm: SLM) -> Frame:
    """Grey 0 at the left edge to 255 at the right one."""
    row = np.rint(np.linspace(0, 255, slm.width)).astype(np.uint8)
    return np.tile(row, (slm.height, 1))


def steps(slm: SLM, count: int = 16) -> Frame:
    """`count` upright bars, equally spaced from grey 0 to 255."""
    if not 2 <= count <= 256:
        raise ValueError(f"2 to 256 grey steps are possible, not {count}")
    bar = np.arange(slm.width) * count // slm.width
    row = np.rint(bar * 255 / (count - 1)).astype(np.uint8)
    return np.tile(row, (slm.height, 1))


def cross_hair(slm: SLM, thickness: int = 2, low: int = 0, high: int = 255) -> Frame:
    """A cross through the panel's centre, with rings every 100 pixels and the panel's border."""
    if thickness < 1:
        raise ValueError(f"lines are at least 1 pixel thick, not {thickness}")
    y = (np.arange(slm.height) - (slm.height - 1) / 2)[:, None]
    x = (np.arange(slm.width) - (slm.width - 1) / 2)[None, :]
    half = thickness / 2
    lines = (np.abs(x) <= half) | (np.abs(y) <= half)
    radius = np.hypot(x, y)
    rings = (np.abs((radius + 50) % 100 - 50) <= half) & (radius > 50)
    border = (np.abs(x) > slm.width / 2 - thickness) | (np.abs(y) > slm.height / 2 - thickness)
    drawn = lines | rings | border
    return np.where(drawn, np.uint8(_level(high)), np.uint8(_level(low)))


def _level(level: int) -> int:
    if not 0 <= level <= 255:
        raise ValueError(f"grey levels run from 0 to 255; {level} is outside")
    return int(level)
