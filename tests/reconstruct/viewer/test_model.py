import numpy as np
import pytest

from chrmc.store import open_video
from reconstruct import four_f
from reconstruct.images import read_image
from reconstruct.viewer.model import ViewerModel
from reconstruct.viewer.shade import Look, shade


@pytest.fixture
def model(video):
    return ViewerModel(open_video(video))


def pixel_of(model, thing):
    slm = model.video.slm
    x, y, _ = thing.target.position
    return (
        round(y / slm.pixel_pitch + (slm.height - 1) / 2),
        round(x / slm.pixel_pitch + (slm.width - 1) / 2),
    )


def test_starts_on_the_first_frame_and_object(model):
    assert model.number == 1 and [t.name for t in model.things()] == ["cluster"]
    assert model.depth == model.things()[0].depth
    low, high = model.depth_range
    assert low < model.depth < high


def test_the_full_picture_is_four_f_and_the_coarse_one_is_near(model):
    v = model.video
    picture = model.picture()
    want = four_f(v.read(1), v.slm, v.wavelength, model.depth, scale=v.scale)
    assert not picture.coarse
    assert np.allclose(np.abs(picture.field) ** 2, want, atol=1e-4 * want.max())
    model.depth += 1e-4
    coarse = model.picture(coarse=True)
    assert coarse.coarse
    full = model.picture()
    row, column = pixel_of(model, model.things()[0])
    part = (slice(row - 30, row + 30), slice(column - 30, column + 30))
    difference = np.abs(coarse.field[part]) - np.abs(full.field[part])
    # Its wrapped light is what a small panel's picture differs by.
    assert np.linalg.norm(difference) < 0.25 * np.linalg.norm(full.field[part])
    # Asked for coarse again, the full one is at hand.
    assert model.picture(coarse=True) is full


def test_pictures_are_kept_until_something_changes(model):
    first = model.picture()
    assert model.picture() is first
    model.change_filter(dc_block=None)
    assert model.picture() is not first
    second = model.picture()
    model.step()
    assert model.picture() is not second and model.number == 2
    hologram = model.hologram()
    model.depth += 1e-3
    assert model.hologram() is hologram


def test_autofocus_finds_the_depth_from_anywhere(model):
    thing = model.things()[0]
    for start in model.depth_range:
        model.depth = start
        found = model.autofocus(*pixel_of(model, thing))
        assert found.focused and model.depth == found.depth
        assert found.depth == pytest.approx(thing.depth, abs=2e-4)
        assert found.depths[0] == model.depth_range[0]  # the whole range, to be drawn


def test_autofocus_on_nothing_leaves_the_depth(model):
    model.number = 3
    model.depth = 0.055
    assert not model.autofocus(128, 128).focused
    assert model.depth == 0.055
    assert model.autofocus(0, 255) is model.last_focus


def test_following_takes_the_objects_depth(model):
    model.follow = "cluster"
    model.depth = 0.055
    model.number = 2
    assert model.depth == model.things()[0].depth
    model.number = 3  # nothing there: the depth stays
    assert model.depth == pytest.approx(model.video.entry(2)["objects"][0]["depth"])


def test_frames_go_round_and_unknown_ones_are_refused(model):
    model.step(-1)
    assert model.number == 3
    model.step(2)
    assert model.number == 2
    model.index = 99
    assert model.number == 3
    with pytest.raises(ValueError, match="no frame 9"):
        model.number = 9


def test_the_filter_decides_what_is_seen(model):
    light = np.abs(model.picture().field).max()
    share = model.figures()["efficiency"]
    model.change_filter(half_plane=False)
    assert model.figures()["efficiency"] == pytest.approx(2 * share, rel=0.05)  # the twin too
    model.change_filter(half_plane=None, aperture=1e-4)
    assert np.abs(model.picture().field).max() < 0.1 * light


def test_figures(model):
    figures = model.figures()
    assert 0 < figures["efficiency"] < figures["blocked"] < 1
    assert figures["contrast"] > 0.5
    sharp = figures["sharpness"]
    model.depth -= 3e-3
    assert model.figures()["sharpness"] < sharp
    model.number = 3
    assert "contrast" not in model.figures()


def test_saving(model, tmp_path):
    model.save(tmp_path / "a.exr")
    values, note = read_image(tmp_path / "a.exr")
    assert np.allclose(values, np.abs(model.picture().field) ** 2, rtol=1e-5)
    assert note["frame"] == 1 and note["depth"] == model.depth
    model.look.mode = "phase"
    model.save(tmp_path / "a.png")
    red, _ = read_image(tmp_path / "a.png")
    assert np.array_equal(red, model.colours()[..., 0])
    assert "0001" in model.suggested_name()


def test_shades():
    field = np.array([[0, 1, 2, 1j, -1]], dtype=np.complex64)
    plain = shade(field, 4.0, Look(gamma=1.0))
    assert plain[0, :, 0].tolist() == [0, 64, 255, 64, 64]
    assert (plain == plain[..., :1]).all()
    brighter = shade(field, 4.0, Look(gamma=1.0, stops=1.0))
    assert brighter[0, 1, 0] == 128
    log = shade(field, 4.0, Look("log"))[0, :, 0]
    assert log[0] == 0 and log[2] == 255 and 200 < log[1] < 255
    phase = shade(field, 1.0, Look("phase"))[0].astype(int)
    assert phase[1, 0] > 200 and max(phase[1, 1:]) < 30  # 0 is red
    assert phase[4, 0] < 30  # π has no red
