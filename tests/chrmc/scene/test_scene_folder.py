"""Folders of EXR frames: our own, and those that other tools write."""

import json
import tempfile
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chrmc import PointCloud, load_scene
from chrmc.scene.folder import write_scene
from chrmc.scene.path import rotation_y
from chrmc.scene.point_scene import PointScene
from chrmc.scene.rgbd import PLANES, RGBDFrame
from chrmc.scene.rgbd_scene import RGBDScene
from chrmc.scene.scene import Pose

PITCH = 40.5e-6


def random_scene(seed, shape=(4, 5), count=3, planes=PLANES, ids=(1, 2, 4000)):
    """Frames of random light, planes and objects; the middle one is black."""
    rng = np.random.default_rng(seed)
    frames = []
    for number in range(1, count + 1):
        light = rng.uniform(0, 2, shape).astype(np.float32) * (rng.random(shape) < 0.6)
        if number == 2:
            light[:] = 0
        if planes is None:
            depth = rng.uniform(0.2, 0.3, shape).astype(np.float32).astype(np.float64)
        else:
            depth = planes.first + rng.integers(planes.count, size=shape) * planes.step
        frames.append(RGBDFrame(light, np.where(light > 0, depth, 0), rng.choice(ids, shape)))
    return RGBDScene(
        name="random",
        read=lambda n: frames[n - 1],
        frame_count=count,
        shape=shape,
        pixel_pitch=PITCH,
        objects={i: f"thing {i}" for i in ids},
        planes=planes,
        wavelength=633e-9,
        poses={
            "thing 2": [Pose(rotation_y(0.1 * k), np.array([k, 0.1, 1 / 3])) for k in range(count)]
        },
        phase_seed=seed,
    )


def assert_same_scene(a, b):
    assert (a.name, a.frame_count, a.shape, a.pixel_pitch) == (
        b.name,
        b.frame_count,
        b.shape,
        b.pixel_pitch,
    )
    assert (a.wavelength, a.object_names, a.form) == (b.wavelength, b.object_names, b.form)
    for number in range(1, a.frame_count + 1):
        for one, other in zip(a.frame(number).objects, b.frame(number).objects, strict=True):
            assert one.name == other.name
            assert np.array_equal(one.cloud.positions, other.cloud.positions)
            assert np.array_equal(one.cloud.amplitude, other.cloud.amplitude)
            assert np.array_equal(one.cloud.phase, other.cloud.phase)
            assert (one.pose is None) == (other.pose is None)
            assert one.pose is None or one.pose.same_as(other.pose)


@settings(max_examples=12, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.tuples(st.integers(1, 6), st.integers(1, 6)),
    st.sampled_from([PLANES, None]),
)
def test_folder_and_back_loses_nothing(seed, shape, planes):
    scene = random_scene(seed, shape, planes=planes)
    with tempfile.TemporaryDirectory() as folder:
        write_scene(scene, Path(folder) / "s")
        assert_same_scene(load_scene(str(Path(folder) / "s")), scene)


def test_built_in_scene_survives_its_folder(tmp_path):
    scene = load_scene("car-house", form="rgbd")
    files = write_scene(scene, tmp_path / "s", frames=(20, 22))
    assert [f.name for f in files] == ["frame_0001.exr", "frame_0002.exr", "frame_0003.exr"]
    loaded = load_scene(str(tmp_path / "s"), form="rgbd")
    assert loaded.form == "rgbd"
    for k in (1, 2, 3):
        a, b = scene.frame(19 + k), loaded.frame(k)
        assert np.array_equal(a.cloud.positions, b.cloud.positions)
        assert np.array_equal(a.cloud.phase, b.cloud.phase)
        assert np.array_equal(a.cloud.amplitude, b.cloud.amplitude)
        assert a.objects[0].pose.same_as(b.objects[0].pose)
    said = json.loads((tmp_path / "s" / "scene.json").read_text())
    assert said["pixel_pitch"] == 40.5e-6 and said["wavelength"] == 532e-9
    assert (said["depth_min"], said["depth_step"], said["depth_planes"]) == (0.244, 1e-4, 256)
    assert said["objects"] == [{"id": 1, "name": "car"}, {"id": 2, "name": "house"}]


def test_a_scene_of_points_can_be_written(tmp_path):
    points = PointCloud([[0, 0, 0], [2 * PITCH, PITCH, 1e-3]], [1, 2], [0, 0])
    poses = [Pose(np.eye(3), np.array([k * PITCH + PITCH / 2, PITCH / 2, 0.25])) for k in range(3)]
    write_scene(PointScene("dots", {"dot": points}, {"dot": poses}), tmp_path / "s")
    loaded = load_scene(tmp_path / "s")
    assert loaded.object_names == ("dot",)
    for number in (1, 2, 3):
        expected = points.positions + poses[number - 1].translation
        assert loaded.frame(number).cloud.positions == pytest.approx(expected, abs=2e-8)


# --- folders by other hands ---------------------------------------------------------------------


def write_channels(path, channels, kinds=None, origin=None):
    """An EXR with the given name → (H, W) channels, through OpenImageIO alone."""
    names = list(channels)
    kinds = kinds or ["float"] * len(names)
    height, width = channels[names[0]].shape
    spec = oiio.ImageSpec(width, height, len(names), "float")
    spec.channelnames = tuple(names)
    spec.channelformats = tuple(kinds)
    if origin is not None:
        spec.x, spec.y, (spec.full_width, spec.full_height) = *origin[0], origin[1]
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), spec), out.geterror()
    pixels = np.stack([np.asarray(c, np.float32) for c in channels.values()], axis=2)
    assert out.write_image(np.ascontiguousarray(pixels)), out.geterror()
    assert out.close()


def light_and_depth(shape=(3, 4)):
    light = np.arange(np.prod(shape), dtype=np.float32).reshape(shape) / 16
    depth = (0.25 + 0.001 * np.arange(np.prod(shape)).reshape(shape)).astype(np.float32)
    return light, depth


def hand_made(folder, channels, count=2, name="frame_{:04d}.exr", kinds=None, **json_keys):
    folder.mkdir()
    for number in range(1, count + 1):
        write_channels(folder / name.format(number), channels, kinds)
    (folder / "scene.json").write_text(json.dumps({"pixel_pitch": 50e-6, **json_keys}))
    return folder


@pytest.mark.parametrize(
    ("light_name", "depth_name"),
    [
        ("Y", "Z"),
        ("I", "depth"),
        ("intensity", "Depth.Z"),
        ("Grey", "Z"),
        ("ViewLayer.Combined.Y", "ViewLayer.Depth.V"),
    ],
)
def test_channel_names_of_other_tools(tmp_path, light_name, depth_name):
    light, depth = light_and_depth()
    extra = np.ones_like(light)
    channels = {"A": extra, depth_name: depth, "motion.X": extra, light_name: light}
    scene = load_scene(hand_made(tmp_path / "s", channels))
    assert scene.name == "s" and scene.object_names == ("scene",)
    assert scene.wavelength is None and scene.pixel_pitch == 50e-6
    cloud = scene.frame(2).cloud
    assert cloud.intensity == pytest.approx(light.ravel()[1:])
    assert np.array_equal(cloud.positions[:, 2], depth.ravel()[1:].astype(np.float64))
    assert cloud.positions[0, :2] == pytest.approx([-0.5 * 50e-6, -1 * 50e-6])


def test_colours_count_by_their_luminance(tmp_path):
    light, depth = light_and_depth()
    channels = {"B": light, "G": light / 2, "R": light / 4, "Z": depth, "A": light}
    cloud = load_scene(hand_made(tmp_path / "s", channels)).frame(1).cloud
    expected = (0.2126 / 4 + 0.7152 / 2 + 0.0722) * light.ravel()[1:]
    assert cloud.intensity == pytest.approx(expected, rel=1e-6)


def test_layers_of_a_renderer(tmp_path):
    light, depth = light_and_depth()
    wrong = np.full_like(light, 9)
    layers = {f"ViewLayer.{layer}.{c}": wrong for layer in ("AO", "Normal") for c in "RGB"}
    layers |= {f"ViewLayer.{layer}.{c}": wrong for layer in ("Normal", "Vector") for c in "XYZ"}
    layers |= {f"ViewLayer.Combined.{c}": light for c in "RGBA"}
    layers |= {"ViewLayer.Depth.Z": depth, "ViewLayer.IndexOB.X": np.full_like(light, 3)}
    scene = load_scene(hand_made(tmp_path / "s", layers))
    assert scene.object_names == ("object 3",)
    cloud = scene.frame(1).cloud
    assert cloud.intensity == pytest.approx(light.ravel()[1:], rel=1e-6)
    assert cloud.positions[:, 2] == pytest.approx(depth.ravel()[1:])


@pytest.mark.parametrize("kind", ["float", "half"])
def test_objects_by_id(tmp_path, kind):
    light, depth = light_and_depth()
    ids = np.array([[0, 1, 1, 1], [7, 7, 7, 7], [3, 3, 3, 3]])
    folder = hand_made(
        tmp_path / "s",
        {"Object_ID": ids, "Y": light, "Z": depth},
        kinds=[kind, "half", "float"],
        objects=[{"id": 3, "name": "tree"}, {"id": 1, "name": "bird"}, {"id": 9, "name": "cat"}],
    )
    scene = load_scene(folder)
    assert scene.object_names == ("tree", "bird", "cat", "object 7")
    assert [len(o.cloud) for o in scene.frame(1).objects] == [4, 3, 0, 4]


def test_whole_number_channels_are_not_normalised(tmp_path):
    (tmp_path / "scene.json").write_text('{"pixel_pitch": 1e-3}')
    pixels = np.array([[[70000, 9, 1], [2, 4, 3]]], np.uint32)
    spec = oiio.ImageSpec(2, 1, 3, "uint")
    spec.channelnames = ("id", "Y", "Z")
    out = oiio.ImageOutput.create(str(tmp_path / "1.exr"))
    assert out.open(str(tmp_path / "1.exr"), spec) and out.write_image(pixels) and out.close()
    scene = load_scene(tmp_path)
    assert scene.object_names == ("object 2", "object 70000")
    assert scene.frame(1).cloud.intensity == pytest.approx([4, 9])
    assert scene.frame(1).cloud.positions[:, 2].tolist() == [3, 1]


def test_cropped_data_window_keeps_its_place(tmp_path):
    folder = tmp_path / "s"
    folder.mkdir()
    light, depth = np.ones((2, 3), np.float32), np.full((2, 3), 0.25, np.float32)
    write_channels(folder / "a1.exr", {"Y": light, "Z": depth}, origin=((4, 1), (9, 5)))
    (folder / "scene.json").write_text('{"pixel_pitch": 1e-3}')
    scene = load_scene(folder)
    assert scene.shape == (5, 9)
    positions = scene.frame(1).cloud.positions
    assert positions[0] == pytest.approx([0, -1e-3, 0.25])
    assert positions[-1] == pytest.approx([2e-3, 0, 0.25])


def test_numbering_may_start_anywhere_or_be_listed(tmp_path):
    light, depth = light_and_depth()
    channels = {"Y": light, "Z": depth}
    folder = hand_made(tmp_path / "s", channels, name="render.{:03d}.exr", count=3)
    (folder / "render.001.exr").unlink()
    assert load_scene(folder).frame_count == 2
    write_channels(folder / "odd.exr", {"Y": 4 * light, "Z": depth})
    (folder / "scene.json").write_text(
        '{"pixel_pitch": 1e-5, "frames": ["odd.exr", "render.003.exr"]}'
    )
    scene = load_scene(folder)
    assert scene.frame(1).cloud.intensity == pytest.approx(4 * scene.frame(2).cloud.intensity)


def test_depth_in_a_part_of_its_own(tmp_path):
    light, depth = light_and_depth()
    specs = []
    for name, channel in (("beauty", "Y"), ("depth", "Z")):
        spec = oiio.ImageSpec(4, 3, 1, "float")
        spec.channelnames = (channel,)
        spec.attribute("name", name)
        specs.append(spec)
    path = str(tmp_path / "1.exr")
    out = oiio.ImageOutput.create(path)
    assert out.open(path, tuple(specs)) and out.write_image(light[:, :, None])
    assert out.open(path, specs[1], "AppendSubimage") and out.write_image(depth[:, :, None])
    assert out.close()
    (tmp_path / "scene.json").write_text('{"pixel_pitch": 1e-3}')
    cloud = load_scene(tmp_path).frame(1).cloud
    assert cloud.intensity == pytest.approx(light.ravel()[1:])
    assert cloud.positions[:, 2] == pytest.approx(depth.ravel()[1:])


# --- refusals -----------------------------------------------------------------------------------


def refused(folder, *parts):
    with pytest.raises((ValueError, OSError)) as caught:
        load_scene(folder)
    message = str(caught.value)
    assert "\n" not in message
    for part in parts:
        assert part in message
    return message


def good(tmp_path, **keys):
    light, depth = light_and_depth()
    return hand_made(tmp_path / "s", {"Y": light, "Z": depth}, count=3, **keys)


@pytest.mark.parametrize(
    ("where", "value", "parts"),
    [
        ("Z", np.nan, ("frame_0002.exr", "depth is NaN", "row 1, column 2")),
        ("Y", np.nan, ("frame_0002.exr", "intensity is NaN", "row 1, column 2")),
        ("Y", -1, ("frame_0002.exr", "negative")),
        ("Z", 0, ("frame_0002.exr", "not a positive")),
        ("Z", np.inf, ("frame_0002.exr", "not a positive")),
    ],
)
def test_bad_values_name_file_and_pixel(tmp_path, where, value, parts):
    folder = good(tmp_path)
    light, depth = light_and_depth()
    {"Y": light, "Z": depth}[where][1, 2] = value
    write_channels(folder / "frame_0002.exr", {"Y": light, "Z": depth})
    refused(folder, *parts)


def test_depth_range_is_kept(tmp_path):
    refused(good(tmp_path, depth_range=[0.2, 0.255]), "6 lit pixels", "256 to 261", "200 to 255")


def test_depth_planes_are_a_range_too(tmp_path):
    folder = good(tmp_path, depth_min=0.25, depth_step=1e-3, depth_planes=10)
    refused(folder, "2 depths from 260 to 261 mm", "250 to 259 mm")


def test_frames_of_another_size(tmp_path):
    folder = good(tmp_path)
    light, depth = light_and_depth((4, 4))
    write_channels(folder / "frame_0003.exr", {"Y": light, "Z": depth})
    refused(folder, "frame_0003.exr has 4 × 4 pixels", "4 × 3")


def test_size_that_scene_json_contradicts(tmp_path):
    refused(good(tmp_path, shape=[240, 320]), "4 × 3", "320 × 240")


def test_missing_frames(tmp_path):
    folder = good(tmp_path)
    (folder / "frame_0002.exr").unlink()
    refused(folder, "gap", "frame 2")


def test_fewer_frames_than_announced(tmp_path):
    refused(good(tmp_path, frame_count=5), "3 of the 5 frames")


def test_no_scene_json(tmp_path):
    folder = good(tmp_path)
    (folder / "scene.json").unlink()
    refused(folder, "scene.json", "pixel_pitch")


def test_no_frames(tmp_path):
    (tmp_path / "scene.json").write_text('{"pixel_pitch": 1e-5}')
    refused(tmp_path, "holds no .exr frames")


@pytest.mark.parametrize("keep", [0, 100, 400, -1])
def test_damaged_frames(tmp_path, keep):
    folder = good(tmp_path)
    path = folder / "frame_0002.exr"
    path.write_bytes(path.read_bytes()[:keep])
    refused(folder, "frame_0002.exr")


def test_two_series_of_frames(tmp_path):
    folder = good(tmp_path)
    light, depth = light_and_depth()
    write_channels(folder / "depth_0001.exr", {"Y": light, "Z": depth})
    refused(folder, "two series", "depth_0001.exr")


def test_links_out_of_the_folder_are_not_followed(tmp_path):
    write_scene(random_scene(1), tmp_path / "mine")
    write_scene(random_scene(1), tmp_path / "s")
    frame = tmp_path / "s" / "frame_0002.exr"
    frame.rename(tmp_path / "s" / "kept")
    frame.symlink_to("kept")
    load_scene(tmp_path / "s")
    frame.unlink()
    frame.symlink_to(tmp_path / "mine" / "frame_0002.exr")
    refused(tmp_path / "s", "frame_0002.exr", "leads out of")
    frame.unlink()
    (tmp_path / "s" / "more").symlink_to(tmp_path / "mine")
    path = tmp_path / "s" / "scene.json"
    names = ["frame_0001.exr", "more/frame_0002.exr", "frame_0003.exr"]
    path.write_text(json.dumps(json.loads(path.read_text()) | {"frames": names}))
    refused(tmp_path / "s", "more/frame_0002.exr", "leads out of")


def test_missing_channels(tmp_path):
    light, depth = light_and_depth()
    refused(hand_made(tmp_path / "a", {"Y": light}), "none called Z or depth")
    refused(hand_made(tmp_path / "b", {"R": light, "Z": depth}), "R, Z, no Y")


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("{", "not valid JSON"),
        ("[]", "must be an object"),
        ("{}", "pixel_pitch is missing"),
        ('{"pixel_pitch": -1}', "pixel_pitch -1 m lies outside"),
        ('{"pixel_pitch": "40 um"}', "pixel_pitch must be a number"),
        ('{"pixel_pitch": NaN}', "pixel_pitch"),
        ('{"pixel_pitch": 1e-5, "form": "mesh"}', "unknown form 'mesh'"),
        ('{"pixel_pitch": 1e-5, "depth_step": 1e-4}', "depth_min"),
        ('{"pixel_pitch": 1e-5, "objects": [{"name": "a"}]}', "objects must be a list"),
        ('{"pixel_pitch": 1e-5, "objects": [{"id": 1}, {"id": 1}]}', "listed twice"),
        ('{"pixel_pitch": 1e-5, "wavelength": 0}', "wavelength"),
        ('{"pixel_pitch": 1e-5, "poses": {"scene": [{"rotation": 1}]}}', "pose 1 of 'scene'"),
        ('{"pixel_pitch": 1e-5, "frames": ["none.exr"]}', "none.exr"),
    ],
)
def test_bad_scene_json(tmp_path, text, part):
    folder = good(tmp_path)
    (folder / "scene.json").write_text(text)
    refused(folder, part)


def test_unknown_names_say_what_there_is(tmp_path):
    with pytest.raises(ValueError, match=r"car-house, car-house-deep.*\), a folder"):
        load_scene("carhouse")
    with pytest.raises(ValueError, match="choose points or rgbd"):
        load_scene("car-house", form="mesh")
    (tmp_path / "x").write_text("")
    with pytest.raises(ValueError, match="is a file"):
        load_scene(tmp_path / "x")


# --- writing over -------------------------------------------------------------------------------


def test_writing_again_keeps_frames_and_continues(tmp_path):
    scene = random_scene(1, count=4)
    write_scene(scene, tmp_path / "s", frames=(1, 2))
    kept = (tmp_path / "s" / "frame_0001.exr").stat().st_mtime_ns
    (tmp_path / "s" / "frame_0002.exr").unlink()
    write_scene(scene, tmp_path / "s")
    assert (tmp_path / "s" / "frame_0001.exr").stat().st_mtime_ns == kept
    assert_same_scene(load_scene(tmp_path / "s"), scene)


def test_another_scene_is_not_overwritten_unasked(tmp_path):
    write_scene(random_scene(1, count=3), tmp_path / "s")
    before = {p.name: p.read_bytes() for p in (tmp_path / "s").iterdir()}
    for other in (random_scene(2), random_scene(1, shape=(5, 5))):
        with pytest.raises(ValueError, match="another scene"):
            write_scene(other, tmp_path / "s")
    with pytest.raises(ValueError, match="other frames of it"):
        write_scene(random_scene(1), tmp_path / "s", frames=(2, 3))
    assert before == {p.name: p.read_bytes() for p in (tmp_path / "s").iterdir()}
    write_scene(random_scene(2, count=2), tmp_path / "s", force=True)
    assert_same_scene(load_scene(tmp_path / "s"), random_scene(2, count=2))


def test_frames_of_somebody_else_are_not_taken_for_ours(tmp_path):
    light, depth = light_and_depth()
    write_channels(tmp_path / "frame_0001.exr", {"Y": light, "Z": depth})
    with pytest.raises(ValueError, match="another scene"):
        write_scene(random_scene(1), tmp_path)
