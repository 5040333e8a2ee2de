"""What keys and buttons do, and the files that come of it."""

import json
import shutil
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from chrmc.store.video import open_video
from reconstruct.animation import movies_there
from reconstruct.images import read_image
from reconstruct.viewer import saving
from reconstruct.viewer.keys import KEYS
from reconstruct.viewer.measure import Region
from reconstruct.viewer.recent import note_recent, read_recent
from reconstruct.viewer.session import SAVES, Session
from reconstruct.viewer.shade import shade
from reconstruct.viewer.sources import open_source, titles_of


@pytest.fixture
def session(video, tmp_path):
    made = Session(open_video(video), folder=tmp_path, recent_file=tmp_path / "state" / "r.json")
    made.model.settle()
    yield made
    made.model.close()


def wait_for(session, first, last=""):
    """Update until a message begins and ends with these words."""
    end = time.monotonic() + 240
    while not (session.message.startswith(first) and session.message.endswith(last)):
        assert time.monotonic() < end, session.message
        time.sleep(0.005)
        session.update()


def test_every_key_does_something_that_there_is(session):
    names = [k.name for k in KEYS]
    assert len(set(names)) == len(names)
    for key in KEYS:
        assert callable(getattr(session, key.action)), key
        assert session.press(key.name)
    assert session.leaving and not session.press("F12")


def test_keys_change_frame_and_depth(session):
    model = session.model
    for name, number in (("Right", 2), ("Left", 1), ("End", 3), ("Home", 1), ("Left", 3)):
        session.press(name)
        assert model.number == number
    session.press("Home")
    model.depth = depth = 0.06
    model.follow = "cluster"
    for name, step in (("Up", 1e-4), ("Down", 0), ("PageUp", 1e-3), ("PageDown", 0)):
        session.press(name)
        assert model.depth == pytest.approx(depth + step) and model.follow is None
    session.press("O")
    assert model.depth == float(model.objects()[0].position[2])


def test_escape_closes_one_thing_after_the_other_and_never_leaves(session):
    session.press("H")
    session.press("L")
    session.press("Escape")
    assert not session.help and session.tool == "line"
    session.press("Escape")
    assert session.tool == "focus"
    for _ in range(3):
        session.press("Escape")
    assert not session.leaving


def test_a_saved_picture_is_what_is_seen_and_tells_how_it_was_made(session, tmp_path):
    model = session.model
    model.look.mode, model.look.colours, model.look.stops = "log", "magma", 1.0
    model.change_filter(aperture=4e-3)
    model.settle()
    session.press("S")
    wait_for(session, "saved", ".png")
    path = next(tmp_path.glob("frame_0001*.png"))
    red, note = read_image(path)
    want = shade(model.picture().field, model.picture().white, model.look)
    assert np.array_equal(red, want[..., 0])
    assert note["frame"] == 1 and note["depth"] == model.depth and note["aperture"] == 4e-3
    assert (note["mode"], note["colours"], note["stops"]) == ("log", "magma", 1.0)
    assert note["wavelength"] == 532e-9 and note["encoding"] == "ssb"
    session.press("E")
    wait_for(session, "saved", ".exr")
    values, note = read_image(next(tmp_path.glob("*.exr")))
    assert np.allclose(values, model.picture().light, rtol=1e-5) and note["frame"] == 1


def test_all_kinds_of_files_are_saved_one_after_the_other(session, tmp_path, monkeypatch):
    monkeypatch.setattr("reconstruct.viewer.saving.STACK_COUNT", 8)
    session.model.look.mode = "phase"
    session.model.depth_range = (0.058, 0.062)
    session.model.follow = "cluster"
    kinds = [s for s in SAVES if movies_there() or not s[1].endswith("mp4")]
    for _, ending, kind in kinds:
        session.save(ending, kind)
    end = time.monotonic() + 240
    while session.model.busy:
        assert time.monotonic() < end
        time.sleep(0.01)
        session.update()
    found = {p.name for p in tmp_path.iterdir() if p.is_file()}
    assert len(found) == len(kinds)
    svg = next(tmp_path.glob("*.svg")).read_text()
    assert "frame: 1" in svg and "wavelength: 532 nm" in svg
    assert next(tmp_path.glob("*.pdf")).read_bytes()[:4] == b"%PDF"
    from PIL import Image

    with Image.open(next(tmp_path.glob("*_frames.gif"))) as movie:
        assert movie.n_frames == 3
        kept = json.loads(movie.info["comment"])
        assert kept["frame"] == [1, 2, 3] and len(kept["depth"]) == 3 and kept["mode"] == "phase"
    for movie_ in tmp_path.glob("*.mp4"):
        assert movie_.stat().st_size > 1000
    assert not list(tmp_path.glob(".*partial*"))


def test_who_leaves_while_a_picture_is_written_has_it(session, tmp_path, monkeypatch):
    writing, write = threading.Event(), saving.write_colour

    def slowly(*arguments):
        writing.set()
        time.sleep(0.7)
        write(*arguments)

    monkeypatch.setattr(saving, "write_colour", slowly)
    session.press("S")
    assert writing.wait(240)
    session.model.close()
    (picture,) = tmp_path.glob("*.png")
    assert read_image(picture)[0].shape[:2] == session.model.video.slm.shape
    assert not list(tmp_path.glob(".*partial*"))


def test_a_marked_region_is_measured_in_what_is_shown(session):
    model = session.model
    assert session.statistics() is None
    model.region = Region((100, 90), (150, 170))
    found = session.statistics()
    part = model.picture().light[100:151, 90:171]
    assert found.most == part.max() and found.mean == pytest.approx(part.mean(dtype=float))
    assert session.statistics() is found
    model.step()
    model.settle()
    assert session.statistics() is not found


def test_a_difference_is_saved_with_what_was_measured(video, tmp_path):
    session = Session([open_video(video), open_video(video)], folder=tmp_path)
    session.model.mode = "difference"
    session.press("S")
    assert "not" in session.message or "yet" in session.message
    session.model.settle()
    session.press("E")
    wait_for(session, "saved", ".exr")
    values, note = read_image(next(tmp_path.glob("*_less_*.exr")))
    assert not values.any() and note["ssim"] == 1 and note["psnr"] is None
    session.press("S")
    wait_for(session, "saved", ".png")
    session.model.close()


def test_a_folder_that_cannot_be_written_is_told(session, tmp_path):
    session.folder = tmp_path / "file"
    session.folder.write_text("")
    session.press("S")
    wait_for(session, "[Errno")
    assert "file" in session.message
    session.model.settle()


def test_opening_another_and_what_cannot_be_opened(session, video, tmp_path):
    model = session.model
    assert not session.open(tmp_path / "nowhere")
    assert "nowhere" in session.message and session.model is model
    assert session.open(video / "manifest.json")
    assert session.model is not model and session.recent() == [video.resolve()]
    session.model.settle()


def test_a_list_of_what_was_opened_that_is_damaged_is_begun_anew(video, tmp_path):
    for damaged in ("[" * 100_000, "{", "3", '["a\\u0000", null]'):
        (tmp_path / "r.json").write_text(damaged)
        note_recent(tmp_path / "r.json", video)
        assert read_recent(tmp_path / "r.json") == [video.resolve()]


def test_any_picture_opens_as_its_panel_says(video, tmp_path):
    from chrmc import SLM

    path = video / "frame_0001.tif"
    with pytest.raises(ValueError, match=r"256 × 256 pixels.*--slm 256x256:PITCH"):
        open_source(path)
    one = open_source(path, SLM("small", 256, 256, 8.1e-6), 633e-9, "real")
    assert one.numbers == [1] and one.wavelength == 633e-9 and one.encoding == "real"
    assert np.array_equal(one.read(1), open_video(video).read(1))
    session = Session(one, folder=tmp_path, recent_file=tmp_path / "r.json")
    assert session.title == "frame_0001.tif - chrmc"
    assert session.recent() == [path.resolve()]
    session.model.start(None, 0.06, None)
    assert session.model.depth_range == (0.03, 0.12)
    session.model.settle()
    assert session.model.picture().light.max() > 0
    session.press("O")
    assert "no objects" in session.message
    session.model.close()
    with pytest.raises(ValueError, match="leave out --wavelength"):
        open_source(video, wavelength=633e-9)


def test_recent_ones_are_few_and_there(tmp_path):
    file = tmp_path / "deep" / "recent.json"
    folders = [tmp_path / f"v{i}" for i in range(14)]
    for folder in folders:
        folder.mkdir()
        note_recent(file, folder)
    note_recent(file, folders[5])
    found = read_recent(file)
    assert found[0] == folders[5] and len(found) == 10 == len(set(found))
    folders[5].rmdir()
    assert folders[5] not in read_recent(file)
    file.write_text("{not json")
    assert read_recent(file) == []
    file.write_text(json.dumps({"a": 1}))
    note_recent(file, Path(folders[0]))
    assert read_recent(file) == [folders[0]]


def test_two_folders_of_one_name_are_told_apart(video, tmp_path):
    folders = [shutil.copytree(video, tmp_path / which / "video") for which in ("before", "after")]
    two = [open_source(folder) for folder in folders]
    assert titles_of(two) == ["before/video", "after/video"]
    assert titles_of([two[0], open_source(video)]) == ["video", Path(video).name]
    assert titles_of(two[:1]) == ["video"]
