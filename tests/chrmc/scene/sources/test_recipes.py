"""Every recipe of docs/your-own-scene.md runs as it stands there."""

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from chrmc.cli.main import main
from chrmc.store.video import open_video

from .making import blender_frame, recording, track_rows, write_picture

PAGE = Path(__file__).parents[4] / "docs" / "your-own-scene.md"
TEXT = PAGE.read_text("utf-8")
COMMANDS = [
    line
    for block in re.findall(r"```sh\n(.*?)```", TEXT, flags=re.DOTALL)
    for line in block.splitlines()
    if line.startswith("chrmc ")
]


@pytest.fixture(scope="module")
def folder(models: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files that the page speaks of: real models, and what the page itself spells out."""
    made = tmp_path_factory.mktemp("recipes")
    for path in (models / "OBJ").glob("*.jpg"):
        (made / path.name).write_bytes(path.read_bytes())
    for name in ("spider.obj", "spider.mtl"):
        (made / name).write_bytes((models / "OBJ" / name).read_bytes())
    (made / "cow.ply").write_bytes((models / "PLY" / "Wuson.ply").read_bytes())
    for name, text in re.findall(r"<!-- (\S+) -->\n```\w+\n(.*?)```", TEXT, flags=re.DOTALL):
        (made / name).parent.mkdir(exist_ok=True)
        (made / name).write_text(text)
    (made / "mocap.csv").write_text(track_rows())
    rng = np.random.default_rng(1)
    lines = [f"{x},{y},{z},1" for x, y, z in rng.normal(size=(300, 3))]
    (made / "scan.csv").write_text("x,y,z,amplitude\n" + "\n".join(lines))
    write_picture(made / "photo.png", rng.integers(0, 255, (30, 40, 3)).astype(np.uint8))
    recording(made / "recording", False)
    for number in (1, 2):
        blender_frame(made / "render" / f"frame_{number:04d}.exr", 0.1 * number)
    return made


def test_every_recipe_runs(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    for line in COMMANDS:
        words = shlex.split(line, comments=True)[1:]
        if words[0] == "inspect":  # as it is, but quicker
            words += ["--points", "300"]
        if "reuse=always" in words:
            words += ["--frames", "1:4", "--slm", "240x180:8um"]
        elif words[0] == "generate":
            words += ["--compensation", "none"]
        if words[0] == "generate":
            words += ["--check-pixels", "0"]
            folders = {"recording", "render", "spider.npz"}  # have their own points
            words += [] if {"--points", *folders} & set(words) else ["--points", "400"]
        with pytest.raises(SystemExit) as ended:
            main(words)
        assert not ended.value.code, line
    few, again = open_video(folder / "few"), open_video(folder / "again")
    assert few.scene["fingerprint"] == again.scene["fingerprint"]
    assert len(open_video(folder / "turntable").frames) == 4
    assert len(open_video(folder / "recorded").frames) == 3
    assert len(open_video(folder / "together").frames) == 3
    assert [frame["key"] for frame in open_video(folder / "slow").frames] == [True] + 3 * [False]


def test_scene_json_of_the_page_is_json(folder: Path) -> None:
    assert json.loads((folder / "render" / "scene.json").read_text())["camera"]["lens"] == 50
