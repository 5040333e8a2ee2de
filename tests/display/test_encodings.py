"""Encodings as entries: each through encode and the 4-f system, and what bits do to grey levels."""

import numpy as np
import pytest

from chrmc.encoding import CODINGS, Coding, coding_for
from chrmc.grey_levels import (
    allowed_levels,
    encode,
    encode_signal,
    limit_band,
    scale_for,
    signal_of,
)
from chrmc.optics.passband import Passband
from chrmc.response import GreyResponse
from chrmc.slm import SLM
from reconstruct.four_f_system import FourF, decode_field, four_f

PANEL = SLM("panel", 256, 192, 8e-6)
BINARY, PHASE = ("error-diffusion", "lee"), ("double-phase", "kinoform")


def speckle(slm, share=1.0, seed=0):
    """A random field of the middle `share` of the band in both directions."""
    rng = np.random.default_rng(seed)
    field = rng.normal(size=slm.shape) + 1j * rng.normal(size=slm.shape)
    edge = share * slm.nyquist
    return limit_band(field.astype(np.complex64), slm, Coding("", Passband(edge, edge), 0.0))


def error(decoded, truth):
    """Relative L2, the best complex factor taken off."""
    factor = np.vdot(decoded, truth) / np.vdot(decoded, decoded)
    return np.linalg.norm(factor * decoded - truth) / np.linalg.norm(truth)


@pytest.mark.parametrize(
    ("name", "share", "largest"),
    [
        ("ssb", 0.5, 0.04),
        ("bipolar", 0.5, 0.04),
        ("burch", 0.5, 0.06),
        ("error-diffusion", 0.1, 0.16),
        ("error-diffusion", 0.5, 0.85),
        ("lee", 0.1, 0.26),
        ("double-phase", 0.1, 0.03),
        ("double-phase", 0.5, 0.45),
        ("kinoform", 0.5, 0.55),
    ],
)
def test_the_four_f_system_reads_what_was_encoded(name, share, largest):
    field = speckle(PANEL, share)
    coding = coding_for(name, PANEL)
    decoded = decode_field(encode(field, PANEL, name), PANEL, name)
    if share < 0.5:  # a camera sees only what a small picture holds
        decoded = limit_band(decoded, PANEL, Coding("", Passband(*[share * PANEL.nyquist] * 2), 0))
    assert error(decoded, field) < largest
    assert coding.name == name


@pytest.mark.parametrize("name", ["ssb", "error-diffusion", "double-phase"])
def test_gain_and_scale_give_the_fields_own_units(name):
    field = speckle(PANEL, 0.1)
    peak = float(np.abs(field).max()) * 1.2
    decoded = decode_field(encode(field, PANEL, name, peak), PANEL, name, peak)
    decoded = limit_band(decoded, PANEL, Coding("", Passband(*[0.1 * PANEL.nyquist] * 2), 0.0))
    factor = np.vdot(decoded, field) / np.vdot(decoded, decoded)
    assert abs(factor - 1) < 0.06  # neither scaled nor turned


@pytest.mark.parametrize("scale", [1.0, 40.0])
def test_a_kinoform_shows_the_phase_at_its_scale(scale):
    field = speckle(PANEL, 0.5)
    decoded = decode_field(encode(field, PANEL, "kinoform", scale), PANEL, "kinoform", scale)
    wanted = scale * field / np.abs(field)
    # 256 steps of phase: 2π/256/√12 of a radian.
    assert np.linalg.norm(decoded - wanted) < 0.01 * np.linalg.norm(wanted)


def test_lees_first_order_is_a_over_pi():
    """Of a wave much wider than the stripes; the pixels' steps leave a few per cent."""
    slm = SLM("wide", 64, 4096, 8e-6)
    depth = np.linspace(0.01, 1, slm.height)[:, None] * np.ones(slm.shape)
    field = (depth * np.exp(0.4j * np.arange(slm.height)[:, None])).astype(np.complex64)
    decoded = decode_field(encode(field, slm, "lee", 1.0), slm, "lee", 1.0)
    middle = slice(1000, 3600)
    smooth = np.convolve((decoded / field)[middle, 30].real, np.ones(400) / 400, "valid")
    assert np.abs(smooth - 1).max() < 0.12


@pytest.mark.parametrize("name", BINARY)
def test_binary_encodings_are_binary(name):
    frame = encode(speckle(PANEL, 0.4), PANEL, name)
    assert set(np.unique(frame)) == {0, 255}
    assert 0.1 < (frame > 0).mean() < 0.6


def test_what_is_dark_has_no_stripes():
    field = speckle(PANEL, 0.4)
    field[:, :128] = 0
    frame = encode(field, PANEL, "lee", band_limited=True)
    assert not frame[:, :128].any() and frame[:, 128:].any()
    assert not encode(0 * field, PANEL, "lee").any()


def test_rounding_errors_vanish_around_the_carrier():
    field = speckle(PANEL, 0.4)
    scale = float(np.abs(field).max())
    wanted = (
        0.5
        + 0.5
        * np.real(field * np.exp(2j * np.pi * 0.25 * PANEL.y()[:, None] / PANEL.pixel_pitch))
        / scale
    )
    noise = np.fft.fft2(encode(field, PANEL, "error-diffusion", scale) / 255 - wanted)
    power = np.abs(noise).mean(axis=1) ** 2
    rows = np.fft.fftfreq(PANEL.height)
    near, far = power[np.abs(rows - 0.25) < 0.02].mean(), power[np.abs(rows - 0.45) < 0.02].mean()
    assert near < 0.05 * far


@pytest.mark.parametrize("name", PHASE)
def test_phase_encodings_absorb_nothing(name):
    system = FourF(PANEL, 532e-9, name)
    energy = system.energy(encode(speckle(PANEL, 0.4), PANEL, name))
    assert energy.absorbed == pytest.approx(0, abs=1e-3 * energy.incident)
    assert energy.efficiency > (0.99 if name == "kinoform" else 0.15)


def test_a_point_is_seen_where_it_is_by_every_encoding():
    from chrmc import PointCloud, compute_field

    point = PointCloud([[2e-4, -1.5e-4, 0.05]], [1.0], [0.0])
    for name in CODINGS:
        coding = coding_for(name, PANEL)
        field = compute_field(point, PANEL, 532e-9, passband=coding.passband)
        image = four_f(encode(field, PANEL, name), PANEL, 532e-9, 0.05, name)
        row, column = np.unravel_index(np.argmax(image), image.shape)
        assert abs(PANEL.x(column) - 2e-4) <= 8.1e-6, name
        assert abs(PANEL.y(row) + 1.5e-4) <= 8.1e-6, name


def test_an_encoding_is_one_function_and_one_line(monkeypatch):
    """A panel that is fed the imaginary part instead: made here, and read by the 4-f system."""

    def imaginary(slm):
        half = Passband(slm.nyquist, slm.nyquist / 2)
        return Coding(
            "imaginary", half, slm.nyquist / 2, needs_field=True, limits=True, half_plane=True,
            levels=lambda field, signal, scale, slm, response=None: encode(
                -1j * field, slm, "ssb", scale, response=response, band_limited=True
            ),
        )  # fmt: skip

    monkeypatch.setitem(CODINGS, "imaginary", imaginary)
    field = speckle(PANEL, 0.5)
    decoded = decode_field(encode(field, PANEL, "imaginary"), PANEL, "imaginary")
    assert error(decoded, field) < 0.04
    factor = np.vdot(decoded, field)
    assert abs(np.angle(factor) - np.pi / 2) < 0.01
    image = four_f(encode(field, PANEL, "imaginary"), PANEL, 532e-9, 0.1, "imaginary")
    assert image.shape == PANEL.shape and image.max() > 0


def test_an_unknown_encoding_is_refused():
    with pytest.raises(ValueError, match=r"'hologram'.*ssb.*lee"):
        encode(speckle(PANEL), PANEL, "hologram")


@pytest.mark.parametrize("bits", [1, 2, 4, 6, 8])
def test_bits_are_honoured(bits):
    slm = SLM("few", 64, 48, 8e-6, bits=bits)
    frame = encode(speckle(slm, 0.5), slm)
    levels = allowed_levels(bits)
    assert levels[0] == 0 and levels[-1] == 255 and len(levels) == 2**bits
    assert set(np.unique(frame)) <= set(levels.tolist())
    assert len(np.unique(frame)) > 0.7 * 2**bits
    signal = np.linspace(-1, 1, 1000, dtype=np.float32)[None, :]
    nearest = np.abs(levels[None, :] / 127.5 - 1 - signal.T).min(axis=1)
    shown = encode_signal(signal, 1.0, bits=bits)[0] / 127.5 - 1
    assert np.allclose(np.abs(shown - signal[0]), nearest, atol=1 / 127)


def test_bits_and_a_response_together():
    slm = SLM("few", 64, 48, 8e-6, bits=4)
    gamma = GreyResponse.from_gamma(2.2)
    frame = encode(speckle(slm, 0.5), slm, response=gamma)
    assert set(np.unique(frame)) <= set(allowed_levels(4).tolist())
    full = encode(speckle(slm, 0.5), SLM("full", 64, 48, 8e-6), response=gamma)
    assert np.abs(frame.astype(int) - full).max() <= 9  # half a step of 17


def test_phase_levels_of_few_bits():
    slm = SLM("few", 64, 48, 8e-6, bits=2)
    assert set(np.unique(encode(speckle(slm, 0.4), slm, "kinoform"))) == {0, 64, 128, 192}


def test_wrong_bits_are_refused():
    with pytest.raises(ValueError, match="at least 1 bit"):
        allowed_levels(0)
    ten, eight = (SLM("deep", 64, 48, 8e-6, bits=bits) for bits in (10, 8))
    for name in ("ssb", "kinoform"):
        frames = [encode(speckle(eight, 0.4), slm, name) for slm in (ten, eight)]
        assert np.array_equal(*frames)


def test_the_panels_fill_factor_dims_the_edges_of_the_band():
    full, half = PANEL, SLM("gaps", 256, 192, 8e-6, fill_factor=0.5)
    frame = encode(speckle(PANEL, 0.5), PANEL)
    energy = [FourF(slm, 532e-9).energy(frame) for slm in (full, half)]
    assert energy[1].image < 0.3 * energy[0].image  # at most fill² of it
    assert energy[1].image > 0.1 * energy[0].image


@pytest.mark.parametrize("name", CODINGS)
@pytest.mark.filterwarnings("error")
def test_a_dark_field_is_encoded_and_shows_no_picture(name):
    frame = encode(np.zeros(PANEL.shape, dtype=np.complex64), PANEL, name)
    light = np.abs(decode_field(frame, PANEL, name))
    # A kinoform has no dark: its panel sends all of its light straight on.
    assert np.allclose(light, 1 if name == "kinoform" else 0, atol=5e-3)


def test_what_each_encoding_occupies_and_uses():
    nyquist = PANEL.nyquist
    half, lifted, full = (nyquist, nyquist / 2), nyquist / 2, (nyquist, nyquist)
    table = {  # passband, carrier, from the field, limited, one half plane, round the zero order
        "ssb": (half, lifted, False, True, True, False),
        "real": (full, 0, False, False, False, False),
        "bipolar": (half, lifted, False, False, True, False),
        "burch": (half, lifted, False, False, True, False),
        "offaxis": (half, lifted, True, False, True, False),
        "error-diffusion": (half, lifted, True, True, True, False),
        "lee": (half, lifted, True, True, True, False),
        "double-phase": ((nyquist / 2, nyquist / 2), 0, True, True, False, True),
        "kinoform": (full, 0, True, False, False, True),
    }
    assert set(table) == set(CODINGS)
    for name, wanted in table.items():
        one = coding_for(name, PANEL)
        band = one.passband.fx_max, one.passband.fy_max
        found = band, one.carrier, one.needs_field, one.limits, one.half_plane, one.zero_order
        assert found == wanted, name
        assert one.bits == (1 if name in BINARY else None)


def test_a_field_that_keeps_to_its_band_is_not_filtered_again():
    """What is told to be limited is taken as it is, as by the encoding without the filter."""
    rng = np.random.default_rng(3)
    field = (rng.normal(size=PANEL.shape) + 1j * rng.normal(size=PANEL.shape)).astype(np.complex64)
    taken = encode(field, PANEL, "ssb", 4.0, band_limited=True)
    assert np.array_equal(taken, encode(field, PANEL, "bipolar", 4.0))
    assert not np.array_equal(taken, encode(field, PANEL, "ssb", 4.0))


@pytest.mark.parametrize(
    ("name", "sigmas"), [("ssb", 3.0), ("offaxis", 3.0), ("error-diffusion", 1.5), ("lee", 2.0)]
)
def test_where_the_grey_range_of_a_single_field_ends(name, sigmas):
    field = speckle(PANEL, 0.4)
    deviation = np.sqrt(np.mean(signal_of(field, PANEL, name).astype(float) ** 2))
    assert scale_for(field, PANEL, name) == pytest.approx(sigmas * deviation, rel=1e-5)


def test_scales_that_are_the_fields_own():
    field = speckle(PANEL, 0.4)
    rms = np.sqrt(np.mean(np.abs(field.astype(complex)) ** 2))
    assert scale_for(field, PANEL, "kinoform") == pytest.approx(rms, rel=0.02)
    assert scale_for(field, PANEL, "burch") == pytest.approx(np.abs(field).max(), rel=1e-6)
    # Of a video, whose fields nobody has seen: the largest of N speckles, expected.
    count = PANEL.width * PANEL.height
    assert coding_for("burch", PANEL).sigmas == pytest.approx(np.sqrt(2 * np.log(count)))
