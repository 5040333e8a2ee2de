import sys

import moderngl
import numpy as np
import pytest

from reconstruct.viewer.canvas import Canvas
from reconstruct.viewer.shade import MODES, TINTS, Look, shade
from reconstruct.viewer.view import View

RNG = np.random.default_rng(2)
FIELD = (RNG.standard_normal((30, 40)) + 1j * RNG.standard_normal((30, 40))).astype(np.complex64)


@pytest.fixture(scope="module")
def context():
    backend = {"backend": "egl"} if sys.platform.startswith("linux") else {}
    made = moderngl.create_context(standalone=True, **backend)
    yield made
    assert made.error == "GL_NO_ERROR"
    made.release()


def view_of(shape, size):
    made = View(shape[1], shape[0])
    made.resize(*size)
    return made


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("tint", TINTS)
def test_the_shader_shades_like_numpy(context, mode, tint):
    look = Look(mode, tint, gamma=1.8, stops=0.5)
    canvas = Canvas(context, "complex")
    canvas.upload(FIELD, 1)
    canvas.draw((40, 30), view_of(FIELD.shape, (40, 30)), look, 2.0)
    got, want = canvas.read().astype(int), shade(FIELD, 2.0, look).astype(int)
    assert np.abs(got - want).max() <= 1


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


def test_the_fourier_plane_is_centred_and_what_is_blocked_is_red(context):
    spectrum = np.zeros((6, 8), dtype=np.complex64)
    spectrum[0, 0] = 1
    passed = np.ones((6, 8), dtype=np.float32)
    passed[5] = 0  # the frequency before zero: the row above the middle
    canvas = Canvas(context, "complex", shifted=True)
    canvas.upload(spectrum, 1)
    canvas.upload_mask(passed)
    canvas.draw((8, 6), view_of((6, 8), (8, 6)), Look(gamma=1), 1.0)
    got = canvas.read().astype(int)
    assert got[3, 4].tolist() == [255, 255, 255]
    assert (got[2, :, 0] > 50).all() and (got[2, :, 1] < 30).all()
    got[3, 4] = got[2] = 0
    assert not got.any()


def test_pictures_are_uploaded_once_per_key_and_may_change_size(context):
    canvas = Canvas(context, "complex")
    assert canvas.upload(FIELD, "a") and not canvas.upload(0 * FIELD, "a")
    assert canvas.upload(FIELD[:10, :12], "b")
    canvas.draw((12, 10), view_of((10, 12), (12, 10)), Look(), 1.0)
    want = shade(FIELD[:10, :12], 1.0, Look()).astype(int)
    assert np.abs(canvas.read().astype(int) - want).max() <= 1
