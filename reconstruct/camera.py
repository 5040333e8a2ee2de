"""The camera in the image plane: pixels that gather light, and count it in so many bits."""

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from chrmc.optics.propagation import Patch
from reconstruct.images import exposure


@dataclass(frozen=True)
class Camera:
    """pixel_pitch : of the sensor, metres
    shape : (rows, columns); default as many as see the whole image
    bits : of the counts
    full_scale : intensity that fills the range; default `exposure` of the photograph
    full_well : photons that fill the range, for shot noise; None counts without noise
    seed : of the noise
    upright : turned by 180° against the image that the 4-f system turns, so it looks as the scene
    """

    pixel_pitch: float
    shape: tuple[int, int] | None = None
    bits: int = 8
    full_scale: float | None = None
    full_well: float | None = None
    seed: int = 0
    upright: bool = True

    def __post_init__(self) -> None:
        if not (isfinite(self.pixel_pitch) and self.pixel_pitch > 0):
            raise ValueError(f"a camera needs a positive pixel pitch, not {self.pixel_pitch} m")
        if not 1 <= self.bits <= 16:
            raise ValueError(f"a camera counts in 1 to 16 bits, not {self.bits}")
        if self.full_well is not None and not self.full_well > 0:
            raise ValueError(f"full_well must be positive, not {self.full_well}")

    def gather(
        self, image: NDArray[np.floating], patch: Patch, magnification: float = 1.0
    ) -> NDArray[np.float64]:
        """Mean intensity over each camera pixel, the camera centred on the image.

        image : (h, w) intensity on `patch`, scene coordinates
        magnification : of the 4-f system, so that a camera pixel covers pixel_pitch/magnification
        """
        pitch = self.pixel_pitch / magnification
        counts = self.shape
        if counts is None:
            sides = [n * patch.pitch / pitch for n in image.shape]
            counts = (max(1, round(sides[0])), max(1, round(sides[1])))
        rows, columns = (
            overlaps(n, patch.pitch, m, pitch) for n, m in zip(image.shape, counts, strict=True)
        )
        seen = rows @ np.asarray(image, dtype=np.float64) @ columns.T
        return seen if self.upright else seen[::-1, ::-1]

    def photograph(
        self, image: NDArray[np.floating], patch: Patch, magnification: float = 1.0
    ) -> NDArray[np.uint8] | NDArray[np.uint16]:
        """Counts: uint8 up to 8 bits, else uint16. Arguments as `gather`."""
        light = self.gather(image, patch, magnification)
        full = exposure(light) if self.full_scale is None else self.full_scale
        share = light / full if full > 0 else np.zeros_like(light)
        if self.full_well is not None:
            photons = np.random.default_rng(self.seed).poisson(share * self.full_well)
            share = photons / self.full_well
        top = 2**self.bits - 1
        counts = np.rint(np.clip(share, 0, 1) * top)
        return counts.astype(np.uint8) if self.bits <= 8 else counts.astype(np.uint16)


def overlaps(count: int, pitch: float, wanted: int, wanted_pitch: float) -> NDArray[np.float64]:
    """(wanted, count) shares of each wanted pixel that each given one covers, both rows of pixels
    centred on one point; a wanted pixel beside the given ones sees darkness there."""
    edges = (np.arange(count + 1) - count / 2) * pitch
    sought = (np.arange(wanted + 1) - wanted / 2) * wanted_pitch
    low = np.maximum(edges[None, :-1], sought[:-1, None])
    high = np.minimum(edges[None, 1:], sought[1:, None])
    return np.maximum(high - low, 0) / wanted_pitch
