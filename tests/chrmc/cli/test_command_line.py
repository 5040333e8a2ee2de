"""What a user types wrong is told in one line on stderr with exit status 2."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from chrmc.cli.main import COMMANDS, main
from chrmc.files import sha256
from chrmc.store.video import open_video

SMALL = ["--slm", "192x120:8.1e-5", "--cgh", "fresnel", "--compensation", "none"]


def run(*arguments: str | Path) -> int:
    with pytest.raises(SystemExit) as ended:
        main([str(a) for a in arguments])
    assert isinstance(ended.value.code, int)
    return ended.value.code


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nonsense"], "nonsense"),
        (["generate"], "SCENE"),
        (["generate", "no-such-scene", "--out", "x"], "car-house"),
        (["generate", "car-house"], "--out"),
        (["generate", "car-house", "--out", "x", "--frames", "0:3"], "frames 1 to 80"),
        (["generate", "car-house", "--out", "x", "--frames", "5:81"], "frames 1 to 80"),
        (["generate", "car-house", "--out", "x", "--frames", "9:2"], "backwards"),
        (["generate", "car-house", "--out", "x", "--frames", "one"], "1:80"),
        (["generate", "car-house", "--out", "x", "--cgh", "magic"], "fresnel"),
        (["generate", "car-house", "--out", "x", "--compensation", "magic"], "none"),
        (["generate", "car-house", "--out", "x", "--encoding", "magic"], "ssb"),
        (["generate", "car-house", "--out", "x", "--slm", "big"], "1920x1080:8e-6"),
        (["generate", "car-house", "--out", "x", "--wavelength", "532"], "532nm"),
        (["generate", "car-house", "--out", "x", "--tolerance", "2"], "tolerance"),
        (["generate", "car-house", "--out", "x", "--cgh", "rt", "--tolerance", "1e-3"], "rt"),
        (
            ["generate", "car-house", "--out", "x", "--surface", "paper", "--tolerance", "1e-3"],
            "cannot promise",
        ),
        (["generate", "car-house", "--out", "x", "--set", "radius"], "NAME=VALUE"),
        (
            ["generate", "car-house", "--out", "x", *SMALL, "--set", "sharpness=3"],
            "sharpness",
        ),
        (["play", "absent"], "absent"),
        (["check", "absent"], "absent"),
        (["reconstruct", "absent", "--frame", "1", "--depth", "0.25", "--out", "x.png"], "absent"),
    ],
)
def test_one_line_and_exit_status_2(
    arguments: list[str],
    words: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(*arguments) == 2
    shown = capsys.readouterr()
    assert shown.err.count("\n") == 1
    assert words in shown.err
    assert "Usage" not in shown.err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_help(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(name, "--help") == 0
    assert "Usage: chrmc" in capsys.readouterr().out


def test_a_run_is_resumed_where_it_stopped_and_its_frames_agree(tmp_path: Path) -> None:
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    assert run("generate", "car-house", "--out", whole, *SMALL, "--frames", "1:4") == 0
    assert run("generate", "car-house", "--out", parts, *SMALL, "--frames", "3:4") == 0
    kept = sha256(parts / "frame_0003.tif")
    (parts / "frame_0004.tif").write_bytes(b"half a fr")
    assert run("generate", "car-house", "--out", parts, *SMALL, "--frames", "1:4") == 0
    a, b = open_video(whole), open_video(parts)
    assert a.scale == b.scale
    assert sha256(parts / "frame_0003.tif") == kept
    assert [f["sha256"] for f in a.frames] == [f["sha256"] for f in b.frames]


def test_another_video_in_the_folder_is_refused_without_force(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["generate", "car-house", "--out", tmp_path / "v", "--frames", "1:1", *SMALL]
    assert run(*arguments) == 0
    before = (tmp_path / "v" / "manifest.json").read_bytes()
    assert run(*arguments, "--encoding", "real") == 2
    assert "--force" in capsys.readouterr().err
    assert (tmp_path / "v" / "manifest.json").read_bytes() == before
    assert run(*arguments, "--encoding", "real", "--force") == 0
    assert open_video(tmp_path / "v").encoding == "real"


def test_the_manifest_says_what_the_frames_are(tmp_path: Path) -> None:
    assert run("generate", "car-house", "--out", tmp_path, *SMALL, "--frames", "21") == 0
    manifest = json.loads((tmp_path / "manifest.json").read_text())
    frame = manifest["frames"][0]
    assert frame["number"] == 21
    assert frame["file"] == "frame_0021.tif"
    assert frame["key"] is True
    assert 0 <= frame["error_reference"] < 0.5
    assert frame["points_computed"] == sum(o["points"] for o in frame["objects"])
    assert {o["name"] for o in frame["objects"]} == {"car", "house"}
    assert sum(frame["stage_seconds"].values()) > 0
    for obj in frame["objects"]:
        low, high = np.array(obj["box"])
        assert (low <= obj["position"]).all()
        assert (obj["position"] <= high).all()
        assert obj["depth"] == obj["position"][2]


def test_the_console_script_and_the_module_agree() -> None:
    shown = subprocess.run(
        [sys.executable, "-m", "chrmc", "--version"], capture_output=True, text=True, check=True
    )
    assert "0.1.0" in shown.stdout
