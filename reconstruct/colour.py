"""Reconstructions in the light of one laser, or of several as one colour picture.

Pictures are (H, W, lasers) intensities; a video in one colour is one of a single laser.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from chrmc.colour import LUMINANCE, mixed, primaries, srgb_levels
from chrmc.store.colour import ColourVideo
from chrmc.store.video import Video
from reconstruct.bench import Bench
from reconstruct.four_f_system import FourF, intensity
from reconstruct.images import exposure, to_grey, write_colour, write_image
from reconstruct.sequence import composite, system_of

BRIGHTEST = 0.995
"""Share of the brightest channel's pixels that are not cut, unless `white` is given: the bright
grains of speckle would leave the rest in the dark."""


def colour_picture(
    intensities: Sequence[ArrayLike], wavelengths: Sequence[float], white: float | None = None
) -> NDArray[np.uint8]:
    """Intensities at one depth, a wavelength each, as (H, W, 3) 8-bit sRGB.

    intensities : (H, W) for each laser, on the same pixels and in the same unit
    wavelengths : metres, visible; lasers are balanced so that equal intensities are white
    white : the intensity that is drawn as white; default what 99.5 % of the brightest laser's
        pixels stay below. Give one for all frames of a film

    The lasers' light is added in the linear space of sRGB. What lies outside sRGB is cut.
    """
    if len(intensities) != len(wavelengths) or not len(wavelengths):
        raise ValueError(f"{len(intensities)} pictures for {len(wavelengths)} wavelengths")
    powers = np.stack([np.asarray(i, dtype=np.float64) for i in intensities], axis=-1)
    if powers.ndim != 3 or not np.isfinite(powers).all():
        raise ValueError(f"intensities must be finite (H, W) each, not {powers.shape[:-1]}")
    if white is None:
        white = float(np.quantile(powers, BRIGHTEST, axis=(0, 1)).max()) or 1.0
    if not (np.isfinite(white) and white > 0):
        raise ValueError(f"white must be a positive intensity, not {white}")
    return srgb_levels(mixed(powers / white, wavelengths))


def colour_systems(video: Video | ColourVideo, bench: Bench | None = None) -> list[FourF]:
    """The 4-f system of each laser of a stored video."""
    return [system_of(channel, bench) for channel in video.channels]


def balanced(video: Video | ColourVideo, images: Sequence[ArrayLike]) -> NDArray[np.float32]:
    """(H, W, lasers) intensities in which equal ones are white, in the first laser's unit.

    images : (H, W) intensity of each laser, as its system in `colour_systems` gives it
    """
    first = video.channels[0].scale
    shares = [(first / channel.scale) ** 2 for channel in video.channels]
    lit = [np.asarray(i, dtype=np.float32) for i in images]
    return np.stack([i * np.float32(s) for i, s in zip(lit, shares, strict=True)], axis=-1)


def colour_image(
    video: Video | ColourVideo,
    number: int,
    depth: float | None,
    systems: Sequence[FourF] | None = None,
    levels: Sequence[NDArray[np.uint8]] | None = None,
) -> NDArray[np.float32]:
    """(H, W, lasers) balanced intensities of a frame.

    depth : metres; None shows every object at its own
    levels : of each laser, in place of the stored ones
    """
    video.entry(number)
    images = []
    for k, system in enumerate(systems or colour_systems(video)):
        channel = video.channels[k]
        frame = channel.read(number) if levels is None else levels[k]
        if depth is None:
            images.append(composite(channel, number, system, levels=frame).image)
        else:
            images.append(system.image(frame, depth))
    return balanced(video, images)


def colour_stack(
    video: Video | ColourVideo,
    depths: Sequence[float],
    systems: Sequence[FourF],
    levels: Sequence[NDArray[np.uint8]],
) -> Iterator[NDArray[np.float32]]:
    """(H, W, lasers) balanced intensities at one depth after the other, of each laser's levels."""
    fields = [system.field(frame) for system, frame in zip(systems, levels, strict=True)]
    for depth in depths:
        yield balanced(
            video,
            [intensity(s.at(f, float(depth))) for s, f in zip(systems, fields, strict=True)],
        )


def colour_levels(
    image: NDArray[np.floating],
    video: Video | ColourVideo,
    white: float | None = None,
    gamma: float = 2.2,
) -> NDArray[np.uint8]:
    """(H, W, 3) sRGB of balanced intensities; (H, W) grey levels of one laser's.

    white : intensity drawn as white, default `colour_exposure`; give one for all frames of a film
    gamma : of the display, for grey levels; sRGB has its own curve
    """
    top = colour_exposure(image) if white is None else white
    if image.shape[-1] == 1:
        return to_grey(image[..., 0], top, gamma)
    lasers = [image[..., k] for k in range(image.shape[-1])]
    return colour_picture(lasers, video.wavelengths, top or 1.0)


def colour_exposure(image: NDArray[np.floating]) -> float:
    """Intensity to show as white: that of the laser that needs most, see `images.exposure`."""
    return max(exposure(image[..., k]) for k in range(image.shape[-1]))


def luminance(
    image: NDArray[np.floating], wavelengths: Sequence[float]
) -> NDArray[np.floating[Any]]:
    """(…) how bright balanced intensities (…, lasers) are to an eye; of one laser, themselves."""
    if len(wavelengths) == 1:
        return image[..., 0]
    return image @ (LUMINANCE @ primaries(wavelengths)).astype(image.dtype)


def write_picture(
    path: Path,
    image: NDArray[np.floating],
    video: Video | ColourVideo,
    note: dict[str, Any],
    white: float | None = None,
    gamma: float = 2.2,
) -> None:
    """Write balanced intensities (H, W, lasers) by the suffix: a PNG for the eye, or an EXR of
    intensities, of several lasers in linear sRGB; with the frame's metadata.

    note : metadata of this picture; white, gamma : as in `colour_levels`
    """
    lasers = video.wavelengths
    note = note | {
        "pixel_pitch": video.slm.pixel_pitch,
        "encoding": video.channels[0].encoding,
        "scene": video.scene.get("name"),
    }
    if len(lasers) == 1:
        note["wavelength"] = lasers[0]
        write_image(path, image[..., 0], note, white, gamma)
        return
    top = white or colour_exposure(image) or 1.0
    note |= {"wavelengths": list(lasers), "full_scale": top}
    if path.suffix.lower() == ".exr":
        write_colour(path, mixed(image, lasers).astype(np.float32), note)
    else:
        write_colour(path, colour_levels(image, video, top), note)
