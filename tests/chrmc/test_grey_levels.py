"""Grey levels at the ends of what numbers can be: refused in one line, never wrong in silence."""

import numpy as np
import pytest

from chrmc.encoding import coding_for
from chrmc.grey_levels import allowed_levels, encode, encode_signal, limit_band
from chrmc.response import GreyResponse
from chrmc.slm import SLM

PANEL = SLM("s", 16, 12, 40e-6)


@pytest.mark.parametrize("peak", [1e-300, 1e-20, 1e30, 1e38, 1e300])
@pytest.mark.parametrize("encoding", ["ssb", "real", "offaxis", "burch"])
def test_fields_beyond_single_precision_are_refused(peak: float, encoding: str) -> None:
    field = np.zeros(PANEL.shape, dtype=np.complex128)
    field[3, 4] = peak
    with pytest.raises(ValueError, match="single precision"):
        encode(field, PANEL, encoding)


def test_what_a_field_is_multiplied_by_changes_no_grey() -> None:
    rng = np.random.default_rng(2)
    field = rng.normal(size=PANEL.shape) + 1j * rng.normal(size=PANEL.shape)
    plain = encode(field, PANEL)
    for factor in (2.0**-40, 2.0**40):
        assert np.array_equal(encode(factor * field, PANEL), plain)


def test_a_dark_field_is_mid_grey_and_a_dark_scale_takes_no_light_at_all() -> None:
    assert np.all(encode(np.zeros(PANEL.shape, complex), PANEL) == 128)
    signal = np.zeros(PANEL.shape, dtype=np.float32)
    assert np.all(encode_signal(signal, 0.0) == 128)
    signal[5, 5] = 1e-3
    with pytest.raises(ValueError, match="scale is 0"):
        encode_signal(signal, 0.0)


@pytest.mark.parametrize("scale", [-1.0, 1e-40, 0.9e-30, 1.1e30, 1e40, np.inf, np.nan])
def test_a_scale_that_can_be_none_is_refused(scale: float) -> None:
    with pytest.raises(ValueError, match="scale"):
        encode_signal(np.ones(PANEL.shape, dtype=np.float32), scale)


@pytest.mark.parametrize("scale", [1e-30, 1e30])
def test_the_smallest_and_the_largest_scale_are_taken(scale: float) -> None:
    signal = np.full(PANEL.shape, 0.5 * scale, dtype=np.float32)
    assert np.all(encode_signal(signal, scale) == np.rint(0.75 * 255))


def test_light_whose_sum_no_single_number_holds_is_no_infinite_light() -> None:
    signal = np.full(PANEL.shape, 1e37, dtype=np.float32)
    with np.errstate(over="ignore"):
        assert np.all(encode_signal(signal, 1e30) == 255)
    signal[7, 3] = np.inf
    with pytest.raises(ValueError, match="NaN or infinite"), np.errstate(over="ignore"):
        encode_signal(signal, 1e30)


@pytest.mark.parametrize("kind", [object, "U1", bool])
def test_an_array_of_no_numbers_is_no_field(kind: object) -> None:
    with pytest.raises(ValueError, match="array of numbers"):
        encode(np.full(PANEL.shape, 1, dtype=kind), PANEL)  # type: ignore[call-overload]


@pytest.mark.parametrize(("peak", "shown"), [(9e-16, 0), (1.1e-15, 1), (9e14, 1), (1.1e15, 0)])
def test_where_single_precision_ends(peak: float, shown: bool) -> None:
    field = np.zeros(PANEL.shape, dtype=np.complex64)
    field[2, 3] = peak * 1j
    if shown:
        assert encode(field, PANEL, "kinoform").any()
    else:
        with pytest.raises(ValueError, match="single precision is safe"):
            encode(field, PANEL)


@pytest.mark.parametrize("bits", [1, 2, 6])
def test_a_panel_of_few_bits_takes_the_nearest_of_its_levels_with_a_map_too(bits: int) -> None:
    signal = np.random.default_rng(1).uniform(-1, 1, PANEL.shape).astype(np.float32)
    levels = np.linspace(0, 1, 256) ** 0.7
    plain = encode_signal(signal, 1.0, GreyResponse(levels), bits=bits)
    mapped = encode_signal(signal, 1.0, GreyResponse(levels, tilt=np.zeros((256, 2))), bits=bits)
    assert set(np.unique(mapped)) <= set(allowed_levels(bits).tolist())
    assert np.mean(plain != mapped) < 0.03  # where two levels are as near as each other


def test_what_lies_at_the_end_of_the_whole_band_is_kept() -> None:
    """Single sideband limits rows' frequencies to half the band, columns' to all of it."""
    columns = np.tile((-1.0) ** np.arange(PANEL.width), (PANEL.height, 1)).astype(np.complex64)
    assert np.allclose(limit_band(columns, PANEL, coding_for("ssb", PANEL)), columns, atol=1e-6)
    rows = np.tile((-1.0) ** np.arange(PANEL.height)[:, None], (1, PANEL.width))
    assert not limit_band(rows.astype(np.complex64), PANEL, coding_for("ssb", PANEL)).any()


def test_a_panel_of_more_bits_than_a_frame_has_all_its_levels():
    assert allowed_levels(10).tolist() == allowed_levels(8).tolist() == list(range(256))


@pytest.mark.parametrize("signal", [np.zeros(9, np.float32), np.zeros((3, 3))])
def test_a_signal_is_of_rows_and_columns_and_of_float32(signal):
    with pytest.raises(ValueError, match="signal must be float32"):
        encode_signal(signal, 1.0)
