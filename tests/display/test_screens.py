"""Real windows: what a screenshot of the X server shows is what the file holds."""

import csv
import signal
import subprocess
import sys

import numpy as np
import pytest

from chrmc.pictures import read_grey, write_grey
from chrmc.slm import LC_R_1080


def shows(server, frame, column=0):
    """Whether the desktop holds the frame, in all three channels, from a column on."""
    rows, columns = frame.shape
    part = server.screenshot()[:rows, column : column + columns]
    return np.array_equal(part, frame[:, :, None].repeat(3, axis=2))


def finish(process):
    """End a player politely; its output."""
    process.send_signal(signal.SIGTERM)
    return process.communicate(timeout=240)


def test_a_screenshot_equals_the_frame(one_monitor, tmp_path):
    frame = np.random.default_rng(3).integers(0, 256, LC_R_1080.shape, dtype=np.uint8)
    frame[:256, :256] = np.arange(256)  # every level among known neighbours
    path = tmp_path / "frame.tif"
    write_grey(path, frame)
    player = one_monitor.start("play", str(path), "--log", str(tmp_path / "log.csv"))
    try:
        one_monitor.until(lambda: shows(one_monitor, frame), player)
    finally:
        _, errors = finish(player)
    assert "Traceback" not in errors, errors
    assert player.returncode == 130
    rows = list(csv.DictReader((tmp_path / "log.csv").open()))
    assert rows and all(r["frame"] == "1" for r in rows)


def test_read_back_from_a_window_is_exact(one_monitor, tmp_path, video_maker, small):
    folder = video_maker(tmp_path / "video", small, 3)
    player = one_monitor.start("play", str(folder), "--windowed", "--verify")
    output, errors = player.communicate(timeout=240)
    assert player.returncode == 0, errors
    assert "equals its file to the pixel" in output


def test_an_slm_that_is_not_there_is_refused(one_monitor, tmp_path, video_maker, small):
    folder = video_maker(tmp_path / "video", small, 2)
    player = one_monitor.start("play", str(folder))
    _, errors = player.communicate(timeout=240)
    assert player.returncode == 2
    assert len(errors.strip().splitlines()) == 1 and "640 × 480" in errors


def test_monitors_are_listed(two_monitors):
    player = two_monitors.start("monitors", "--slm", "640x480:8.1e-6")
    output, errors = player.communicate(timeout=240)
    assert player.returncode == 0, errors
    first, second = output.splitlines()[1:3]
    assert "DUMMY0" in first and "800 × 600" in first and "primary" in first and "*" not in first
    assert "DUMMY1" in second and "(800, 0)" in second and second.startswith("*")
    assert "60 Hz" in second


@pytest.mark.parametrize("wanted", [[], ["--monitor", "dummy1"], ["--monitor", "1"]])
def test_the_second_monitor_gets_the_frame(two_monitors, tmp_path, video_maker, small, wanted):
    folder = video_maker(tmp_path / "video", small, 1)
    before = two_monitors.screenshot()[:600, :800]
    path = folder / "frame_0001.tif"
    player = two_monitors.start("play", str(path), "--slm", "640x480:8.1e-6", *wanted)
    frame = read_grey(path)
    try:
        two_monitors.until(lambda: shows(two_monitors, frame, 800), player)
        assert np.array_equal(two_monitors.screenshot()[:600, :800], before)
    finally:
        _, errors = finish(player)
    assert "Traceback" not in errors, errors


def test_the_wrong_monitor_is_refused(two_monitors, tmp_path, video_maker, small):
    folder = video_maker(tmp_path / "video", small, 1)
    for wanted, complaint in (("DUMMY0", "800 × 600"), ("dummy", "2 monitors match"), ("x", "no")):
        player = two_monitors.start("play", str(folder), "--monitor", wanted)
        _, errors = player.communicate(timeout=240)
        assert player.returncode == 2 and complaint in errors
        assert len(errors.strip().splitlines()) == 1


def test_the_gamma_ramp_is_straight_while_playing_and_put_back(
    two_monitors, tmp_path, video_maker, small
):
    def gamma():
        text = two_monitors.run("xrandr", "--verbose").split("DUMMY1")[1]
        return text.split("Gamma:")[1].split()[0]

    two_monitors.run("xrandr", "--output", "DUMMY1", "--gamma", "1:0.5:2")
    bent = gamma()
    assert bent != "1.0:1.0:1.0"
    folder = video_maker(tmp_path / "video", small, 1)
    player = two_monitors.start("play", str(folder / "frame_0001.tif"), "--slm", "640x480:8.1e-6")
    try:
        two_monitors.until(lambda: gamma() == "1.0:1.0:1.0", player)
    finally:
        finish(player)
    assert gamma() == bent
    two_monitors.run("xrandr", "--output", "DUMMY1", "--gamma", "1:1:1")


def test_the_screen_saver_is_held_off_while_playing(two_monitors, tmp_path, video_maker, small):
    def timeout():
        return two_monitors.run("xset", "q").split("timeout:")[1].split()[0]

    two_monitors.run("xset", "s", "300")
    path = video_maker(tmp_path / "video", small, 1) / "frame_0001.tif"
    player = two_monitors.start("play", str(path), "--slm", "640x480:8.1e-6")
    try:
        two_monitors.until(lambda: timeout() == "0", player)
    finally:
        finish(player)
    assert timeout() == "300"


def test_keys_reach_the_player(one_monitor, tmp_path, video_maker, small):
    folder = video_maker(tmp_path / "video", LC_R_1080, 2)
    log = tmp_path / "log.csv"
    player = one_monitor.start(
        "play", str(folder), "--loop", "--start-on", "key", "--log", str(log)
    )
    told = [player.stdout.readline()]
    while told[-1] and "a key starts it" not in told[-1]:
        told.append(player.stdout.readline())
    assert "dark for up to 2 s" in "".join(told)
    assert len(log.read_text().splitlines()) <= 1
    one_monitor.press("Return")
    one_monitor.until(lambda: len(log.read_text().splitlines()) > 5, player)
    one_monitor.press("space")
    one_monitor.until(lambda: "paused" in log.read_text(), player)
    one_monitor.press("Escape")
    output, errors = player.communicate(timeout=240)
    assert player.returncode == 0, errors
    assert "flips in" in output


def test_a_killed_player_leaves_a_whole_log(one_monitor, tmp_path, video_maker):
    folder = video_maker(tmp_path / "video", LC_R_1080, 2)
    log = tmp_path / "log.csv"
    player = one_monitor.start("play", str(folder), "--loop", "--log", str(log))
    one_monitor.until(lambda: log.exists() and len(log.read_text().splitlines()) > 10, player)
    player.kill()
    player.communicate(timeout=240)
    text = log.read_text()
    assert text.endswith("\n")
    rows = list(csv.DictReader(text.splitlines()))
    assert [int(r["flip"]) for r in rows] == list(range(1, len(rows) + 1))
    assert all(r["sha256"] and r["status"] and r["missed"] is not None for r in rows)


def test_a_monitor_that_goes_away_ends_play_with_one_line(
    two_monitors, tmp_path, video_maker, small
):
    path = video_maker(tmp_path / "video", small, 1) / "frame_0001.tif"
    log = tmp_path / "log.csv"
    player = two_monitors.start(
        "play", str(path), "--slm", "640x480:8.1e-6", "--monitor", "DUMMY1", "--log", str(log)
    )
    try:
        two_monitors.until(lambda: log.exists() and len(log.read_text().splitlines()) > 5, player)
        two_monitors.run("xrandr", "--output", "DUMMY1", "--off")
        _, errors = player.communicate(timeout=240)
    finally:
        player.kill()
        two_monitors.restore()
    assert player.returncode == 2, errors
    lines = [line for line in errors.strip().splitlines() if not line.startswith("warning")]
    assert len(lines) == 1 and "disconnected" in lines[0] and "log saved in" in lines[0], errors
    assert log.read_text().endswith("\n")


def test_a_display_without_opengl_is_one_line(tmp_path, video_maker, x_server_without_opengl):
    folder = video_maker(tmp_path / "video", LC_R_1080, 1)
    player = x_server_without_opengl.start("play", str(folder))
    _, errors = player.communicate(timeout=240)
    assert player.returncode == 2
    assert len(errors.strip().splitlines()) == 1 and "OpenGL" in errors, errors


TWO_PLAYERS = """
import sys
from pathlib import Path
from chrmc.slm import SLM
from display.log import FlipLog
from display.player import Options, Player, play_together
from display.playlist import open_playlist
from display.prefetch import Ring
from display.window import Window
left, right = SLM("left", 800, 600, 8e-6), SLM("right", 640, 480, 8e-6)
players = []
for slm, target in ((left, sys.argv[1]), (right, sys.argv[2])):
    playlist = open_playlist(target, slm)
    ring = Ring(playlist.read, 1)
    ring.__enter__()
    options = Options(hold=True)
    window = Window(slm)
    players.append(Player(window, ring, [1], slm.shape, options))
print([s.frames for s in play_together(players)])
"""


def test_two_players_on_two_monitors_from_one_program(two_monitors, tmp_path, small):
    rng = np.random.default_rng(5)
    frames = [rng.integers(0, 256, shape, dtype=np.uint8) for shape in ((600, 800), small.shape)]
    paths = []
    for name, frame in zip(("left.tif", "right.tif"), frames, strict=True):
        paths.append(str(tmp_path / name))
        write_grey(tmp_path / name, frame)
    program = subprocess.Popen(
        [sys.executable, "-c", TWO_PLAYERS, *paths],
        env=two_monitors.environment, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    try:
        two_monitors.until(
            lambda: shows(two_monitors, frames[0]) and shows(two_monitors, frames[1], 800), program
        )
        windows = two_monitors.run("xdotool", "search", "--onlyvisible", "--class", "chrmc")
        two_monitors.press("Escape", *windows.split())
        output, errors = program.communicate(timeout=240)
    finally:
        program.kill()
    assert program.returncode == 0, errors
    assert output.strip() == "[1, 1]"
