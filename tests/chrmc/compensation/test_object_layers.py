"""How light on the sphere changes with range: layers against waves taken one by one."""

import numpy as np
import pytest

from chrmc import WAVELENGTH
from chrmc.cgh.curved.interface import chebyshev
from chrmc.compensation.ch_rmc_object.chart import Floats, Place, path
from chrmc.compensation.ch_rmc_object.layers import (
    layer_series,
    layer_waves,
    middle_range,
    polynomials,
)

SPAN = (3.96, 4.04)  # 1/r
BOX = np.array([[-8e-4, 8e-4], [-3.5e-4, 3.5e-4], [-4e-4, 4e-4]])
ENDS = (0.18, 0.22), (0.03, 0.06)


def layers_of(count: int) -> Floats:
    low, high = SPAN
    return (low + high) / 2 + (high - low) / 2 * chebyshev(count)


def wave(alpha: Floats, beta: Floats, place: Place, r: float) -> np.ndarray:
    """The wave at a range over its phase at the middle of `SPAN`, from the distance itself."""
    gamma = np.sqrt(1 - alpha * alpha - beta * beta)
    x, y, z = place
    far = np.sqrt((r * alpha - x) ** 2 + (r * beta - y) ** 2 + (r * gamma + z) ** 2)
    middle = path(alpha, beta, place, 2 / sum(SPAN))
    return np.asarray(r / far * np.exp(2j * np.pi / WAVELENGTH * (far - r - middle)))


@pytest.mark.parametrize(("count", "error"), [(1, 0.17), (2, 7e-3), (3, 2e-4), (5, 5e-7)])
def test_layers_add_up_to_the_wave_at_every_range(count: int, error: float) -> None:
    random = np.random.default_rng(count)
    x, y, z = (random.uniform(low, high, 40) for low, high in BOX)
    alpha, beta = np.array(0.2), np.array(0.05)
    layers = layers_of(count)
    for s in (SPAN[0], 3.99, 4.013, SPAN[1]):
        total = 0j
        for order, share in enumerate(polynomials(layers, SPAN, np.array(s))):
            angle, modulus = layer_waves(order, layers, alpha, beta, (x, y, z), WAVELENGTH)
            total = total + share * modulus * np.exp(1j * angle)
        assert np.abs(total - wave(alpha, beta, (x, y, z), 1 / s)).max() < error


def test_layers_that_are_little_take_few_terms_and_keep_the_tolerance() -> None:
    layers = layers_of(3)
    a, b = np.array(0.2), np.array(0.045)
    r = middle_range(layers)

    def rest(alpha: Floats, beta: Floats, place: Place) -> Floats:
        crossed = path(alpha, b, place, r) + path(a, beta, place, r)
        return path(alpha, beta, place, r) + path(a, b, place, r) - crossed

    made = layer_series(ENDS, BOX, layers, rest, WAVELENGTH, 2e-4)
    assert made is not None
    series, dropped = made
    assert dropped < 4e-4
    terms = [one.terms for one in series]
    assert len(terms) == 3 and terms[2] < min(terms[:2])
    random = np.random.default_rng(0)
    place = np.stack([random.uniform(low, high, 60) for low, high in BOX])
    alpha, beta = np.linspace(*ENDS[0], 9), np.linspace(*ENDS[1], 7)
    at = 3.975
    total = np.zeros((7, 9, 60), dtype=complex)
    for one, share in zip(series, polynomials(layers, SPAN, np.array(at)), strict=True):
        on = one.on_nodes(alpha, beta, np.float64)
        values = np.stack([real + 1j * imag for real, imag in map(on.of, range(one.terms))])
        total += share * np.tensordot(values, one.at_points(place.T), (0, 0))
    full = alpha[:, None], beta[:, None, None]
    cloud = place[0], place[1], place[2]
    turn = np.exp(2j * np.pi / WAVELENGTH * rest(*full, cloud))
    truth = wave(*full, cloud, 1 / at) * turn
    assert np.sqrt(np.mean(np.abs(total - truth) ** 2)) < 6e-4
