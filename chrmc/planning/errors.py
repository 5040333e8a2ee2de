"""What error to expect of a CGH method, from a few waves as it forms them.

Points of unrelated phases add in power, and so do their errors: a few points, each on some pixels
of its own footprint, stand for all points and all pixels. Where waves cancel, no such estimate
holds; the error check on stored frames sees that.
"""

from typing import Any

import numpy as np

from chrmc.cgh.method import CGHMethod
from chrmc.optics.footprint import expected_power, pixels_within
from chrmc.optics.passband import Passband
from chrmc.reference import true_waves
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM

POINTS, PIXELS = 8, 64
"""Points that are tried, and pixels of each."""
PROMISED = 0.45
"""Error that is found, over the tolerance, where a method keeps one."""
SAFE = 3.0
"""How far a measured error may lie above the expected one."""


def expected_error(
    method: CGHMethod,
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    passband: Passband,
    **options: Any,
) -> float | None:
    """Relative L2 error of the field; None of a method that says nothing about its waves."""
    if "tolerance" in options:
        return PROMISED * float(options["tolerance"])
    if method.waves is None:
        return None
    if len(cloud) == 0:
        return 0.0
    random = np.random.default_rng(0)
    drawn = random.choice(len(cloud), min(POINTS, len(cloud)), replace=False)
    few = cloud.select(np.sort(drawn))
    rows, columns = pixels_within(few, slm, wavelength, passband, PIXELS, random)
    truth = true_waves(few, slm, wavelength, rows, columns, passband)
    waves = method.waves(few, slm, wavelength, rows, columns, passband, **options)
    light = np.mean(np.abs(truth) ** 2, axis=1)
    missed = np.mean(np.abs(waves - truth) ** 2, axis=1)
    seen = light > 0
    weight = expected_power(few, slm, wavelength, passband)[seen]
    if not weight.sum() > 0:
        return method.rounding
    square = float(weight @ (missed[seen] / light[seen]) / weight.sum())
    return float(np.hypot(np.sqrt(square), method.rounding))
