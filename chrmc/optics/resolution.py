"""What a panel resolves at a depth, across and along."""

from math import inf

from chrmc.optics.footprint import reach
from chrmc.optics.passband import Passband
from chrmc.slm import SLM


def apertures(slm: SLM, wavelength: float, depth: float, passband: Passband) -> tuple[float, float]:
    """(y, x) metres of the panel that show a point on the axis: its side or the footprint's,
    whichever is smaller."""
    sides = []
    for count, f_max in ((slm.height, passband.fy_max), (slm.width, passband.fx_max)):
        side, slope = count * slm.pixel_pitch, reach(wavelength, f_max)
        sides.append(side if slope == inf else min(side, 2 * depth * slope))
    return sides[0], sides[1]


def resolution(
    slm: SLM, wavelength: float, depth: float, passband: Passband
) -> tuple[float, float]:
    """λz/A in (y, x), metres: two points so far apart are told from each other."""
    y, x = apertures(slm, wavelength, depth, passband)
    return wavelength * depth / y, wavelength * depth / x


def depth_of_focus(
    slm: SLM, wavelength: float, depth: float, passband: Passband
) -> tuple[float, float]:
    """2λ(z/A)² in (y, x), metres."""
    y, x = apertures(slm, wavelength, depth, passband)
    return 2 * wavelength * (depth / y) ** 2, 2 * wavelength * (depth / x) ** 2
