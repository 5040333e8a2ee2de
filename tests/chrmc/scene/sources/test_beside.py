"""A video remembers its meshes with the materials, textures and buffers beside them."""

import shutil
from pathlib import Path

import pytest

from chrmc.scene.origin import content_hash
from chrmc.scene.sources.beside import beside


def test_an_obj_with_its_materials_and_textures(models: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(models / "OBJ", tmp_path / "obj")
    spider = folder / "spider.obj"
    names = {p.name for p in beside(spider)}
    # The material names its textures as Windows does; each of them is used.
    assert names == {"spider.mtl", "wal67ar_small.jpg", "wal69ar_small.jpg", "SpiderTex.jpg",
                     "drkwood2.jpg", "engineflare1.jpg"}  # fmt: skip
    (tmp_path / "scene.toml").write_text('[[object]]\nfile = "obj/spider.obj"\n')
    for changed in ("spider.mtl", "SpiderTex.jpg"):
        before = content_hash(spider), content_hash(tmp_path / "scene.toml")
        with (folder / changed).open("ab") as file:
            file.write(b"\n")
        after = content_hash(spider), content_hash(tmp_path / "scene.toml")
        assert before[0] != after[0] and before[1] != after[1]
    (folder / "testline.obj").unlink()  # no part of it
    assert content_hash(spider) == after[0]


def test_what_a_gltf_and_a_ply_name(models: Path, tmp_path: Path) -> None:
    box = models / "glTF2" / "BoxTextured-glTF"
    if not box.is_dir():
        pytest.skip("no glTF with files beside it here")
    names = {p.suffix for p in beside(box / "BoxTextured.gltf")}
    assert names == {".bin", ".png"}
    (tmp_path / "a b.png").write_bytes(b"")
    scan = tmp_path / "scan.ply"
    scan.write_bytes(b"ply\nformat ascii 1.0\ncomment TextureFile a b.png\r\nend_header\n")
    assert [p.name for p in beside(scan)] == ["a b.png"]


def test_names_of_nothing_are_no_error(tmp_path: Path) -> None:
    for name, content in (
        ("a.obj", b"mtllib absent.mtl\nmtllib /dev/zero\nmtllib\n"),
        ("a.gltf", b'{"images": [{"uri": null}], "buffers": 3}'),
        ("b.gltf", b"{"),
        ("a.glb", b"glTF"),
        ("a.stl", b""),
    ):
        (tmp_path / name).write_bytes(content)
        assert beside(tmp_path / name) == []
    itself = tmp_path / "scene.toml"
    itself.write_text('[[object]]\nfile = "scene.toml"\n')
    assert len(content_hash(itself)) == 64
