"""What is drawn, without a window: room for the controls, grounds under words, whose thread."""

import threading

import pytest

from chrmc.store.video import open_video
from reconstruct.viewer import pipeline
from reconstruct.viewer.session import Session
from reconstruct.viewer.shade import Look
from reconstruct.viewer.view import View

pytest.importorskip("imgui_bundle", reason="chrmc[viewer] is optional")

from imgui_bundle import imgui

from reconstruct.viewer import overlays, theme
from reconstruct.viewer.layout import Layout
from reconstruct.viewer.panes import Pane


@pytest.fixture
def gui():
    """`gui(scale, size)`: Dear ImGui as the window sets it up; the font of headings."""

    def set_up(scale, size):
        imgui.create_context()
        io = imgui.get_io()
        io.set_ini_filename("")
        io.backend_flags |= int(imgui.BackendFlags_.renderer_has_textures)
        io.display_size, io.delta_time = imgui.ImVec2(*size), 1 / 60
        return theme.apply(scale)

    yield set_up
    imgui.destroy_context()


def draw(layout, session, size, times=3):
    for _ in range(times):  # sizes of what is new are known at the second
        imgui.new_frame()
        layout.draw(session, float(size[0]), float(size[1]), 1.0)
        imgui.render()


@pytest.mark.parametrize(("scale", "size"), [(1, (1280, 720)), (2, (2560, 1440))])
@pytest.mark.parametrize("compared", [False, True])
def test_controls_need_no_scrolling_and_cut_no_words(
    context, gui, video, tmp_path, monkeypatch, scale, size, compared
):
    videos = [open_video(video)] * (2 if compared else 1)
    session = Session(videos, folder=tmp_path, recent_file=tmp_path / "r.json")
    session.model.settle()
    cut, words = [], set()

    def watched(made, text_of):
        def call(*arguments):
            answer = made(*arguments)
            text = text_of(*arguments)
            room = imgui.get_item_rect_size().x - 2 * imgui.get_style().frame_padding.x
            words.add(text)
            if imgui.calc_text_size(text).x > room + 1:
                cut.append(text)
            return answer

        return call

    monkeypatch.setattr(imgui, "button", watched(imgui.button, lambda t, *_: t.split("##")[0]))
    typed = watched(imgui.input_float, lambda name, value, a, b, form, *_: form % value)
    monkeypatch.setattr(imgui, "input_float", typed)
    layout = Layout(context, gui(scale, size))
    session.model.look.stops = -4.5
    for marks in (False, True):
        session.show_marks = marks
        draw(layout, session, size)
        controls = imgui.internal.find_window_by_name("controls")
        assert not controls.scrollbar_x and not controls.scrollbar_y
        assert controls.content_size.x <= controls.size.x
    assert not cut and {"Play", "+0.1", "curves"} <= words
    assert compared or "-4.5 EV" in words
    session.model.close()


def test_nothing_is_computed_where_it_is_drawn(context, gui, video, tmp_path, monkeypatch):
    ours, threads = threading.get_ident(), {}

    def watched(name):
        made = getattr(pipeline, name)

        def call(*arguments):
            threads.setdefault(name, set()).add(threading.get_ident())
            return made(*arguments)

        monkeypatch.setattr(pipeline, name, call)

    for name in ("coarse_field", "intensity", "exposure", "shrunk"):
        watched(name)
    session = Session(open_video(video), folder=tmp_path, recent_file=tmp_path / "r.json")
    layout = Layout(context, gui(1, (1500, 900)))
    draw(layout, session, (1500, 900))
    session.model.settle()
    draw(layout, session, (1500, 900))
    for name in ("Right", "Up", "3"):
        session.press(name)
        session.model.settle()
        draw(layout, session, (1500, 900))
    session.model.close()
    assert set(threads) == {"coarse_field", "intensity", "exposure", "shrunk"}
    assert all(ours not in found for found in threads.values())


class Drawn:
    """A draw list that keeps what it is told."""

    def __init__(self):
        self.grounds, self.words = [], []

    def add_rect_filled(self, low, high, shade, *_):
        self.grounds.append((low.x, low.y, high.x, high.y, shade & 0xFFFFFF))

    def add_text(self, place, shade, words):
        end = imgui.calc_text_size(words)
        box = (place.x, place.y, place.x + end.x, place.y + end.y)
        under = [
            g for g in self.grounds
            if g[0] <= box[0] and g[1] <= box[1] and g[2] >= box[2] and g[3] >= box[3]
        ]  # fmt: skip
        dark = max(under[-1][4] >> shift & 0xFF for shift in (0, 8, 16)) < 60 if under else False
        self.words.append((words, dark))

    def __getattr__(self, name):
        return lambda *arguments, **named: None


def test_words_over_pictures_stand_on_a_dark_ground_and_phases_have_their_legend(gui):
    gui(1, (1500, 900))
    imgui.new_frame()
    pane = Pane("Reconstruction", View(1920, 1200))
    pane.view.resize(900, 500)
    drawn = Drawn()
    overlays.scale_bar(pane, drawn, 8.1e-6)
    overlays.colour_bar(pane, drawn, Look("phase"), 1.0, (0.0, 2.0), False)
    overlays.colour_bar(pane, drawn, Look(), 1.0, (0.0, 2.0), False)
    overlays.busy(pane, drawn, "focus curve of car", 0.5)
    imgui.render()
    words = [w for w, _ in drawn.words]
    assert words[0].endswith("mm") and {"−π", "0", "π", "focus curve of car"} <= set(words)
    assert "0 … 2" in words and all(dark for _, dark in drawn.words), drawn.words
