"""How far the light of a cloud has to be followed for a window, and the grid that holds it."""

from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from chrmc.optics.footprint import reach
from chrmc.optics.passband import Passband
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM
from chrmc.window import Window

FADE = 4.0
"""Light that misses the window fades out over this many Fresnel zones √(λz)."""
_GRID_STEP = 128  # samples; grids that grow in such steps are seldom new ones


def paths_to(
    cloud: PointCloud, slm: SLM, wavelength: float, window: Window, passband: Passband
) -> tuple["Path", "Path"]:
    """How far light has to be followed per axis (y, x)."""
    farthest = float(cloud.positions[:, 2].max())
    fade = FADE * np.sqrt(wavelength * farthest)
    paths = []
    for axis, pixels, f_max in (
        (1, slm.y(window.rows), passband.fy_max),
        (0, slm.x(window.columns), passband.fx_max),
    ):
        at = cloud.positions[:, axis]
        needed = float(max(pixels[-1] - at.min(), at.max() - pixels[0]))
        slope = reach(wavelength, f_max)
        paths.append(Path(needed, min(farthest * slope, needed + fade), slope))
    return paths[0], paths[1]


@dataclass(frozen=True)
class Path:
    """Metres along one axis, from a point to the hologram.

    needed : to the farthest pixel of the window
    spread : to where the light is followed; it fades out from `needed` on
    slope : half-width of a footprint per unit of depth
    """

    needed: float
    spread: float
    slope: float

    def weight(self, distance: NDArray[np.float64]) -> NDArray[np.float64]:
        """1 where needed, cos² down to 0 at the spread."""
        width = max(self.spread - self.needed, 1e-12)
        return np.cos(np.pi / 2 * np.clip((np.abs(distance) - self.needed) / width, 0, 1)) ** 2


def grid_length(sources: list[tuple[int, int]], window: tuple[int, int], spread: float) -> int:
    """Grid on which no source's light wraps around into the window.

    sources, window : index ranges; spread : pixels that light strays on its way. The transfer
    function drops frequencies that travel half the grid or more; that edge has to stay clear of
    the light (measured: 1.15 times its spread, or the error is 10 times the floor).
    """
    longest = max(max(window[1] - low, high - window[0]) for low, high in sources)
    need = max(longest + spread + 64, 2.3 * spread)
    return int(scipy.fft.next_fast_len(-(-int(np.ceil(need)) // _GRID_STEP) * _GRID_STEP))
