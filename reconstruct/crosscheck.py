"""The same propagation by other means: a direct sum, and an independent package.

Both take a field in the hologram plane and give it at depth d > 0 behind it, like
`chrmc.optics.propagation.propagate(field, pitch, wavelength, -d)`.
"""

from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

PACKAGE = "hcipy"


def rayleigh_sommerfeld(
    field: NDArray[np.complexfloating],
    pixel_pitch: float,
    wavelength: float,
    depth: float,
    rows: NDArray[np.integer],
    columns: NDArray[np.integer],
) -> NDArray[np.complex128]:
    """The first Rayleigh–Sommerfeld integral as a plain sum in float64, at single pixels.

    U(P) = Σ U₀·p²·d/(2πr²)·(1/r + ik)·exp(−ikr): light going back to its sources. Samples are
    points of light, so what a pixel sends beyond its Nyquist angle is in it too: faint, and far
    from where the field is bright.

    rows, columns : (n,) pixels; returns (n,)
    """
    height, width = field.shape
    y = (np.arange(height) - (height - 1) / 2) * pixel_pitch
    x = (np.arange(width) - (width - 1) / 2) * pixel_pitch
    k = 2 * np.pi / wavelength
    out = np.empty(len(rows), dtype=np.complex128)
    for i, (row, column) in enumerate(zip(rows, columns, strict=True)):
        r = np.sqrt((y[:, None] - y[row]) ** 2 + (x[None, :] - x[column]) ** 2 + depth**2)
        kernel = depth / (2 * np.pi * r**2) * (1 / r + 1j * k) * np.exp(-1j * k * r)
        out[i] = np.sum(field * kernel) * pixel_pitch**2
    return out


def package_there() -> bool:
    """Whether the independent package is installed."""
    return find_spec(PACKAGE) is not None


def package_propagate(
    field: NDArray[np.complexfloating], pixel_pitch: float, wavelength: float, depth: float
) -> NDArray[np.complex128]:
    """The field at a depth by HCIPy's AngularSpectrumPropagator (Por et al., Proc. SPIE 10703,
    2018), which pads to twice the window and picks transfer function or impulse response itself.

    Raises OSError when HCIPy is not installed.
    """
    if not package_there():
        raise OSError(f"{PACKAGE} is not installed: pip install 'chrmc[crosscheck]'")
    hcipy: Any = import_module(PACKAGE)
    height, width = field.shape
    grid = hcipy.make_uniform_grid([width, height], [width * pixel_pitch, height * pixel_pitch])
    propagator = hcipy.AngularSpectrumPropagator(grid, depth, num_oversampling=1)
    wave = hcipy.Wavefront(
        hcipy.Field(np.asarray(field, dtype=np.complex128).ravel(), grid), wavelength
    )
    # Its backward pass is the adjoint: the wave at the hologram traced back to the object.
    back = propagator.backward(wave).electric_field
    return np.asarray(back, dtype=np.complex128).reshape(height, width)
