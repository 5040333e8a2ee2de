"""A factor is shown only where expectation and a look at its pixels agree that it is right."""

import numpy as np
import pytest

from chrmc import SLM, WAVELENGTH, PointCloud
from chrmc.cgh.curved.interface import Budget, low_rank, plane_of
from chrmc.compensation.ch_rmc_object.promise import Promise
from chrmc.optics.passband import full_band
from chrmc.window import Window

PANEL = SLM("small", 240, 160, 16e-6)


def points(count: int, seed: int = 1) -> PointCloud:
    random = np.random.default_rng(seed)
    positions = (random.random((count, 3)) - 0.5) * 5e-4 + np.array([0, 0, 0.2])
    return PointCloud(positions, np.ones(count), random.uniform(0, 6.3, count))


@pytest.mark.parametrize(
    ("count", "frames", "looked"),
    [(60, None, True), (60, 3, True), (5001, None, True), (5001, 3, False), (5001, 8, True)],
)
def test_a_wrong_factor_is_refused_when_it_is_looked_at(
    count: int, frames: int | None, looked: bool
) -> None:
    window, band = Window.full(PANEL), full_band(PANEL)
    cloud = points(count)
    low = low_rank(cloud, PANEL, WAVELENGTH, window, band)
    (factor,) = low.factors
    plane = plane_of(PANEL, WAVELENGTH, window, band)
    promise = Promise(plane, 1e-3)
    assert promise.kept(factor, cloud, low.budget, frames)
    assert not promise.kept(
        factor, cloud, Budget(2e-6 * low.budget.light, low.budget.light), frames
    )
    for part in (factor.real, factor.imag):
        part *= np.float32(1.003)
    assert promise.kept(factor, cloud, low.budget, frames) == (not looked)
    assert Promise(plane, 1e-2).kept(factor, cloud, low.budget, frames)


def test_objects_that_cancel_are_looked_at_together() -> None:
    window, band = Window.full(PANEL), full_band(PANEL)
    one = points(60)
    other = PointCloud(one.positions, 0.99 * one.amplitude, one.phase + np.pi)
    made = [low_rank(cloud, PANEL, WAVELENGTH, window, band) for cloud in (one, other)]
    both = PointCloud.concatenate([one, other])
    plane = plane_of(PANEL, WAVELENGTH, window, band)
    promise = Promise(plane, 1e-3)
    total = made[0].budget + made[1].budget
    factors = [low.factors[0] for low in made]
    for part in (factors[1].real, factors[1].imag):
        part *= np.float32(1.0005)  # little of each, much of what they leave
    assert promise.broken_together(factors, both, total)
    apart = [
        made[0].factors[0],
        low_rank(points(60, 2), PANEL, WAVELENGTH, window, band).factors[0],
    ]
    united = PointCloud.concatenate([one, points(60, 2)])
    assert not promise.broken_together(apart, united, total)
