"""scene.toml: several things, their motions, and what leaves the volume."""

from pathlib import Path

import numpy as np
import pytest

from chrmc import LC_R_1080, load_scene
from chrmc.scene.sources.volume import box, outside

from .making import FEW, run, track_rows


def test_a_world_is_written_and_means_the_same(models: Path, tmp_path: Path) -> None:
    spider = models / "OBJ" / "spider.obj"
    (tmp_path / "w.toml").write_text(
        f'points = {FEW}\n[[object]]\nname = "a"\nfile = "{spider}"\nsize = 1.5e-3\n'
        "place = [1e-3, 0, 0.24]\nturn = [0, 30, 0]\n"
        'motion = { kind = "turntable", degrees = 45 }\n'
        f'[[object]]\nname = "b"\nfile = "{models / "PLY" / "Wuson.ply"}"\nup = "y"\n'
        "place = [-1e-3, 0, 0.26]\n"
    )
    first = load_scene(str(tmp_path / "w.toml"))
    assert first.frame_count == 8
    assert first.object_names == ("a", "b")
    assert run("scene", tmp_path / "w.toml", "--out", tmp_path / "again.toml") == 0
    again = load_scene(str(tmp_path / "again.toml"))
    for number in (1, 4):
        one, two = first.frame(number), again.frame(number)
        assert len(one.cloud) > 300
        assert one.cloud.positions == pytest.approx(two.cloud.positions, abs=1e-9)
    # A turntable about y: heights stay, a full turn comes back.
    poses = [first.pose("a", n) for n in range(1, 9)]
    for pose in poses:
        assert pose.translation[1] == pytest.approx(poses[0].translation[1], abs=1e-15)
    step = poses[1].rotation @ poses[0].rotation.T
    assert step @ [0, 0, 1] == pytest.approx([np.sin(np.pi / 4), 0, np.cos(np.pi / 4)])


def test_poses_move_an_object_as_tracked(models: Path, tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text(track_rows())
    (tmp_path / "w.toml").write_text(
        f'points = {FEW}\nrate = 10\n[[object]]\nfile = "{models / "OBJ" / "spider.obj"}"\n'
        'motion = { kind = "poses", file = "t.csv", scale = 1e-3 }\n'
    )
    scene = load_scene(str(tmp_path / "w.toml"))
    assert scene.frame_count == 5
    shift = scene.pose("spider", 5).translation - scene.pose("spider", 1).translation
    assert shift == pytest.approx([0.4e-3, 0, 0], abs=1e-12)
    # y is up in the file: a turn about its z, towards us, is one about −z here.
    turn = scene.pose("spider", 5).rotation @ scene.pose("spider", 1).rotation.T
    assert turn @ [1, 0, 0] == pytest.approx([np.cos(0.4), -np.sin(0.4), 0])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("frames = ", "no TOML"),
        ("frames = 3", "nothing in it"),
        ("[[object]]\nsize = 1", "a file or a text"),
        ('[[object]]\ntext = "A"\nsize = 1\nscale = 2', "keep one"),
        ('[[object]]\ntext = "A"\nsise = 1', "no 'sise'"),
        ('[[object]]\ntext = "A"\nup = "w"', "choose one of"),
        ('[[object]]\ntext = "A"\nplace = [0, 0]', "three numbers"),
        ('[[object]]\ntext = "A"\nmotion = { kind = "fly" }', "unknown motion"),
        ('shading = "toon"\n[[object]]\ntext = "A"', "unknown shading"),
        ('frames = true\n[[object]]\ntext = "A"', "whole number"),
        ('[[object]]\ntext = "A"\n[[object]]\ntext = "A"', "called 'A'"),
        ('[[object]]\nfile = "no.ply"', "missing"),
    ],
)
def test_a_bad_world_is_told_in_one_line(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "w.toml").write_text(text)
    with pytest.raises((ValueError, OSError), match=words) as told:
        load_scene(str(tmp_path / "w.toml"))
    assert "\n" not in str(told.value)


def test_what_leaves_the_volume_is_said_left_out_and_fitted(tmp_path: Path) -> None:
    rows = "\n".join(f"{n / 10},{0.01 * n},0,0" for n in range(11))
    (tmp_path / "t.csv").write_text("time,x,y,z\n" + rows)
    (tmp_path / "w.toml").write_text(
        'rate = 10\n[[object]]\ntext = "A"\nplace = [0, 0, 0.25]\nsize = 1e-3\n'
        'motion = { kind = "poses", file = "t.csv", scale = 0.3 }\n'
    )
    scene = load_scene(str(tmp_path / "w.toml"))
    (note,) = [n for n in scene.notes if "leaves" in n]
    assert "5 frames from 7 to 11, by up to 14.5 mm" in note
    assert len(scene.frame(1).cloud) > 0 == len(scene.frame(11).cloud)
    fitted = load_scene(str(tmp_path / "w.toml"), fit=True)
    assert any("--fit" in n for n in fitted.notes)
    half = np.array(box(LC_R_1080, 532e-9, 0.25)) / 2 * 1.0001
    for number in (1, 11):
        cloud = fitted.frame(number).cloud
        assert len(cloud) > 0
        assert (np.abs(cloud.positions[:, :2]) <= half).all()
        assert outside(cloud.positions, LC_R_1080, 532e-9).max() < 0
    assert run("scene", tmp_path / "w.toml", "--fit", "--out", tmp_path / "fit.toml") == 0
    written = load_scene(str(tmp_path / "fit.toml"))
    for number in (1, 6, 11):
        assert written.pose("A", number).translation == pytest.approx(
            fitted.pose("A", number).translation, abs=1e-9
        )
