"""Clouds, pictures, text, scene.toml, recordings, animations and exported points as scenes."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh

from chrmc import LC_R_1080, PointCloud, load_scene
from chrmc.cli.main import main
from chrmc.scene.sources.export import write_export
from chrmc.scene.sources.mesh import read_mesh
from chrmc.scene.sources.recording import read_recording
from chrmc.scene.sources.things import build_things
from chrmc.scene.sources.volume import box, outside

FEW = 3000


def run(*words: object) -> int:
    with pytest.raises(SystemExit) as ended:
        main([str(w) for w in words])
    return int(ended.value.code or 0)


def write_picture(path: Path, samples: np.ndarray) -> Path:
    import OpenImageIO as oiio

    if samples.ndim == 2:
        samples = samples[:, :, None]
    height, width, channels = samples.shape
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), oiio.ImageSpec(width, height, channels, str(samples.dtype)))
    assert out.write_image(np.ascontiguousarray(samples))
    out.close()
    return path


# Point clouds


def test_columns_by_name_and_by_number(tmp_path: Path) -> None:
    (tmp_path / "named.csv").write_text(
        "phase;z;y;x;amplitude\n0.5;3;2;1;2\n0.6;3;2;2;4\n0.7;3;0;1;1\n"
    )
    scene = load_scene(str(tmp_path / "named.csv"))
    cloud = scene.frame(1).cloud
    assert cloud.amplitude.tolist() == [2, 4, 1]
    assert cloud.phase.tolist() == [0.5, 0.6, 0.7]
    # y is up in such files, and this project's y runs down.
    assert cloud.positions[2, 1] > cloud.positions[0, 1]
    (tmp_path / "plain.xyz").write_text("3\n0 0 0 255 255 255\n1 0 0 0 0 0\n0 1 1 188 188 188\n")
    cloud = load_scene(str(tmp_path / "plain.xyz")).frame(1).cloud
    assert cloud.intensity == pytest.approx([1, 0, 0.5], abs=0.01)


def test_a_ply_of_points(models: Path) -> None:
    cloud = PointCloud.from_file(models / "PLY" / "points.ply", fit=LC_R_1080)
    assert len(cloud) == 4
    assert np.ptp(cloud.positions, axis=0).max() == pytest.approx(
        box(LC_R_1080, 532e-9, 0.25)[1] / 2
    )


def test_npz_and_positions_left_where_they_are(tmp_path: Path) -> None:
    positions = np.array([[0, 0, 0.2], [1e-3, 2e-3, 0.21]])
    np.savez(tmp_path / "c.npz", positions=positions, amplitude=[1, 2], phase=[0, 1])
    assert PointCloud.from_file(tmp_path / "c.npz").positions == pytest.approx(positions)
    np.savez(tmp_path / "d.npz", positions=positions, amplitude=[1, 2, 3])
    with pytest.raises(ValueError, match=r"d\.npz.*2 positions but 3"):
        load_scene(str(tmp_path / "d.npz"))


@pytest.mark.parametrize(
    ("text", "words"),
    [("", "no point"), ("1 2\n3 4\n", "2 columns"), ("x,y\n1,2\n", "x, y and z")],
)
def test_bad_clouds(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(ValueError, match=words):
        load_scene(str(tmp_path / "bad.csv"))


def test_lines_without_numbers_are_counted(tmp_path: Path) -> None:
    (tmp_path / "holes.csv").write_text("x,y,z\n0,0,0\nnan,1,1\n1,1,1\n1,,2\n")
    scene = load_scene(str(tmp_path / "holes.csv"))
    assert len(scene.frame(1).cloud) == 2
    assert any("2 lines" in note for note in scene.notes)


# Pictures and text


def test_a_picture_stands_upright_at_its_depth(tmp_path: Path) -> None:
    samples = np.zeros((60, 90, 3), np.uint8)
    samples[:20, :30] = 255  # top left
    samples[-10:, -10:] = 188  # half the light, bottom right
    write_picture(tmp_path / "a.png", samples)
    scene = load_scene([f"{tmp_path / 'a.png'}@0.22", "text:F@0.28"])
    assert scene.object_names == ("a", "F")
    first, second = (o.cloud for o in scene.frame(1).objects)
    assert first.positions[:, 2] == pytest.approx(0.22)
    assert second.positions[:, 2] == pytest.approx(0.28)
    width, height = box(LC_R_1080, 532e-9, 0.22)
    assert first.positions[:, 0].min() == pytest.approx(-min(width, 1.5 * height) / 2, rel=0.02)
    left = first.positions[:, 0] < 0
    assert first.positions[left, 1].max() < 0 < first.positions[~left, 1].min()
    assert np.median(first.intensity[~left]) / np.median(first.intensity[left]) == pytest.approx(
        0.5, abs=0.02
    )
    # An F has its weight at the top and on the left.
    x, y = second.positions[:, 0], second.positions[:, 1]
    assert x.mean() < (x.min() + x.max()) / 2 and y.mean() < (y.min() + y.max()) / 2


def test_words_that_mean_nothing(tmp_path: Path) -> None:
    write_picture(tmp_path / "dark.png", np.zeros((4, 4, 3), np.uint8))
    for words, told in (
        (f"{tmp_path / 'dark.png'}", "black"),
        (f"{tmp_path / 'dark.png'}@near", "no depth"),
        (f"{tmp_path / 'dark.png'}@220000", "no depth"),
        ("text:", "says nothing"),
    ):
        with pytest.raises(ValueError, match=told):
            load_scene(words)


# scene.toml


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


def track_rows() -> str:
    """Five rows that slide along x and turn about z."""
    rows = [(n / 10, 0.1 * n, 0.0, 0.0, 0.0, 0.0, 0.1 * n) for n in range(5)]
    return "time,x,y,z,rx,ry,rz\n" + "\n".join(",".join(map(str, row)) for row in rows)


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


# Animations


def animated(models: Path, path: Path) -> None:
    """Two real meshes on two nodes: one slides and turns, one swings under a still parent."""
    import pygltflib

    scene = trimesh.Scene()
    wuson = trimesh.load_mesh(models / "STL" / "Wuson.stl")
    spider = trimesh.load_mesh(models / "STL" / "Spider_binary.stl")
    scene.add_geometry(wuson, node_name="wuson")
    scene.add_geometry(
        spider, node_name="spider", transform=trimesh.transformations.translation_matrix([4, 1, 0])
    )
    scene.export(path)
    gltf = pygltflib.GLTF2().load(str(path))
    names = [n.name for n in gltf.nodes]
    blob = bytearray(gltf.binary_blob())

    def accessor(values: np.ndarray, kind: str) -> int:
        while len(blob) % 4:
            blob.append(0)
        data = np.ascontiguousarray(values, "<f4").tobytes()
        view = pygltflib.BufferView(buffer=0, byteOffset=len(blob), byteLength=len(data))
        gltf.bufferViews.append(view)
        blob.extend(data)
        gltf.accessors.append(
            pygltflib.Accessor(
                bufferView=len(gltf.bufferViews) - 1,
                componentType=5126,
                count=len(values),
                type=kind,
                min=[float(np.min(values))],
                max=[float(np.max(values))],
            )
        )
        return len(gltf.accessors) - 1

    time = accessor(np.array([0.0, 0.5]), "SCALAR")
    slide = accessor(np.array([[0, 0, 0], [2.0, 0, 0]]), "VEC3")
    half = np.sqrt(0.5)
    swing = accessor(np.array([[0, 0, 0, 1], [0, half, 0, half]]), "VEC4")
    gltf.animations.append(
        pygltflib.Animation(
            samplers=[
                pygltflib.AnimationSampler(input=time, output=slide),
                pygltflib.AnimationSampler(input=time, output=swing),
            ],
            channels=[
                pygltflib.AnimationChannel(
                    sampler=k,
                    target=pygltflib.AnimationChannelTarget(node=names.index(node), path=what),
                )
                for k, (node, what) in enumerate([("wuson", "translation"), ("spider", "rotation")])
            ],
        )
    )
    for node in gltf.nodes:  # an animated node has no matrix
        if node.matrix is not None and node.name == "spider":
            node.matrix, node.translation = None, [4.0, 1.0, 0.0]
    gltf.buffers[0].byteLength = len(blob)
    gltf.set_binary_blob(bytes(blob))
    gltf.save(str(path))


def test_each_animated_node_is_a_rigid_object(models: Path, tmp_path: Path) -> None:
    path = tmp_path / "two.glb"
    animated(models, path)
    scene = load_scene(str(path), points=FEW)
    assert scene.frame_count == 13  # half a second at 24 frames a second, both ends
    assert set(scene.object_names) == {"two wuson", "two spider"}
    scale = 1 / 1000  # any: ratios only
    slide = [scene.pose("two wuson", n).translation for n in (1, 7, 13)]
    assert (slide[2] - slide[0])[0] > 0
    assert slide[1] - slide[0] == pytest.approx((slide[2] - slide[0]) / 2, abs=scale * 1e-6)
    first, last = (scene.pose("two spider", n) for n in (1, 13))
    turn = last.rotation @ first.rotation.T
    # A quarter turn about the file's y (up) is one about −y here: z, away, comes to −x.
    assert turn @ [0, 0, 1] == pytest.approx([-1, 0, 0], abs=1e-6)
    still = load_scene(str(path), points=FEW).frame(5)
    assert all(len(o.cloud) > 50 for o in still.objects)


def test_a_skinned_and_a_morphing_mesh_bend(models: Path) -> None:
    for name in (
        "glTF2/simple_skin/simple_skin.gltf",
        "glTF2/glTF-Sample-Models/AnimatedMorphCube-glTF/AnimatedMorphCube.gltf",
    ):
        built = build_things([str(models / name)], points=FEW)
        scene = built.cast.points()
        assert any("bends" in note for note in scene.notes)
        assert scene.frame_count > 20
        (key,) = scene.object_names
        (surface,) = built.cast.drawn.values()
        first, middle = (scene.frame(n).objects[0] for n in (1, scene.frame_count // 3))
        assert middle.body is None and middle.pose is None and scene.pose(key, 2) is None
        # A point keeps its phase, and its place on the surface: two vertices' mid-point stays one.
        known = {p: k for k, p in enumerate(first.cloud.phase.tolist())}
        both = [(known[p], k) for k, p in enumerate(middle.cloud.phase.tolist()) if p in known]
        assert len(both) > 100
        before, after = surface.in_frame(0), surface.in_frame(scene.frame_count // 3 - 1)
        assert before.vertices == pytest.approx(surface.vertices, abs=1e-9)
        moved = np.linalg.norm(after.vertices - before.vertices, axis=1).max()
        assert moved > 1e-5
        a, b = np.array(both[::7]).T
        shift = np.linalg.norm(middle.cloud.positions[b] - first.cloud.positions[a], axis=1)
        assert 0 < shift.max() <= moved * (1 + 1e-6)


def test_skin_as_its_two_bones_say(models: Path) -> None:
    surface = next(iter(read_mesh(models / "glTF2/simple_skin/simple_skin.gltf").bodies.values()))
    # The upper bone turns by 90° about z at height 1 and back; what hangs on the lower one stays.
    assert surface.shape is not None
    frames = [surface.shape(k) for k in range(24 * 5 // 2)]
    low = surface.vertices[:, 1] == 0
    for vertices in frames:
        assert vertices[low] == pytest.approx(surface.vertices[low], abs=1e-6)
    top = surface.vertices[:, 1] == 2
    reach = [np.abs(v[top, 0] - surface.vertices[top, 0]).max() for v in frames]
    assert max(reach) > 0.5
    # Bones do not stretch: the way from the joint at height 1 to the top keeps its length.
    for vertices in frames:
        length = np.linalg.norm(vertices[top] - [0, 1, 0], axis=1)
        assert length == pytest.approx(
            np.linalg.norm(surface.vertices[top] - [0, 1, 0], axis=1), abs=1e-5
        )


# Depth cameras


def recording(folder: Path, tum: bool) -> None:
    """A wall at 2 m with a box at 1 m in its upper left, holes, stamps out of order, one depth
    picture missing."""
    folder.mkdir()
    rgb, depth = folder / "rgb", folder / "depth"
    rgb.mkdir(), depth.mkdir()
    stamps = [2.0, 1.0, 3.0, 4.0]
    lists: dict[str, list[str]] = {"rgb": ["# stamp file"], "depth": ["# stamp file"]}
    for stamp in stamps:
        colour = np.full((48, 64, 3), 60, np.uint8)
        far = np.full((48, 64), 10000 if tum else 2000, np.uint16)
        colour[6:20, 8:24] = 250
        far[6:20, 8:24] //= 2
        far[30:34, 40:50] = 0
        name = f"{stamp:.6f}.png" if tum else f"color_{int(stamp):04d}.png"
        deep = f"{stamp + 0.008:.6f}.png" if tum else f"depth_{int(stamp):04d}.png"
        write_picture(rgb / name, colour)
        lists["rgb"].append(f"{stamp:.6f} rgb/{name}")
        if stamp != 3.0:
            write_picture(depth / deep, far)
            lists["depth"].append(f"{stamp + 0.008:.6f} depth/{deep}")
    if tum:
        for kind, lines in lists.items():
            (folder / f"{kind}.txt").write_text("\n".join(lines))
    camera = {"fx": 60.0, "fy": 60.0, "ppx": 31.5, "ppy": 23.5, "depth_scale": 0.001}
    if tum:
        camera["depth_scale"] = 5000
    (folder / "intrinsics.json").write_text(json.dumps({"color": {}, "camera": camera}))


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
        ("{", "no JSON"), ("{}", "no fx"), ('{"fx": 0, "fy": 1, "cx": 0, "cy": 0}', "positive"),
    ):  # fmt: skip
        camera.write_text(text)
        with pytest.raises(ValueError, match=words):
            read_recording(tmp_path / "walk", LC_R_1080)


def blender_frame(path: Path, shift: float) -> None:
    """Multilayer EXR as Blender writes it: a lit square at 5 m before a far background."""
    import OpenImageIO as oiio

    height, width = 40, 60
    names = ["ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B",
             "ViewLayer.Combined.A", "ViewLayer.Depth.Z"]  # fmt: skip
    data = np.zeros((height, width, 5), np.float32)
    data[:, :, 4] = 1e10
    data[5:15, 10:20, :4] = 1
    data[5:15, 10:20, 4] = 5 + shift
    data[30:, 50:, :3] = 0.3  # a sky that is lit, but nowhere
    data[30:, 50:, 3] = 1
    spec = oiio.ImageSpec(width, height, 5, "float")
    spec.channelnames = tuple(names)
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), spec) and out.write_image(data)
    out.close()


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


# Points out and in again


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


# The commands


def test_inspect_says_what_will_be_seen(models: Path, tmp_path: Path, capsys) -> None:
    thing = models / "OBJ" / "spider.obj"
    picture = tmp_path / "s.png"
    assert run("inspect", thing, "--points", 300, "--out", picture) == 0
    told = capsys.readouterr().out
    for words in ("field of view", "resolution", "depth of focus", "speckle contrast", "curved",
                  "shown 1.6"):  # fmt: skip
        assert words in told
    assert picture.stat().st_size > 10_000


def test_generate_exports_and_nothing_is_half_written(models: Path, tmp_path: Path, capsys) -> None:
    thing = models / "OBJ" / "spider.obj"
    points = tmp_path / "p.npz"
    video = tmp_path / "video"
    assert run("generate", thing, "--out", video, "--points", 500, "--export-points", points) == 0
    assert points.is_file() and (video / "manifest.json").is_file()
    assert run("generate", models / "invalid" / "empty.ply", "--out", tmp_path / "none") == 2
    assert not (tmp_path / "none").exists()


def test_sizes_for_what_has_its_own_are_refused() -> None:
    for options in ({"points": 5}, {"density": 1.0}, {"fit": True}):
        with pytest.raises(ValueError, match="belong to files"):
            load_scene("car-house", **options)
