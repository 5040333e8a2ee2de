"""Lasers and colours: the eye's side against published numbers, the scene's against energy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from chrmc.colour import laser_powers, linear, mixed, primaries, spectral_xyz, srgb_levels

RGB_LASERS = (638e-9, 532e-9, 450e-9)


@pytest.mark.parametrize(
    ("nm", "xyz"),
    [
        # CIE 1931 2° colour-matching functions, Wyszecki and Stiles, Table I(3.3.1)
        (450, (0.3362, 0.0380, 1.7721)),
        (530, (0.1655, 0.8620, 0.0422)),
        (555, (0.5121, 1.0000, 0.0057)),
        (600, (1.0622, 0.6310, 0.0008)),
        (640, (0.4479, 0.1750, 0.0000)),
    ],
)
def test_colour_matching_functions(nm: float, xyz: tuple[float, float, float]) -> None:
    assert spectral_xyz(nm * 1e-9) == pytest.approx(xyz, abs=0.02)


def test_balanced_lasers_make_white_and_each_has_its_hue() -> None:
    assert mixed([1, 1, 1], RGB_LASERS) == pytest.approx([1, 1, 1], abs=1e-12)
    red, green, blue = mixed(np.eye(3), RGB_LASERS)
    assert red.argmax() == 0 and green.argmax() == 1 and blue.argmax() == 2


@given(st.lists(st.floats(0, 1), min_size=3, max_size=3))
def test_three_lasers_mix_srgb_colours(colour: list[float]) -> None:
    powers = laser_powers([colour], RGB_LASERS)
    assert powers.min() >= 0
    # The blue of sRGB, (0.150, 0.060), lies just outside the triangle of these lasers.
    exact = colour[2] <= min(colour[:2]) * 5
    assert mixed(powers, RGB_LASERS)[0] == pytest.approx(colour, abs=1e-9 if exact else 0.05)


def test_one_laser_shows_brightness_and_impossible_sets_are_refused() -> None:
    green_is_brighter = laser_powers(np.eye(3), [532e-9])[:, 0]
    assert green_is_brighter == pytest.approx([0.2126, 0.7152, 0.0722])
    with pytest.raises(ValueError, match="cannot be mixed to a white"):
        primaries([638e-9, 650e-9])
    with pytest.raises(ValueError, match="has no colour"):
        spectral_xyz(1064e-9)


def test_the_sRGB_curve_goes_back_and_forth() -> None:
    levels = np.arange(256)
    assert np.array_equal(srgb_levels(linear(levels / 255)), levels)
    assert srgb_levels(0.18) == 118  # middle grey
