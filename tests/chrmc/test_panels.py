"""Panels by name, by file, and from the user's folder."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import chrmc
import display
from chrmc.cli.arguments import SLMType
from chrmc.cli.main import group, main
from chrmc.panels import PANELS, encoding_for, read_panel
from chrmc.slm import KINDS, LC_R_1080

GOOD = 'name = "mine"\nwidth = 800\nheight = 600\npixel_pitch = 9e-6\nbits = 1\nkind = "binary"\n'


def convert(text):
    return SLMType().convert(text, None, None)


def test_shipped_panels_have_a_source_and_a_kind():
    assert convert("lc-r-1080") is LC_R_1080
    for name, panel in PANELS.items():
        assert convert(name.upper()) is panel.slm
        assert panel.source and panel.slm.kind in KINDS
        assert (panel.slm.bits == 1) == (panel.slm.kind == "binary")


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
    assert slm.kind == "binary"


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
        (GOOD.replace("bits = 1", "bits = 8"), "a binary panel has 1 bit, not 8"),
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
    assert "unconfirmed: refresh, fill factor" in listing


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


def test_a_panel_s_kind_holds_in_python_too(tmp_path: Path) -> None:
    crystal, mirrors = (
        chrmc.SLM(kind, 96, 64, 8e-6, 1 if kind == "binary" else 8, kind=kind)
        for kind in ("phase", "binary")
    )
    assert encoding_for(crystal) == "double-phase" and encoding_for(mirrors) == "error-diffusion"
    assert encoding_for(replace(crystal, kind=None), "kinoform") == "kinoform"
    dots = chrmc.PointCloud([[0, 0, 0], [5e-5, 0, 0]], [1.0, 1], [0.0, 1])
    pose = chrmc.Pose(np.eye(3), [0, 0, 0.01])
    scene = chrmc.PointScene("dots", {"dots": dots}, {"dots": [pose]})
    video = chrmc.generate(scene, tmp_path / "phase", slm=crystal, check_pixels=0)
    assert video.encoding == "double-phase" and video.slm == crystal
    with pytest.raises(ValueError, match="kind binary, which shows error-diffusion, lee, not ssb"):
        chrmc.generate(scene, tmp_path / "v", slm=mirrors, encoding="ssb")
    field = chrmc.compute_field(scene.frame(1).cloud, mirrors, 532e-9, tolerance=1e-3)
    assert set(np.unique(display.encode(field, mirrors))) == {0, 255}
    # A manifest of before panels had a kind is continued.
    manifest = tmp_path / "phase" / "manifest.json"
    content = json.loads(manifest.read_text())
    del content["slm"]["kind"]
    manifest.write_text(json.dumps(content))
    chrmc.generate(scene, tmp_path / "phase", slm=crystal, check_pixels=0)
    with pytest.raises(ValueError, match="holds another video"):
        chrmc.generate(scene, tmp_path / "phase", slm=replace(crystal, fill_factor=0.5))


def test_what_a_binary_panel_cannot_show_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    size = "width = 64\nheight = 48\npixel_pitch = 8e-6\n"
    (tmp_path / "own.toml").write_text(size + 'kind = "binary"\nname = "mirrors"\n')
    (tmp_path / "crystal.toml").write_text(size + 'kind = "phase"\n')
    mirrors = read_panel(tmp_path / "own.toml").slm
    grey, dark = np.full(mirrors.shape, 128, np.uint8), np.zeros(mirrors.shape, np.uint8)
    with display.Screen(headless=True, slm=mirrors) as screen:
        assert screen.encoding == "error-diffusion"
        with pytest.raises(ValueError, match="the frame has grey levels, but mirrors is either"):
            screen.show(grey)
        screen.show(dark)
        screen.show(display.pack_planes([dark, dark + 255]))  # bit planes
        with pytest.raises(ValueError, match="no grey response"):
            display.calibrate_response(screen, lambda grey: grey)
    with pytest.raises(ValueError, match="kind binary"):
        display.Screen(headless=True, slm=mirrors, encoding="ssb")
    told: list[str] = []
    crystal = replace(mirrors, bits=8, kind="phase")
    square = display.Trigger(size=4)
    with display.Screen(headless=True, slm=crystal, trigger=square, tell=told.append):
        assert any("no photodiode" in line for line in told)

    def run(*words: object) -> tuple[int, str]:
        with pytest.raises(SystemExit) as ended:
            main([str(word) for word in words])
        return int(ended.value.code or 0), capsys.readouterr().err

    own, out = ("--slm", tmp_path / "own.toml"), tmp_path / "p.png"
    assert "ramp has grey levels" in run("pattern", "ramp", *own, "--out", out)[1]
    assert run("pattern", "checkerboard", *own, "--out", out)[0] == 0
    assert run("pattern", "point", *own, "--depth", "10mm", "--out", out)[0] == 0
    assert run("play", out, *own, "--headless")[0] == 0
    assert run("pattern", "ramp", "--slm", "64x48:8um", "--out", out)[0] == 0
    status, said = run("play", out, *own, "--headless")
    assert status == 2 and "grey levels" in said
    (tmp_path / "dots.csv").write_text("x,y,z\n0,0,0\n1,0,0\n0,1,0\n")
    folder = tmp_path / "v"
    assert run("generate", tmp_path / "dots.csv", "--out", folder, "--slm", "64x48:8um")[0] == 0
    assert "kind phase" in run("play", folder, "--slm", tmp_path / "crystal.toml", "--headless")[1]


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
