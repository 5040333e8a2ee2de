"""Points at one place are one point, for every method."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from chrmc import SLM, WAVELENGTH, PointCloud, compute_field
from chrmc.bench import extremes
from chrmc.cgh import METHODS
from chrmc.reference import reference_field, relative_error
from chrmc.scene.coincident import merged

PANEL = SLM("s", 60, 40, 20e-6)


def crowd(seed: int, places: int, points: int) -> PointCloud:
    """Points of random strength, at least one at each place."""
    random = np.random.default_rng(seed)
    where = random.uniform((-2e-4, -2e-4, 0.2), (2e-4, 2e-4, 0.201), (places, 3))
    at = np.append(np.arange(places), random.integers(places, size=points - places))
    random.shuffle(at)
    light = random.uniform(-1, 1, points), random.uniform(-9, 9, points)
    return PointCloud(where[at], *light, random.random((points, 3)))


@given(st.integers(0, 99), st.integers(1, 20), st.integers(0, 40))
def test_the_wave_of_a_place_is_the_sum_of_its_points(seed: int, places: int, more: int) -> None:
    cloud = crowd(seed, places, places + more)
    one = merged(cloud)
    assert len(one) == places and (one is cloud) == (more == 0)
    true = reference_field(cloud, PANEL, WAVELENGTH)
    assert relative_error(reference_field(one, PANEL, WAVELENGTH), true) < 1e-9
    _, first = np.unique(cloud.positions, axis=0, return_index=True)
    first.sort()
    assert np.array_equal(one.positions, cloud.positions[first])
    assert np.array_equal(one.colour, cloud.colour[first])


def test_what_all_but_cancels_is_left_to_the_methods() -> None:
    cloud = PointCloud([[0, 0, 0.2]] * 2, [1, 1], [0, np.pi * (1 + 1e-9)])
    assert merged(cloud) is cloud


def test_neighbours_in_the_last_digit_stay_apart() -> None:
    z = 0.2
    cloud = PointCloud([[0, 0, z], [0, 0, np.nextafter(z, 1)], [0, 0, z]], [1, 1, 1], [0, 0, 1])
    assert len(merged(cloud)) == 2


@pytest.mark.parametrize("method", METHODS)
def test_every_method_sees_one_point(method: str) -> None:
    cloud = crowd(1, 5, 30)
    made = compute_field(cloud, PANEL, WAVELENGTH, method)
    assert np.array_equal(made, compute_field(merged(cloud), PANEL, WAVELENGTH, method))


def test_a_place_of_many_points_is_kept_to_the_tolerance() -> None:
    """57,854 points at one place: their errors add in amplitude, so none could be promised."""
    out = extremes.run(extremes.case_of(1795316380))
    assert not out.fault and not out.refused and out.error < 1e-6 and out.cpu < 2
