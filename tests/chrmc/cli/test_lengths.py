"""Lengths on the command line: their units, and what is meant by a number that cannot be one."""

from contextlib import suppress
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from chrmc.cli.arguments import Setting, SLMType
from chrmc.cli.lengths import DEPTH, FOCAL, METRES, PITCH, PLACE, WAVELENGTH, parse_length, shown
from chrmc.cli.main import group


@pytest.mark.parametrize(
    ("text", "kind", "metres"),
    [
        ("252mm", DEPTH, 0.252),
        ("252 mm", DEPTH, 0.252),
        ("25.2cm", DEPTH, 0.252),
        ("0.252", DEPTH, 0.252),
        (".252m", DEPTH, 0.252),
        ("2.52E-1", DEPTH, 0.252),
        ("40m", DEPTH, 40.0),
        ("8um", PITCH, 8e-6),
        ("8µm", PITCH, 8e-6),
        ("8μm", PITCH, 8e-6),
        ("532nm", WAVELENGTH, 532e-9),
        ("532e-9", WAVELENGTH, 532e-9),
        ("-5mm", PLACE, -5e-3),
    ],
)
def test_a_length_is_metres_whatever_its_unit(text: str, kind: object, metres: float) -> None:
    assert parse_length(text, kind) == pytest.approx(metres, rel=1e-12)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("text", "kind", "meant"),
    [
        ("252", DEPTH, "252mm (0.252)"),
        ("50", DEPTH, "50mm"),
        ("532", WAVELENGTH, "532nm (5.32e-07)"),
        ("0.532", WAVELENGTH, "0.532um"),
        ("8.1", PITCH, "8.1um"),
        ("150", FOCAL, "150mm"),
        ("-5km", PLACE, "write it with its unit"),
        ("0.25,", DEPTH, "252mm"),
        ("nan", DEPTH, "252mm"),
        ("inf", DEPTH, "252mm"),
        ("1e999", DEPTH, "1 µm to 1000 m"),
        ("0", DEPTH, "1 µm"),
        ("-252mm", DEPTH, "1 µm"),
        ("252mm", WAVELENGTH, "10 nm to 1 mm"),
        ("٣mm", DEPTH, "252mm"),
        ("", DEPTH, "252mm"),
    ],
)
def test_what_cannot_be_meant_is_refused_with_what_may_be(
    text: str, kind: object, meant: str
) -> None:
    with pytest.raises(ValueError) as told:
        parse_length(text, kind)  # type: ignore[arg-type]
    assert meant in str(told.value)


@given(st.floats(1e-6, 9.9), st.sampled_from(sorted(METRES)))
def test_the_unit_changes_nothing_but_the_unit(metres: float, unit: str) -> None:
    written = f"{metres / METRES[unit]:.17g}{unit}"
    assert parse_length(written, DEPTH) == pytest.approx(metres, rel=1e-12)


@given(st.text(max_size=12))
def test_any_text_is_a_length_or_a_value_error(text: str) -> None:
    with suppress(ValueError):
        assert 1e-6 <= parse_length(text, DEPTH) <= 1e3


@given(st.floats(1e-9, 900.0))
def test_a_length_is_shown_as_it_can_be_typed(metres: float) -> None:
    number, unit = shown(metres).split()
    assert float(number) * METRES[unit.replace("µ", "u")] == pytest.approx(metres, rel=1e-5)


@pytest.mark.parametrize("text", ["1920x1080:8um", "1920×1080:8µm", "1920X1080:8e-6"])
def test_a_panel_is_read_in_all_spellings(text: str) -> None:
    slm = SLMType().convert(text, None, None)
    assert (slm.width, slm.height) == (1920, 1080)
    assert slm.pixel_pitch == pytest.approx(8e-6)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("radius=145mm", 0.145),
        ("radius=0.145", 0.145),
        ("layers=3", 3),
        ("tolerance=1e-3", 1e-3),
        ("exact=true", True),
        ("radius=none", None),
        ("rule=strict", "strict"),
    ],
)
def test_settings_are_numbers_lengths_words(text: str, value: object) -> None:
    _, read = Setting().convert(text, None, None)
    assert read == pytest.approx(value) if isinstance(value, float) else read == value
    assert type(read) is type(value)


@pytest.mark.parametrize("text", ["tolerance=", "=3", "radius", "radius=1e308", "n=" + "9" * 40])
def test_settings_that_nothing_can_be_are_refused(text: str) -> None:
    with pytest.raises(click.BadParameter):
        Setting().convert(text, None, None)


@pytest.mark.parametrize(
    "arguments",
    [
        ["reconstruct", "{}", "--frame", "1", "--depth", "252", "--out", "x.png"],
        ["reconstruct", "{}", "--frame", "1", "--depths", "245:270:3", "--out", "x"],
        ["reconstruct", "{}", "--frame=1", "--depth=252mm", "--camera=3.45:8", "--out=x.png"],
        ["reconstruct", "{}", "--frame=1", "--depth=252mm", "--aperture=3", "--out=x.png"],
        ["reconstruct", "{}", "--frame=1", "--depth=252mm", "--focal1", "150", "--out=x.png"],
        ["reconstruct", "{}", "--frame=1", "--depth=252mm", "--dc-block", "10", "--out=x.png"],
        ["check", "{}", "--depth-tolerance", "0.5km"],
        ["check", "{}", "--lateral-tolerance", "40"],
        ["view", "{}", "--depth", "252"],
        ["pattern", "point", "--depth", "250", "--out", "x.png"],
        ["pattern", "point", "--wavelength", "532", "--out", "x.png"],
        ["bench-sheet", "--focal1", "150"],
        ["bench-sheet", "--slm", "1920x1080:8"],
        ["generate", "car-house", "--wavelength", "532", "--out", "x"],
        ["bench", "propagation", "{}", "--depth", "252"],
    ],
)
def test_every_length_of_every_command_is_read_alike(
    arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stored_video: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    filled = [a.format(stored_video) for a in arguments]
    shown = CliRunner().invoke(group, filled, standalone_mode=False)
    error = shown.exception
    assert isinstance(error, (click.BadParameter, ValueError)), shown.output
    said = error.format_message() if isinstance(error, click.ClickException) else str(error)
    assert "plausible" in said or "is no length" in said
    assert list(tmp_path.iterdir()) == []
