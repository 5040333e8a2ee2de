"""Sharpness of an image: published focus metrics, larger is sharper, free of overall brightness.

All take (h, w) intensity and return a number; 0 for a dark image.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Metric = Callable[[NDArray[np.floating]], float]


def normalised_variance(image: NDArray[np.floating]) -> float:
    """var(I)/mean(I)² (Groen, Young and Ligthart, Cytometry 6, 81, 1985)."""
    mean = float(np.mean(image, dtype=np.float64))
    return float(np.var(image, dtype=np.float64)) / mean**2 if mean > 0 else 0.0


def peakedness(image: NDArray[np.floating]) -> float:
    """N·ΣI²/(ΣI)²: how few pixels hold the light; 1 for a flat image."""
    return normalised_variance(image) + 1.0 if np.any(image) else 0.0


def gradient(image: NDArray[np.floating]) -> NDArray[np.float64]:
    """(h − 2, w − 2) magnitude of the Sobel gradient, borders left out."""
    i = np.asarray(image, dtype=np.float64)
    across = i[:, 2:] - i[:, :-2]
    along = i[2:, :] - i[:-2, :]
    gx = across[:-2] + 2 * across[1:-1] + across[2:]
    gy = along[:, :-2] + 2 * along[:, 1:-1] + along[:, 2:]
    return np.hypot(gx, gy)


def tenengrad(image: NDArray[np.floating]) -> float:
    """Mean squared Sobel gradient over the squared mean intensity (Tenenbaum 1970)."""
    mean = float(np.mean(image, dtype=np.float64))
    if min(image.shape) < 3 or mean <= 0:
        return 0.0
    return float(np.mean(gradient(image) ** 2)) / mean**2


def tamura_gradient(image: NDArray[np.floating]) -> float:
    """Tamura coefficient of the gradient, √(σ/⟨·⟩) (Zhang et al., Opt. Lett. 42, 3824, 2017)."""
    if min(image.shape) < 3:
        return 0.0
    g = gradient(image)
    mean = float(g.mean())
    return float(np.sqrt(g.std() / mean)) if mean > 0 else 0.0


METRICS: dict[str, Metric] = {
    "variance": normalised_variance,
    "peakedness": peakedness,
    "tenengrad": tenengrad,
    "tamura": tamura_gradient,
}


def metric_named(name: str) -> Metric:
    """A metric by its name, or ValueError."""
    if name not in METRICS:
        raise ValueError(f"unknown focus metric {name!r}: choose one of {', '.join(METRICS)}")
    return METRICS[name]
