"""Two videos beside each other: what sets their pictures apart."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from chrmc.metrics import psnr, ssim
from reconstruct.images import exposure
from reconstruct.metrics import scale_to
from reconstruct.viewer.measure import Region
from reconstruct.viewer.pipeline import Picture, Request

MODES = ("side by side", "wipe", "difference", "A", "B")


@dataclass(frozen=True, eq=False)
class Comparison:
    """B against A, as intensities.

    factor : what B's intensity is multiplied by, to be nearest to A's in least squares
    psnr : dB, the peak being A's largest intensity; ssim : None while it is not measured yet
    region : what all three are of; None is the whole picture
    """

    request: Request
    a: Picture
    b: Picture
    factor: float
    psnr: float
    ssim: float | None
    region: Region | None = None

    @property
    def coarse(self) -> bool:
        """Whether it is of first pictures, at the screen's resolution."""
        return self.a.coarse or self.b.coarse

    @cached_property
    def difference(self) -> NDArray[np.float32]:
        """(h, w) intensity of B, brought to A's brightness, less that of A."""
        return self.b.light * np.float32(self.factor) - self.a.light

    @cached_property
    def span(self) -> float:
        """Difference to show in the strongest colours."""
        return exposure(np.abs(self.difference)) or 1.0


def compare(
    request: Request,
    pictures: Sequence[Picture | None],
    with_ssim: bool,
    panel: tuple[int, int],
    region: Region | None = None,
) -> Comparison | None:
    """The comparison, or None where a picture is missing or they have other samples.

    panel : (rows, columns) that the region's places count
    """
    a, b = pictures
    if a is None or b is None or a.field.shape != b.field.shape:
        return None
    part: tuple[slice, ...] = ()
    if region is not None:
        shape = a.field.shape[0], a.field.shape[1]
        part = region.scaled(panel, shape).slices(shape)
    truth, other = a.light[part], b.light[part]
    factor = scale_to(other, truth)
    level = other * np.float32(factor)
    alike = ssim(level, truth) if with_ssim else None
    made = Comparison(request, a, b, factor, psnr(level, truth), alike, region)
    made.span  # noqa: B018  made here, not in the window's thread
    return made
