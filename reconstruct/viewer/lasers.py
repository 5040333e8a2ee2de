"""What several lasers show together: one field to measure, and the colours to look at."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chrmc.colour import mixed, primaries
from chrmc.store.colour import ColourVideo
from chrmc.store.video import Video
from reconstruct.four_f_system import intensity
from reconstruct.images import exposure

LUMINANCE = (0.2126, 0.7152, 0.0722)
"""Of red, green and blue in linear sRGB (IEC 61966-2-1)."""

Source = Video | ColourVideo
"""What the viewer shows as one video."""


@dataclass(frozen=True)
class Lasers:
    """The lasers of a video in colours.

    wavelengths : metres; shares : what brings each laser's intensities into balance
    """

    wavelengths: tuple[float, ...]
    shares: tuple[float, ...]

    @classmethod
    def of(cls, video: ColourVideo) -> "Lasers":
        """Those of a stored video, in the first laser's unit as `reconstruct.colour.balanced`."""
        first = video.channels[0].scale
        return cls(video.wavelengths, tuple((first / c.scale) ** 2 for c in video.channels))

    @property
    def lead(self) -> int:
        """The laser that the eye sees best: its hologram, phase and focus stand for all."""
        return int(np.argmax(np.asarray(LUMINANCE) @ primaries(self.wavelengths)))

    def mix(
        self, fields: Sequence[NDArray[np.complex64]]
    ) -> tuple[NDArray[np.complex64], NDArray[np.float32], float]:
        """One picture of the lasers' (h, w) fields: a field whose intensity is the luminance and
        whose phase is the leading laser's, (h, w, 3) linear sRGB, and the intensity of white."""
        lead = fields[self.lead]
        light = [
            _fitted(intensity(f), lead.shape) * np.float32(s)
            for f, s in zip(fields, self.shares, strict=True)
        ]
        glow = mixed(np.stack(light, axis=-1), self.wavelengths).astype(np.float32)
        bright = np.sqrt(glow @ np.asarray(LUMINANCE, dtype=np.float32))
        turn = np.exp(1j * np.angle(lead)).astype(np.complex64)
        return bright * turn, glow, max(exposure(one[::2, ::2]) for one in light)


def _fitted(light: NDArray[np.float32], shape: tuple[int, ...]) -> NDArray[np.float32]:
    """Intensities on another number of samples: coarse pictures of other bands have others."""
    if light.shape == shape:
        return light
    from PIL import Image

    image = Image.fromarray(np.ascontiguousarray(light))
    small = image.resize((shape[1], shape[0]), Image.Resampling.BILINEAR)
    return np.asarray(small, dtype=np.float32)


def leading(source: Source) -> Video:
    """The ordinary video that stands for a source: itself, or that of its leading laser."""
    if isinstance(source, ColourVideo):
        return source.channels[Lasers.of(source).lead]
    return source
