"""One scene, several lasers: a further colour channel is a further wavelength."""

import json
from pathlib import Path

import numpy as np
import pytest

import chrmc
import display
import reconstruct
from chrmc.pictures import write_pixels
from chrmc.scene.folder import write_scene
from chrmc.scene.rgbd_scene import rasterised
from chrmc.scene.sources.export import write_export

PANEL = chrmc.SLM("small", 96, 64, 8.1e-6)
FOUR = (638e-9, 577e-9, 532e-9, 450e-9)


def coloured(colours: list[list[float]], side: float = 1.2e-4) -> chrmc.PointScene:
    n = len(colours)
    place = np.stack([np.linspace(-side, side, n), np.zeros(n), np.zeros(n)], axis=1)
    body = chrmc.PointCloud(place, np.ones(n), np.zeros(n), np.array(colours))
    grey = chrmc.PointCloud([[0, 1e-4, 0]], [0.5], [0.0])
    poses = [chrmc.Pose(np.eye(3), [0, 0, z]) for z in (0.02, 0.021)]
    return chrmc.PointScene("dyed", {"dots": body, "grey": grey}, {"dots": poses, "grey": poses})


@pytest.mark.parametrize("wavelengths", [FOUR[:1], (638e-9, 532e-9, 450e-9), FOUR])
def test_each_laser_has_its_share_of_the_same_points(wavelengths: tuple[float, ...]) -> None:
    scene = coloured([[1, 0, 0], [0, 1, 0], [1, 1, 1]])
    lit = chrmc.scenes_in_light(scene, wavelengths)
    assert [s.wavelength for s in lit] == list(wavelengths)
    for one in lit:
        frame, own = one.frame(2), scene.frame(2)
        assert np.array_equal(frame.cloud.positions, own.cloud.positions)
        assert frame.objects[0].cloud.amplitude[2] == pytest.approx(1)  # white stays white
        assert frame.objects[1].cloud.amplitude == pytest.approx([0.5])
        # Reuse from frame to frame goes by the body: it must be the same one.
        assert one.frame(1).objects[0].body is frame.objects[0].body
    if len(wavelengths) == 3:
        red, green, _ = (s.frame(1).objects[0].cloud.intensity for s in lit)
        assert red[0] > 5 * green[0] and green[1] > 2 * red[1]


def test_a_channel_more_is_a_wavelength_more(tmp_path: Path) -> None:
    for one in chrmc.scenes_in_light(coloured([[1, 0, 0], [0, 0, 1]]), FOUR):
        folder = tmp_path / f"{one.wavelength * 1e9:.0f}nm"
        video = chrmc.generate(one, folder, slm=PANEL, compensation="none", tolerance=1e-4)
        assert video.wavelength == one.wavelength and video.numbers == [1, 2]
        assert all(f["error_reference"] < 1e-4 for f in video.frames)


def test_colours_come_back_through_the_4f_system() -> None:
    panel = chrmc.SLM("medium", 384, 256, 8.1e-6)
    lasers = (638e-9, 532e-9, 450e-9)
    shown = coloured([[0.9, 0.1, 0.1], [0.2, 0.8, 0.2], [0.1, 0.2, 0.9]], side=6e-4)
    images = []
    for one in chrmc.scenes_in_light(shown, lasers):
        cloud = one.frame(1).objects[0].cloud
        field = chrmc.compute_field(cloud, panel, one.wavelength, tolerance=1e-4)
        scale = 400.0  # one for all: what is as bright in each laser comes back as bright
        levels = display.encode(field, panel, scale=scale)
        images.append(reconstruct.four_f(levels, panel, one.wavelength, 0.02, scale=scale))
    picture = reconstruct.colour_picture(images, lasers)
    assert picture.shape == (*panel.shape, 3) and picture.dtype == np.uint8
    row = (panel.height - 1) // 2
    for k, x in enumerate((-6e-4, 0.0, 6e-4)):
        column = round(x / panel.pixel_pitch + (panel.width - 1) / 2)
        patch = picture[row - 2 : row + 4, column - 2 : column + 4].reshape(-1, 3)
        assert patch.sum(axis=0).argmax() == k


def test_colours_of_files_reach_the_lasers(tmp_path: Path) -> None:
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=3)
    left = ball.vertices[:, 0] < 0
    ball.visual.vertex_colors = np.where(left[:, None], [255, 0, 0, 255], [0, 0, 255, 255])
    ball.export(tmp_path / "ball.ply")
    scene = chrmc.load_scene(tmp_path / "ball.ply")
    red, _, blue = (
        s.frame(1).cloud for s in chrmc.scenes_in_light(scene, (638e-9, 532e-9, 450e-9))
    )
    side = np.sign(red.positions[:, 0])
    assert red.intensity[side < 0].sum() > 5 * red.intensity[side > 0].sum()
    assert blue.intensity[side > 0].sum() > 5 * blue.intensity[side < 0].sum()
    pictured = chrmc.load_scene(tmp_path / "ball.ply", "rgbd").frame(1).cloud
    assert pictured.colour is not None
    for sign, dark in ((-1, 2), (1, 0)):  # away from the seam, whose triangles are mixed
        assert pictured.colour[sign * pictured.positions[:, 0] > 3e-4, dark].max() < 1e-3


def halves(path: Path, kind: str) -> None:
    """A scene of some kind whose left half is red and whose right half is blue."""
    rgb = np.zeros((40, 60, 3), np.uint8)
    rgb[:, :30, 0], rgb[:, 30:, 2] = 255, 255
    depth = np.full((40, 60, 1), 1000, np.uint16)
    x, y = (v.ravel() / 60 for v in np.meshgrid(np.arange(60), np.arange(40)))
    if kind == "camera":
        (path / "rgb").mkdir(parents=True)
        (path / "depth").mkdir()
        write_pixels(path / "rgb" / "1.png", rgb, "uint8")
        write_pixels(path / "depth" / "1.png", depth, "uint16")
        (path / "camera.json").write_text('{"fx": 60, "fy": 60, "cx": 29.5, "cy": 19.5}')
    elif kind in ("renderer", "folder", "followed"):
        path.mkdir()
        pixels = np.concatenate([rgb / 255, 0.25 * depth / 1000], axis=2).astype(np.float32)
        write_pixels(path / "frame_1.exr", pixels, "float", list("RGBZ"))
        words = '{"camera": {"lens": 50}}' if kind == "renderer" else '{"pixel_pitch": 4e-5}'
        if kind == "followed":
            still = [{"rotation": np.eye(3).tolist(), "translation": [0, 0, 0.25]}]
            told = {"pixel_pitch": 4e-5, "objects": [{"id": 0, "name": "scene"}]}
            words = json.dumps({**told, "poses": {"scene": still}})
        (path / "scene.json").write_text(words)
    elif kind == "picture.png":
        write_pixels(path, rgb, "uint8")
    elif kind == "cloud.npz":
        np.savez(path, positions=np.stack([x, y, 0 * x], 1), colors=rgb.reshape(-1, 3))
    elif kind == "cloud.csv":
        rows = np.column_stack([x, y, 0 * x, rgb.reshape(-1, 3), 0 * x + 0.7])
        np.savetxt(path, rows, delimiter=",", header="x,y,z,r,g,b,amplitude", comments="")


@pytest.mark.parametrize(
    "kind",
    ["camera", "renderer", "folder", "followed", "picture.png", "cloud.npz", "cloud.csv"],
)
def test_every_source_hands_its_colours_on(tmp_path: Path, kind: str) -> None:
    halves(tmp_path / kind, kind)
    few = {"points": 5000} if kind == "picture.png" else {}
    scene = chrmc.load_scene(tmp_path / kind, **few)
    cloud = scene.frame(1).cloud
    assert len(cloud) > 1000 and cloud.colour is not None
    left = cloud.positions[:, 0] < 0
    assert np.allclose(cloud.colour[left], [1 / 0.2126, 0, 0], rtol=1e-6, atol=1e-12)
    assert np.allclose(cloud.colour[~left], [0, 0, 1 / 0.0722], rtol=1e-6, atol=1e-12)
    write_export(scene, tmp_path / "points.npz")
    again = chrmc.load_scene(tmp_path / "points.npz").frame(1).cloud
    assert np.array_equal(again.colour, cloud.colour)
    write_scene(rasterised(scene, (200, 300)), tmp_path / "written")
    drawn = chrmc.load_scene(tmp_path / "written").frame(1).cloud
    side = drawn.positions[:, 0] < 0
    assert drawn.colour is not None and drawn.colour[side, 0].min() > 4
    assert drawn.colour[~side, 2].min() > 13


def test_refusals() -> None:
    scene = coloured([[1, 1, 1]])
    with pytest.raises(ValueError, match="different wavelengths"):
        chrmc.scenes_in_light(scene, (532e-9, 532e-9))
    with pytest.raises(ValueError, match="532e-9 for 532 nm"):
        chrmc.scenes_in_light(scene, (532,))
    with pytest.raises(ValueError, match="must not be negative"):
        chrmc.PointCloud([[0, 0, 0.1]], [1.0], [0.0], [[1, -1, 0]])
    with pytest.raises(ValueError, match="2 pictures for 1"):
        reconstruct.colour_picture([np.ones((2, 2))] * 2, [532e-9])
