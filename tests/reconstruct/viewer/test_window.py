"""The window on a real X server, with real mouse and keys."""

import contextlib
import json
import os
import queue
import random
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

DRIVER = """
import json, sys, time
from reconstruct.viewer.sources import open_source
from reconstruct.viewer.window import ViewerWindow
window = ViewerWindow([open_source(path) for path in sys.argv[1:]])
from imgui_bundle import imgui
import glfw
longest = 0.0
def tell():
    session, model = window.session, window.session.model
    pane = window.layout.panes[0]
    picture, found = model.picture(), model.found
    print(json.dumps({
        "number": model.number, "depth": model.depth, "zoom": pane.view.scale,
        "mode": model.look.mode, "playing": model.playing,
        "focused": None if found is None else found.focus.focused, "follow": model.follow,
        "shown": None if picture is None else [picture.number, picture.depth, picture.coarse],
        "origin": pane.origin, "size": [pane.view.screen_width, pane.view.screen_height],
        "centre": [pane.view.x, pane.view.y], "resting": model.resting and not window._lively > 0,
        "help": session.help, "line": model.line and model.line.length(8.1e-6),
        "listed": imgui.is_popup_open("", int(imgui.PopupFlags_.any_popup)),
        "tool": session.tool, "asking": session.asking, "typing": imgui.get_io().want_text_input,
        "source": str(model.video.folder), "path": session.path,
        "region": model.region and [model.region.corner, model.region.opposite],
        "message": session.told, "fault": model.fault(), "compared": model.mode,
        "wipe": model.wipe, "longest": longest}), flush=True)
while not glfw.window_should_close(window._handle):
    window.wait()
    start = time.perf_counter()
    window.draw()
    longest = max(longest, time.perf_counter() - start)
    tell()
error = window.context.error
window.close()
print(json.dumps({"error": error}), flush=True)
"""


def program(name, package):
    path = shutil.which(name)
    if path is None:
        pytest.fail(f"{name} is missing: install the Debian package {package}")
    return path


@pytest.fixture(scope="module")
def display(tmp_path_factory):
    log = tmp_path_factory.mktemp("xvfb") / "log"
    read, write = os.pipe()
    command = [program("Xvfb", "xvfb"), "-screen", "0", "1600x950x24"]
    free = f":{random.randrange(50_000, 59_000)}"  # also in a chroot: see tests/display/conftest.py
    command += [free, "-nolisten", "tcp", "-nolisten", "local", "-noreset"]
    with log.open("wb") as output:
        server = subprocess.Popen(
            [*command, "-displayfd", str(write)], pass_fds=[write], stdout=output, stderr=output
        )
    os.close(write)
    with os.fdopen(read) as answer:
        number = answer.readline().strip()
    if not number:
        pytest.fail(f"Xvfb does not start: {log.read_text()[-500:]}")
    yield f":{number}"
    server.terminate()
    server.wait()


class Driven:
    """A running viewer, its states as it tells them, and hands."""

    def __init__(self, display, where, *folders):
        kept = {k: v for k, v in os.environ.items() if k != "WAYLAND_DISPLAY"}
        own = {
            "DISPLAY": display,
            "XDG_SESSION_TYPE": "x11",
            "LIBGL_ALWAYS_SOFTWARE": "1",
            "XDG_STATE_HOME": str(where / "state"),
        }
        self.environment = kept | own
        self.process = subprocess.Popen(
            [sys.executable, "-c", DRIVER, *[str(f) for f in folders]],
            env=self.environment, cwd=where, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            text=True,
        )  # fmt: skip
        self.lines = queue.SimpleQueue()
        threading.Thread(target=self._listen, daemon=True).start()
        self.state = {}

    def _listen(self):
        for line in self.process.stdout:
            self.lines.put(json.loads(line))

    def until(self, what, seconds=240):
        """Read states until one fits."""
        end = time.monotonic() + seconds
        while True:
            if self.state and what(self.state):
                return self.state
            try:
                self.state = self.lines.get(timeout=0.2)
            except queue.Empty:
                if time.monotonic() > end or self.process.poll() is not None:
                    tail = ""
                    if self.process.poll() is not None:
                        tail = self.process.stderr.read()[-800:]
                    pytest.fail(f"never: last state {self.state} {tail}")

    def hands(self, *arguments):
        subprocess.run(
            [program("xdotool", "xdotool"), *[str(a) for a in arguments]],
            env=self.environment, check=True, timeout=120,
        )  # fmt: skip

    def key(self, name):
        self.hands("key", name)

    def at(self, row, column):
        """Screen place of a pixel of the reconstruction."""
        s = self.state
        x = (column + 0.5 - s["centre"][0]) * s["zoom"] + s["size"][0] / 2 + s["origin"][0]
        y = (row + 0.5 - s["centre"][1]) * s["zoom"] + s["size"][1] / 2 + s["origin"][1]
        return round(x), round(y)

    def screenshot(self):
        shot = subprocess.run(
            [program("import", "imagemagick"), "-window", "root", "-depth", "8", "rgb:-"],
            env=self.environment, capture_output=True, check=True, timeout=120,
        )  # fmt: skip
        return np.frombuffer(shot.stdout, dtype=np.uint8).reshape(950, 1600, 3)


@pytest.fixture
def start(display, tmp_path):
    """Starts a viewer on folders, and waits for its first pictures."""
    pytest.importorskip("imgui_bundle", reason="chrmc[viewer] is optional")
    running = []

    def start_one(*folders):
        running.append(Driven(display, tmp_path, *folders))
        running[-1].until(lambda s: s["resting"])
        return running[-1]

    yield start_one
    for driven in running:
        with contextlib.suppress(Exception):
            driven.process.kill()
        driven.process.wait()


def leave(viewer):
    viewer.key("q")
    last = viewer.until(lambda s: "error" in s)
    assert last["error"] == "GL_NO_ERROR"
    assert viewer.process.wait(240) == 0
    assert viewer.process.stderr.read() == ""


def test_hands_and_keys(start, video, tmp_path):
    viewer = start(video)
    manifest = json.loads(Path(video, "manifest.json").read_text())
    x, y, z = manifest["frames"][0]["objects"][0]["position"]
    place = (round(y / 8.1e-6 + 127.5), round(x / 8.1e-6 + 127.5))

    # The picture is there: bright where the object is, dark beside it.
    sx, sy = viewer.at(*place)
    shot = viewer.screenshot().astype(float)
    there = shot[sy - 30 : sy + 30, sx - 30 : sx + 30].mean()
    elsewhere = shot[sy - 30 : sy + 30, sx + 160 : sx + 220].mean()
    assert there > elsewhere + 20

    # Slider: drag away from the focus; the first picture comes while dragging.
    viewer.hands("mousemove", 30, 258, "mousedown", 1)
    viewer.hands("mousemove", 90, 258)
    moved = viewer.until(lambda s: abs(s["depth"] - z) > 1e-3)
    viewer.hands("mousemove", 160, 258)
    viewer.until(lambda s: abs(s["depth"] - moved["depth"]) > 1e-3)
    viewer.until(lambda s: s["shown"][2] and s["shown"][1] == s["depth"])
    viewer.hands("mouseup", 1)
    viewer.until(lambda s: s["resting"] and not s["shown"][2])

    # A click on the object focuses on it.
    viewer.hands("mousemove", *viewer.at(*place), "sleep", "0.1", "click", 1)
    viewer.until(lambda s: s["focused"] and abs(s["depth"] - z) < 3e-4)

    # Wheel: zoom, what is under the cursor stays there.
    before = viewer.state["zoom"]
    sx, sy = viewer.at(*place)
    viewer.hands("mousemove", sx, sy, "click", 4, "sleep", "0.1", "click", 4)
    viewer.until(lambda s: s["zoom"] > 1.4 * before)
    again = viewer.at(*place)
    assert abs(again[0] - sx) <= 2 and abs(again[1] - sy) <= 2

    # Drag: the picture moves with the hand, and nothing is focused anew.
    depth, centre = viewer.state["depth"], viewer.state["centre"]
    viewer.hands("mousemove", sx, sy, "mousedown", 1)
    for step in (10, 25, 40):
        viewer.hands("mousemove", sx + step, sy)
    viewer.hands("mouseup", 1)
    viewer.until(lambda s: abs((centre[0] - s["centre"][0]) * s["zoom"] - 40) < 2)
    assert viewer.state["depth"] == depth
    viewer.key("f")
    viewer.until(lambda s: s["zoom"] == pytest.approx(before))

    # Keys: frames, depth, modes, play, save.
    viewer.key("Right")
    viewer.until(lambda s: s["number"] == 2 and s["focused"] is None)
    viewer.key("Left")
    viewer.until(lambda s: s["number"] == 1)
    viewer.key("Up")
    viewer.until(lambda s: s["depth"] == pytest.approx(depth + 1e-4))
    viewer.key("3")
    viewer.until(lambda s: s["mode"] == "phase" and s["resting"])
    shot = viewer.screenshot().astype(int)
    sx, sy = viewer.at(*place)
    part = shot[sy - 30 : sy + 30, sx - 30 : sx + 30]
    assert np.abs(part[..., 0] - part[..., 1]).mean() > 10  # colours
    viewer.key("1")
    viewer.key("space")
    viewer.until(lambda s: s["playing"])
    viewer.until(lambda s: s["number"] == 3)
    viewer.key("space")
    viewer.until(lambda s: not s["playing"])
    viewer.key("s")
    end = time.monotonic() + 240
    while not list(tmp_path.glob("frame_*.png")):
        assert time.monotonic() < end, "no picture saved"
        time.sleep(0.1)
    leave(viewer)


def test_escape_closes_what_is_open_and_never_the_window(start, video):
    viewer = start(video)
    viewer.hands("mousemove", 123, 22, "sleep", "0.2", "click", 1)  # Save
    viewer.until(lambda s: s["listed"])
    viewer.key("Escape")
    viewer.until(lambda s: not s["listed"])
    viewer.key("h")
    viewer.until(lambda s: s["help"])
    viewer.key("Escape")
    viewer.until(lambda s: not s["help"])
    viewer.key("Escape")
    viewer.key("Right")
    viewer.until(lambda s: s["number"] == 2)
    viewer.key("ctrl+z")
    viewer.until(lambda s: s["number"] == 1)
    leave(viewer)


@pytest.mark.long
def test_a_path_is_typed_to_open_another_video(start, video, tmp_path):
    other = shutil.copytree(video, tmp_path / "other")
    viewer = start(video)
    viewer.key("ctrl+o")
    viewer.until(lambda s: s["asking"] and s["typing"])
    viewer.hands("type", "--delay", "20", str(tmp_path / "nowhere"))
    viewer.key("Return")
    viewer.until(lambda s: "nowhere" in s["message"])
    assert viewer.state["asking"] and viewer.state["number"] == 1
    viewer.key("Escape")
    viewer.until(lambda s: not s["asking"])
    viewer.key("ctrl+o")
    viewer.until(lambda s: s["asking"] and s["typing"])
    viewer.hands("type", "--delay", "20", str(other))  # in place of what was there
    viewer.key("Return")
    viewer.until(lambda s: s["source"] == str(other) and not s["asking"] and s["resting"])
    leave(viewer)


# A file manager's side of a drop (freedesktop.org, XDND 5): enter, position, drop, and the list of
# files when the window asks for it.
DROP = """
import sys
from pathlib import Path
from Xlib import X, display
from Xlib.protocol import event
d = display.Display()
root, atom = d.screen().root, d.intern_atom
wanted, folder = sys.argv[1], Path(sys.argv[2]).as_uri() + "\\r\\n"

def below(window):
    if wanted in (window.get_wm_name() or "") and window.get_wm_class():
        return window
    return next((w for child in window.query_tree().children if (w := below(child))), None)

target = below(root)
ours = root.create_window(0, 0, 1, 1, 0, X.CopyFromParent)
uris = atom("text/uri-list")
ours.set_selection_owner(atom("XdndSelection"), X.CurrentTime)

def tell(name, *values):
    data = (32, [ours.id, *values, *[0] * (4 - len(values))])
    target.send_event(event.ClientMessage(window=target, client_type=atom(name), data=data))
    d.flush()

tell("XdndEnter", 5 << 24, uris)
tell("XdndPosition", 0, 400 << 16 | 300, X.CurrentTime, atom("XdndActionCopy"))
while True:
    got = d.next_event()
    if got.type == X.SelectionRequest:
        got.requestor.change_property(got.property, uris, 8, folder.encode())
        got.requestor.send_event(event.SelectionNotify(
            time=got.time, requestor=got.requestor, selection=got.selection,
            target=got.target, property=got.property))
        d.flush()
    elif got.type == X.ClientMessage and got.client_type == atom("XdndStatus"):
        assert got.data[1][1] & 1, "not taken"
        tell("XdndDrop", 0, X.CurrentTime)
    elif got.type == X.ClientMessage and got.client_type == atom("XdndFinished"):
        break
"""


def test_a_folder_that_is_dropped_opens(start, video, tmp_path):
    other = shutil.copytree(video, tmp_path / "other folder")
    viewer = start(video)
    done = subprocess.run(
        [sys.executable, "-c", DROP, "chrmc", str(other)],
        env=viewer.environment, capture_output=True, text=True, timeout=240,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    viewer.until(lambda s: s["source"] == str(other) and s["resting"])
    leave(viewer)


def test_marks_are_drawn_with_the_hand(start, video):
    viewer = start(video)
    viewer.key("l")
    viewer.until(lambda s: s["tool"] == "line")
    a, b = viewer.at(60, 60), viewer.at(60, 160)
    viewer.hands("mousemove", *a, "mousedown", 1)
    viewer.hands("mousemove", (a[0] + b[0]) // 2, a[1], "sleep", "0.1", "mousemove", *b)
    viewer.until(lambda s: s["line"] and abs(s["line"] - 100 * 8.1e-6) < 2 * 8.1e-6)
    viewer.hands("mouseup", 1)
    viewer.key("Escape")  # the tool is put away
    viewer.key("Escape")  # the mark is dropped
    viewer.until(lambda s: s["line"] is None)
    viewer.key("r")
    viewer.until(lambda s: s["tool"] == "region")
    viewer.hands("mousemove", *a, "mousedown", 1)
    viewer.hands("mousemove", b[0], b[1] + 60, "sleep", "0.1", "mouseup", 1)
    state = viewer.until(lambda s: s["region"])
    assert abs(state["region"][1][1] - state["region"][0][1]) == pytest.approx(100, abs=2)
    viewer.key("Right")
    viewer.until(lambda s: s["number"] == 2 and s["resting"])
    leave(viewer)


def test_two_videos_beside_each_other_and_a_bad_frame_between(start, video, tmp_path):
    other = shutil.copytree(video, tmp_path / "other")
    (other / "frame_0002.tif").unlink()
    viewer = start(video, other)
    assert viewer.state["compared"] == "side by side"
    beside = viewer.state["size"][0]
    viewer.key("w")
    viewer.until(lambda s: s["compared"] == "wipe" and s["resting"] and s["size"][0] > 1.5 * beside)
    (left, top), (wide, tall) = viewer.state["origin"], viewer.state["size"]
    middle = round(left + wide / 2), round(top + tall / 2)
    viewer.hands("mousemove", *middle, "sleep", "0.2", "mousedown", 1, "sleep", "0.2")
    viewer.hands("mousemove", middle[0] + 150, middle[1], "sleep", "0.2", "mouseup", 1)
    viewer.until(lambda s: s["wipe"] == pytest.approx(0.5 + 150 / wide, abs=0.02))
    for mode in ("difference", "A", "B"):
        viewer.key("w")
        viewer.until(lambda s, mode=mode: s["compared"] == mode)
    viewer.key("Tab")
    viewer.key("Right")
    viewer.until(lambda s: s["number"] == 2 and s["shown"][0] == 2)
    viewer.key("w")
    viewer.key("Right")
    viewer.until(lambda s: s["number"] == 3 and s["resting"])
    leave(viewer)


def test_no_display_is_one_line(video):
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    code = "from chrmc.cli.main import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code, "view", str(video)],
        env=environment, capture_output=True, text=True, timeout=240,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1 and "display" in done.stderr
