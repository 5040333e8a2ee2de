"""The window lands on its monitor, pixel for pixel, whichever window manager runs."""

import csv
import json
import signal
import subprocess
import sys

import numpy as np
import pytest

from chrmc.pictures import read_grey
from chrmc.slm import SLM

RIGHT, LEFT = SLM("right", 640, 480, 8e-6), SLM("left", 800, 600, 8e-6)
ALWAYS = ["metacity", "openbox"]
WHERE_INSTALLED = ["mutter", "fluxbox", "xfwm4", "icewm", "kwin_x11", "i3", "twm"]


def part(server, slm):
    """What the root window shows where the SLM's monitor is."""
    shot = server.screenshot()
    return shot[: slm.height, :800] if slm is LEFT else shot[: slm.height, 800:1440]


def shows(server, slm, frame):
    return np.array_equal(part(server, slm), frame[:, :, None].repeat(3, axis=2))


def picture(video_maker, folder, slm):
    path = video_maker(folder, slm, 1) / "frame_0001.tif"
    return path, read_grey(path)


def play(server, path, slm, *more):
    size = f"{slm.width}x{slm.height}:{slm.pixel_pitch}"
    return server.start("play", str(path), "--slm", size, *more)


def finish(player):
    player.send_signal(signal.SIGTERM)
    output, errors = player.communicate(timeout=240)
    assert "Traceback" not in errors, errors
    return output, errors


def lands_and_stays(server, tmp_path, video_maker, slm, name):
    """Whole on its monitor, nothing on the other, also after the focus goes elsewhere."""
    other = LEFT if slm is RIGHT else RIGHT
    path, frame = picture(video_maker, tmp_path / slm.name, slm)
    log = tmp_path / f"{slm.name}.csv"
    player = play(server, path, slm, "--log", str(log))
    try:
        server.until(lambda: shows(server, slm, frame), player)
        rows, columns = (min(a, b) for a, b in zip(slm.shape, other.shape, strict=True))
        elsewhere = part(server, other)[:rows, :columns, 0]
        assert (elsewhere == frame[:rows, :columns]).mean() < 0.05  # clocks and docks may change
        before = part(server, other)
        x = 100 if other is LEFT else 900
        visitor = server.run_beside("xmessage", "-geometry", f"120x60+{x}+100", "elsewhere")
        try:
            server.until(lambda: not np.array_equal(part(server, other), before), player)
            server.run("xdotool", "mousemove", str(x + 30), "130", "click", "1")
            server.until(lambda: shows(server, slm, frame), player)
            server.until(lambda: log.read_text().endswith(",ok\n"), player)
        finally:
            visitor.kill()
            visitor.wait()
    finally:
        _, errors = finish(player)
    rows = list(csv.DictReader(log.open()))
    # A visitor may pass over the panel on its way to the place that its manager gives it.
    assert rows and {r["place"] for r in rows} <= {"ok", "covered"}, (name, errors)
    assert name not in ALWAYS or {r["place"] for r in rows} == {"ok"}, (name, errors)
    facts = json.loads(log.with_suffix(".json").read_text())
    assert facts["monitor"]["width"] == slm.width and facts["monitor"]["name"].startswith("DUMMY")
    assert {"utc", "versions", "reported_refresh_hz", "measured_refresh_hz"} <= set(facts)
    return facts


@pytest.mark.parametrize("slm", [LEFT, RIGHT], ids=["main", "panel"])
@pytest.mark.parametrize("managed", ALWAYS, indirect=True)
def test_the_window_lands_on_its_monitor_and_stays(managed, tmp_path, video_maker, slm):
    server, name = managed
    facts = lands_and_stays(server, tmp_path, video_maker, slm, name)
    assert facts["window_manager"].lower().startswith(name[:4])
    assert not [note for note in facts["notes"] if "warning" in note]
    assert any("composes the desktop" in note for note in facts["notes"]) == (name == "metacity")


@pytest.mark.long
@pytest.mark.parametrize("managed", WHERE_INSTALLED, indirect=True)
def test_other_window_managers(managed, tmp_path, video_maker):
    server, name = managed
    for slm in (LEFT, RIGHT):
        lands_and_stays(server, tmp_path, video_maker, slm, name)


def test_without_a_window_manager_it_stays(two_monitors, tmp_path, video_maker):
    facts = lands_and_stays(two_monitors, tmp_path, video_maker, RIGHT, "none")
    assert facts["window_manager"] == "none"


def test_a_window_over_the_panel_is_logged(two_monitors, tmp_path, video_maker):
    path, frame = picture(video_maker, tmp_path / "video", RIGHT)
    log = tmp_path / "log.csv"
    player = play(two_monitors, path, RIGHT, "--log", str(log))
    try:
        two_monitors.until(lambda: shows(two_monitors, RIGHT, frame), player)
        visitor = two_monitors.run_beside("xmessage", "-geometry", "120x60+900+100", "over it")
        try:
            two_monitors.until(lambda: ",covered" in log.read_text(), player)
        finally:
            visitor.kill()
            visitor.wait()
        two_monitors.until(lambda: log.read_text().endswith(",ok\n"), player)
        two_monitors.press("Escape", window_of(two_monitors))
        output, errors = player.communicate(timeout=240)
    finally:
        player.kill()
    assert player.returncode == 1, errors
    assert "did NOT show the whole window" in output
    assert "the panel's window is covered by 'xmessage'" in errors


def window_of(server):
    return server.run("xdotool", "search", "--onlyvisible", "--class", "chrmc").split()[0]


@pytest.mark.parametrize("managed", ["openbox"], indirect=True)
def test_a_window_moved_away_is_logged(managed, tmp_path, video_maker):
    server, _ = managed
    path, frame = picture(video_maker, tmp_path / "video", RIGHT)
    log = tmp_path / "log.csv"
    player = play(server, path, RIGHT, "--log", str(log))
    try:
        server.until(lambda: shows(server, RIGHT, frame), player)
        server.run("wmctrl", "-x", "-r", "chrmc", "-b", "remove,fullscreen")
        server.until(lambda: ",moved" in log.read_text(), player)
        server.run("wmctrl", "-x", "-r", "chrmc", "-b", "add,fullscreen")
    finally:
        finish(player)


def test_a_window_manager_that_will_not_is_refused(two_monitors, tmp_path, video_maker):
    """One that answers no request, not even for a window it does not manage."""
    path, _ = picture(video_maker, tmp_path / "video", RIGHT)
    stubborn = two_monitors.run_beside(sys.executable, "-c", STUBBORN)
    try:
        check = ("xprop", "-root", "_NET_SUPPORTING_WM_CHECK")
        two_monitors.until(lambda: "window id" in two_monitors.run(*check), stubborn)
        size = f"{RIGHT.width}x{RIGHT.height}:{RIGHT.pixel_pitch}"
        player = subprocess.Popen(
            [sys.executable, "-c", IMPATIENT, "play", str(path), "--slm", size],
            env=two_monitors.environment, text=True, stderr=subprocess.PIPE,
        )  # fmt: skip
        _, errors = player.communicate(timeout=240)
    finally:
        stubborn.kill()
        stubborn.wait()
    assert player.returncode == 2, errors
    lines = [line for line in errors.strip().splitlines() if not line.startswith("warning")]
    assert len(lines) == 1, errors
    assert "window manager Stubborn" in lines[0] and "(33, 44)" in lines[0] and "800, 0" in lines[0]


# Gives the manager half a second, twice, where users' players give it eight.
IMPATIENT = """
import display.placement
from chrmc.cli.main import main
display.placement._PATIENCE = 0.5
main()
"""

# Puts every window at (33, 44), and those that it is told to leave alone back there too.
STUBBORN = """
import time
from Xlib import X, display
d = display.Display()
root = d.screen().root
own = root.create_window(-5, -5, 1, 1, 0, X.CopyFromParent)
atom = d.intern_atom
for window in (root, own):
    window.change_property(atom("_NET_SUPPORTING_WM_CHECK"), atom("WINDOW"), 32, [own.id])
own.change_property(atom("_NET_WM_NAME"), atom("UTF8_STRING"), 8, b"Stubborn")
names = ["_NET_WM_STATE", "_NET_WM_STATE_FULLSCREEN", "_NET_SUPPORTED"]
root.change_property(atom("_NET_SUPPORTED"), atom("ATOM"), 32, [atom(n) for n in names])
root.change_attributes(event_mask=X.SubstructureRedirectMask | X.SubstructureNotifyMask)
d.flush()
while True:
    event = d.next_event()
    if event.type == X.MapRequest:
        event.window.map()
    if event.type in (X.MapRequest, X.MapNotify, X.ConfigureNotify) and event.window != own:
        place = event.window.get_geometry()
        if (place.x, place.y) != (33, 44):
            event.window.configure(x=33, y=44)
    d.flush()
"""


def test_a_monitor_that_changes_its_mode_ends_play(two_monitors, tmp_path, video_maker):
    path, frame = picture(video_maker, tmp_path / "video", RIGHT)
    log = tmp_path / "log.csv"
    player = play(two_monitors, path, RIGHT, "--log", str(log))
    try:
        two_monitors.until(lambda: shows(two_monitors, RIGHT, frame), player)
        two_monitors.run("xrandr", "--output", "DUMMY1", "--mode", "800x600", "--pos", "800x0")
        _, errors = player.communicate(timeout=240)
    finally:
        player.kill()
        two_monitors.restore()
    assert player.returncode == 2
    assert "changed from 640 × 480" in errors and "800 × 600" in errors and "log saved" in errors


def test_a_lost_terminal_ends_play(two_monitors, tmp_path, video_maker):
    path, frame = picture(video_maker, tmp_path / "video", RIGHT)
    player = play(two_monitors, path, RIGHT, "--loop")
    two_monitors.until(lambda: shows(two_monitors, RIGHT, frame), player)
    player.send_signal(signal.SIGHUP)
    player.communicate(timeout=240)
    assert player.returncode == 130


def test_a_monitor_is_found_by_its_label(two_monitors, tmp_path, video_maker, label_maker):
    path, frame = picture(video_maker, tmp_path / "video", RIGHT)
    with label_maker(two_monitors, "DUMMY1", "HOLOEYE LC-R"):
        listing, _ = two_monitors.start("monitors").communicate(timeout=240)
        assert any("HOLOEYE LC-R" in line and "DUMMY1" in line for line in listing.splitlines())
        player = play(two_monitors, path, RIGHT, "--monitor", "holoeye")
        try:
            two_monitors.until(lambda: shows(two_monitors, RIGHT, frame), player)
        finally:
            output, _ = finish(player)
    assert "on HOLOEYE LC-R" in output


def test_every_monitor_shows_its_number(two_monitors):
    before = two_monitors.screenshot()
    player = two_monitors.start("monitors", "--identify", "--seconds", "60")
    try:
        two_monitors.until(
            lambda: (
                all((part(two_monitors, slm) == 255).any() for slm in (LEFT, RIGHT))
                and (part(two_monitors, LEFT) == 255).mean() > 0.01
            ),
            player,
        )
        left, right = part(two_monitors, LEFT), part(two_monitors, RIGHT)
        assert not np.array_equal(left[:480, :640], right)
        two_monitors.press("space", window_of(two_monitors))
        player.communicate(timeout=240)
    finally:
        player.kill()
    assert player.returncode == 0
    two_monitors.until(lambda: np.array_equal(two_monitors.screenshot(), before))
