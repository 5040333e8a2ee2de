"""How good a reconstructed image is, alone and against another.

Images are (h, w) intensities. Masks are boolean (h, w): the object's own area, and the dark
surroundings that it is compared with.
"""

from math import inf, log10

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.floating]
Mask = NDArray[np.bool_]


def psnr(image: Image, truth: Image, peak: float | None = None) -> float:
    """10·log10(peak²/mean squared difference) in dB, peak the truth's largest; inf if equal."""
    difference = np.asarray(image, dtype=np.float64) - np.asarray(truth, dtype=np.float64)
    top = float(np.max(truth)) if peak is None else peak
    error = float(np.mean(difference**2))
    if error == 0:
        return inf
    return 10 * log10(top**2 / error) if top > 0 else -inf


def ssim(image: Image, truth: Image, peak: float | None = None) -> float:
    """Structural similarity (Wang et al. 2004: Gaussian window of 1.5 pixels), 1 for equal images.

    Images smaller than its 11-pixel window are padded with their own border.
    """
    from skimage.metrics import structural_similarity

    top = float(np.max(truth)) if peak is None else peak
    if not top > 0:
        return 1.0 if np.array_equal(image, truth) else 0.0
    grow = [(0, max(0, 11 - n)) for n in truth.shape]
    a, b = (np.pad(np.asarray(i, dtype=np.float64), grow, mode="edge") for i in (image, truth))
    value = structural_similarity(
        a, b, data_range=top, gaussian_weights=True, sigma=1.5, use_sample_covariance=False
    )
    return float(value)


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
