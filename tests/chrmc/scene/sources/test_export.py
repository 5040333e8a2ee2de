"""Points out and in again, and the commands that take files."""

from pathlib import Path

import numpy as np
import pytest

from chrmc import load_scene
from chrmc.scene.sources.export import write_export

from .making import FEW, recording, run


@pytest.mark.parametrize("kind", ["bodies", "frames"])
def test_exported_points_come_back_as_they_were(models: Path, tmp_path: Path, kind: str) -> None:
    if kind == "bodies":
        (tmp_path / "w.toml").write_text(
            f'points = {FEW}\nframes = 3\n[[object]]\nfile = "{models / "OBJ" / "spider.obj"}"\n'
            'motion = "turntable"\n[[object]]\ntext = "A"\nplace = [0, 1e-3, 0.26]\n'
        )
        scene = load_scene(str(tmp_path / "w.toml"))
    else:
        recording(tmp_path / "walk", False)
        scene = load_scene(str(tmp_path / "walk"))
    write_export(scene, tmp_path / "p.npz")
    again = load_scene(str(tmp_path / "p.npz"))
    assert (again.frame_count, again.object_names) == (scene.frame_count, scene.object_names)
    for number in range(1, scene.frame_count + 1):
        for one, two in zip(scene.frame(number).objects, again.frame(number).objects, strict=True):
            assert np.array_equal(one.cloud.positions, two.cloud.positions)
            assert np.array_equal(one.cloud.amplitude, two.cloud.amplitude)
            assert np.array_equal(one.cloud.phase, two.cloud.phase)
            assert (one.ids is None) == (two.ids is None)
            if one.ids is not None:
                assert np.array_equal(one.ids, two.ids)


def test_inspect_says_what_will_be_seen(models: Path, tmp_path: Path, capsys) -> None:
    obj = models / "OBJ" / "spider.obj"
    picture = tmp_path / "s.png"
    assert run("inspect", obj, "--points", 300, "--out", picture) == 0
    told = capsys.readouterr().out
    for words in ("field of view", "resolution", "depth of focus", "speckle contrast", "curved",
                  "shown 1.6"):  # fmt: skip
        assert words in told
    assert picture.stat().st_size > 10_000


def test_generate_exports_and_nothing_is_half_written(models: Path, tmp_path: Path, capsys) -> None:
    obj = models / "OBJ" / "spider.obj"
    points = tmp_path / "p.npz"
    video = tmp_path / "video"
    assert run("generate", obj, "--out", video, "--points", 500, "--export-points", points) == 0
    assert points.is_file() and (video / "manifest.json").is_file()
    assert run("generate", models / "invalid" / "empty.ply", "--out", tmp_path / "none") == 2
    assert not (tmp_path / "none").exists()


def test_sizes_for_what_has_its_own_are_refused() -> None:
    for options in ({"points": 5}, {"density": 1.0}, {"fit": True}):
        with pytest.raises(ValueError, match="belong to meshes"):
            load_scene("car-house", **options)
