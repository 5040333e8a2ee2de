"""Videos in colours: stored, continued, refused, looked at and judged as one."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import chrmc
import reconstruct
from chrmc.cli.main import main
from chrmc.colour import mixed
from chrmc.optics.footprint import expected_power
from chrmc.response_fit import ResponseFit
from reconstruct.colour import balanced, colour_image, colour_systems
from reconstruct.colour_likeness import delta_e

PANEL = chrmc.SLM("small", 240, 160, 8.1e-6)
LASERS = (638e-9, 532e-9, 450e-9)


def card(colours: list[list[float]], frames: int = 2, points: int = 300) -> chrmc.PointScene:
    """Flat fields side by side, one of each colour."""
    rng = np.random.default_rng(3)
    bodies, poses = {}, {}
    for k, colour in enumerate(colours):
        place = rng.uniform(-1.5e-4, 1.5e-4, (points, 3)) * (1, 1, 0)
        bodies[f"field {k}"] = chrmc.PointCloud(
            place, np.ones(points), rng.uniform(0, 2 * np.pi, points), np.tile(colour, (points, 1))
        )
        x = (k - (len(colours) - 1) / 2) * 4e-4
        poses[f"field {k}"] = [
            chrmc.Pose(np.eye(3), [x, 0, 0.02 + 1e-4 * n]) for n in range(frames)
        ]
    return chrmc.PointScene("card", bodies, poses)


def made(folder: Path, scene: chrmc.PointScene | None = None, **more: object) -> chrmc.ColourVideo:
    scene = card([[1, 0.5, 0.5], [1, 1, 1]]) if scene is None else scene
    options = {"slm": PANEL, "wavelength": LASERS, "compensation": "none", "check_pixels": 0}
    video = chrmc.generate(scene, folder, **{**options, **more})
    assert isinstance(video, chrmc.ColourVideo)
    return video


@pytest.fixture(scope="module")
def video(tmp_path_factory: pytest.TempPathFactory) -> chrmc.ColourVideo:
    return made(tmp_path_factory.mktemp("colour") / "video")


def test_a_video_in_colours_is_a_video_for_each_laser(video: chrmc.ColourVideo) -> None:
    assert video.wavelengths == LASERS and video.numbers == [1, 2] and len(video) == 2
    assert video.read(2).shape == (*PANEL.shape, 3)
    assert {p.name for p in video.folder.iterdir()} == {"colour.json", "638nm", "532nm", "450nm"}
    again = chrmc.open_video(video.folder)
    assert np.array_equal(again.read(1), video.read(1))
    alone = chrmc.open_video(video.folder / "532nm")
    assert isinstance(alone, chrmc.Video) and alone.wavelength == 532e-9


def test_white_points_give_the_same_light_in_every_colour(video: chrmc.ColourVideo) -> None:
    """One factor for all lasers, the brightest fills its range; white stays in balance."""
    white = card([[1, 1, 1], [1, 1, 1]])
    band = chrmc.coding_for("ssb", PANEL).passband
    power = [
        max(expected_power(white.frame(n).cloud, PANEL, w, band).sum() for n in (1, 2))
        for w in LASERS
    ]
    scales = np.array([channel.scale for channel in video.channels])
    shares = scales / np.sqrt(power)
    assert shares == pytest.approx([shares[0]] * 3, rel=1e-9)
    found = [
        chrmc.generate(
            one, video.folder.parent / f"{k}", slm=PANEL, compensation="none", check_pixels=0
        ).scale
        for k, one in enumerate(chrmc.scenes_in_light(card([[1, 0.5, 0.5], [1, 1, 1]]), LASERS))
    ]
    assert min(scales / found) == pytest.approx(1, rel=1e-9)


def test_a_stopped_video_goes_on_and_another_is_refused(tmp_path: Path) -> None:
    whole, parts = made(tmp_path / "whole"), tmp_path / "parts"
    made(parts, frames=(2, 2))
    (parts / "450nm" / "frame_0002.tif").unlink()
    stored = made(parts)
    for number in (1, 2):
        assert np.array_equal(stored.read(number), whole.read(number))
    with pytest.raises(ValueError, match="638, 532, 450 nm"):
        made(parts, wavelength=(638e-9, 532e-9))
    with pytest.raises(ValueError, match="holds another video"):
        made(parts, card([[0, 1, 0]]))
    with pytest.raises(ValueError, match="video in colours"):
        made(parts, wavelength=532e-9)
    other = made(parts, card([[0, 1, 0]]), wavelength=(638e-9, 520e-9), force=True)
    assert other.wavelengths == (638e-9, 520e-9)
    assert {p.name for p in parts.iterdir()} == {"colour.json", "638nm", "520nm"}


def test_each_laser_has_its_response(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """White stays white, though the panel is darker and bent otherwise in each light."""
    grey = np.arange(256) / 255
    panels = []
    for wavelength, gamma, dark in ((638e-9, 1.4, 0.3), (532e-9, 2.2, 0.02), (450e-9, 3.0, 0.1)):
        intensity = dark + (1 - dark) * grey**gamma
        fit = ResponseFit(255 * grey, intensity, intensity, 0 * grey, wavelength=wavelength)
        panels.append(fit.write(tmp_path / f"{wavelength * 1e9:.0f}.csv"))
    white = card([[1, 1, 1]], frames=1, points=600)
    video = made(tmp_path / "video", white, response=panels)
    stored = [chrmc.GreyResponse.from_dict(channel.response) for channel in video.channels]
    for response, path in zip(stored, panels, strict=True):
        assert np.array_equal(response.levels, chrmc.GreyResponse.from_csv(path).levels)
        assert response.wavelength == pytest.approx(float(path.stem) * 1e-9)
    light = colour_image(video, 1, 0.02).sum((0, 1))
    linear = colour_image(made(tmp_path / "linear", white), 1, 0.02).sum((0, 1))
    # What is left is clipped in other measure; without the scales' part red would be a fifth.
    assert light / light.max() == pytest.approx(linear / linear.max(), abs=0.12)
    assert np.ptp([response.swing for response in stored]) > 0.3

    for wrong, said in (
        ([panels[0], panels[2], panels[1]], "measured at 450 nm, not at 532 nm"),
        (panels[:2], "2 responses for 3 wavelengths"),
        (panels[0], "measured at 638 nm"),
    ):
        with pytest.raises(ValueError, match=said):
            made(tmp_path / "wrong", white, response=wrong)
    assert not (tmp_path / "wrong").exists()

    monkeypatch.chdir(tmp_path)
    (tmp_path / "dots.xyz").write_text("x y z r g b\n0 0 0 255 90 90\n1 1 0 90 90 255\n")
    asked = ["generate", "dots.xyz", "--slm", "64x48:8um", "--out", "dots", "--check-pixels", "0"]
    asked += ["--wavelength", "638nm,532nm,450nm", "--response"]
    for names, code in (("638.csv,532.csv,450.csv", 0), ("638.csv,,450.csv", 2)):
        with pytest.raises(SystemExit) as ended:
            main([*asked, names])
        assert ended.value.code == code
    assert "empty name" in capsys.readouterr().err
    again = chrmc.open_video(tmp_path / "dots")
    assert [channel.response["name"] for channel in again.channels] == [p.name for p in panels]


def test_nothing_is_left_where_nothing_came_about(tmp_path: Path) -> None:
    far = chrmc.PointScene(
        "far",
        {"dot": chrmc.PointCloud([[0, 0, 0]], [1.0], [0.0])},
        {"dot": [chrmc.Pose(np.eye(3), [0.5, 0, 0.02])]},
    )
    with pytest.raises(ValueError, match="can be shown by no pixel"):
        made(tmp_path / "video", far)
    assert not (tmp_path / "video").exists()


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ({"format": 2}, "format 1"),
        ({"format": 1, "wavelengths": [532e-9], "scales": [1.0]}, "list of 2"),
        ({"format": 1, "wavelengths": [532e-9] * 2, "scales": [1.0] * 2}, "different"),
        ({"format": 1, "wavelengths": [532e-9, "x"], "scales": [1.0] * 2}, "must be a number"),
        ({"format": 1, "wavelengths": [638e-9, 532e-9], "scales": [1.0, -1]}, "scale"),
        ({"format": 1, "wavelengths": [638e-9, 650e-9], "scales": [1.0, 1]}, "white"),
        ({"format": 1, "wavelengths": [638e-9, 520e-9], "scales": [1.0, 1]}, "no frames at 638"),
    ],
)
def test_a_bad_colour_file_is_one_line(content: dict, said: str, tmp_path: Path) -> None:
    (tmp_path / "colour.json").write_text(json.dumps(content))
    with pytest.raises((ValueError, OSError), match=said):
        chrmc.open_video(tmp_path)


def test_channels_of_different_videos_are_refused(video: chrmc.ColourVideo, tmp_path: Path) -> None:
    other = made(tmp_path / "other", encoding="burch")
    (other.folder / "532nm").rename(tmp_path / "away")
    (other.folder / "532nm").symlink_to(video.folder / "532nm")
    with pytest.raises(ValueError, match="different scenes, panels or encodings"):
        chrmc.open_video(other.folder)


def test_each_colour_is_judged(video: chrmc.ColourVideo) -> None:
    verdicts = reconstruct.check(video, [1])
    assert [v.wavelength for v in verdicts] == list(LASERS)
    assert all(v.passed for v in verdicts)


def test_colours_come_back(video: chrmc.ColourVideo) -> None:
    """The mean light of each field, over a few grains of speckle, has its colour."""
    image = colour_image(video, 1, None)
    middle = (PANEL.height - 1) // 2
    found = []
    for x in (-2e-4, 2e-4):
        column = round(x / PANEL.pixel_pitch + (PANEL.width - 1) / 2)
        found.append(image[middle - 15 : middle + 16, column - 15 : column + 16].mean((0, 1)))
    wanted = [chrmc.scenes_in_light(card([c]), LASERS) for c in ([1, 0.5, 0.5], [1, 1, 1])]
    for light, scenes in zip(found, wanted, strict=True):
        true = np.array([s.frame(1).cloud.intensity.sum() for s in scenes])
        assert light / light.sum() == pytest.approx(true / true.sum(), abs=0.06)


def test_balance_is_undone_by_the_scales(video: chrmc.ColourVideo) -> None:
    ones = [np.full((2, 3), channel.scale**2) for channel in video.channels]
    assert np.ptp(balanced(video, ones)) < 1e-6 * video.channels[0].scale ** 2
    assert [s.wavelength for s in colour_systems(video)] == list(LASERS)


def test_colour_differences() -> None:
    """Against pairs of Sharma, Wu and Dalal (2005) it would repeat scikit-image's own tests: here
    that linear light, not sRGB, is what is compared."""
    grey = np.full((1, 3), 0.184187)  # L* = 50
    lighter = np.full((1, 3), 0.24)
    assert delta_e(grey, grey) == pytest.approx([0.0])
    # ΔL'/S_L with S_L near 1 around L* = 53
    lightness = 116 * np.cbrt([0.184187, 0.24]) - 16
    assert delta_e(grey, lighter)[0] == pytest.approx(np.diff(lightness)[0], rel=0.05)


def test_pictures_and_movies_on_the_command_line(
    video: chrmc.ColourVideo, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = str(video.folder)

    def run(*words: object) -> int:
        with pytest.raises(SystemExit) as ended:
            main([str(word) for word in words])
        return int(ended.value.code or 0)

    asked = ("reconstruct", folder, "--frame", 1, "--depth", "20mm")
    assert run(*asked, "--out", tmp_path / "one.png") == 0
    one = np.asarray(Image.open(tmp_path / "one.png")).astype(float)
    assert one.shape == (*PANEL.shape, 3)
    left, right = one[60:100, 80:110].mean((0, 1)), one[60:100, 130:160].mean((0, 1))
    assert left[0] > 1.2 * left[1] and right.min() > 0.7 * right.max()
    assert run(*asked, "--out", tmp_path / "one.exr", "--energy") == 0
    assert run("reconstruct", folder, "--movie", tmp_path / "movie.gif") == 0
    with Image.open(tmp_path / "movie.gif") as movie:
        assert movie.n_frames == 2
    assert run("reconstruct", folder, "--all", "--follow", "field 0", "--out", tmp_path / "f") == 0
    assert len(list((tmp_path / "f").iterdir())) == 2
    assert run("check", folder, "--frames", 1) == 0
    assert "450 nm" in capsys.readouterr().out
    counts = ("--frame", 1, "--depth", "20mm", "--camera", "16.2um:12", "--out", tmp_path / "c.png")
    assert run("reconstruct", folder, *counts) == 0
    red, green, blue = (
        np.asarray(Image.open(tmp_path / f"c_{name}.png")).astype(float)
        for name in ("638nm", "532nm", "450nm")
    )
    assert red.shape == (80, 120)
    left, right = np.s_[30:50, 39:57], np.s_[30:50, 63:81]  # reddish and white
    assert red[left].mean() > 1.3 * blue[left].mean()
    assert np.ptp([c[right].mean() for c in (red, green, blue)]) < 0.3 * green[right].mean()


def test_a_focal_stack_in_colour(video: chrmc.ColourVideo, tmp_path: Path) -> None:
    """One white for all depths and lasers; sharp where the fields are, in their colours."""
    from chrmc.cli.reconstruct import command
    from reconstruct.images import read_image

    out = tmp_path / "stack"
    words = [str(video.folder), "--frame", "1", "--depths", "19.4mm:20.6mm:7", "--out", str(out)]
    words += ["--format", "exr", "--preview", str(tmp_path / "stack.gif")]
    assert command.main(words, standalone_mode=False) == 0
    with Image.open(tmp_path / "stack.gif") as preview:
        assert preview.n_frames == 7
        assert np.ptp(np.asarray(preview.convert("RGB")).astype(int), axis=2).max() > 60
    shown = [read_colour(out / f"depth_{z:08.3f}mm.exr") for z in (19.4, 20.0)]
    assert shown[0].sum() == pytest.approx(shown[1].sum(), rel=0.1)
    truth = mixed(colour_image(video, 1, 0.02), LASERS)
    assert np.allclose(shown[1], truth, atol=1e-4 * truth.max())
    depth, _ = read_image(out / "depth_map.exr")
    sharp = read_colour(out / "all_in_focus.exr")
    for x, colour in ((-2e-4, [1, 0.5, 0.5]), (2e-4, [1, 1, 1])):
        column = round(x / PANEL.pixel_pitch + (PANEL.width - 1) / 2)
        part = np.s_[65:96, column - 15 : column + 16]
        assert np.median(depth[part]) == pytest.approx(0.02, abs=2e-4)
        light = sharp[part].mean((0, 1))
        assert light / light.max() == pytest.approx(colour, abs=0.25)


def read_colour(path: Path) -> np.ndarray:
    """(H, W, 3) of an EXR."""
    import OpenImageIO

    source = OpenImageIO.ImageInput.open(str(path))
    pixels = source.read_image("float")
    source.close()
    return np.asarray(pixels)


def test_a_panorama_in_colour(video: chrmc.ColourVideo, tmp_path: Path) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["panorama", str(video.folder), "--out", str(tmp_path / "p.png"), "--panels", "1"])
    assert ended.value.code == 0
    picture = np.asarray(Image.open(tmp_path / "p.png").convert("RGB")).astype(int)
    assert (picture[..., 0] - picture[..., 2]).max() > 60


def test_one_laser_of_it_knows_its_share_of_the_scene(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from chrmc.survey import spot_check
    from reconstruct.checking import scene_of

    monkeypatch.chdir(tmp_path)
    (tmp_path / "dots.xyz").write_text("x y z r g b\n0 0 0 255 90 90\n1 1 0 90 90 255\n")
    video = made(tmp_path / "video", tmp_path / "dots.xyz")  # type: ignore[arg-type]
    for channel in video.channels:
        assert spot_check(scene_of(channel)) == channel.scene["spot_check"]


def test_a_montage_in_colour(video: chrmc.ColourVideo, tmp_path: Path) -> None:
    from chrmc.cli.montage import command

    words = [str(video.folder), "--frames", "1", "--out", str(tmp_path / "montage.png")]
    assert command.main(words, standalone_mode=False) == 0
    picture = np.asarray(Image.open(tmp_path / "montage.png").convert("RGB")).astype(int)
    assert (np.ptp(picture, axis=2) > 60).mean() > 0.01
