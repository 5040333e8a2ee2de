"""The exact sum: what double precision leaves of waves that all but cancel."""

import numpy as np
import pytest

from chrmc import SLM, PointCloud
from chrmc.cgh import curved
from chrmc.cgh.curved.direct import direct_field
from chrmc.cgh.curved.exact import rounding_of, rounding_seen
from chrmc.optics.passband import UNLIMITED
from chrmc.reference import reference_field, relative_error
from chrmc.window import Window

NOWHERE = np.inf, np.inf
longer = pytest.mark.skipif(
    np.finfo(np.longdouble).eps > 1e-18, reason="this machine has no longer floats"
)


def against(count: int, turned: float, depth: float) -> PointCloud:
    """Points in a row along z, and as many that all but cancel them."""
    random = np.random.default_rng(0)
    places = np.stack([np.full(count, 1e-3), np.full(count, 2e-3), depth + np.arange(count) * 1e-6])
    phase, amplitude = random.uniform(0, 2 * np.pi, count), random.uniform(0.2, 1, count)
    return PointCloud(
        np.concatenate([places.T] * 2),
        np.concatenate([amplitude] * 2),
        np.concatenate([phase, phase + np.pi * (1 + turned)]),
    )


def test_phases_that_turn_past_a_whole_one_leave_nothing_behind() -> None:
    """A turn of 2π in double precision is too short by 2e-16, alike for half of the waves."""
    slm, wavelength = SLM("pixel", 1, 1, 6.4e-6), 7.8e-7
    cloud = against(40_000, 1e-9, 0.3)
    exact = direct_field(cloud, slm.x(), slm.y(), wavelength, NOWHERE)
    truth = reference_field(cloud, slm, wavelength, footprint=None)
    assert np.abs(truth).max() < 1e-8 * (cloud.amplitude / cloud.positions[:, 2]).sum()
    assert relative_error(exact, truth) < 1e-6


@longer
def test_pairs_that_cancel_are_kept_though_their_paths_have_too_few_digits() -> None:
    slm, wavelength = SLM("few", 4, 3, 6.4e-6), 7.8e-7
    cloud = against(2000, 1e-9, 0.3)
    given = cloud, slm.x(), slm.y(), wavelength, NOWHERE
    exact = direct_field(*given)
    # Their errors cancel as they do, which no bound knows.
    assert rounding_of(exact, *given) > 1e-2 and rounding_seen(exact, *given) < 1e-6
    window = Window.full(slm)
    made = curved.field(cloud, slm, wavelength, window, UNLIMITED, tolerance=1e-5)
    assert relative_error(made, reference_field(cloud, slm, wavelength, footprint=None)) < 1e-5


def test_a_ring_of_opposite_waves_is_refused_for_what_its_paths_lack() -> None:
    """Aside by 20,000 wavelengths: neighbours cancel to less than their places are known to."""
    slm, wavelength = SLM("column", 1, 94, 1.6e-6), 9.4e-6
    angle = 2 * np.pi * np.arange(30_000) / 30_000
    places = np.stack([2e-3 * np.cos(angle) + 0.2, 2e-3 * np.sin(angle), np.full(30_000, 0.28)])
    cloud = PointCloud(places.T, np.ones(30_000), np.pi * (np.arange(30_000) % 2))
    with pytest.raises(ValueError, match="holds what is left to"):
        curved.field(cloud, slm, wavelength, Window.full(slm), UNLIMITED, tolerance=1e-3)
    ordinary = PointCloud(places.T, np.ones(30_000), np.arange(30_000) ** 2 % 7.0)
    given = ordinary, slm.x(), slm.y(), wavelength, NOWHERE
    exact = direct_field(*given)
    assert (rounding_of(exact, *given) < 1e-7 and rounding_seen(exact, *given) < 1e-7) or (
        rounding_seen(exact, *given) == np.inf
    )
