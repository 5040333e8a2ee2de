import shutil
import time

import numpy as np
import pytest

from chrmc.metrics import psnr
from chrmc.pictures import read_grey, write_grey
from chrmc.store.video import open_video
from reconstruct import four_f
from reconstruct.viewer.compare import compare
from reconstruct.viewer.history import History
from reconstruct.viewer.measure import Region
from reconstruct.viewer.model import ViewerModel
from reconstruct.viewer.pipeline import Request

PATIENCE = 240
PANEL = (256, 256)


def until(model, what):
    """Update until it holds."""
    end = time.monotonic() + PATIENCE
    while not what():
        assert time.monotonic() < end, "never"
        time.sleep(0.002)
        model.update()


@pytest.fixture
def model(video):
    made = ViewerModel(open_video(video))
    yield made
    made.close()


@pytest.fixture
def pair(video):
    made = ViewerModel([open_video(video), open_video(video)])
    yield made
    made.close()


def pixel_of(model, target):
    slm = model.video.slm
    x, y, _ = target.position
    return (
        round(y / slm.pixel_pitch + (slm.height - 1) / 2),
        round(x / slm.pixel_pitch + (slm.width - 1) / 2),
    )


def depth_of(target):
    return float(target.position[2])


def test_starts_on_the_first_frame_and_object(model):
    assert model.number == 1 and [t.name for t in model.objects()] == ["cluster"]
    assert model.depth == depth_of(model.objects()[0])
    low, high = model.depth_range
    assert low < model.depth < high


def test_starts_where_it_is_told_to(model):
    model.start(2, None, None)
    assert model.number == 2 and model.depth == depth_of(model.objects()[0])
    model.start(2, 0.31, None)  # far from the objects, and not clamped
    assert model.depth == 0.31 and model.depth_range[1] >= 0.31
    model.start(1, None, "cluster")
    assert model.follow == "cluster"
    with pytest.raises(ValueError, match="no object 'bus'; the video has cluster"):
        model.start(1, None, "bus")
    with pytest.raises(ValueError, match="no frame 9"):
        model.start(9, None, None)


def test_a_first_picture_comes_and_then_that_of_four_f(model):
    until(model, lambda: model.picture() is not None)
    first = model.picture()
    model.settle()
    sharp = model.picture()
    assert first.coarse and not sharp.coarse and sharp.depth == model.depth
    v = model.video
    want = four_f(v.read(1), v.slm, v.wavelength, model.depth, scale=v.scale)
    assert np.allclose(sharp.light, want, atol=1e-4 * want.max())
    row, column = pixel_of(model, model.objects()[0])
    row -= row % 2  # the first picture has every other row
    part = (slice(row - 30, row + 30, 2), slice(column - 30, column + 30))
    near = (slice(row // 2 - 15, row // 2 + 15), part[1])
    difference = np.abs(first.field[near]) - np.abs(sharp.field[part])
    assert np.linalg.norm(difference) < 0.05 * np.linalg.norm(sharp.field[part])


def test_while_it_moves_there_are_pictures_and_the_last_one_is_of_the_last_depth(model):
    model.settle()
    seen = set()
    end = time.monotonic() + PATIENCE
    while len(seen) < 4:  # dragging: a request newer than any answer
        assert time.monotonic() < end
        model.depth += 1e-6
        model.update()
        assert model.picture().coarse  # nothing sharp is made meanwhile
        seen.add(model.picture().depth)
        time.sleep(0.001)
    model.settle()
    assert not model.picture().coarse and model.picture().depth == model.depth
    assert model.figures.request.depth == model.depth


def test_what_does_not_change_is_not_made_again(model):
    model.settle()
    plane = model.decoded().frame
    sharp = model.picture()
    model.screen = (100, 100)  # another window: the sharp picture is still right
    until(model, lambda: model.quick.request.screen == (100, 100))
    assert model.picture() is sharp
    model.change_filter(dc_block=None)
    model.settle()
    assert model.picture() is not sharp and model.decoded().frame is plane


def test_autofocus_finds_the_depth_from_anywhere_and_tells_its_progress(model):
    target = model.objects()[0]
    for start in model.depth_range:
        model.depth = start
        model.settle()
        model.focus_at(*pixel_of(model, target))
        until(model, lambda: model.progress is not None and model.progress.share > 0)
        until(model, lambda: model.found)
        assert model.found.focus.focused
        assert model.depth == model.found.focus.depth
        assert model.depth == pytest.approx(depth_of(target), abs=2e-4)
        assert model.found.focus.depths[0] == model.depth_range[0]  # the whole range, to be drawn
        model.settle()
        assert model.progress is None
        model.found = None


def test_autofocus_on_nothing_leaves_the_depth(model):
    model.number = 3
    model.depth = 0.055
    model.settle()
    model.focus_at(128, 128)
    until(model, lambda: model.found)
    assert not model.found.focus.focused and model.depth == 0.055
    assert model.messages() == ["nothing comes into focus there"]


def test_focus_and_curves_belong_to_their_frame(model):
    model.settle()
    model.focus_at(*pixel_of(model, model.objects()[0]))
    until(model, lambda: model.found)
    model.settle()
    model.find_curves()
    until(model, lambda: model.curves)
    assert model.curves["cluster"].focus.depth == pytest.approx(0.06, abs=3e-4)
    model.step()
    model.update()
    assert model.found is None and not model.curves


def test_moving_on_interrupts_the_autofocus(model):
    model.settle()
    model.focus_at(*pixel_of(model, model.objects()[0]))
    until(model, lambda: model.progress is not None)
    model.depth += 5e-3
    depth = model.depth
    model.settle()
    assert model.found is None and model.depth == depth and model.progress is None


def test_following_takes_the_objects_depth(model):
    model.follow = "cluster"
    model.depth = 0.055
    model.number = 2
    assert model.depth == depth_of(model.objects()[0])
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


def test_playing_shows_every_frame_at_the_rate_that_is_set_and_tells_it(model):
    model.settle()
    model.playing, model.rate = True, 20.0
    seen = []
    end = time.monotonic() + PATIENCE
    while len(seen) < 10:
        assert time.monotonic() < end
        model.update()
        if model.quick.request.number not in seen[-1:]:
            seen.append(model.quick.request.number)
        time.sleep(0.001)
    steps = np.diff(seen) % 3
    assert (steps == 1).all()  # none left out
    assert 0 < model.shown_rate < 30  # a late frame is made up for by the next


def test_the_filter_decides_what_is_seen(model):
    model.settle()
    light = np.abs(model.picture().field).max()
    share = model.figures.values[0]["efficiency"]
    model.change_filter(half_plane=False)
    model.settle()
    both = model.figures.values[0]["efficiency"]
    assert both == pytest.approx(2 * share, rel=0.05)  # the twin too
    model.change_filter(half_plane=None, aperture=1e-4)
    model.settle()
    assert np.abs(model.picture().field).max() < 0.1 * light


def test_figures(model):
    model.settle()
    figures = model.figures.values[0]
    assert 0 < figures["efficiency"] < figures["blocked"] < 1
    assert figures["contrast"] > 0.5
    model.depth -= 3e-3
    model.settle()
    assert model.figures.values[0]["sharpness"] < figures["sharpness"]
    model.number = 3
    model.settle()
    assert "contrast" not in model.figures.values[0]


@pytest.mark.parametrize("damage", ["missing", "cut", "noise"])
def test_a_bad_frame_is_named_and_the_next_one_is_shown(video, tmp_path, damage, capfd):
    folder = shutil.copytree(video, tmp_path / "bad")
    path = folder / "frame_0002.tif"
    if damage == "missing":
        path.unlink()
    elif damage == "cut":
        path.write_bytes(path.read_bytes()[:20000])
    else:
        path.write_bytes(bytes(range(256)) * 8)
    model = ViewerModel(open_video(folder))
    model.number = 2
    model.settle()
    assert "frame_0002.tif" in model.fault() and "\n" not in model.fault()
    assert len(model.fault()) < 300
    assert model.picture() is None and model.decoded() is None
    model.focus_at(3, 3)  # nothing to focus on, and nothing happens
    model.step()
    model.settle()
    assert model.fault() == "" and model.picture() is not None
    model.close()
    told = capfd.readouterr()
    assert told.out == told.err == ""


def test_views_are_undone_and_redone(model):
    model.settle()
    first = model.snapshot()
    model.number = 2
    model.view.show(10, 20, 3.0)
    model.settle()
    model.look.mode = "phase"
    model.settle()
    assert model.undo() and model.look.mode == "intensity" and model.number == 2
    assert model.undo() and model.snapshot() == first
    assert not model.undo()
    assert model.redo() and model.number == 2 and model.view.zoom == 3.0
    model.depth = 0.055
    model.settle()
    assert not model.redo()  # forgotten by going elsewhere


def test_history_keeps_the_newest():
    history = History(0)
    for i in range(1, 1000):
        history.note(i)
        history.note(i)
    assert history.undo() == 998
    history.note(5)
    assert history.redo() is None and history.undo() == 998


def test_equal_videos_have_no_difference(pair):
    pair.settle()
    held = pair.comparison
    assert held.ssim == 1.0 and held.psnr == np.inf and held.factor == pytest.approx(1)
    assert not held.difference.any()
    assert pair.picture(0).depth == pair.picture(1).depth


def test_ssim_comes_while_hands_move(pair):
    pair.settle()
    for _ in range(200):  # hands that never rest
        pair.depth += 1e-6
        pair._changed_at = time.monotonic()
        pair.update()
        until(pair, lambda: pair.quick.request.subject == pair.request.subject)
        if pair.alike is not None and pair.alike.coarse:
            break
        time.sleep(0.002)
    assert (
        pair.alike.coarse and pair.alike.ssim == pytest.approx(1) and pair.comparison.psnr == np.inf
    )
    pair.settle()
    assert not pair.comparison.coarse and pair.comparison is pair.alike


def test_a_difference_is_measured_apart_from_brightness(model):
    model.settle()
    a = model.picture()
    request = Request(1, model.depth, model.filter)
    brighter = type(a)(1, a.depth, 2 * a.field, a.white, False)
    held = compare(request, (a, brighter), True, PANEL)
    assert held.factor == pytest.approx(0.25) and held.psnr > 100 and held.ssim > 0.999
    noisy = a.light + np.float32(0.1 * a.light.max())
    other = type(a)(1, a.depth, np.sqrt(noisy).astype(np.complex64), a.white, False)
    held = compare(request, (a, other), False, PANEL)
    error = np.mean((noisy * held.factor - a.light) ** 2)
    assert held.psnr == pytest.approx(10 * np.log10(a.light.max() ** 2 / error), abs=0.01)
    assert compare(request, (a, None), True, PANEL) is None


def test_videos_are_compared_within_the_marked_region(video, tmp_path):
    other = shutil.copytree(video, tmp_path / "other")
    levels = read_grey(other / "frame_0001.tif")
    levels[:, 128:] = 128  # half of it shows nothing
    write_grey(other / "frame_0001.tif", levels)
    model = ViewerModel([open_video(video), open_video(other)])
    model.settle()
    whole = model.comparison
    assert whole.region is None and whole.ssim is not None
    model.region = Region((60, 60), (180, 180))
    until(model, lambda: model.comparison.region == model.region)
    a, b = (model.picture(i).light[60:181, 60:181] for i in (0, 1))
    assert model.comparison.psnr == pytest.approx(psnr(b * model.comparison.factor, a), abs=1e-3)
    assert model.comparison.psnr != pytest.approx(whole.psnr, abs=0.1)
    model.region = None
    until(model, lambda: model.comparison.region is None)
    assert model.comparison.psnr == pytest.approx(whole.psnr)
    model.close()


def test_videos_of_other_panels_or_frames_are_not_compared(video, tmp_path):
    folder = shutil.copytree(video, tmp_path / "other")
    manifest = folder / "manifest.json"
    text = manifest.read_text()
    manifest.write_text(text.replace('"width": 256', '"width": 128'))
    with pytest.raises(ValueError, match="128 × 256 pixels"):
        ViewerModel([open_video(video), open_video(folder)])
    for number in (1, 2, 3):
        text = text.replace(f'"number": {number},', f'"number": {number + 10},')
    manifest.write_text(text)
    with pytest.raises(ValueError, match="no frame in common"):
        ViewerModel([open_video(video), open_video(folder)])
