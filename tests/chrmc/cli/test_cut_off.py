"""Commands that are cut off: what was finished is whole, and the same command goes on."""

import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from chrmc.files import sha256
from chrmc.pictures import read_grey
from chrmc.store.video import open_video

ROOT = Path(__file__).parents[3]
SMALL = ["--slm", "192x120:81um", "--cgh", "rt", "--compensation", "none", "--check-pixels", "0"]
OWN = '''
import time
from pathlib import Path
import chrmc

made = 0

def field(cloud, slm, wavelength, window, passband):
    """Ray tracing that stops in its fourth frame until there is a file "go"."""
    global made
    made += 1
    while made > 3 and not Path("go").exists():
        time.sleep(0.01)
    return chrmc.compute_field(cloud, slm, wavelength, "rt", window=window, passband=passband)
'''
GENERATE = ["generate", "car-house", "--out", "v", "--frames", "1:12", *SMALL]


def started(
    arguments: list[str], folder: Path, before: Callable[[], None] | None = None
) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-m", "chrmc", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=before,
    )


def ended(process: "subprocess.Popen[str]") -> tuple[int, str]:
    """Status and what was said on stderr."""
    _, told = process.communicate(timeout=200)
    return process.returncode, told


def cut(arguments: list[str], folder: Path, sign: str, number: int) -> tuple[int, str]:
    """The command, ended by a signal as soon as a file of the pattern `sign` is there."""
    process = started(arguments, folder)
    while not any(folder.glob(sign)):
        assert process.poll() is None, process.communicate()[1]
        time.sleep(0.01)
    process.send_signal(number)
    return ended(process)


@pytest.mark.parametrize(
    "number",
    [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.long), signal.SIGKILL],
)
def test_a_video_that_is_cut_off_is_whole_as_far_as_it_goes_and_goes_on(
    number: signal.Signals, tmp_path: Path
) -> None:
    (tmp_path / "own.py").write_text(OWN)
    generate = [word if word != "rt" else "own.py:field" for word in GENERATE]
    status, told = cut(generate, tmp_path, "v/frame_0002.tif", number)
    if number == signal.SIGKILL:
        assert status == -signal.SIGKILL
    else:
        assert status == 130
        assert len(told.split("\n")) <= 3 and "kept" in told
        assert not list(tmp_path.rglob("*.partial*"))
        found = open_video(tmp_path / "v")
        assert 2 <= len(found) < 12
        assert {p.name for p in (tmp_path / "v").glob("frame_*")} == {
            str(f["file"]) for f in found.frames
        }
    kept = {p.name: sha256(p) for p in (tmp_path / "v").glob("frame_*.tif")}
    (tmp_path / "go").touch()
    assert ended(started(generate, tmp_path))[0] == 0
    whole = open_video(tmp_path / "v")
    assert whole.numbers == list(range(1, 13))
    for frame in whole.frames:
        assert sha256(tmp_path / "v" / frame["file"]) == frame["sha256"]
        assert kept.get(str(frame["file"]), frame["sha256"]) == frame["sha256"]
    assert not list(tmp_path.rglob("*.partial*"))


def test_a_scene_that_is_cut_off_goes_on(tmp_path: Path) -> None:
    number = signal.SIGKILL
    arguments = ["scene", "car-house", "--out", "s", "--frames", "1:12"]
    status, told = cut(arguments, tmp_path, "s/frame_0002.exr", number)
    assert status == -number, told
    (tmp_path / "s" / ".frame_0003.99.partial.exr").write_bytes(b"half")
    assert ended(started(arguments, tmp_path)) == (0, "")
    assert len(list((tmp_path / "s").glob("frame_*.exr"))) == 12
    assert not list(tmp_path.rglob("*.partial*"))


def test_reconstructions_that_are_cut_off_are_whole_pictures(
    stored_video: Path, tmp_path: Path
) -> None:
    far = ["--depths", "245mm:270mm:120", "--frame", "1", "--out", "o"]
    status, told = cut(
        ["reconstruct", str(stored_video), *far], tmp_path, "o/*.png", signal.SIGTERM
    )
    assert status == 130 and len(told.split("\n")) <= 3
    assert not list(tmp_path.rglob("*.partial*"))
    for picture in (tmp_path / "o").glob("*.png"):
        assert read_grey(picture).shape == (120, 192)


@pytest.mark.parametrize(
    "arguments",
    [
        GENERATE,
        ["scene", "car-house", "--out", "s", "--frames", "1:2"],
        ["pattern", "grating", "--out", "p.tif"],
    ],
)
def test_a_full_disk_is_one_line_and_nothing_half_written_is_left(
    arguments: list[str], tmp_path: Path
) -> None:
    def full() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

    status, told = ended(started(arguments, tmp_path, full))
    assert status == 2, told
    assert told.count("\n") == 1
    left = [p for p in tmp_path.rglob("*") if p.is_file()]
    assert [p.name for p in left if p.suffix in (".tif", ".exr", ".png")] == []
    assert not [p.name for p in left if "partial" in p.name]


@pytest.mark.parametrize(
    "arguments",
    [
        [*GENERATE[:2], "--out", "/proc/v", *GENERATE[4:]],
        ["scene", "car-house", "--out", "/proc/s", "--frames", "1:2"],
        ["pattern", "grating", "--out", "/proc/p.tif"],
    ],
)
def test_a_place_that_takes_no_files_is_one_line(arguments: list[str], tmp_path: Path) -> None:
    status, told = ended(started(arguments, tmp_path))
    assert status == 2
    assert told.count("\n") == 1 and "/proc" in told
