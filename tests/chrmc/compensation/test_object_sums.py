"""Sums on a grid of directions, piece by piece against plain NumPy in double precision."""

import numpy as np
import pytest

from chrmc.compensation.ch_rmc_object.chart import path
from chrmc.compensation.ch_rmc_object.sums import (
    chunks_of,
    cycles_of,
    phase_table,
    product_of,
    weighed,
)

WAVELENGTH = 532e-9


@pytest.mark.parametrize("count", [2, 30, 400])
@pytest.mark.parametrize(("ends", "other"), [((-0.05, 0.11), 0.0), ((-0.6, 0.6), 0.1)])
def test_cycles_from_few_places_are_the_cycles(
    count: int, ends: tuple[float, float], other: float
) -> None:
    place = tuple(np.random.default_rng(0).uniform(-2e-3, 2e-3, (3, 20, 1)))
    at, beta = np.linspace(*ends, count), np.array(other)

    def length(a: np.ndarray) -> np.ndarray:
        return path(a, beta, place, 0.25)

    found = cycles_of(length, at, beta, WAVELENGTH)
    assert found.shape == (20, count)
    assert np.abs(found - length(at) / WAVELENGTH).max() < 1e-10
    assert np.array_equal(cycles_of(length, at[:1], beta, WAVELENGTH), length(at[:1]) / WAVELENGTH)


@pytest.mark.parametrize(("real", "exact"), [(np.float32, 3e-7), (np.float64, 1e-9)])
def test_a_table_is_cosine_and_sine_of_many_turns(real: type, exact: float) -> None:
    cycles = np.array([[0.0, 0.25, -0.3, 1234567.125, -7654321.4]])
    cos, sin = phase_table(cycles.copy(), real)
    assert cos.dtype == real
    assert np.abs(cos - np.cos(2 * np.pi * (cycles % 1))).max() < exact
    assert np.abs(sin - np.sin(2 * np.pi * (cycles % 1))).max() < exact


def test_products_are_sums_over_terms_and_points() -> None:
    random = np.random.default_rng(1)
    terms, count, wide, high = 3, 5, 7, 4
    across, down = (
        random.normal(size=(2, count, wide)),
        random.normal(size=(2, count, high)),
    )
    scale = random.normal(size=(terms, count))
    weights = random.normal(size=(terms, high, wide)) + 1j * random.normal(size=(terms, high, wide))
    found = product_of(across, down, scale, weights)
    a, d = across[0] + 1j * across[1], down[0] + 1j * down[1]
    want = np.einsum("tba,tn,nb,na->ba", weights, scale, d, a)
    assert np.abs(found - want).max() < 1e-12 * np.abs(want).max()


@pytest.mark.parametrize(("count", "number"), [(3, 1), (64, 1), (65, 2), (4096, 2), (4097, 3)])
def test_chunks_hold_every_point_once(count: int, number: int) -> None:
    found = chunks_of(count)
    held = np.zeros(count, dtype=int)
    for part in found:
        held[part] += 1
        assert 0 < part.stop - part.start <= 2048
    assert np.all(held == 1) and len(found) == number


@pytest.mark.parametrize("kind", [np.complex64, np.complex128])
def test_weighed_neighbours_are_their_weighted_sums(kind: type) -> None:
    random = np.random.default_rng(2)
    values = (random.normal(size=(50, 2)) + 1j * random.normal(size=(50, 2))).astype(kind)
    start = random.integers(0, 44, (3, 4))
    weight = random.normal(size=(3, 4, 6)).astype(np.float32)
    found = weighed(values, start, weight)
    want = np.sum(weight[..., None] * values[start[..., None] + np.arange(6)], axis=-2)
    assert found.dtype == kind and np.abs(found - want).max() < 2e-6
