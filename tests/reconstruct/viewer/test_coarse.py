"""The first picture against the full one: exact where its band holds everything."""

import numpy as np
import pytest
import scipy.fft

from chrmc import LC_R_1080, SLM, PointCloud, compute_field
from chrmc.encoding import coding_for
from chrmc.grey_levels import encode
from reconstruct import Bench, Filter, FourF
from reconstruct.viewer.coarse import BUDGET, coarse_field, coarse_shape

LAMBDA = 532e-9


def frame_of(slm, encoding="ssb", depth=0.06):
    rng = np.random.default_rng(5)
    places = rng.uniform(-1, 1, (40, 3)) * [0.3e-3, 0.2e-3, 0.2e-3] + [0.1e-3, -0.2e-3, depth]
    cloud = PointCloud(places, np.ones(40), rng.uniform(0, 6.3, 40))
    band = coding_for(encoding, slm).passband
    return encode(compute_field(cloud, slm, LAMBDA, passband=band), slm, encoding, scale=60.0)


def cropped(field, shape):
    """The field on fewer samples, its spectrum cut at theirs."""
    spectrum = scipy.fft.fft2(field)
    rows, columns = (
        np.rint(scipy.fft.fftfreq(m) * m).astype(int) % n
        for m, n in zip(shape, field.shape, strict=True)
    )
    part = spectrum[np.ix_(rows, columns)]
    return scipy.fft.ifft2(part) * (np.prod(shape) / field.size)


# 250 rows: the carrier lies between two samples of the spectrum
@pytest.mark.parametrize("rows", [256, 250])
@pytest.mark.parametrize("filter_", [Filter(), Filter(half_plane=False), Filter(aperture=4e-3)])
def test_a_band_that_holds_all_gives_the_field_of_four_f(rows, filter_):
    slm = SLM("small", 320, rows, 8.1e-6)
    system = FourF(slm, LAMBDA, "ssb", Bench(filter=filter_), scale=60.0)
    frame = frame_of(slm)
    coarse = coarse_field(system, system.fourier_plane(frame), (10**6, 10**6), 0.07)
    assert coarse.lost < 0.01
    assert coarse.spectrum.shape != coarse.shape  # small enough to be padded
    want = cropped(system.at(system.field(frame), 0.0605), coarse.shape)
    got = coarse.at(0.0605)
    # What the edges of so small a panel diffract is 3 % of the light, and wraps in both.
    assert np.linalg.norm(got - want) < 0.06 * np.linalg.norm(want)


def test_a_narrower_band_says_how_much_light_it_leaves_out():
    slm = SLM("small", 512, 512, 8.1e-6)
    system = FourF(slm, LAMBDA, "ssb", scale=60.0)
    plane = system.fourier_plane(frame_of(slm))
    whole = coarse_field(system, plane, (512, 512), 0.07)
    part = coarse_field(system, plane, (60, 60), 0.07)
    assert part.shape == (120, 120) and whole.shape == (256, 512)
    light = [float(np.sum(np.abs(c.at(0.06)) ** 2)) / np.prod(c.shape) for c in (whole, part)]
    assert 0.3 < part.lost < 0.95
    assert light[1] / light[0] == pytest.approx(1 - part.lost, abs=0.03)


def test_at_full_size_the_band_of_a_sideband_fits_the_budget_and_is_one_percent_off():
    system = FourF(LC_R_1080, LAMBDA, "ssb", scale=60.0)
    assert coarse_shape(system, (1200, 1920)) == (600, 1920)
    frame = frame_of(LC_R_1080, depth=0.25)
    coarse = coarse_field(system, system.fourier_plane(frame), (1200, 1920), 0.27)
    got = np.abs(coarse.at(0.25)) ** 2
    want = np.abs(cropped(system.at(system.field(frame), 0.25), coarse.shape)) ** 2
    assert np.linalg.norm(got - want) < 0.02 * np.linalg.norm(want)


@pytest.mark.parametrize("size", [(3840, 2160), (7680, 4320), (1, 1), (1920, 17), (33, 1200)])
def test_any_panel_is_within_the_budget(size):
    system = FourF(SLM("any", *size, 3.74e-6), LAMBDA, "real")
    for screen in ((1, 1), (700, 1140), (10**6, 10**6)):
        rows, columns = coarse_shape(system, screen)
        assert 1 <= rows <= size[1] and 1 <= columns <= size[0]
        assert rows * columns <= 1.2 * BUDGET


def test_the_phase_is_the_full_pictures():
    slm = SLM("small", 256, 256, 8.1e-6)
    system = FourF(slm, LAMBDA, "ssb", scale=60.0)
    frame = frame_of(slm)
    got = coarse_field(system, system.fourier_plane(frame), (256, 256), 0.07).at(0.06)
    want = cropped(system.at(system.field(frame), 0.06), got.shape)
    assert abs(np.angle(np.vdot(want, got))) < 1e-3
