"""Panels by name, by file, and from the user's folder."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import chrmc
from chrmc.cli.arguments import SLMType
from chrmc.cli.main import group, main
from chrmc.panels import KINDS, PANELS, panel_named, read_panel
from chrmc.slm import LC_R_1080

GOOD = 'name = "mine"\nwidth = 800\nheight = 600\npixel_pitch = 9e-6\nbits = 1\nkind = "binary"\n'


def convert(text):
    return SLMType().convert(text, None, None)


def test_shipped_panels_have_a_source_and_a_kind():
    assert convert("lc-r-1080") is LC_R_1080
    for name, panel in PANELS.items():
        assert convert(name.upper()) is panel.slm
        assert panel.source and panel.kind in KINDS
        assert (panel.slm.bits == 1) == (panel.kind == "binary")


def test_sizes_and_pitches_with_units():
    for text in ("800x600:8um", "800×600:8µm", "800x600:8e-6"):
        slm = convert(text)
        assert (slm.width, slm.height) == (800, 600)
        assert slm.pixel_pitch == pytest.approx(8e-6)


def test_a_file_is_a_panel(tmp_path):
    path = tmp_path / "panel.toml"
    path.write_text(GOOD)
    slm = convert(str(path))
    assert (slm.name, slm.width, slm.bits, slm.pixel_pitch) == ("mine", 800, 1, 9e-6)
    assert panel_named(str(path)).kind == "binary"


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("width = ", "no TOML"),
        ("width = 800\nheight = 600\n", "pixel_pitch is missing"),
        (GOOD + "colour = 3\n", "no such key 'colour'"),
        (GOOD.replace("9e-6", "9.0"), "pixel_pitch"),
        (GOOD.replace("9e-6", '"wide"'), "pixel_pitch"),
        (GOOD.replace("800", "0"), "side"),
        (GOOD.replace("binary", "sound"), "kind is amplitude, binary, phase"),
        (GOOD.replace('"mine"', "7"), "name must be text"),
    ],
)
def test_a_bad_file_is_one_line(tmp_path, text, complaint):
    path = tmp_path / "panel.toml"
    path.write_text(text)
    with pytest.raises(ValueError, match=complaint) as caught:
        read_panel(path)
    assert "panel.toml" in str(caught.value)


def test_own_panels_are_found_and_listed(tmp_path, monkeypatch):
    monkeypatch.setattr("chrmc.panels.user_folder", lambda: tmp_path)
    (tmp_path / "mine.toml").write_text(GOOD)
    (tmp_path / "broken.toml").write_text("width = 3")
    assert convert("mine").width == 800
    listing = CliRunner().invoke(group, ["panels"]).output
    assert "mine" in listing and "800 × 600" in listing and "dlp6500" in listing
    assert "height is missing" in listing


def test_an_unknown_name_says_what_there_is():
    done = CliRunner().invoke(group, ["monitors", "--slm", "plutonium"])
    assert (
        done.exit_code == 2 and "lc-r-1080" in done.output and "WIDTHxHEIGHT:PITCH" in done.output
    )


def test_a_panel_brings_its_encoding_and_its_response(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "dots.csv").write_text("x,y,z\n0,0,0\n1,0,0\n0,1,0\n")
    (tmp_path / "grey.csv").write_text("grey,intensity\n0,0.1\n128,1\n255,4\n")
    size = "width = 96\nheight = 64\npixel_pitch = 8e-6\n"
    (tmp_path / "own.toml").write_text(size + 'kind = "phase"\n')
    (tmp_path / "grey.toml").write_text(size + 'response = "grey.csv"\n')
    (tmp_path / "bad.toml").write_text(size + 'response = "none.csv"\n')

    def made(panel: str, *words: str) -> int:
        with pytest.raises(SystemExit) as ended:
            main(["generate", str(tmp_path / "dots.csv"), "--out", str(tmp_path / "v"), "--force",
                  "--frames", "1", "--slm", panel, *words])  # fmt: skip
        return int(ended.value.code or 0)

    assert made(str(tmp_path / "own.toml")) == 0
    assert chrmc.open_video(tmp_path / "v").encoding == "double-phase"
    assert made(str(tmp_path / "grey.toml")) == 0
    stored = chrmc.open_video(tmp_path / "v")
    assert stored.encoding == "ssb" and stored.response["name"] == "grey.csv"
    assert made(str(tmp_path / "own.toml"), "--encoding", "ssb") == 2
    assert "kind phase, which shows double-phase, kinoform, not ssb" in capsys.readouterr().err
    assert made(str(tmp_path / "bad.toml")) == 2
    assert "names no file" in capsys.readouterr().err


@pytest.mark.parametrize("bits", [1, 4])
@pytest.mark.parametrize("made_with", ["none", "ch-rmc"])
def test_generate_gives_a_panel_the_levels_that_it_has(tmp_path, bits, made_with):
    panel = chrmc.SLM("coarse", 64, 48, 8.1e-6, bits=bits)
    rng = np.random.default_rng(2)
    spread = rng.uniform(-5e-5, 5e-5, (40, 3)) * (1, 1, 0)
    cloud = chrmc.PointCloud(spread, np.ones(40), rng.uniform(0, 6, 40))
    poses = [chrmc.Pose(np.eye(3), [1e-5 * n, 0, 0.02]) for n in range(3)]
    scene = chrmc.PointScene("dots", {"dots": cloud}, {"dots": poses})
    options = {"encoding": "ssb", "compensation": made_with, "check_pixels": 0}
    video = chrmc.generate(scene, tmp_path / "coarse", slm=panel, **options)
    fine = chrmc.generate(scene, tmp_path / "fine", slm=replace(panel, bits=8), **options)
    step = 255 / (2**bits - 1)
    for number in video.numbers:
        levels = video.read(number).astype(float)
        there = set(np.unique(levels))
        assert there <= set(np.rint(step * np.arange(2**bits))) and len(there) > 2 ** (bits - 1)
        # The nearest of them: half a step off at most, and what rounding to a whole grey adds.
        assert np.abs(levels - fine.read(number)).max() <= step / 2 + 1
