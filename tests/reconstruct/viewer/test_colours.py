"""Videos in colours in the viewer's model: what is seen is what the lasers add up to."""

import numpy as np
import pytest

import chrmc
from reconstruct.bench import Filter
from reconstruct.colour import colour_image, colour_levels
from reconstruct.viewer.model import ViewerModel
from reconstruct.viewer.saving import save_picture, save_stack, settings_of
from reconstruct.viewer.shade import Look, shade
from reconstruct.viewer.sources import open_source, title_of

PANEL = chrmc.SLM("small", 240, 160, 8.1e-6)
LASERS = (638e-9, 532e-9, 450e-9)
PAINTS = ([1.0, 0.1, 0.1], [1.0, 1.0, 1.0], [0.1, 0.1, 1.0])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Three flat fields side by side: red, white, blue."""
    rng = np.random.default_rng(5)
    bodies, poses = {}, {}
    for k, paint in enumerate(PAINTS):
        place = rng.uniform(-1e-4, 1e-4, (200, 3)) * (1, 1, 0)
        phase = rng.uniform(0, 2 * np.pi, 200)
        bodies[f"{k}"] = chrmc.PointCloud(place, np.ones(200), phase, np.tile(paint, (200, 1)))
        poses[f"{k}"] = [
            chrmc.Pose(np.eye(3), [(k - 1) * 4e-4, 0, 0.02 + n * 1e-3]) for n in (0, 1)
        ]
    path = tmp_path_factory.mktemp("colours") / "flag"
    scene = chrmc.PointScene("flag", bodies, poses)
    options = {"slm": PANEL, "compensation": "none", "check_pixels": 0}
    chrmc.generate(scene, path, wavelength=LASERS, **options)
    return path


@pytest.fixture
def model(folder):
    made = ViewerModel(open_source(folder))
    yield made
    made.close()


def test_the_sharp_picture_is_the_lasers_sum(model, folder):
    model.settle()
    video = chrmc.open_video(folder)
    seen = model.picture()
    assert not seen.coarse and model.numbers == [1, 2] and model.video.wavelength == 532e-9
    image = colour_image(video, 1, model.depth)
    luminance = seen.glow @ np.array([0.2126, 0.7152, 0.0722])
    assert np.allclose(seen.light, luminance, rtol=1e-4, atol=1e-6 * seen.light.max())
    # The viewer's gamma is 2.2, sRGB's is nearly so.
    shown = shade(seen.field, seen.white, Look(), seen.glow).astype(int)
    wanted = colour_levels(image, video, seen.white).astype(int)
    assert np.abs(shown - wanted).max() <= 12
    assert seen.glow.max() > 0 and set(model.figures.values[0]) >= {"sharpness", "contrast"}


def test_fields_have_their_colours_coarse_and_sharp(model):
    model.settle()
    for picture in (model.quick.pictures[0], model.picture()):
        rows, wide = picture.glow.shape[:2]
        scale = wide / PANEL.width
        part = {}
        for k in range(3):
            middle = (PANEL.width / 2 + (k - 1) * 4e-4 / PANEL.pixel_pitch) * scale
            half = 10 * scale
            part[k] = picture.glow[
                round(rows / 2 - half) : round(rows / 2 + half),
                round(middle - half) : round(middle + half),
            ].mean(axis=(0, 1))
        assert part[0][0] > 2 * part[0][2] and part[2][2] > 2 * part[2][0]
        assert part[1].max() < 2 * part[1].min()


def test_changes_reach_every_laser_and_maps_show_luminance(model):
    model.settle()
    before = model.picture()
    model.number = 2
    model.filter = Filter(half_plane=False)
    model.settle()
    after = model.picture()
    assert after.number == 2 and after.glow.shape == (*PANEL.shape, 3)
    assert all(np.any(before.glow[..., k] != after.glow[..., k]) for k in range(3))
    for look in (Look(colours="viridis"), Look(mode="log"), Look(mode="phase")):
        plain = shade(after.field, after.white, look)
        assert np.array_equal(shade(after.field, after.white, look, after.glow), plain)


def test_focus_and_files(model, tmp_path, monkeypatch):
    monkeypatch.setattr("reconstruct.viewer.saving.STACK_COUNT", 3)
    model.settle()
    depth = model.depth
    model.depth = depth + 2e-3
    model.settle()
    model.focus_at(PANEL.height // 2, PANEL.width // 2)
    while model.found is None:
        model.update()
    assert model.found.focus.focused
    source = model.sources[0]
    assert title_of(source) == "flag"
    note = settings_of(source, model.request, Look())
    assert note["wavelength"] == list(LASERS)
    for name in ("a.png", "a.exr"):
        list(save_picture(tmp_path / name, source, model.decoded(), model.request, Look()))
    list(save_stack(tmp_path / "a.gif", model.decoded(), (depth, depth + 1e-3), Look(), 10, note))
    from PIL import Image

    for name in ("a.png", "a.gif"):
        red, _, blue = np.asarray(Image.open(tmp_path / name).convert("RGB")).T.astype(int)
        assert (red - blue).max() > 60 and (blue - red).max() > 60, name


def test_two_in_colours_are_compared_and_an_unfinished_one_is_told(folder, tmp_path):
    model = ViewerModel([open_source(folder), open_source(folder / "532nm")])
    try:
        model.settle()
        assert model.picture(0).glow is not None and model.picture(1).glow is None
        assert np.isfinite(model.comparison.psnr)
    finally:
        model.close()
    (tmp_path / "colour.json").write_bytes((folder / "colour.json").read_bytes())
    with pytest.raises((ValueError, OSError), match="no frames"):
        open_source(tmp_path)
