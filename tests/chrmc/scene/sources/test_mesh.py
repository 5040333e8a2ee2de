"""Meshes: the right way round, painted, fitted, and refused in one line."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

import chrmc
from chrmc import LC_R_1080, PointCloud, load_scene
from chrmc.scene.sources.files import build_sources
from chrmc.scene.sources.mesh import read_mesh
from chrmc.scene.sources.model import UP
from chrmc.scene.sources.volume import box
from reconstruct import four_f

FEW = 4000


@pytest.mark.parametrize("up", UP)
def test_no_axis_convention_mirrors(up: str) -> None:
    assert np.linalg.det(UP[up]) == pytest.approx(1)
    assert np.allclose(UP[up] @ UP[up].T, np.eye(3))
    axis = np.eye(3)["xyz".index(up[-1])] * (-1 if up[0] == "-" else 1)
    assert UP[up] @ axis == pytest.approx([0, -1, 0])


@pytest.mark.parametrize("name", ["OBJ/WusonOBJ.obj", "PLY/Wuson.ply", "STL/Wuson.stl"])
def test_a_real_animal_stands_on_its_feet_and_faces_us(models: Path, name: str) -> None:
    built = build_sources([str(models / name)])
    (body,) = built.cast.bodies.values()
    (poses,) = built.cast.poses.values()
    shown = poses[0].apply(body.vertices)
    raw = trimesh.load_mesh(models / name, process=False)
    size = np.ptp(raw.vertices, axis=0)
    up = 1 if name[0] != "S" else 2
    assert np.ptp(shown, axis=0).max() == pytest.approx(0.5 * min(box(LC_R_1080, 532e-9, 0.25)))
    assert np.ptp(shown[:, 1]) / np.ptp(shown, axis=0).max() == pytest.approx(size[up] / size.max())
    # Where its skin has its middle: above half its height, and not half its length.
    middle = raw.area_faces @ raw.triangles_center / raw.area
    share = (middle - raw.vertices.min(axis=0)) / size
    at = body.areas @ shown[body.faces].mean(axis=1) / body.areas.sum()
    found = (at - shown.min(axis=0)) / np.ptp(shown, axis=0)
    # File axes that run to the picture's right, down and away.
    right, down, away = {"y": (share[0], 1 - share[1], 1 - share[2]),
                         "z": (share[0], 1 - share[2], share[1])}["yz"[up - 1]]  # fmt: skip
    assert found == pytest.approx([right, down, away], abs=1e-4)
    assert abs(share[1] - 0.5) > 0.02 and abs(share[2] - 0.5) > 0.005


def test_the_reconstruction_is_the_rendered_view_and_no_mirror_image_of_it(models: Path) -> None:
    obj = str(models / "OBJ" / "spider.obj")
    cloud = load_scene(obj, points=30000).frame(1).cloud
    view = load_scene(obj, form="rgbd").rgbd(1).intensity
    image = np.zeros(LC_R_1080.shape)
    rng = np.random.default_rng(1)
    for _ in range(2):
        look = PointCloud(cloud.positions, cloud.amplitude, rng.uniform(0, 6.3, len(cloud)))
        field = chrmc.compute_field(look, LC_R_1080, 532e-9)
        import display

        image += four_f(display.encode(field, LC_R_1080), LC_R_1080, 532e-9, 0.25)

    def alike(picture: np.ndarray) -> float:
        # Over blocks of 8 pixels, so that speckle and blur do not decide.
        a, b = (x.reshape(150, 8, 240, 8).mean(axis=(1, 3)) for x in (picture, image))
        return float(np.corrcoef(a.ravel(), b.ravel())[0, 1])

    right = alike(view)
    assert right > 0.75
    for wrong in (view[::-1], view[:, ::-1], view[::-1, ::-1]):
        assert alike(wrong) < right - 0.2


def test_textures_colours_and_materials(models: Path, tmp_path: Path) -> None:
    from chrmc.scene.surface.sampling import sample

    def greys(path: Path) -> np.ndarray:
        (surface,) = read_mesh(path).bodies.values()
        size = np.sqrt(surface.areas.sum() / 2000)
        return np.asarray(surface.paint(*sample(surface, size, 1)))

    textured = greys(models / "OBJ" / "spider.obj")
    assert textured.min() < 0.02 < 0.7 < textured.max()
    solid = trimesh.creation.box()
    solid.visual.vertex_colors = np.where(solid.vertices[:, :1] > 0, 255, [[0, 0, 0, 255]])
    solid.export(tmp_path / "half.ply")
    assert greys(tmp_path / "half.ply").mean() == pytest.approx(0.5, abs=0.05)
    white = trimesh.creation.box()
    white.visual = trimesh.visual.TextureVisuals(
        material=trimesh.visual.material.PBRMaterial(baseColorFactor=[128, 128, 128, 255])
    )
    white.export(tmp_path / "grey.glb")
    assert greys(tmp_path / "grey.glb") == pytest.approx(128 / 255, abs=0.01)


def test_absent_texture_is_said_and_the_mesh_shown(models: Path, tmp_path: Path) -> None:
    for name in ("spider.obj", "spider.mtl"):
        (tmp_path / name).write_bytes((models / "OBJ" / name).read_bytes())
    model = read_mesh(tmp_path / "spider.obj")
    assert any("SpiderTex.jpg" in note and "absent" in note for note in model.notes)
    assert model.bodies


def test_size_and_depth_are_said(models: Path) -> None:
    scene = load_scene(f"{models / 'OBJ' / 'spider.obj'}@0.3", points=FEW)
    assert any("shown" in note and "at 300 mm" in note for note in scene.notes)
    assert scene.frame(1).cloud.centroid[2] == pytest.approx(0.3, abs=1e-3)


def test_a_closed_mesh_shows_no_back_and_a_turned_inside_out_one_is_mended(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(subdivisions=4)
    ball.invert()
    ball.export(tmp_path / "ball.stl")
    scene = load_scene(str(tmp_path / "ball.stl"), points=FEW)
    assert scene.frame(1).cloud.positions[:, 2].max() < 0.25 + 2e-5
    assert not any("not" in note and "closed" in note for note in scene.notes)


def degenerate(path: Path) -> None:
    """Ten good triangles among a million of no area."""
    good, flat = trimesh.exchange.stl.export_stl(trimesh.creation.box()), 1_000_000
    count = (12 + flat).to_bytes(4, "little")
    path.write_bytes(good[:80] + count + good[84:] + bytes(50 * flat))


def test_a_million_triangles_of_no_area(tmp_path: Path) -> None:
    degenerate(tmp_path / "flat.stl")
    model = read_mesh(tmp_path / "flat.stl")
    (surface,) = model.bodies.values()
    assert len(surface.faces) == 12
    assert any("faces of no area" in note for note in model.notes) or len(model.notes) <= 1


@pytest.mark.parametrize(
    "name",
    [
        "invalid/empty.ply",
        "invalid/empty.obj",
        "invalid/malformed.obj",
        "glTF2/MissingBin/BoxTextured.gltf",
        "glTF2/BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb",
        "glTF2/RecursiveNodes/RecursiveNodes.gltf",
        "glTF2/wrongTypes/badArray.gltf",
        "glTF/CesiumMilkTruck/CesiumMilkTruck.gltf",
    ],
)
def test_bad_files_get_one_line(models: Path, name: str) -> None:
    refused(models / name)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("PLY/Wuson.ply", "cut short"),
        ("STL/Spider_binary.stl", "cut short: 683 of 1368 triangles"),
        ("STL/Spider_ascii.stl", "cut short"),
        ("glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb", "cannot be read"),
    ],
)
def test_a_file_that_is_cut_off_is_told_so(
    models: Path, tmp_path: Path, name: str, told: str
) -> None:
    whole, half = (models / name).read_bytes(), tmp_path / f"half{Path(name).suffix}"
    half.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(OSError, match=told):
        load_scene(str(half))


def refused(path: Path) -> None:
    """One line that names the file."""
    with pytest.raises((ValueError, OSError)) as told:
        load_scene(str(path), points=FEW).frame(1)
    assert "\n" not in str(told.value)
    assert path.name in str(told.value)


def test_meshes_that_are_points_and_text_of_other_alphabets(models: Path) -> None:
    for name, count in (("PLY/issue623.ply", 24), ("OBJ/box_UTF16BE.obj", 20)):
        cloud = load_scene(str(models / name), points=FEW).frame(1).cloud
        assert len(cloud) >= count
    with pytest.raises(ValueError, match="without compression"):
        load_scene(str(models / "glTF2/draco/2CylinderEngine.gltf"))


def test_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="missing"):
        load_scene(str(tmp_path / "absent.ply"))


def test_nan_vertices_lose_their_faces_only(models: Path, tmp_path: Path) -> None:
    mesh = trimesh.load_mesh(models / "STL" / "Wuson.stl")
    mesh.vertices[5] = np.nan
    (tmp_path / "nan.stl").write_bytes(trimesh.exchange.stl.export_stl(mesh))
    model = read_mesh(tmp_path / "nan.stl")
    (surface,) = model.bodies.values()
    assert len(mesh.faces) - 12 < len(surface.faces) < len(mesh.faces)
    assert any("left out" in note for note in model.notes)
    assert np.isfinite(load_scene(str(tmp_path / "nan.stl"), points=FEW).frame(1).cloud.phase).all()


@pytest.mark.parametrize("stray", ["9 9 9", "0 1 1e999"])
def test_corners_of_no_face_do_not_count_for_the_size(tmp_path: Path, stray: str) -> None:
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    faces = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    shown = []
    for name, more in (("plain", ""), ("stray", f"v {stray}\n")):
        (tmp_path / f"{name}.obj").write_text(corners + more + faces)
        (body,) = build_sources([str(tmp_path / f"{name}.obj")]).cast.bodies.values()
        shown.append(np.ptp(body.vertices, axis=0))
    assert np.isfinite(shown).all() and shown[1] == pytest.approx(shown[0])


def test_density_and_points(models: Path) -> None:
    obj = str(models / "OBJ" / "WusonOBJ.obj")
    few, more = (load_scene(obj, points=n).frame(1).objects[0] for n in (2000, 8000))
    assert len(few.body) == pytest.approx(2000, rel=0.05)
    assert len(more.body) == pytest.approx(8000, rel=0.05)
    coarse, fine = (len(load_scene(obj, density=d).frame(1).cloud) for d in (4, 1))
    assert fine == pytest.approx(4 * coarse, rel=0.08)
    # The mean light does not depend on how many points carry it.
    assert few.cloud.intensity.sum() == pytest.approx(more.cloud.intensity.sum(), rel=0.08)
    with pytest.raises(ValueError, match="keep one"):
        load_scene(obj, points=100, density=1.0)


def test_point_cloud_from_a_file(models: Path) -> None:
    cloud = PointCloud.from_file(models / "OBJ" / "WusonOBJ.obj", fit=LC_R_1080, points=FEW)
    assert 200 < len(cloud) < FEW
    assert np.all(np.abs(cloud.positions - [0, 0, 0.25]) < 1.1e-3)
