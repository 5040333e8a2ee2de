"""One scene, several lasers: a further colour channel is a further wavelength."""

from pathlib import Path

import numpy as np
import pytest

import chrmc
import display
import reconstruct

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
