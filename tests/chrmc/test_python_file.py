"""Scenes and methods of one's own in Python files, on the command line and stored."""

import json
import os
from pathlib import Path

import pytest

import chrmc
from chrmc.cli.main import main
from chrmc.python_file import from_python_file, is_python_name

CODE = """
import neighbour
import numpy as np
import chrmc

body = chrmc.PointCloud(np.eye(3) * neighbour.SIZE, np.ones(3), np.zeros(3))
still = chrmc.PointScene("three", {"dots": body}, {"dots": [chrmc.Pose(np.eye(3), [0, 0, 0.1])]})

def scene():
    poses = [chrmc.Pose(np.eye(3), [n * 2e-5, 0, 0.1]) for n in range(3)]
    return chrmc.PointScene("three", {"dots": body}, {"dots": poses})

def field(cloud, slm, wavelength, window, passband, *, strength=1.0):
    part = dict(window=window, passband=passband)
    return strength * chrmc.compute_field(cloud, slm, wavelength, "fresnel", **part)

def frames(scene, slm, wavelength, cgh, numbers, coding, **options):
    from chrmc.compensation.none import frames as afresh
    yield from afresh(scene, slm, wavelength, cgh, numbers, coding, **options)

def wrong():
    return undefined_name

def wrong_field(cloud, slm, wavelength, window, passband):
    return cloud.no_such_attribute
"""


@pytest.fixture
def own(tmp_path: Path) -> Path:
    (tmp_path / "neighbour.py").write_text("SIZE = 1e-4\n")
    (tmp_path / "own.py").write_text(CODE)
    return tmp_path / "own.py"


def run(*arguments: object) -> int:
    with pytest.raises(SystemExit) as ended:
        main([str(a) for a in arguments])
    assert isinstance(ended.value.code, int)
    return ended.value.code


SMALL = ["--slm", "120x80:8.1e-6", "--check-pixels", "16"]


def test_only_a_file_and_a_name_count() -> None:
    assert is_python_name("a/b.py:scene")
    assert is_python_name(r"C:\a\b.py:scene")
    for other in ("curved", "a.py", "a.py:", "a.txt:scene", "a.py:x y", None, Path("a.py")):
        assert not is_python_name(other)


def test_a_scene_and_methods_of_ones_own_are_stored_resumed_and_checked(
    own: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "v"
    arguments = ["generate", f"{own}:scene", "--out", out, *SMALL, "--cgh", f"{own}:field"]
    arguments += ["--compensation", f"{own}:frames", "--set", "strength=2"]
    assert run(*arguments, "--frames", "1:2") == 0
    assert run(*arguments) == 0
    manifest = json.loads((out / "manifest.json").read_text())
    assert manifest["scene"]["source"]["file"] == "own.py"
    cgh = manifest["methods"]["cgh"]
    assert (cgh["file"], cgh["function"], len(cgh["sha256"])) == ("own.py", "field", 64)
    assert chrmc.open_video(out).numbers == [1, 2, 3]
    capsys.readouterr()
    assert run("check", out, "--frames", "1", "--depth-tolerance", "0.05") in (0, 1)
    assert "dots" in capsys.readouterr().out
    assert run("check", out, "--frames", "1", "--scene", f"{own}:scene", "--truth") in (0, 1)
    assert "PSNR" in capsys.readouterr().out
    assert run("check", out, "--frames", "1", "--truth") == 2
    assert "--scene FILE.py:scene" in capsys.readouterr().err
    own.write_text(CODE + "\n# another version\n")
    assert run(*arguments) == 2
    assert "sha256" in capsys.readouterr().err


def test_a_scene_may_be_an_object_too(own: Path) -> None:
    scene = chrmc.load_scene(f"{own}:still")
    assert scene.frame_count == 1
    field = chrmc.compute_field(
        scene.frame(1).cloud, chrmc.SLM("s", 40, 30, 8.1e-6), 532e-9, f"{own}:field"
    )
    assert abs(field).max() > 0


@pytest.mark.parametrize(
    ("scene", "more", "words"),
    [
        ("own.py:absent", (), "no 'absent'; it has"),
        ("absent.py:scene", (), "there is no Python file absent.py"),
        ("own.py:wrong", (), "line 22: NameError"),
        ("own.py:body", (), "is no scene: it has no name"),
        ("neighbour.py:SIZE", (), "is no scene"),
        ("broken.py:scene", (), "line 1: SyntaxError"),
        ("own.py:scene", ("--cgh", "own.py:wrong_field"), "line 25: AttributeError"),
        ("own.py:scene", ("--cgh", "own.py:body"), "is a function or"),
        ("own.py:scene", ("--cgh", "own.py:field", "--set", "force=3"), "force"),
    ],
)
def test_mistakes_in_own_files_are_one_line_and_leave_nothing(
    own: Path,
    scene: str,
    more: tuple[str, ...],
    words: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(own.parent)
    Path("broken.py").write_text("def scene(:\n")
    assert run("generate", scene, "--out", "v", *SMALL, *more) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert words in told
    assert not Path("v").exists()


def test_two_versions_of_one_second_and_size_are_two(tmp_path: Path) -> None:
    file, before = tmp_path / "own.py", None
    for number in (1, 2):
        file.write_text(f"value = {number}\n")
        stamps = before or (file.stat().st_atime_ns, file.stat().st_mtime_ns)
        os.utime(file, ns=stamps)
        before = stamps
        assert from_python_file(f"{file}:value") == number
