"""Frames without compensation: the coded signal straight from the points, and its pictures."""

import csv
import hashlib
from pathlib import Path

import numpy as np
import pytest

import chrmc
from chrmc import SLM, WAVELENGTH, load_scene
from chrmc.cgh import curved
from chrmc.cli.main import main
from chrmc.encoding import coding_for
from chrmc.generation.group import grey_levels
from chrmc.generation.recipe import recipe_for
from chrmc.grey_levels import encode, video_scale
from chrmc.scene.point_scene import PointScene
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Pose
from chrmc.store.video import open_video

PANEL = SLM("a quarter of the paper's", 320, 200, 16e-6)
ARGUMENTS = ["car-house", "--compensation", "none", "--slm", "320x200:1.6e-5", "--frames", "1:2"]


@pytest.mark.parametrize("encoding", ["ssb", "real", "burch"])
@pytest.mark.parametrize("tolerance", [1e-2, 1e-5])
def test_the_signal_is_the_fields_to_single_precision(encoding: str, tolerance: float) -> None:
    coding = coding_for(encoding, PANEL)
    carrier = np.exp(2j * np.pi * coding.carrier * PANEL.y())[:, None]
    made = chrmc.video(load_scene("car-house"), PANEL, cgh="curved", coding=coding,
                       frames=(1, 2), tolerance=tolerance, compensation="none")  # fmt: skip
    for frame in made:
        assert frame.signal is not None and frame.signal.dtype == np.float32
        assert frame.record.point_pixels == len(frame.cloud) * PANEL.width * PANEL.height
        assert "field" not in vars(frame)  # nobody asked for it yet
        wanted = (frame.field * carrier).real
        assert np.linalg.norm(frame.signal - wanted) < 1e-6 * np.linalg.norm(wanted)


def test_a_frame_without_points_is_dark_both_ways() -> None:
    nothing = PointCloud(np.zeros((0, 3)), np.zeros(0), np.zeros(0))
    still = Pose(np.eye(3), np.array([0, 0, 0.25]))
    scene = PointScene("empty", {"it": nothing}, {"it": [still]}, {})
    (frame,) = chrmc.video(scene, PANEL, cgh="curved", coding="ssb", compensation="none")
    assert frame.signal is not None
    assert frame.signal.shape == PANEL.shape and not frame.signal.any() and not frame.field.any()


def test_a_point_that_no_pixel_shows_is_refused_both_ways() -> None:
    aside = PointCloud(np.zeros((1, 3)), np.ones(1), np.zeros(1))
    still = Pose(np.eye(3), np.array([0.1, 0, 0.25]))
    scene = PointScene("aside", {"it": aside}, {"it": [still]}, {})
    (frame,) = chrmc.video(scene, PANEL, cgh="curved", coding="ssb", compensation="none")
    for attribute in ("signal", "field"):
        with pytest.raises(ValueError, match="no pixel"):
            getattr(frame, attribute)


def test_only_curved_where_the_signal_is_enough_gives_it() -> None:
    scene = load_scene("car-house")

    def signal(cgh: object, encoding: str, **options: object) -> object:
        made = chrmc.video(
            scene, PANEL, cgh=cgh, coding=encoding, frames=(1, 1), **options, compensation="none"
        )
        return next(made).signal

    assert signal(curved.METHOD, "ssb") is not None
    assert signal("fresnel", "ssb") is None
    assert signal(curved.field, "ssb") is None  # a plain function is no more than its field
    assert signal("curved", "offaxis") is None  # |U + R|² needs the field
    assert signal("curved", "ssb", footprint=None) is None  # only the field knows bare waves
    with pytest.raises(ValueError, match="no option 'sharpness'"):
        signal("curved", "ssb", sharpness=3)


def test_grey_levels_come_without_a_field_and_are_the_fields() -> None:
    recipe = recipe_for(load_scene("car-house"), PANEL, compensation="none", check_pixels=0)
    scale = video_scale(recipe.scene, PANEL, WAVELENGTH, recipe.coding)
    for frame in recipe.video(1, 2):
        levels = grey_levels(frame, recipe, scale).astype(int)
        assert "field" not in vars(frame)
        wanted = encode(frame.field, PANEL, "ssb", scale, band_limited=True).astype(int)
        # A signal on the edge between two grey levels may fall to either side.
        assert np.abs(levels - wanted).max() <= 1
        assert np.count_nonzero(levels != wanted) < 1e-3 * levels.size
        assert wanted.std() > 10


def test_generate_and_live_show_these_pictures(tmp_path: Path) -> None:
    def run(*arguments: str | Path) -> None:
        with pytest.raises(SystemExit) as ended:
            main([str(a) for a in arguments])
        assert ended.value.code == 0

    run("generate", *ARGUMENTS, "--check-pixels", "64", "--out", tmp_path / "video")
    run("live", *ARGUMENTS, "--headless", "--verify", "--log", tmp_path / "log.csv")
    stored = open_video(tmp_path / "video")
    with (tmp_path / "log.csv").open(encoding="utf-8") as file:
        shown = {int(row["frame"]): row["sha256"] for row in csv.DictReader(file)}
    recipe = recipe_for(load_scene("car-house"), PANEL, compensation="none")
    for frame in recipe.video(1, 2):
        levels = grey_levels(frame, recipe, stored.scale)
        np.testing.assert_array_equal(stored.read(frame.number), levels)
        assert shown[frame.number] == hashlib.sha256(levels.data).hexdigest()
        error = stored.entry(frame.number)["error_reference"]
        assert error is not None and error < 1e-3
