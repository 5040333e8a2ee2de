import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chrmc.optics.propagation import Patch
from reconstruct.camera import Camera, overlaps

P = 8.1e-6
IMAGE = np.random.default_rng(3).random((24, 36))
PATCH = Patch((0.0, 0.0), (24, 36), P)


@settings(max_examples=30, deadline=None)
@given(st.floats(0.3, 4), st.integers(1, 20))
def test_light_is_neither_made_nor_lost_on_a_large_sensor(ratio, extra):
    """Σ of mean intensity times pixel area is the image's."""
    counts = tuple(int(np.ceil(n / ratio)) + extra for n in IMAGE.shape)
    seen = Camera(ratio * P, counts).gather(IMAGE, PATCH)
    assert seen.sum() * ratio**2 == pytest.approx(IMAGE.sum())


def test_equal_pixels_see_the_image_itself_and_large_ones_means():
    assert np.allclose(Camera(P).gather(IMAGE, PATCH), IMAGE)
    want = IMAGE.reshape(8, 3, 12, 3).mean(axis=(1, 3))
    assert np.allclose(Camera(3 * P).gather(IMAGE, PATCH), want)


def test_magnification_and_the_turned_image():
    assert np.allclose(Camera(2 * P).gather(IMAGE, PATCH, 2.0), IMAGE)
    turned = Camera(P, upright=False).gather(IMAGE, PATCH)
    assert np.allclose(turned, IMAGE[::-1, ::-1])


@pytest.mark.parametrize(("bits", "kind"), [(1, np.uint8), (8, np.uint8), (12, np.uint16)])
def test_counts_have_their_bits(bits, kind):
    counts = Camera(P, bits=bits, full_scale=0.5).photograph(IMAGE, PATCH)
    assert counts.dtype == kind and counts.max() == 2**bits - 1
    back = counts / (2**bits - 1) * 0.5
    assert np.abs(back - np.minimum(IMAGE, 0.5)).max() <= 0.51 * 0.5 / (2**bits - 1)
    assert not Camera(P, bits=bits).photograph(0 * IMAGE, PATCH).any()


def test_shot_noise_is_the_square_root_of_the_photons():
    flat = np.full((100, 100), 0.5)
    camera = Camera(P, bits=16, full_scale=1.0, full_well=10_000)
    counts = camera.photograph(flat, Patch((0, 0), (100, 100), P)) / 65535
    assert counts.mean() == pytest.approx(0.5, rel=0.01)
    assert counts.std() == pytest.approx(np.sqrt(5000) / 10_000, rel=0.05)


def test_overlaps_are_shares():
    assert overlaps(4, 1.0, 2, 2.0).tolist() == [[0.5, 0.5, 0, 0], [0, 0, 0.5, 0.5]]
    assert overlaps(2, 1.0, 4, 1.0).sum(axis=1).tolist() == [0, 1, 1, 0]


def test_impossible_cameras():
    for wrong in ({"pixel_pitch": 0}, {"pixel_pitch": P, "bits": 17}):
        with pytest.raises(ValueError, match="camera"):
            Camera(**wrong)
    with pytest.raises(ValueError, match="full_well"):
        Camera(P, full_well=0)
