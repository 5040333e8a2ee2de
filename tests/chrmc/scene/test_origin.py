"""A manifest says what a video was made of, and the same scene comes from it again."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import chrmc
from chrmc.scene.origin import MADE_OF, content_hash
from chrmc.survey import spot_check
from reconstruct.checking import scene_of

from .sources.making import recording, run, track_rows

MODELS = Path("/usr/share/assimp/models")


def obj(kind: str, folder: Path) -> list[str]:
    """Words of the command line, of several kinds."""
    if kind == "recording":
        recording(folder / "walk", False)
        return [str(folder / "walk"), "--points", "700"]
    if kind == "scene.toml":
        (folder / "t.csv").write_text(track_rows())
        (folder / "spider.obj").write_bytes((MODELS / "OBJ" / "spider.obj").read_bytes())
        (folder / "w.toml").write_text(
            'points = 900\nframes = 2\n[[object]]\nfile = "spider.obj"\n'
            'motion = { kind = "poses", file = "t.csv", scale = 1e-3 }\n'
        )
        return [str(folder / "w.toml"), "--fit"]
    (folder / "spider.obj").write_bytes((MODELS / "OBJ" / "spider.obj").read_bytes())
    return [f"{folder / 'spider.obj'}@300mm", "text:HI@0.2", "--points", "800"]


@pytest.mark.parametrize("kind", ["recording", "scene.toml", "several"])
def test_the_scene_comes_back_as_it_was(tmp_path: Path, kind: str) -> None:
    if kind != "recording" and not MODELS.is_dir():
        pytest.skip("needs the Debian package assimp-testmodels")
    words = [*obj(kind, tmp_path), "--out", str(tmp_path / "video"), "--frames", "1:1"]
    small = ["--check-pixels", "0", "--tolerance", "1e-2"]
    assert run("generate", *words, *small) == 0
    video = chrmc.open_video(tmp_path / "video")
    assert video.scene[MADE_OF]["notes"]
    assert spot_check(scene_of(video)) == video.scene["spot_check"]
    # The points decide whether it is the same video, not where its files were.
    folder = tmp_path / "moved"
    shutil.copytree(tmp_path, folder, ignore=shutil.ignore_patterns("video"))
    moved = [w.replace(str(tmp_path), str(folder), 1) for w in words[:-4]]
    assert run("generate", *moved, *words[-4:], *small) == 0
    assert chrmc.open_video(tmp_path / "video").scene == video.scene
    changed = tmp_path / ("walk/intrinsics.json" if kind == "recording" else "spider.obj")
    changed.write_text(changed.read_text() + "\n")
    with pytest.raises(ValueError, match="has changed since"):
        scene_of(video)
    again = scene_of(video, moved[0]) if kind != "several" else None
    assert again is None or spot_check(again) == video.scene["spot_check"]
    assert run("check", tmp_path / "video", "--frames", "1", "--truth") == 2


def test_a_manifest_opens_nothing_but_what_it_was_made_of(tmp_path: Path) -> None:
    (tmp_path / "scan.csv").write_text("x,y,z\n0,0,0\n1,1,1\n")
    video = chrmc.generate(
        tmp_path / "scan.csv", tmp_path / "video", slm=chrmc.SLM("small", 64, 48, 8e-6)
    )
    (entry,) = video.scene[MADE_OF]["things"]
    assert entry["sha256"] == content_hash(tmp_path / "scan.csv")
    secret = tmp_path / "secret.csv"
    secret.write_text("x,y,z\n9,9,9\n")
    entry["path"] = str(secret)
    with pytest.raises(ValueError, match="has changed"):
        scene_of(video)
    entry |= {"path": str(tmp_path / "away.csv")}
    with pytest.raises(FileNotFoundError, match="missing: name it"):
        scene_of(video)
    entry |= {"path": None, "thing": str(secret)}
    with pytest.raises(ValueError, match="no hash"):
        scene_of(video)
    video.scene[MADE_OF] = {"things": 3}
    with pytest.raises(ValueError, match="does not say"):
        scene_of(video)


def test_sized_for_the_panel_that_shows_it(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "scan.xyz", [[0, 0, 0], [1, 1, 1]])
    narrow = chrmc.SLM("narrow", 64, 48, 8e-6)
    chrmc.generate(tmp_path / "scan.xyz", tmp_path / "video", slm=narrow)
    video = chrmc.open_video(tmp_path / "video")
    assert np.ptp(scene_of(video).frame(1).cloud.positions[:, 0]) < 64 * 8e-6 / 2
