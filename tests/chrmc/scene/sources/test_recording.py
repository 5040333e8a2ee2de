"""Recordings of depth cameras and renderers as scenes."""

import json
from pathlib import Path

import numpy as np
import pytest

from chrmc import LC_R_1080, load_scene
from chrmc.scene.sources.recording import read_recording
from chrmc.scene.sources.volume import box

from .making import blender_frame, recording


@pytest.mark.parametrize("tum", [False, True])
def test_a_recording_with_holes_and_a_missing_frame(tmp_path: Path, tum: bool) -> None:
    recording(tmp_path / "walk", tum)
    scene = load_scene(str(tmp_path / "walk"))
    assert scene.frame_count == 3
    assert any("left out" in note for note in scene.notes)
    cloud = scene.frame(2).cloud
    near = cloud.positions[:, 2] < cloud.positions[:, 2].mean()
    bright = cloud.intensity > 0.5
    assert np.array_equal(near, bright)
    # The box was up and left, and is; half as deep as the wall, and is.
    assert cloud.positions[near, 0].mean() < 0 and cloud.positions[near, 1].mean() < 0
    scale = np.ptp(cloud.positions[~near, 0]) / (2.0 * 63 / 60)
    depth = np.median(cloud.positions[~near, 2]) - np.median(cloud.positions[near, 2])
    assert depth == pytest.approx(scale * 1.0, rel=0.01)
    assert len(cloud) == 48 * 64 - 40
    assert np.array_equal(cloud.phase, scene.frame(2).cloud.phase)


def test_bad_recordings(tmp_path: Path) -> None:
    recording(tmp_path / "walk", False)
    camera = tmp_path / "walk" / "intrinsics.json"
    for text, words in (
        ("{", "valid JSON"), ("{}", "no fx"), ('{"fx": 0, "fy": 1, "cx": 0, "cy": 0}', "fx 0 lies"),
    ):  # fmt: skip
        camera.write_text(text)
        with pytest.raises(ValueError, match=words):
            read_recording(tmp_path / "walk", LC_R_1080)
    recording(tmp_path / "tum", True)
    (tmp_path / "tum" / "rgb").rename(tmp_path / "away")
    (tmp_path / "tum" / "rgb").symlink_to(tmp_path / "away")
    with pytest.raises(ValueError, match="leads out of"):
        read_recording(tmp_path / "tum", LC_R_1080)


def test_frames_of_a_renderer_with_a_perspective_camera(tmp_path: Path) -> None:
    for number in (1, 2):
        blender_frame(tmp_path / f"frame_{number:04d}.exr", 0.5 * (number - 1))
    words = {"camera": {"lens": 50}, "scale": 1e-3, "offset": [0, 0, 0.245]}
    (tmp_path / "scene.json").write_text(json.dumps(words))
    scene = load_scene(str(tmp_path))
    assert scene.frame_count == 2
    cloud = scene.frame(1).cloud
    assert len(cloud) == 100
    assert cloud.positions[:, 2] == pytest.approx(0.25, abs=1e-6)
    focal = 60 * 50 / 36
    assert cloud.positions[:, 0].min() == pytest.approx(1e-3 * (10 - 29.5) * 5 / focal)
    assert cloud.positions[:, 1].max() == pytest.approx(1e-3 * (14 - 19.5) * 5 / focal)
    assert scene.frame(2).cloud.positions[:, 2] == pytest.approx(0.2505, abs=1e-6)


def test_a_far_background_is_no_light_in_parallel_projection_either(tmp_path: Path) -> None:
    blender_frame(tmp_path / "frame_0001.exr", 0)
    (tmp_path / "scene.json").write_text('{"pixel_pitch": 4e-5}')
    assert len(load_scene(str(tmp_path)).frame(1).cloud) == 100
    (tmp_path / "scene.json").write_text(
        '{"pixel_pitch": 4e-5, "depth_unit": 0.05, "scale": 1, "offset": [0, 0, 0.01]}'
    )
    cloud = load_scene(str(tmp_path)).frame(1).cloud
    assert cloud.positions[:, 2] == pytest.approx(0.26, abs=1e-6)
    assert np.ptp(cloud.positions[:, 0]) == pytest.approx(9 * 4e-5)


def test_fewer_points_and_all_frames_in_the_volume(tmp_path: Path) -> None:
    recording(tmp_path / "walk", False)
    words = json.loads((tmp_path / "walk" / "intrinsics.json").read_text())
    words |= {"scale": 5e-3, "offset": [0, 0, 0.24]}  # too large
    (tmp_path / "walk" / "intrinsics.json").write_text(json.dumps(words))
    every = len(load_scene(str(tmp_path / "walk")).frame(1).cloud)
    assert 400 < len(load_scene(str(tmp_path / "walk"), points=800).frame(1).cloud) <= 800
    assert len(load_scene(str(tmp_path / "walk"), density=1e5).frame(1).cloud) < every / 4
    fitted = load_scene(str(tmp_path / "walk"), fit=True)
    half = np.array(box(LC_R_1080, 532e-9, 0.25)) / 2 * 1.05
    for number in (1, 2, 3):
        assert (np.abs(fitted.frame(number).cloud.positions[:, :2]) <= half).all()


@pytest.mark.parametrize("tum", [False, True])
def test_a_recording_is_one_object_among_others(tmp_path: Path, tum: bool) -> None:
    recording(tmp_path / "walk", tum)
    (tmp_path / "scene.toml").write_text(
        'frames = 5\n[[object]]\nfile = "walk"\nscale = 1e-3\nplace = [1e-3, 0, 0.25]\n'
        '[[object]]\ntext = "HI"\nsize = 1e-3\nplace = [-1e-3, 0, 0.26]\n'
        '[[object]]\nname = "still"\nfile = "walk"\nsize = 1e-3\nturn = [0, 0, 180]\n'
        'motion = "none"\n'
    )
    scene = load_scene(tmp_path / "scene.toml")
    assert scene.pose("walk", 1) is None and scene.pose("HI", 1) is not None
    # Stamps 1, 2 and 4 seconds: the missing third is the second again, the last one goes on.
    shown = [0, 1, 1, 2, 2] if tum else [0, 1, 2, 2, 2]
    alone = read_recording(tmp_path / "walk", LC_R_1080)
    for number, picture in enumerate(shown, 1):
        cloud = scene.frame(number).objects[0].cloud
        seen = alone.frame(picture + 1).cloud
        assert np.allclose(np.ptp(cloud.positions, axis=0), 1e-3 * np.array([2.1, 1.57, 1.0]), 0.02)
        assert len(cloud) == len(seen) and np.array_equal(cloud.phase, seen.phase)
        assert np.allclose(cloud.amplitude / seen.amplitude, cloud.amplitude[0] / seen.amplitude[0])
    middle = (cloud.positions.min(axis=0) + cloud.positions.max(axis=0)) / 2
    assert middle == pytest.approx([1e-3, 0, 0.25], abs=2e-5)
    turned = scene.frame(5).objects[2].cloud
    near = turned.positions[:, 2] < turned.positions[:, 2].mean()
    assert turned.positions[near, :2].mean(axis=0).min() > 0  # from up and left to down and right


def test_a_recording_is_thinned_and_named_on_the_command_line(tmp_path: Path) -> None:
    recording(tmp_path / "walk", False)
    few = load_scene([f"{tmp_path / 'walk'}@0.3", "text:HI@0.2"], points=800)
    cloud = few.frame(1).objects[0].cloud
    assert 400 < len(cloud) <= 800
    assert np.median(cloud.positions[:, 2]) == pytest.approx(0.3, abs=2e-3)
    pictures = load_scene([f"{tmp_path / 'walk'}@0.3", "text:HI@0.2"], "rgbd", points=800)
    assert {"walk", "HI"} == {o.name for o in pictures.frame(2).objects if len(o.cloud)}
    with pytest.raises(ValueError, match="is no recording"):
        load_scene([str(tmp_path), "text:HI@0.2"])
