import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import display
from chrmc.encoding import coding_for
from chrmc.grey_levels import limit_band
from chrmc.optics.footprint import expected_power
from chrmc.reference import reference_field
from chrmc.response import GreyResponse
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import ObjectFrame, SceneFrame
from chrmc.slm import SLM

SMALL = SLM("small", 96, 128, 8.1e-6)


def noise(shape, seed=0):
    rng = np.random.default_rng(seed)
    return (rng.normal(size=shape) + 1j * rng.normal(size=shape)).astype(np.complex64)


def half_band(slm, seed=0):
    """Noise whose |f_y| stays well below 1/4p."""
    spectrum = np.fft.fft(noise(slm.shape, seed), axis=0)
    spectrum[np.abs(np.fft.fftfreq(slm.height)) > 0.2] = 0
    return np.fft.ifft(spectrum, axis=0).astype(np.complex64)


def decode(frame, slm, scale):
    """The complex field again: positive f_y alone, carrier taken off."""
    signal = (frame / 255 - 0.5) * 2 * scale
    spectrum = np.fft.fft(signal, axis=0)
    spectrum[np.fft.fftfreq(slm.height) <= 0] = 0
    carrier = np.exp(2j * np.pi * slm.y() / (4 * slm.pixel_pitch))
    return 2 * np.fft.ifft(spectrum, axis=0) / carrier[:, None]


def test_single_sideband_comes_back_as_the_complex_field():
    field = half_band(SMALL)
    scale = 6 * float(np.sqrt(np.mean(np.abs(field) ** 2) / 2))  # nothing clipped
    back = decode(display.encode(field, SMALL, "ssb", scale), SMALL, scale)
    error = np.linalg.norm(back - field) / np.linalg.norm(field)
    assert error < 0.02  # rounding to 256 levels


def test_carrier_and_its_sign():
    slm = SLM("square", 64, 64, 8e-6)
    wave = np.exp(2j * np.pi * 4 / 64 * np.arange(64))[:, None] * np.ones(64)
    signal = display.signal_of(wave.astype(np.complex64), slm, "ssb")
    peaks = np.flatnonzero(np.abs(np.fft.fft(signal[:, 0])) > 16)
    assert list(peaks) == [20, 44]  # +4 and the carrier's 16 of 64; 44 its mirror image


def test_beyond_the_half_band_nothing_is_left():
    slm = SLM("square", 32, 96, 8e-6)
    rows = np.arange(96) - 47.5
    bell = np.exp(-((rows / 16) ** 2))  # narrow spectrum, gone at the edges
    wave = (bell * np.exp(2j * np.pi * 0.4 * rows))[:, None] * np.ones(32)
    limited = limit_band(wave.astype(np.complex64), slm, coding_for("ssb", slm))
    assert np.abs(limited).max() < 1e-4
    kept = (bell * np.exp(2j * np.pi * 0.1 * rows))[:, None] * np.ones(32)
    limited = limit_band(kept.astype(np.complex64), slm, coding_for("ssb", slm))
    assert np.abs(limited - kept).max() < 1e-4


def test_the_shortcut_for_limited_fields_agrees_with_the_filter():
    rows = SMALL.y() / SMALL.pixel_pitch
    field = (np.exp(-((rows / 20) ** 2))[:, None] * np.exp(0.3j * rows)[:, None]).astype(
        np.complex64
    ) * noise((1, SMALL.width))
    exact = display.signal_of(field, SMALL)
    fast = display.signal_of(field, SMALL, band_limited=True)
    assert np.abs(exact - fast).max() < 1e-4 * np.abs(exact).max()


@settings(max_examples=40, deadline=None)
@given(
    hnp.arrays(np.float32, (5, 7), elements=st.floats(-1e3, 1e3, width=32)),
    st.floats(0.01, 1e4),
)
def test_grey_levels_follow_the_formula(signal, scale):
    exact = 255 * (0.5 + 0.5 * np.clip(signal.astype(np.float64) / scale, -1, 1))
    frame = display.encode_signal(signal, scale)
    assert frame.dtype == np.uint8
    assert np.abs(frame - exact).max() <= 0.5 + 1e-3


@settings(max_examples=20, deadline=None)
@given(hnp.arrays(np.float32, (3, 9), elements=st.floats(-2, 2, width=32)), st.floats(0.3, 3))
def test_a_response_gives_the_wanted_amplitude_to_the_nearest_level(signal, gamma):
    response = GreyResponse.from_gamma(gamma)
    wanted = 0.5 + 0.5 * np.clip(signal, -1, 1)
    got = response.amplitude(display.encode_signal(signal, 1.0, response))
    levels = response.levels.real
    best = np.abs(levels - wanted[..., None]).min(axis=-1)
    assert np.all(np.abs(got - wanted) <= best + 1e-4)


def test_own_scale_is_three_sigma_and_clips():
    field = noise((400, 400)).astype(np.complex64)
    slm = SLM("square", 400, 400, 8e-6)
    frame = display.encode(field, slm, "real")
    sigma = np.sqrt(np.mean(field.real**2, dtype=np.float64))
    assert np.array_equal(frame, display.encode(field, slm, "real", 3 * sigma))
    clipped = np.mean((frame == 0) | (frame == 255))
    assert 0.001 < clipped < 0.006  # of a normal distribution, 0.27 % lie beyond three sigma


def test_a_dark_field_is_mid_grey():
    for method in ("ssb", "real"):
        frame = display.encode(np.zeros(SMALL.shape, np.complex64), SMALL, method)
        assert np.all(frame == 128)
    assert np.all(display.encode(np.zeros(SMALL.shape), SMALL, scale=0.0) == 128)


def test_inputs_are_left_alone():
    field = noise(SMALL.shape)
    kept = field.copy()
    signal = field.real.copy()
    display.encode(field, SMALL)
    display.encode(field, SMALL, "real")
    display.encode_signal(signal, 1.0)
    assert np.array_equal(field, kept) and np.array_equal(signal, kept.real)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_refused(bad):
    field = noise(SMALL.shape)
    field[3, 4] = bad
    with pytest.raises(ValueError, match="1 NaN or infinite"):
        display.encode(field, SMALL)
    with pytest.raises(ValueError, match="NaN or infinite"):
        display.encode_signal(field.real.copy(), 1.0)


def test_wrong_shapes_methods_and_scales_are_refused():
    with pytest.raises(ValueError, match=r"\(96, 128\)"):
        display.encode(noise((96, 128)), SMALL)
    with pytest.raises(ValueError, match="choose one of"):
        display.encode(noise(SMALL.shape), SMALL, "sideways")
    for scale in (-1.0, np.nan, np.inf, 0.0):
        with pytest.raises(ValueError, match="scale"):
            display.encode(noise(SMALL.shape), SMALL, "ssb", scale)
    for scale in (-1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="scale"):
            display.encode(noise(SMALL.shape), SMALL, "double-phase", scale)


class Clouds:
    """A scene of one object, given its clouds."""

    name, form, object_names, wavelength, pixel_pitch = "clouds", "points", ("it",), None, 4e-5

    def __init__(self, *clouds):
        self.clouds = clouds
        self.frame_count = len(clouds)

    def frame(self, number):
        return SceneFrame(number, (ObjectFrame("it", self.clouds[number - 1]),))


def random_cloud(count, amplitude, seed=1):
    rng = np.random.default_rng(seed)
    positions = np.stack(
        [rng.uniform(-4e-4, 4e-4, count), rng.uniform(-4e-4, 4e-4, count), np.full(count, 0.25)], 1
    )
    return PointCloud(positions, np.full(count, amplitude), rng.uniform(0, 2 * np.pi, count))


def test_video_scale_is_three_sigma_of_the_brightest_frame():
    slm = SLM("square", 128, 128, 8.1e-6)
    coding = coding_for("ssb", slm)
    dim, bright = random_cloud(60, 0.1), random_cloud(60, 0.7, seed=2)
    scale = display.video_scale(Clouds(dim, bright, dim), slm, 532e-9, coding)
    field = reference_field(bright, slm, 532e-9, passband=coding.passband)
    signal = display.signal_of(field.astype(np.complex64), slm, "ssb")
    assert scale == pytest.approx(3 * np.sqrt(np.mean(signal**2)), rel=0.25)  # speckle of 60 points
    power = expected_power(bright, slm, 532e-9, coding.passband).sum()
    assert scale == pytest.approx(3 * np.sqrt(power / 2))


def test_video_scale_of_nothing_is_zero_and_works():
    coding = coding_for("ssb", SMALL)
    scale = display.video_scale(Clouds(PointCloud.empty()), SMALL, 532e-9, coding)
    assert scale == 0
    assert np.all(display.encode(np.zeros(SMALL.shape), SMALL, scale=scale) == 128)


@pytest.mark.parametrize(("method", "limit"), [("bipolar", 0.02), ("burch", 0.02), ("ssb", 0.02)])
def test_encodings_of_one_carrier_decode_alike(method, limit):
    field = half_band(SMALL)
    scale = 1.01 * float(np.abs(field).max())
    back = decode(display.encode(field, SMALL, method, scale), SMALL, scale)
    assert np.linalg.norm(back - field) / np.linalg.norm(field) < limit


def test_burch_clips_nothing_and_the_others_three_sigma():
    field = noise((300, 300), 4)
    slm = SLM("square", 300, 300, 8e-6)
    inside = display.encode(field, slm, "burch")
    assert inside.min() > 0 and inside.max() < 255
    assert display.encode(field, slm, "bipolar").max() == 255


def test_off_axis_is_the_intensity_of_two_waves():
    field = half_band(SMALL)
    scale = 3 * float(np.sqrt(np.mean(np.abs(field) ** 2) / 2))
    reference = scale * np.exp(-2j * np.pi * SMALL.y() / (4 * SMALL.pixel_pitch))[:, None]
    intensity = np.abs(field + reference) ** 2 / (4 * scale**2)
    frame = display.encode(field, SMALL, "offaxis", scale)
    assert np.abs(frame - 255 * np.clip(intensity, 0, 1)).max() <= 0.51
    assert np.all(display.encode(0 * field, SMALL, "offaxis", scale) == 64)  # the reference alone


def test_a_video_of_burch_frames_is_not_clipped():
    slm = SLM("square", 256, 256, 8.1e-6)
    coding = coding_for("burch", slm)
    cloud = random_cloud(200, 0.3)
    scale = display.video_scale(Clouds(cloud), slm, 532e-9, coding)
    field = reference_field(cloud, slm, 532e-9, passband=coding.passband).astype(np.complex64)
    frame = display.encode(field, slm, "burch", scale)
    assert np.mean((frame == 0) | (frame == 255)) < 1e-4
