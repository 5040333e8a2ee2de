import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reconstruct.viewer.figure import length_words, round_length
from reconstruct.viewer.measure import Line, Region, profile, statistics
from reconstruct.viewer.sight import Sight, shrunk, sight_of
from reconstruct.viewer.view import View


def test_a_profile_of_a_ramp_is_straight_whatever_the_samples():
    rows, columns = np.mgrid[:60, :80]
    ramp = 3.0 * columns + 2.0 * rows
    line = Line((5.0, 10.0), (35.0, 70.0))
    share, values = profile(ramp, line, (60, 80))
    assert len(values) == 68 and values[0] == 40 and values[-1] == pytest.approx(280)
    assert np.allclose(values, 40 + share * 240)
    _, coarse = profile(ramp[::2, ::4], line, (60, 80))
    assert np.allclose(coarse, values, atol=1e-6)
    assert line.length(1e-3) == pytest.approx(1e-3 * np.hypot(30, 60))
    assert Line((10, 0), (0, 10)).angle == pytest.approx(45)  # up to the right


def test_statistics_of_a_region():
    image = np.ones((20, 30))
    image[5:8, 10:14] = 9
    found = statistics(image, Region((7.2, 13.1), (4.9, 9.8)))  # drawn from the lower right
    assert (found.least, found.most, found.mean) == (9, 9, 9) and found.speckle == 0
    assert found.light == pytest.approx(108 / (600 - 12 + 108))
    everything = statistics(image, Region((-5, -5), (99, 99)))
    assert everything.least == 1 and everything.light == pytest.approx(1)
    assert everything.speckle == pytest.approx(image.std() / image.mean())
    beside = statistics(image, Region((50, 50), (60, 60)))
    assert beside.mean == 1


@given(st.floats(1e-8, 5.0))
def test_scale_bars_are_round_and_fit(room):
    length = round_length(room)
    assert length <= room * (1 + 1e-6)
    if room > 2e-8:
        assert length > room / 2.6
        assert str(f"{length:.3e}")[0] in "125"


def test_lengths_have_units():
    assert [length_words(v) for v in (0.25173, 2e-3, 8.1e-6, 532e-9)] == [
        "251.73 mm", "2 mm", "8.1 µm", "532 nm",
    ]  # fmt: skip


@pytest.mark.parametrize("width", [364, 417, 510, 700])
def test_a_shrunk_hologram_shows_no_fringe_that_the_screen_cannot(width):
    """A zone plate: below the screen's Nyquist frequency its fringes stay, beyond all is even."""
    height = round(width * 1200 / 1920)
    y, x = np.mgrid[:1200, :1920] - np.array([600, 960])[:, None, None]
    plate = 127.5 + 127.5 * np.cos(np.pi * (x**2 + y**2) / 1920)  # Nyquist at the left edge
    levels = np.rint(plate).astype(np.uint8)
    small = shrunk(levels, Sight((0, 0, 1920, 1200), (width, height))).astype(float)
    factor = 1920 / width
    rows, columns = np.mgrid[:height, :width]
    radius = np.maximum(abs(rows - height / 2), abs(columns - width / 2)) * factor
    frequency = radius / 1920  # along the steeper axis, cycles per pixel of the hologram
    seen = 0.5 / factor
    beyond, within = small[frequency > 1.35 * seen], small[frequency < 0.6 * seen]
    assert within.std() > 60
    assert beyond.std() < 0.02 * 127.5
    boxes = levels[: height * int(factor), : width * int(factor)]
    boxes = boxes.reshape(height, int(factor), width, int(factor)).mean(axis=(1, 3))
    assert boxes[frequency > 1.35 * seen].std() > 3 * beyond.std()  # what means over blocks leave


def test_a_sight_is_what_the_view_shows():
    view = View(1920, 1200)
    view.resize(960, 600)
    assert sight_of(view, 1.0) == Sight((0, 0, 1920, 1200), (960, 600))
    assert sight_of(view, 2.0).size == (1920, 1200)  # twice the dots: pixel by pixel
    view.show(960, 600, 0.75)
    sight = sight_of(view, 1.0)
    assert sight.box == (320, 200, 1600, 1000) and sight.size == (960, 600)
    assert sight.covers == (320, 200, 1280, 800)
    levels = np.arange(1200 * 1920, dtype=np.uint32).reshape(1200, 1920).astype(np.uint8)
    assert shrunk(levels, sight).shape == (600, 960)
    view.show(960, 600, 3.0)
    assert shrunk(levels, sight_of(view, 1.0)) is levels
