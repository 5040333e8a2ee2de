"""Expected errors against measured ones, on scenes that the estimate was not made for."""

from typing import Any

import numpy as np
import pytest

import chrmc
from chrmc.cgh import method_named
from chrmc.encoding import coding_for
from chrmc.optics.passband import Passband
from chrmc.planning.errors import expected_error
from chrmc.reference import reference_samples, relative_error

PANEL = chrmc.SLM("half", 960, 600, 8.1e-6)

# depth and its range, width: near, the usual, far
PLACES = {"near": (0.05, 2e-3, 2e-3), "usual": (0.2, 1e-2, 3e-3), "far": (1.0, 2e-2, 4e-3)}
METHODS: list[tuple[str, dict[str, Any]]] = [
    ("rt", {}),
    ("fresnel", {}),
    ("nlut", {}),
    ("nlut", {"subpixel": "round"}),
    ("nlut-1d", {}),
    ("wrp", {"guard": 8.0}),
    ("wrp", {}),
]


def some_points(place: str, count: int = 12) -> chrmc.PointCloud:
    depth, deep, wide = PLACES[place]
    random = np.random.default_rng(len(place))
    positions = random.uniform(-0.5, 0.5, (count, 3)) * [wide, wide, deep] + [0, 0, depth]
    return chrmc.PointCloud(
        positions, random.uniform(0.5, 1, count), random.uniform(0, 6.28, count)
    )


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(("name", "options"), METHODS, ids=lambda v: str(v))
def test_within_a_factor_of_three(name: str, options: dict[str, Any], place: str) -> None:
    cloud, band = some_points(place), coding_for("ssb", PANEL).passband
    expected = expected_error(method_named(name), cloud, PANEL, 532e-9, band, **options)
    field = chrmc.compute_field(cloud, PANEL, 532e-9, name, passband=band, **options)
    rows, columns = np.random.default_rng(1).integers(0, [[600], [960]], (2, 1000))
    truth = reference_samples(cloud, PANEL, 532e-9, rows, columns, passband=band)
    assert expected is not None
    assert 1 / 3 < expected / relative_error(field[rows, columns], truth) < 3


def test_steep_waves_are_summed_in_double() -> None:
    fine, band = chrmc.SLM("fine", 1500, 1200, 1e-6), Passband(4.9e5, 4.9e5)
    random = np.random.default_rng(1)
    positions = random.uniform([-1e-4, -1e-4, 4.9e-3], [1e-4, 1e-4, 5.1e-3], (4, 3))
    cloud = chrmc.PointCloud(positions, np.ones(4), np.zeros(4))
    expected = expected_error(method_named("rt"), cloud, fine, 532e-9, band)
    field = chrmc.compute_field(cloud, fine, 532e-9, "rt", passband=band)
    rows, columns = random.integers(0, [[1200], [1500]], (2, 500))
    truth = reference_samples(cloud, fine, 532e-9, rows, columns, passband=band)
    assert expected is not None
    assert 1 / 3 < expected / relative_error(field[rows, columns], truth) < 3


def test_every_method_says_what_it_costs_and_how_wrong_it_is() -> None:
    for name in chrmc.cgh.METHODS:
        method = method_named(name)
        assert method.cost is not None
        assert method.waves is not None or method.takes("tolerance")
