import pytest
from hypothesis import given
from hypothesis import strategies as st

from reconstruct.viewer.view import MAX_ZOOM, View


def view():
    made = View(1920, 1200)
    made.resize(800, 600)
    return made


def test_fits_at_first_and_after_resizing():
    made = view()
    assert made.scale == pytest.approx(800 / 1920)
    assert made.to_screen(0, 0) == pytest.approx((0, 50))
    assert made.to_screen(1920, 1200) == pytest.approx((800, 550))
    made.resize(1920, 300)
    assert made.scale == pytest.approx(0.25)


@given(
    st.floats(0, 800),
    st.floats(0, 600),
    st.lists(st.floats(1.05, 3), min_size=1, max_size=5),
)
def test_zooming_keeps_what_is_under_the_cursor(sx, sy, factors):
    made = view()
    made.show(960, 600, 2.0)
    before = made.to_picture(sx, sy)
    for factor in factors:
        made.zoom_at(sx, sy, factor)
    assert made.to_picture(sx, sy) == pytest.approx(before, abs=1e-6)
    assert made.scale <= MAX_ZOOM
    assert made.to_screen(*made.to_picture(123, 45)) == pytest.approx((123, 45))


def test_panning_moves_with_the_hand_and_stays_on_the_picture():
    made = view()
    made.show(960, 600, 4.0)
    before = made.to_picture(400, 300)
    made.pan(40, -20)
    assert made.to_picture(440, 280) == pytest.approx(before)
    made.pan(1e6, 1e6)
    assert (made.x, made.y) == (0, 0)


def test_zooming_out_ends_at_the_fit():
    made = view()
    made.zoom_at(10, 10, 30)
    for _ in range(30):
        made.zoom_at(10, 10, 0.5)
    assert made.zoom is None and made.scale == made.fitting
    made.zoom_at(0, 0, 1e6)
    assert made.scale == MAX_ZOOM


def test_pixels_under_the_cursor():
    made = view()
    made.show(100.5, 50.5, 10.0)
    assert made.pixel_at(400, 300) == (50, 100)
    assert made.pixel_at(406, 300) == (50, 101)
    made.fit()
    assert made.pixel_at(400, 10) is None
