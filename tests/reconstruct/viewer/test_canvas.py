import numpy as np
import pytest

from reconstruct.viewer.canvas import Canvas
from reconstruct.viewer.shade import COLOURS, MODES, Look, shade, shade_difference
from reconstruct.viewer.sight import fourier_covers
from reconstruct.viewer.view import View

RNG = np.random.default_rng(2)
FIELD = (RNG.standard_normal((30, 40)) + 1j * RNG.standard_normal((30, 40))).astype(np.complex64)


def view_of(shape, size):
    made = View(shape[1], shape[0])
    made.resize(*size)
    return made


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("colours", COLOURS)
def test_the_shader_shades_like_numpy(context, mode, colours):
    look = Look(mode, colours, gamma=1.8, stops=0.5)
    canvas = Canvas(context, "complex")
    canvas.upload(FIELD, 1)
    canvas.draw((40, 30), view_of(FIELD.shape, (40, 30)), look, 2.0)
    got, want = canvas.read().astype(int), shade(FIELD, 2.0, look).astype(int)
    assert np.abs(got - want).max() <= 1


def test_the_lasers_colours_are_shown_in_grey_and_nowhere_else(context):
    glow = RNG.exponential(size=(30, 40, 3)).astype(np.float32)
    view = view_of(FIELD.shape, (40, 30))
    canvas = Canvas(context, "complex")
    canvas.upload(FIELD, 1, glow=glow)
    for look in (Look(gamma=1.8, stops=0.5), Look("log"), Look(colours="magma"), Look("phase")):
        canvas.draw((40, 30), view, look, 2.0)
        want = shade(FIELD, 2.0, look, glow).astype(int)
        assert np.abs(canvas.read().astype(int) - want).max() <= 1
    canvas.upload(FIELD, 2)  # a picture of one laser follows
    canvas.draw((40, 30), view, Look(), 2.0)
    want = shade(FIELD, 2.0, Look()).astype(int)
    assert np.abs(canvas.read().astype(int) - want).max() <= 1


def test_zoom_and_pan_show_the_pixels_that_the_view_says(context):
    grey = RNG.integers(0, 256, (30, 40), dtype=np.uint8)
    view = view_of(grey.shape, (64, 48))
    view.show(20.3, 10.7, 7.0)
    canvas = Canvas(context, "grey")
    canvas.upload(grey, 1)
    canvas.draw((64, 48), view, Look(), 1.0)
    got = canvas.read()
    for sx, sy in ((3, 2), (31, 20), (60, 45), (40, 7)):
        pixel = view.pixel_at(sx + 0.5, sy + 0.5)
        assert pixel is not None
        assert got[sy, sx].tolist() == [grey[pixel]] * 3


def test_zoomed_out_shows_the_mean(context):
    grey = np.zeros((40, 40), dtype=np.uint8)
    grey[::2, ::2] = 200
    canvas = Canvas(context, "grey")
    canvas.upload(grey, 1)
    canvas.draw((20, 20), view_of(grey.shape, (20, 20)), Look(), 1.0)
    assert np.abs(canvas.read().astype(int) - 50).max() <= 1


def test_the_fourier_plane_is_square_and_centred_and_what_is_blocked_is_red(context):
    spectrum = np.zeros((6, 8), dtype=np.float32)
    spectrum[3, 4] = 1  # zero frequency is in the middle
    passed = np.ones((6, 8), dtype=np.float32)
    passed[2] = 0
    canvas = Canvas(context, "power")
    canvas.upload(spectrum, 1, fourier_covers((6, 8), 48))
    canvas.upload_mask(passed)
    canvas.draw((48, 48), view_of((48, 48), (48, 48)), Look(gamma=1), 1.0)
    got = canvas.read().astype(int)
    lit = np.argwhere(got[..., 1] > 250)
    assert lit.mean(axis=0) == pytest.approx([23.5, 23.5], abs=0.51)
    assert np.ptp(lit[:, 0]) + 1 == 8 and np.ptp(lit[:, 1]) + 1 == 6
    row = got[23 - 8, :45]  # the last half sample lies beyond the band
    assert (row[:, 0] > 50).all() and (row[:, 1] < 30).all()


def test_values_may_stand_for_a_part_of_the_picture_with_other_samples(context):
    canvas = Canvas(context, "grey")
    canvas.upload(np.array([[10, 20], [30, 40]], dtype=np.uint8), 1, (4.0, 8.0, 8.0, 4.0))
    canvas.draw((16, 16), view_of((16, 16), (16, 16)), Look(), 1.0)
    got = canvas.read()[..., 0]
    assert (got[8:10, 4:8] == 10).all() and (got[8:10, 8:12] == 20).all()
    assert (got[10:12, 4:8] == 30).all() and (got[10:12, 8:12] == 40).all()
    assert (got[:8] == got[0, 0]).all() and (got[:, 12:] == got[0, 0]).all()


def test_differences_have_a_sign(context):
    values = np.linspace(-2, 2, 40, dtype=np.float32)[None].repeat(30, axis=0)
    canvas = Canvas(context, "signed")
    canvas.upload(values, 1)
    canvas.draw((40, 30), view_of((30, 40), (40, 30)), Look(), 1.5)
    got = canvas.read().astype(int)
    assert np.abs(got - shade_difference(values, 1.5, Look()).astype(int)).max() <= 1
    assert got[0, 0, 2] > got[0, 0, 0] and got[0, -1, 0] > got[0, -1, 2]  # blue, red


def test_pictures_are_uploaded_once_per_key_and_may_change_size(context):
    canvas = Canvas(context, "complex")
    assert canvas.upload(FIELD, "a") and not canvas.upload(0 * FIELD, "a")
    assert canvas.upload(FIELD[:10, :12], "b")
    canvas.draw((12, 10), view_of((10, 12), (12, 10)), Look(), 1.0)
    want = shade(FIELD[:10, :12], 1.0, Look()).astype(int)
    assert np.abs(canvas.read().astype(int) - want).max() <= 1
