"""How good a reconstructed image is; against another one see also `chrmc.metrics`.

Images are (h, w) intensities. Masks are boolean (h, w): the object's own area, and the dark
surroundings that it is compared with.
"""

from math import inf, log10

import numpy as np
from numpy.typing import NDArray

from chrmc.metrics import Image

Mask = NDArray[np.bool_]


def scale_to(image: Image, truth: Image) -> float:
    """The factor that brings an image nearest to a truth in least squares."""
    square = float(np.sum(np.asarray(image, dtype=np.float64) ** 2))
    product = float(np.sum(np.asarray(image, dtype=np.float64) * truth))
    return product / square if square > 0 else 1.0


def contrast(image: Image, lit: Mask, dark: Mask) -> float:
    """Michelson contrast of the mean intensities, (lit − dark)/(lit + dark)."""
    bright, dim = _mean(image, lit), _mean(image, dark)
    return (bright - dim) / (bright + dim) if bright + dim > 0 else 0.0


def snr(image: Image, lit: Mask, dark: Mask) -> float:
    """20·log10((mean lit − mean dark)/standard deviation of dark), dB; −inf for no signal."""
    signal = _mean(image, lit) - _mean(image, dark)
    noise = float(np.std(image[dark], dtype=np.float64)) if dark.any() else 0.0
    if signal <= 0:
        return -inf
    return 20 * log10(signal / noise) if noise > 0 else inf


def speckle_contrast(image: Image, lit: Mask | None = None) -> float:
    """Standard deviation over mean of the lit pixels: 1 for fully developed speckle, 0 for none.

    A lattice of separate bright points has more than 1.
    """
    values = image.ravel() if lit is None else image[lit]
    mean = float(np.mean(values, dtype=np.float64)) if values.size else 0.0
    return float(np.std(values, dtype=np.float64)) / mean if mean > 0 else 0.0


def _mean(image: Image, mask: Mask) -> float:
    return float(np.mean(image[mask], dtype=np.float64)) if mask.any() else 0.0
