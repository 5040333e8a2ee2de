"""How like one picture is to another: the two measures that everybody quotes.

Images are (h, w) intensities.
"""

from math import inf, log10

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.floating]


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
