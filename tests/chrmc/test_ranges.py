"""Units at the door: what is meant is said, and single precision goes no further."""

import numpy as np
import pytest

import chrmc
from chrmc.ranges import DISTANCE_RANGE, PITCH_RANGE, WAVELENGTH_RANGE

PANEL = chrmc.SLM("small", 60, 40, 8.1e-6)
CLOUD = chrmc.PointCloud([[0, 0, 0.25], [1e-4, 2e-4, 0.26]], [1, 1], [0, 1])


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (532, "532e-9 for 532 nm"),
        (0.532, "0.532e-6 for 0.532 µm"),
        (0, "metres"),
        (-5e-7, "metres"),
    ],
)
def test_a_wavelength_in_other_units_is_told_what_was_meant(value: float, words: str) -> None:
    for door in (
        lambda: chrmc.compute_field(CLOUD, PANEL, value),
        lambda: chrmc.reference_field(CLOUD, PANEL, value),
        lambda: next(chrmc.video(chrmc.load_scene("car-house"), PANEL, value)),
        lambda: chrmc.generate("car-house", "never", slm=PANEL, wavelength=value),
    ):
        with pytest.raises(ValueError, match=words) as caught:
            door()
        assert "\n" not in str(caught.value)


def test_a_pitch_and_a_distance_in_other_units_are_told_what_was_meant() -> None:
    with pytest.raises(ValueError, match="8e-6 for 8 µm"):
        chrmc.SLM("mine", 1920, 1080, 8)
    with pytest.raises(ValueError, match="250e-3 for 250 mm"):
        chrmc.compute_field(chrmc.PointCloud([[0, 0, 250]], [1], [0]), PANEL, 532e-9)


@pytest.mark.parametrize("value", [None, "532e-9", True, np.nan, np.inf, 10**400, 1j, [5e-7]])
def test_what_is_no_finite_number_is_refused(value: object) -> None:
    with pytest.raises(ValueError, match="wavelength must be a"):
        WAVELENGTH_RANGE.of(value)


def test_every_case_of_the_stated_domain_passes() -> None:
    for value in (200e-9, 10.6e-6, 1e-3):
        assert WAVELENGTH_RANGE.of(value) == value
    for value in (0.5e-6, 100e-6):
        assert PITCH_RANGE.of(value) == value
    for value in (1e-3, 100.0):
        assert DISTANCE_RANGE.of(value) == value


@pytest.mark.parametrize("method", ["rt", "curved", "fresnel"])
def test_single_precision_scalars_count_as_the_numbers_they_are(method: str) -> None:
    single = chrmc.SLM("small", np.int32(60), np.uint16(40), np.float32(8.1e-6))  # type: ignore[arg-type]
    double = chrmc.SLM("small", 60, 40, float(np.float32(8.1e-6)))
    assert type(single.width) is int
    assert type(single.pixel_pitch) is float
    wavelength = np.float32(532e-9)
    narrow = chrmc.compute_field(CLOUD, single, wavelength, method)  # type: ignore[arg-type]
    wide = chrmc.compute_field(CLOUD, double, float(wavelength), method)
    np.testing.assert_array_equal(narrow, wide)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((0, 5, 8e-6), "between 1 and"),
        ((5.5, 5, 8e-6), "whole number"),
        ((10**40, 5, 8e-6), "between 1 and"),
        ((60000, 60000, 8e-6), "pixels in all"),
        ((5, 5, 1e308), "pixel_pitch"),
    ],
)
def test_a_panel_that_cannot_be_is_refused(arguments: tuple, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        chrmc.SLM("odd", *arguments)


def test_a_refresh_rate_that_cannot_be_is_refused() -> None:
    for refresh in (np.inf, 1e29, "often", 0):
        with pytest.raises(ValueError, match="refresh"):
            chrmc.SLM("odd", 5, 5, 8e-6, refresh=refresh)  # type: ignore[arg-type]
