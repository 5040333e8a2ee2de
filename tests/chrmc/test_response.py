import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chrmc.response import GreyResponse

GREY = np.arange(256, dtype=np.uint8)


def test_linear_is_grey_over_255():
    response = GreyResponse.linear()
    assert response.is_linear and response.is_real
    assert np.allclose(response.amplitude(GREY), np.arange(256) / 255, atol=1e-7)
    assert np.array_equal(response.grey(np.arange(256) / 255), GREY)


def test_gamma_is_of_intensity():
    response = GreyResponse.from_gamma(2.2)
    assert np.allclose(response.amplitude(GREY) ** 2, (np.arange(256) / 255) ** 2.2, atol=1e-6)
    assert GreyResponse.from_gamma(2.0).is_linear


@settings(max_examples=30, deadline=None)
@given(st.floats(0.3, 4), st.floats(0, 0.3), st.floats(-0.6, 0.6))
def test_backwards_undoes_forwards(gamma, floor, turn):
    grey = np.arange(256) / 255
    modulus = floor + (1 - floor) * grey ** (gamma / 2)
    response = GreyResponse((modulus * np.exp(1j * turn * grey)).astype(np.complex128), "made")
    amplitude = response.amplitude(GREY)
    dark, bright = complex(amplitude[0]), complex(amplitude[-1])
    chord = np.real((amplitude - dark) * np.conj(bright - dark)) / abs(bright - dark) ** 2
    again = response.amplitude(response.grey(chord))
    assert np.abs(again - amplitude).max() < 1e-3


def test_a_falling_panel_is_turned_over():
    response = GreyResponse.from_table([0, 255], [1.0, 0.1])
    assert response.grey(np.array([0.0, 1.0])).tolist() == [255, 0]


def write(path, text):
    path.write_text(text)
    return path


def test_a_table_of_intensity_is_square_rooted(tmp_path):
    rows = "\n".join(f"{g},{3.7 * (g / 255) ** 2}" for g in range(0, 256, 15))
    response = GreyResponse.from_csv(write(tmp_path / "a.csv", "grey,intensity\n" + rows))
    assert np.allclose(response.amplitude(GREY), np.arange(256) / 255, atol=2e-3)


def test_a_complex_table_keeps_its_phase(tmp_path):
    rows = "\n".join(f"{g},{g / 255},{0.8 * g / 255}" for g in range(0, 256, 5))
    response = GreyResponse.from_csv(write(tmp_path / "a.csv", "grey,amplitude,phase\n" + rows))
    grey = np.arange(256) / 255
    got = response.amplitude(GREY)
    assert got.dtype == np.complex64
    assert np.allclose(got[5:], (grey * np.exp(0.8j * grey))[5:], atol=5e-3)


def test_a_manifest_brings_it_back():
    for response in (GreyResponse.linear(), GreyResponse.from_gamma(1.8)):
        stored = json.loads(json.dumps(response.as_dict()))
        again = GreyResponse.from_dict(stored)
        assert np.array_equal(again.levels, response.levels) and again.name == response.name
        assert again.as_dict() == stored


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "first line must name"),
        ("a,b\n1,2\n", "first line must name"),
        ("grey,intensity\n0,0\n255,x\n", "row 3"),
        ("grey,intensity\n0,0\n255\n", "row 3"),
        ("grey,intensity\n0,0\n", "two rows"),
        ("grey,intensity\n0,0\n128,0.7\n192,0.3\n255,1\n", "not monotone"),
        ("grey,intensity\n0,0\n200,1\n", "0 to 255"),
        ("grey,intensity\n0,0\n9,0.1\n9,0.2\n255,1\n", "rise from 0 to 255"),
        ("grey,intensity\n0,-1\n255,1\n", "negative intensity"),
        ("grey,intensity\n0,nan\n255,1\n", "NaN"),
        ("grey,intensity\n0,1\n255,1\n", "nothing to modulate"),
        ("grey,intensity\n0,0\n255,0\n", "dark"),
    ],
)
def test_bad_tables_are_refused(tmp_path, text, complaint):
    with pytest.raises(ValueError, match=complaint):
        GreyResponse.from_csv(write(tmp_path / "bad.csv", text))


def test_other_bad_input_is_refused(tmp_path):
    (tmp_path / "binary.csv").write_bytes(bytes(range(256)))
    for text in ("gamma:x", "gamma:-1", str(tmp_path / "binary.csv")):
        with pytest.raises(ValueError):
            GreyResponse.parse(text)
    with pytest.raises(OSError):
        GreyResponse.parse(str(tmp_path / "absent.csv"))
    with pytest.raises(ValueError, match="uint8"):
        GreyResponse.linear().amplitude(np.zeros((2, 2)))


MEASURED = (np.arange(0, 256, 5) / 255) ** 2.1


@pytest.mark.parametrize(
    ("text", "coding"),
    [
        ("grey,intensity\n{}", "utf-8"),
        ("Gray level;Power (mW)\n{}", "utf-8-sig"),
        ("# PM100D, 532 nm\nDate: 2024-03-01 10:00\n\nGrey value\tPower [µW]\n{}", "cp1252"),
        ("Index;Counts;Time\n{}", "utf-16"),
        ("gray   power\n{}", "utf-8"),
    ],
)
def test_tables_of_instruments_are_read(tmp_path, text, coding):
    sign = next(s for s in (";", "\t", ",", " ") if s in text.splitlines()[-2])
    third = sign + "7" if "Time" in text else ""
    rows = [f"{5 * i}{sign}{v * 3.1:.6f}{third}" for i, v in enumerate(MEASURED)]
    table = text.format("\n".join(rows))
    if sign != ",":
        table = table.replace(".", ",")
    path = tmp_path / "a.csv"
    path.write_bytes(table.encode(coding))
    response = GreyResponse.from_csv(path)
    want = (np.arange(256) / 255) ** 1.05
    assert np.allclose(response.amplitude(GREY), want, atol=4e-3)


def test_noise_of_a_reading_is_smoothed_and_told_a_turn_is_refused(tmp_path):
    grey = np.arange(0, 256, 5)
    rng = np.random.default_rng(2)
    for noise, fine in ((0.01, True), (0.2, False)):
        values = MEASURED + noise * rng.uniform(-1, 1, len(grey))
        rows = "\n".join(f"{g},{v}" for g, v in zip(grey, values - min(values), strict=True))
        path = write(tmp_path / "a.csv", "grey,intensity\n" + rows)
        if fine:
            response = GreyResponse.from_csv(path)
            assert "smoothed by" in response.name
            got = np.asarray(response.amplitude(GREY), dtype=float)
            assert (np.diff(got) >= -1e-6).all() and np.abs(got[::5] ** 2 - MEASURED).max() < 0.03
        else:
            with pytest.raises(ValueError, match="not monotone"):
                GreyResponse.from_csv(path)


def test_a_table_that_ends_at_250_goes_on_straight_one_that_ends_at_200_does_not(tmp_path):
    rows = "\n".join(f"{g},{g / 255}" for g in range(0, 251, 10))
    response = GreyResponse.from_csv(write(tmp_path / "a.csv", "grey,amplitude\n" + rows))
    assert response.is_real and np.allclose(response.levels.real, np.arange(256) / 255, atol=1e-3)
    rows = "\n".join(f"{g},{g / 255}" for g in range(0, 201, 10))
    with pytest.raises(ValueError, match="0 to 255"):
        GreyResponse.from_csv(write(tmp_path / "a.csv", "grey,amplitude\n" + rows))


def test_what_is_no_small_file_is_not_read(tmp_path):
    with pytest.raises(ValueError, match="not a file"):
        GreyResponse.from_csv("/dev/zero" if Path("/dev/zero").exists() else tmp_path)
    (tmp_path / "big.csv").write_bytes(b"1,2\n" * 400_000)
    with pytest.raises(ValueError, match="256 rows"):
        GreyResponse.from_csv(tmp_path / "big.csv")


def test_phase_in_degrees(tmp_path):
    rows = "\n".join(f"{g},{g / 255},{45 * g / 255}" for g in range(0, 256, 5))
    path = write(tmp_path / "a.csv", "grey,amplitude,phase (deg)\n" + rows)
    assert np.angle(GreyResponse.from_csv(path).levels[-1]) == pytest.approx(np.pi / 4, abs=1e-3)
