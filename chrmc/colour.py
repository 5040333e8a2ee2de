"""Colours as mixtures of laser lines: what each laser must give, and what the eye sees.

Colours are linear sRGB (primaries of Rec. 709, white D65), 0 … 1. A laser of wavelength λ adds
light at one point of the spectral locus, so its chromaticity follows from λ alone. The lasers are
balanced: all at power 1 give white.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

RGB_TO_XYZ = np.array(
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
)
"""Linear sRGB to CIE XYZ (IEC 61966-2-1)."""
LUMINANCE = RGB_TO_XYZ[1]
"""Of linear red, green and blue."""
VISIBLE = (380e-9, 780e-9)
"""Wavelengths that have a colour, metres."""

# Peaks of the fit: height, place in nm, 1/width below and above the place.
_LOBES = (
    (
        (1.056, 599.8, 0.0264, 0.0323),
        (0.362, 442.0, 0.0624, 0.0374),
        (-0.065, 501.1, 0.0490, 0.0382),
    ),
    ((0.821, 568.8, 0.0213, 0.0247), (0.286, 530.9, 0.0613, 0.0322)),
    ((1.217, 437.0, 0.0845, 0.0278), (0.681, 459.0, 0.0385, 0.0725)),
)


def spectral_xyz(wavelength: float) -> NDArray[np.float64]:
    """(3,) CIE 1931 colour-matching values of one wavelength (metres).

    The piecewise-Gaussian fit of Wyman, Sloan and Shirley, J. Comput. Graph. Tech. 2(2), 2013;
    within 0.02 of the tables.
    """
    if not VISIBLE[0] <= wavelength <= VISIBLE[1]:
        raise ValueError(
            f"{wavelength * 1e9:.4g} nm has no colour: between {VISIBLE[0] * 1e9:.0f} and "
            f"{VISIBLE[1] * 1e9:.0f} nm it has"
        )
    nm = wavelength * 1e9
    return np.array(
        [
            sum(
                height * np.exp(-0.5 * ((nm - place) * (below if nm < place else above)) ** 2)
                for height, place, below, above in lobes
            )
            for lobes in _LOBES
        ]
    )


def primaries(wavelengths: Sequence[float]) -> NDArray[np.float64]:
    """(3, C) linear sRGB of each laser, balanced so that all together come nearest to white.

    Columns may have negative entries: a laser is more saturated than sRGB can say.
    """
    spectral = np.stack([spectral_xyz(w) for w in wavelengths], axis=1)
    in_rgb = np.linalg.solve(RGB_TO_XYZ, spectral)
    if len(wavelengths) == 1:
        return np.ones((3, 1))  # one laser shows brightness; its picture is drawn in grey
    power = np.linalg.pinv(in_rgb) @ np.ones(3)
    if (power <= 0).any():
        named = ", ".join(f"{w * 1e9:.0f}" for w in wavelengths)
        raise ValueError(f"{named} nm cannot be mixed to a white: leave one out or choose others")
    return in_rgb * power


def laser_powers(colour: ArrayLike, wavelengths: Sequence[float]) -> NDArray[np.float64]:
    """(N, C) power of each laser, 1 for white, that gives (N, 3) linear sRGB colours.

    What the lasers cannot mix is cut to the nearest without negative powers: of sRGB a little at
    the pure blue for lasers of 638, 532 and 450 nm, the hue for fewer than three lasers.
    """
    rgb = np.atleast_2d(np.asarray(colour, dtype=np.float64))
    if rgb.ndim != 2 or rgb.shape[1] != 3:
        raise ValueError(f"colours must be (N, 3) linear sRGB, not {rgb.shape}")
    if len(wavelengths) == 1:
        return rgb @ LUMINANCE[:, None]
    # Of the mixtures that four and more lasers offer, the one nearest to equal powers.
    lasers = primaries(wavelengths)
    grey = rgb @ LUMINANCE[:, None]
    powers: NDArray[np.float64] = (
        grey + (rgb - grey * lasers.sum(axis=1)) @ np.linalg.pinv(lasers).T
    )
    return np.maximum(powers, 0)


def mixed(powers: ArrayLike, wavelengths: Sequence[float]) -> NDArray[np.float64]:
    """(…, 3) linear sRGB that lasers of (…, C) powers show, negative parts cut to 0."""
    shown: NDArray[np.float64] = np.asarray(powers, dtype=np.float64) @ primaries(wavelengths).T
    return np.maximum(shown, 0)


def srgb_levels(linear: ArrayLike) -> NDArray[np.uint8]:
    """8-bit sRGB of linear values 0 … 1 (the curve of IEC 61966-2-1); more is cut to white."""
    value = np.clip(np.asarray(linear, dtype=np.float64), 0, 1)
    curve = np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)
    return np.rint(255 * curve).astype(np.uint8)


def linear(srgb: ArrayLike) -> NDArray[np.float64]:
    """Linear light of sRGB values, both 0 … 1 (IEC 61966-2-1)."""
    value = np.asarray(srgb, dtype=np.float64)
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def hue(rgb: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """(…, 3) linear colours brought to luminance 1, black to white; None where all are grey."""
    light = rgb @ LUMINANCE
    dark = light <= 0
    found = np.where(dark[..., None], 1.0, rgb / np.where(dark, 1, light)[..., None])
    return None if np.ptp(found, axis=-1).max(initial=0) < 1e-3 else found
