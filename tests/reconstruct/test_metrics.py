from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from skimage.metrics import peak_signal_noise_ratio

from chrmc.metrics import psnr, ssim
from reconstruct import metrics

RNG = np.random.default_rng(7)
IMAGE = RNG.random((24, 31))
LEFT = np.zeros((24, 31), dtype=bool)
LEFT[:, :12] = True


def test_psnr_is_skimages_and_infinite_for_equal_images():
    noisy = IMAGE + 0.02 * RNG.standard_normal(IMAGE.shape)
    want = peak_signal_noise_ratio(IMAGE, noisy, data_range=IMAGE.max())
    assert psnr(noisy, IMAGE) == pytest.approx(want)
    assert psnr(IMAGE, IMAGE) == inf
    assert psnr(IMAGE, 0 * IMAGE) == -inf
    # Ten times the error is 20 dB.
    small, large = (psnr(IMAGE + e, IMAGE) for e in (1e-3, 1e-2))
    assert small - large == pytest.approx(20)


def test_ssim_orders_images_and_takes_small_ones():
    a, b = (IMAGE + s * RNG.standard_normal(IMAGE.shape) for s in (0.02, 0.2))
    assert ssim(IMAGE, IMAGE) == pytest.approx(1)
    assert 1 > ssim(a, IMAGE) > ssim(b, IMAGE)
    assert ssim(IMAGE[:3, :4], IMAGE[:3, :4]) == pytest.approx(1)
    assert ssim(np.zeros((5, 5)), np.zeros((5, 5))) == 1
    assert ssim(np.ones((5, 5)), np.zeros((5, 5))) == 0


@given(st.floats(1e-3, 1e3))
def test_scale_to_undoes_a_gain(gain):
    assert metrics.scale_to(gain * IMAGE, IMAGE) == pytest.approx(1 / gain)


def test_contrast_and_snr_of_known_levels():
    image = np.where(LEFT, 3.0, 1.0)
    assert metrics.contrast(image, LEFT, ~LEFT) == pytest.approx(0.5)
    assert metrics.snr(image, LEFT, ~LEFT) == inf
    noise = np.where(np.arange(image.size).reshape(image.shape) % 2, 0.1, -0.1)
    assert metrics.snr(image + noise, LEFT, ~LEFT) == pytest.approx(20 * np.log10(2 / 0.1), abs=0.1)
    assert metrics.snr(image, ~LEFT, LEFT) == -inf
    assert metrics.contrast(0 * image, LEFT, ~LEFT) == 0


def test_speckle_has_a_contrast_of_one():
    """Fully developed speckle: negative exponential intensity."""
    field = RNG.standard_normal((300, 300)) + 1j * RNG.standard_normal((300, 300))
    assert metrics.speckle_contrast(np.abs(field) ** 2) == pytest.approx(1, abs=0.02)
    assert metrics.speckle_contrast(np.ones((4, 4))) == 0
    assert metrics.speckle_contrast(np.zeros((4, 4))) == 0
    assert metrics.speckle_contrast(IMAGE, np.zeros_like(LEFT)) == 0
