"""How light on the sphere changes with range: Chebyshev polynomials of 1/r, a layer for each.

The first layer is the light at the middle range, all but; the others are what is added to it at
other ranges. That is little, so they are summed to as many fewer digits.
"""

from collections.abc import Callable
from functools import partial
from math import cos, hypot, pi

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.interface import Series, make_series
from chrmc.compensation.ch_rmc_object.chart import Place, Span, path

Floats = NDArray[np.float64]

_LOOSEST = 0.2  # relative error of a layer, at most, however little it is


def layer_waves(
    order: int, layers: Floats, alpha: Floats, beta: Floats, place: Place, wavelength: float
) -> tuple[Floats, Floats]:
    """Radians and modulus of a layer's share of points' waves, over their phase at the middle.

    order : of the layer; layers : (L,) 1/r, Chebyshev nodes, at which waves are taken

    With v_l the wave at range r_l over its phase at the middle of all, Σ_l v_l·T_order(u_l)·2/L.
    The modulus may be negative: both change smoothly where a share passes through 0.
    """
    count = len(layers)
    middle = path(alpha, beta, place, middle_range(layers))
    real, imag = 0.0 * middle, 0.0 * middle
    for number, s in enumerate(layers):
        # T_order at the node, ascending from −1.
        share = cos(pi * order * (count - number - 0.5) / count) * (2 if order else 1) / count
        here = path(alpha, beta, place, float(1 / s))
        turn = 2 * pi / wavelength * (here - middle)
        modulus = share / (1 + here * float(s))
        real += modulus * np.cos(turn)
        imag += modulus * np.sin(turn)
    # Shares of one order are all but real, or all but imaginary.
    for _ in range(order % 4):
        real, imag = imag, -real
    angle = np.arctan(imag / np.where(real == 0, 1e-300, real))
    return angle + order * pi / 2, np.copysign(np.hypot(real, imag), real)


def layer_series(
    ends: tuple[Span, Span],
    box: Floats,
    layers: Floats,
    rest: Callable[[Floats, Floats, Place], Floats],
    wavelength: float,
    tolerance: float,
) -> tuple[list[Series], float] | None:
    """A series for each layer's shares of points' waves, and the relative error of all.

    ends : of α and of β
    box : (3, 2) of the points
    rest : α, β, place → what is left of the path at the middle range, metres

    None where one is long, or the first passes through 0.
    """
    every: list[Series] = []
    dropped = 0.0
    a, b = (np.array(sum(span) / 2) for span in ends)
    for order in range(len(layers)):

        def kernel(
            a: Floats, b: Floats, px: Floats, py: Floats, pz: Floats, order: int = order
        ) -> tuple[Floats, Floats]:
            place = px, py, pz
            angle, modulus = layer_waves(order, layers, a, b, place, wavelength)
            return 2 * pi / wavelength * rest(a, b, place) + angle, modulus

        some = np.meshgrid(*(np.linspace(low, high, 3) for low, high in box))
        _, modulus = kernel(a, b, some[0], some[1], some[2])
        if not order and modulus.min() <= 0:
            return None
        size = max(float(np.max(np.abs(modulus))), 1e-9) if order else 1.0
        enough = min(tolerance / size, _LOOSEST)
        series = make_series(*ends, box, kernel, enough, steepest=partial(kernel, order=0))
        if series is None:
            return None
        every.append(series)
        dropped = hypot(dropped, size * series.dropped)
    return every, dropped


def middle_range(layers: Floats) -> float:
    """r in the middle of the layers' 1/r, metres."""
    return 2 / float(layers[0] + layers[-1])


def polynomials(layers: Floats, span: tuple[float, float], at: Floats) -> list[Floats]:
    """T_0 … T_{L−1} at places 1/r of any shape."""
    out = [np.ones_like(at)]
    if len(layers) > 1:
        low, high = span
        u = (2 * at - low - high) / (high - low)
        out.append(u)
        while len(out) < len(layers):
            out.append(2 * u * out[-1] - out[-2])
    return out
