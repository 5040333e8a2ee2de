"""Signs, axes and centring, each pinned once by what light does."""

import numpy as np
import pytest

import chrmc
from chrmc.encoding import coding_for
from chrmc.optics.propagation import propagate
from chrmc.slm import LC_R_1080, SLM

WAVELENGTH = chrmc.WAVELENGTH
METHODS = ("rt", "fresnel")


def one_point(x: float, y: float, z: float, phase: float = 0.0) -> chrmc.PointCloud:
    return chrmc.PointCloud(np.array([[x, y, z]]), np.ones(1), np.array([phase]))


def field_of(cloud: chrmc.PointCloud, slm: SLM, method: str) -> np.ndarray:
    if method == "reference":
        return chrmc.reference_field(cloud, slm, WAVELENGTH)
    return chrmc.compute_field(cloud, slm, WAVELENGTH, method)


def test_pixels_are_centred_on_the_origin() -> None:
    slm = LC_R_1080
    assert slm.x(959) == pytest.approx(-slm.pixel_pitch / 2)
    assert slm.x(960) == pytest.approx(slm.pixel_pitch / 2)
    assert slm.y(599) == pytest.approx(-slm.pixel_pitch / 2)
    assert np.ptp(slm.x()) == pytest.approx(1919 * 8.1e-6)
    odd = SLM("odd", 3, 5, 1e-6)
    assert odd.x(1) == 0 and odd.y(2) == 0
    assert slm.width * slm.pixel_pitch == pytest.approx(15.552e-3)


@pytest.mark.parametrize("method", ["reference", *METHODS])
def test_phase_grows_with_distance(method: str) -> None:
    # exp(+ikr): away from the foot of a point the phase rises.
    slm = SLM("line", 201, 1, 8.1e-6)
    row = field_of(one_point(0, 0, 0.05), slm, method)[0]
    steps = np.angle(row[101:] * np.conj(row[100:-1]))
    assert np.all(steps[:60] > 0)
    assert np.all(np.angle(row[:100] * np.conj(row[1:101]))[40:] > 0)


@pytest.mark.parametrize("method", ["reference", *METHODS])
def test_absolute_phase_and_amplitude(method: str) -> None:
    slm = SLM("pixel", 1, 1, 8.1e-6)
    z = 0.25
    value = field_of(one_point(0, 0, z, phase=0.7), slm, method)[0, 0]
    assert abs(value) == pytest.approx(1 / z, rel=1e-5)
    expected = np.exp(1j * (2 * np.pi * np.fmod(z / WAVELENGTH, 1) + 0.7))
    assert np.angle(value / expected) == pytest.approx(0, abs=1e-3)


@pytest.mark.parametrize("method", METHODS)
def test_back_propagation_focuses_at_the_point(method: str) -> None:
    slm = SLM("small", 320, 256, 8.1e-6)
    column, row, z = 200, 90, 0.04
    cloud = one_point(float(slm.x(column)), float(slm.y(row)), z)
    hologram = field_of(cloud, slm, method)
    peaks = {}
    for depth in (0.9 * z, z, 1.1 * z, -z):
        image = np.abs(propagate(hologram, slm.pixel_pitch, WAVELENGTH, -depth)) ** 2
        peaks[depth] = image.max()
        if depth == z:  # x to the right, y down, nothing inverted
            assert np.unravel_index(np.argmax(image), image.shape) == (row, column)
    assert peaks[z] > 4 * max(v for d, v in peaks.items() if d != z)


@pytest.mark.parametrize("method", ["reference", *METHODS])
def test_half_pixel_centring_is_symmetric(method: str) -> None:
    slm = SLM("even", 64, 48, 8.1e-6)
    centred = field_of(one_point(0, 0, 0.02), slm, method)
    np.testing.assert_allclose(centred, centred[::-1, ::-1], rtol=1e-4)
    right = field_of(one_point(40e-6, 24e-6, 0.02), slm, method)
    left = field_of(one_point(-40e-6, -24e-6, 0.02), slm, method)
    np.testing.assert_allclose(right, left[::-1, ::-1], rtol=1e-3, atol=1e-2)
    assert not np.allclose(right, left, rtol=1e-1)


def test_the_carrier_lifts_the_single_sideband_to_positive_frequencies() -> None:
    slm = SLM("small", 128, 512, 8.1e-6)
    coding = coding_for("ssb", slm)
    assert coding.carrier == pytest.approx(1 / (4 * slm.pixel_pitch))
    field = chrmc.compute_field(
        one_point(0, 1e-4, 0.05), slm, WAVELENGTH, passband=coding.passband, method="rt"
    )
    lifted = field * np.exp(2j * np.pi * coding.carrier * slm.y())[:, None]
    power = np.sum(np.abs(np.fft.fft2(lifted)) ** 2, axis=1)
    f_y = np.fft.fftfreq(slm.height)
    assert power[f_y > 0].sum() > 0.99 * power.sum()
