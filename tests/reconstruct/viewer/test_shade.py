import numpy as np
import pytest

from reconstruct.viewer.shade import (
    COLOURS,
    Look,
    colour_table,
    level_of,
    light_of,
    shade,
    shade_difference,
)


def test_shades():
    field = np.array([[0, 1, 2, 1j, -1]], dtype=np.complex64)
    plain = shade(field, 4.0, Look(gamma=1.0))
    assert plain[0, :, 0].tolist() == [0, 64, 255, 64, 64]
    assert (plain == plain[..., :1]).all()
    brighter = shade(field, 4.0, Look(gamma=1.0, stops=1.0))
    assert brighter[0, 1, 0] == 128
    log = shade(field, 4.0, Look("log"))[0, :, 0]
    assert log[0] == 0 and log[2] == 255 and 200 < log[1] < 255
    phase = shade(field, 1.0, Look("phase"))[0].astype(int)
    assert phase[1, 0] > 200 and max(phase[1, 1:]) < 30  # 0 is red
    assert phase[4, 0] < 30  # π has no red


@pytest.mark.parametrize("name", COLOURS)
def test_colours_are_in_order_of_lightness(name):
    table = colour_table(name)
    lightness = table @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(lightness) > -1e-3).all() and lightness[-1] > lightness[0] + 0.4


@pytest.mark.parametrize("look", [Look(), Look("log"), Look(gamma=1.0, stops=-2.0)])
def test_a_colour_bar_tells_the_intensity_of_each_level(look):
    for level in (0.1, 0.5, 1.0):
        light = np.array([light_of(level, 7.0, look)])
        assert level_of(light, 7.0, look)[0] == pytest.approx(level)


def test_no_difference_is_neutral():
    got = shade_difference(np.zeros((1, 1)), 1.0, Look()).astype(int)[0, 0]
    assert np.ptp(got) <= 6
