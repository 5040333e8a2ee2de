"""Files from strangers that once ended in a traceback, a warning, or hours: one line instead."""

import json
import os
import re
import shutil
import zipfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from chrmc.panels import read_panel
from chrmc.scene.read_folder import numbered
from chrmc.scene.sources.beside import beside
from chrmc.scene.sources.cloud import load_arrays, read_cloud, read_npz
from chrmc.scene.sources.files import load_sources
from chrmc.scene.sources.mesh import read_mesh
from chrmc.scene.sources.picture import text_picture
from chrmc.scene.sources.poses import poses_from_csv
from chrmc.scene.sources.recording import read_recording, recorded_model
from chrmc.scene.sources.world_toml import read_world
from chrmc.slm import SLM

pytestmark = pytest.mark.filterwarnings("error")
PLACES = np.random.default_rng(0).normal(0, 1, (20, 3))
DEEP = "[" * 100_000 + "]" * 100_000
TRACK = "time,x,y,z,qx,qy,qz,qw\n0,0,0,1,0,0,0,1\n"
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
OBJECT = '[[object]]\ntext = "A"\n'


def refused(read: Callable[[Path], Any], path: Path, words: str) -> None:
    with pytest.raises((ValueError, OSError), match=words) as raised:
        read(path)
    assert "\n" not in str(raised.value) and len(str(raised.value)) < 400


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('x,y,z\n1,2,3\n"' + "a" * 200_000 + '",1,2\n', "no table"),
        ("1,2,3\n" * 3000 + ",".join("1" * 10_000), "10000 columns"),
        ("²\n1 2 3\n", "columns"),
        ("x,y,z,r,g,b\n1,0,0,-5,-5,-5\n0,0,0,1,0,0\n", "colours run from"),
        ("x,y,z,r,g,b\n1,0,0,1e300,0,0\n", "colours run from"),
    ],
)
def test_tables_of_points(text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "c.csv").write_text(text)
    refused(read_cloud, tmp_path / "c.csv", words)


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({"positions": PLACES + 1j}, "real numbers"),
        ({"positions": np.zeros(5, [("a", "f8")])}, "real numbers"),
        ({"positions": PLACES, "colors": np.ones(20)}, "indices"),
        ({"positions": PLACES, "colors": np.full((20, 3), 1e308)}, "colours run from"),
        ({"positions": PLACES, "intensity": PLACES[:, 0] * 1j}, "real numbers"),
    ],
)
def test_arrays_of_points(arrays: dict[str, Any], words: str, tmp_path: Path) -> None:
    np.savez(tmp_path / "p.npz", **arrays)
    refused(read_npz, tmp_path / "p.npz", words)


def test_an_npz_that_unpacks_to_gigabytes_is_not_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "p.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("positions.npy", b"few")
    content = path.read_bytes().replace(
        (3).to_bytes(4, "little"), (2**32 - 2).to_bytes(4, "little")
    )
    path.write_bytes(content)
    refused(load_arrays, path, "unpacks to 4.3 GB")


@pytest.mark.parametrize(
    ("rows", "fps", "words"),
    [
        ("1,0,0,1,0,0,0,1\n", 1e6, "1000001 frames"),
        ("1e300,0,0,1,0,0,0,1\n", 60, "at most 1e"),
        ("1,0,0,1,1e200,0,0,1e200\n", 60, "at most 1e"),
    ],
)
def test_tracks(rows: str, fps: float, words: str, tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text(TRACK + rows)
    refused(lambda path: poses_from_csv(path, fps), tmp_path / "t.csv", words)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a = " + DEEP, "no TOML"),
        ("frames = " + "9" * 5000, "no TOML"),
        ("frames = " + "9" * 400 + "\n" + OBJECT, "between 1 and 100000"),
        ("frames = 1000000000\n" + OBJECT, "between 1 and 100000"),
        (OBJECT + "up = []\n", "choose one"),
        (OBJECT + "size = 1e-320\n", "size .* lies outside"),
        (OBJECT + "place = [" + "9" * 400 + ", 0, 0]\n", "place must be"),
        (OBJECT + 'motion = { kind = "turntable", axis = [1e-320, 0, 0] }\n', "direction"),
    ],
)
def test_descriptions_of_scenes(text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(text)
    refused(read_world, tmp_path / "s.toml", words)


def test_panels(tmp_path: Path) -> None:
    (tmp_path / "p.toml").write_text("a = " + DEEP)
    refused(read_panel, tmp_path / "p.toml", "no TOML")
    (tmp_path / "d.toml").symlink_to("/dev/zero")
    refused(read_panel, tmp_path / "d.toml", "no file")


def test_an_object_behind_the_panel(tmp_path: Path) -> None:
    trimesh.creation.box().export(tmp_path / "t.obj")
    (tmp_path / "s.toml").write_text('[[object]]\nfile = "t.obj"\nplace = [0, 0, -1]\n')
    panel = SLM("small", 60, 40, 32e-6)
    refused(
        lambda path: load_sources([str(path)], slm=panel).frame(1),
        tmp_path / "s.toml",
        "behind the hologram",
    )


@pytest.mark.parametrize("name", ["/dev/zero", "pipe"])
def test_materials_that_never_end(name: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "m.mtl").write_text(f"newmtl a\nmap_Kd {name}\n")
    for library in (name, "m.mtl"):
        (tmp_path / "t.obj").write_text(f"mtllib {library}\nusemtl a\nvt 0 0\n" + TRIANGLE)
        assert "is absent" in read_mesh(tmp_path / "t.obj").notes[0]


@pytest.mark.parametrize("size", [1e308, 1e150])
def test_a_mesh_whose_squares_are_no_numbers(size: float, tmp_path: Path) -> None:
    path = tmp_path / "t.obj"
    path.write_text(TRIANGLE.replace("1", f"{size}", 2))
    with suppress(ValueError):
        read_mesh(path)


@pytest.mark.parametrize("last", [10**13, int("9" * 100)])
def test_numbers_of_frames_that_leave_a_gap_of_ages(last: int, tmp_path: Path) -> None:
    for number in (1, last):
        (tmp_path / f"f_{number}.exr").touch()
    refused(numbered, tmp_path, re.escape("frame 2, 3, 4, 5, 6 …"))


@pytest.mark.parametrize(
    ("text", "words"),
    [("W" * 3000, "3000 letters"), ("a\udcff", "no letter"), ("a\tb", "no letter"), ("漢", "font")],
)
def test_texts(text: str, words: str) -> None:
    refused(lambda _: text_picture(text), Path(), words)


@pytest.mark.parametrize(
    ("children", "words"),
    [([[0]], "own ancestor"), ([[1], [0]], "own ancestor"), ([[1, 1], []], "two parents")],
)
def test_nodes_without_end(children: list[list[int]], words: str, tmp_path: Path) -> None:
    nodes = [{"children": those} for those in children]
    (tmp_path / "g.gltf").write_text(json.dumps({"asset": {"version": "2.0"}, "nodes": nodes}))
    refused(read_mesh, tmp_path / "g.gltf", words)


def test_a_gltf_of_brackets(tmp_path: Path) -> None:
    (tmp_path / "g.gltf").write_text(DEEP)
    refused(read_mesh, tmp_path / "g.gltf", "too deep|cannot be read")


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    from PIL import Image

    for kind, levels in (("rgb", np.full((24, 32, 3), 200, np.uint8)),
                         ("depth", np.full((24, 32), 1000, np.uint16))):  # fmt: skip
        (tmp_path / kind).mkdir()
        for k in range(2):
            Image.fromarray(levels).save(tmp_path / kind / f"{k}.png")
    return tmp_path


@pytest.mark.parametrize(("stamps", "words"), [(("inf", "0"), "time stamp"), (("nan", "0"), "time"),
                                               (("1e308", "-1e308"), "time stamp")])  # fmt: skip
def test_time_stamps(stamps: tuple[str, str], words: str, recording: Path) -> None:
    for kind in ("rgb", "depth"):
        lines = [f"{stamp} {kind}/{k}.png\n" for k, stamp in enumerate(stamps)]
        (recording / f"{kind}.txt").write_text("".join(lines))
    refused(recorded_model, recording, words)


def test_frames_at_all_but_one_time(recording: Path) -> None:
    for kind in ("rgb", "depth"):
        (recording / f"{kind}.txt").write_text(f"0 {kind}/0.png\n1e-320 {kind}/1.png\n")
    assert recorded_model(recording).frames == 1


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (DEEP, "valid JSON"),
        ('{"fx": 1e-320, "fy": 1, "cx": 0, "cy": 0}', "fx .* lies outside"),
        ('{"fx": 1, "fy": 1, "cx": 0, "cy": 0, "depth_scale": Infinity}', "finite"),
        ('{"fx": 1, "fy": 1, "cx": 0, "cy": 0, "depth_scale": 1e-320}', "lies outside"),
        ('{"fx": 1, "fy": 1, "cx": 0, "cy": 0, "depth_unit": ' + "9" * 400 + "}", "depth_unit"),
    ],
)
def test_cameras(text: str, words: str, recording: Path) -> None:
    (recording / "camera.json").write_text(text)
    refused(lambda path: read_recording(path, SLM("small", 60, 40, 32e-6)), recording, words)


TEXTURED = TRIANGLE.replace("f 1 2 3", "vt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3")


def textured(folder: Path, picture: str) -> Path:
    (folder / "m.mtl").write_text(f"newmtl a\nmap_Kd {picture}\n")
    (folder / "t.obj").write_text("mtllib m.mtl\n" + TEXTURED)
    return folder / "t.obj"


@pytest.mark.parametrize("size", [(10_000, 10_000), (60_000, 60_000)])
def test_a_texture_that_is_too_large(size: tuple[int, int], tmp_path: Path) -> None:
    from PIL import Image

    Image.new("1", (1, 1)).save(tmp_path / "t.bmp")
    content = (tmp_path / "t.bmp").read_bytes()
    claim = b"".join(side.to_bytes(4, "little") for side in size)
    (tmp_path / "t.bmp").write_bytes(content[:18] + claim + content[26:])
    before = Image.MAX_IMAGE_PIXELS
    refused(read_mesh, textured(tmp_path, "t.bmp"), f"{size[0]} × {size[1]} .* make it smaller")
    assert before == Image.MAX_IMAGE_PIXELS


def test_a_texture_that_is_cut_short(tmp_path: Path) -> None:
    from PIL import Image

    Image.effect_noise((64, 64), 50).save(tmp_path / "t.png")
    (tmp_path / "t.png").write_bytes((tmp_path / "t.png").read_bytes()[:2000])
    refused(read_mesh, textured(tmp_path, "t.png"), "t.obj: a texture cannot be read")


@pytest.mark.parametrize("way", ["../secret.png", "{}/secret.png", "link.png"])
def test_a_mesh_reads_nothing_outside_its_folder(way: str, tmp_path: Path) -> None:
    from PIL import Image

    Image.new("RGB", (2, 2), (255, 0, 0)).save(tmp_path / "secret.png")
    folder = tmp_path / "mesh"
    folder.mkdir()
    (folder / "link.png").symlink_to("../secret.png")
    path = textured(folder, way.format(tmp_path))
    model = read_mesh(path)
    assert way.format(tmp_path) in model.notes[0] and "is absent" in model.notes[0]
    assert tmp_path / "secret.png" not in [p.resolve() for p in beside(path)]
    # Meant as beside the mesh, as Windows' paths of whoever made it: there it is found.
    (folder / "link.png").unlink()
    Image.new("RGB", (2, 2), (0, 255, 0)).save(folder / Path(way).name)
    colours = read_mesh(path).bodies["t"].paint(np.zeros(1, int), np.full((1, 3), 1 / 3))
    assert colours[0].tolist() == [0, 1, 0]


def test_a_gltf_moves_by_nothing_outside_its_folder(tmp_path: Path) -> None:
    from chrmc.scene.sources.gltf_motion import read_motion

    times = np.array([0, 1], np.float32).tobytes() + np.zeros(6, np.float32).tobytes()
    (tmp_path / "secret.bin").write_bytes(times)
    accessor = {"bufferView": 0, "componentType": 5126, "count": 2}
    sampler = {"input": 0, "output": 1}
    channel = {"sampler": 0, "target": {"node": 0, "path": "translation"}}
    content = {
        "asset": {"version": "2.0"},
        "nodes": [{"name": "a"}],
        "buffers": [{"uri": "../secret.bin", "byteLength": len(times)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(times)}],
        "accessors": [
            {**accessor, "type": "SCALAR"},
            {**accessor, "type": "VEC3", "byteOffset": 8},
        ],
        "animations": [{"samplers": [sampler], "channels": [channel]}],
    }
    folder = tmp_path / "mesh"
    folder.mkdir()
    (folder / "g.gltf").write_text(json.dumps(content))
    refused(read_motion, folder / "g.gltf", "secret.bin is not in its folder")
    shutil.move(tmp_path / "secret.bin", folder)
    assert len(read_motion(folder / "g.gltf").poses) == 1
