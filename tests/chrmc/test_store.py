"""A stored video is whole, verifiable and resumable."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import chrmc.store.group as group_module
from chrmc.files import replacing, sha256, write_json
from chrmc.pictures import read_grey, write_grey
from chrmc.record import FrameRecord
from chrmc.slm import SLM
from chrmc.store.group import GroupWriter
from chrmc.store.manifest import FORMAT
from chrmc.store.video import MANIFEST, open_video, ranges
from chrmc.store.writer import VideoWriter, remove_video

PANEL = SLM("test", 48, 31, 8e-6)


def description(**changes: Any) -> dict[str, Any]:
    return {
        "format": FORMAT,
        "slm": asdict(PANEL),
        "wavelength": 532e-9,
        "scene": {"name": "s", "pixel_pitch": 40e-6},
        "methods": {"cgh": "rt"},
        "encoding": "ssb",
        "scale": 3.0,
    } | changes


def stored(folder: Path, *numbers: int, suffix: str = ".tif") -> None:
    """A video of these frames, as a run leaves it."""
    video, group = VideoWriter(folder, description(), suffix), GroupWriter(folder, 1, suffix)
    for n in numbers:
        group.add(FrameRecord(n, points_computed=n), levels(n))
    group.save()
    video.collect()


def levels(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, PANEL.shape, dtype=np.uint8)


@pytest.mark.parametrize("suffix", [".tif", ".png"])
def test_frames_come_back_to_the_bit(tmp_path: Path, suffix: str) -> None:
    stored(tmp_path / "v", 3, 4, suffix=suffix)
    video = open_video(tmp_path / "v")
    assert video.numbers == [3, 4]
    assert video.slm == PANEL
    assert video.scale == 3.0
    for n in (3, 4):
        np.testing.assert_array_equal(video.read(n), levels(n))
        assert sha256(video.path(n)) == video.entry(n)["sha256"]
    names = {p.name for p in (tmp_path / "v").iterdir()}
    assert names == {MANIFEST, f"frame_0003{suffix}", f"frame_0004{suffix}"}


def test_a_stopped_run_keeps_whole_frames_and_drops_damaged_ones(tmp_path: Path) -> None:
    stored(tmp_path, 1, 2, 3)
    file = tmp_path / "frame_0002.tif"
    file.write_bytes(file.read_bytes()[:-100])
    assert sorted(VideoWriter(tmp_path, description()).entries) == [1, 3]


@pytest.mark.parametrize("moment", ["write_grey", "sha256", "asdict"])
def test_an_interrupt_leaves_no_frame_unlisted(
    tmp_path: Path, moment: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    stored(tmp_path, 1)
    group = GroupWriter(tmp_path, 2)
    real = getattr(group_module, moment)

    def interrupted(*arguments: Any, **options: Any) -> None:
        real(*arguments, **options)
        raise KeyboardInterrupt

    monkeypatch.setattr(group_module, moment, interrupted)
    with pytest.raises(KeyboardInterrupt):
        group.add(FrameRecord(2), levels(2))
    assert [p.name for p in tmp_path.glob("frame_*")] == ["frame_0001.tif"]
    assert open_video(tmp_path).numbers == [1]


def test_a_second_attempt_that_fails_leaves_what_the_first_stored(tmp_path: Path) -> None:
    first, second = GroupWriter(tmp_path, 1), GroupWriter(tmp_path, 1)
    first.add(FrameRecord(1), levels(1))
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(ValueError):
        second.add(FrameRecord(1), levels(1).astype(float))
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_folder_of_another_video_is_refused_and_left_alone(tmp_path: Path) -> None:
    stored(tmp_path, 1)
    before = (tmp_path / MANIFEST).read_bytes()
    with pytest.raises(ValueError, match="another video"):
        VideoWriter(tmp_path, description(scale=4.0))
    assert (tmp_path / MANIFEST).read_bytes() == before
    remove_video(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_frames_without_a_manifest_are_not_taken_over(tmp_path: Path) -> None:
    (tmp_path / "frame_0001.tif").write_bytes(b"somebody's")
    with pytest.raises(ValueError, match=r"without a manifest\.json"):
        VideoWriter(tmp_path, description())


def test_a_write_that_fails_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    write_json(path, {"a": 1})
    with pytest.raises(RuntimeError), replacing(path) as partial:
        partial.write_text("half")
        raise RuntimeError
    assert json.loads(path.read_text()) == {"a": 1}
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("{", "not valid JSON"),
        ("[]", "not a hologram video's manifest"),
        ('{"format": 99}', "format 99"),
        ('{"format": 1}', "not a hologram video's manifest"),
    ],
)
def test_a_bad_manifest_is_told_in_one_line(tmp_path: Path, content: str, message: str) -> None:
    (tmp_path / MANIFEST).write_text(content)
    with pytest.raises(ValueError, match=message) as caught:
        open_video(tmp_path)
    assert "\n" not in str(caught.value)


def test_an_absent_video_says_how_to_make_one(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="chrmc generate"):
        open_video(tmp_path / "nothing")


def test_a_manifest_cannot_point_outside_its_folder(tmp_path: Path) -> None:
    entry = {"number": 1, "file": "../secret.tif", "sha256": ""}
    write_json(tmp_path / MANIFEST, description(frames=[entry]))
    with pytest.raises(ValueError, match="plain file name"):
        open_video(tmp_path)


def test_a_frame_of_the_wrong_size_is_refused(tmp_path: Path) -> None:
    stored(tmp_path, 1)
    write_grey(tmp_path / "frame_0001.tif", np.zeros((5, 7), np.uint8))
    with pytest.raises(ValueError, match="7 × 5 pixels; 48 × 31 are needed"):
        open_video(tmp_path).read(1)


def test_pictures_refuse_what_an_amplitude_panel_cannot_show(tmp_path: Path) -> None:
    import OpenImageIO as oiio

    colour = tmp_path / "c.png"
    out = oiio.ImageOutput.create(str(colour))
    assert out.open(str(colour), oiio.ImageSpec(4, 4, 3, "uint8"))
    pixels = np.zeros((4, 4, 3), np.uint8)
    pixels[..., 1] = 200
    assert out.write_image(pixels)
    assert out.close()
    with pytest.raises(ValueError, match="colour"):
        read_grey(colour)
    (tmp_path / "bad.png").write_bytes(b"no picture")
    with pytest.raises(OSError, match="cannot be read"):
        read_grey(tmp_path / "bad.png")


def test_ranges_reads_like_a_person_writes() -> None:
    assert ranges([1, 2, 3, 7, 9, 10]) == "1:3, 7, 9:10"
    assert ranges([]) == ""
