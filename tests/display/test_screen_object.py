"""`display.Screen`: arrays shown from scripts and threads, flips told and logged."""

import csv
import gc
import json
import os
import pty
import socket
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import display
from chrmc.encoding import SIGMAS
from chrmc.files import sha256
from chrmc.grey_levels import encode, signal_of
from chrmc.pictures import read_grey, write_grey
from chrmc.slm import LC_R_1080
from display.planes import pack_planes
from display.start import parse_time


@pytest.fixture
def screen(small):
    with display.Screen(headless=True, slm=small) as opened:
        yield opened


def noise(slm, seed=0):
    return np.random.default_rng(seed).integers(0, 256, slm.shape, dtype=np.uint8)


def shown(screen):
    picture = screen.read()
    assert np.array_equal(picture[..., 0], picture[..., 1])
    return picture[..., 0]


def test_show_returns_when_it_is_on(screen, small):
    before = time.perf_counter()
    first, second = screen.show(noise(small, 1)), screen.show(noise(small, 2))
    assert np.array_equal(shown(screen), noise(small, 2))
    assert before < first.time < second.time < time.perf_counter()
    assert first.interval is None
    assert second.interval == pytest.approx(second.time - first.time, abs=1e-9)
    assert not second.late and second.missed == 0


def test_default_panel_and_repr():
    with display.Screen(headless=True) as screen:
        assert screen.slm is LC_R_1080 and "1920 × 1200" in repr(screen)
    assert screen.closed and "closed" in repr(screen)


def test_a_field_is_encoded_with_one_fixed_scale(screen, small):
    rng = np.random.default_rng(0)
    field = (rng.normal(size=small.shape) + 1j * rng.normal(size=small.shape)).astype(np.complex64)
    screen.show(field)
    signal = signal_of(field, small)
    assert screen.scale == pytest.approx(SIGMAS * np.sqrt(np.mean(signal**2)), rel=1e-5)
    screen.show(0.5 * field)
    assert np.array_equal(shown(screen), encode(0.5 * field, small, scale=screen.scale))


def test_a_scale_given_is_kept(small):
    field = np.full(small.shape, 1 + 1j, np.complex64)
    with display.Screen(headless=True, slm=small, scale=7.0, encoding="real") as screen:
        screen.show(field)
        assert screen.scale == 7.0
        assert np.array_equal(shown(screen), encode(field, small, "real", 7.0))


@pytest.mark.parametrize(
    ("frame", "complaint"),
    [
        (np.zeros((4, 5), np.uint8), "5 × 4 pixels, but .* 640 × 480"),
        (np.zeros((480, 640)), "uint8 grey levels or a complex field, not float64"),
        (np.zeros((480, 640, 4), np.uint8), r"not the shape \(480, 640, 4\)"),
        (np.zeros((480, 641), np.complex64), r"\(480, 641\)"),
    ],
)
def test_wrong_frames_are_refused_and_the_screen_lives_on(screen, small, frame, complaint):
    with pytest.raises(ValueError, match=complaint):
        screen.show(frame)
    screen.show(noise(small))
    assert np.array_equal(shown(screen), noise(small))


def test_wrong_screens_are_refused():
    for wrong in ({"monitor": "x"}, {"windowed": True}, {"scale": -1.0}, {"verify": "twice"}):
        with pytest.raises(ValueError):
            display.Screen(headless=True, **wrong)


def test_a_closed_screen_says_so(small):
    screen = display.Screen(headless=True, slm=small)
    screen.show(noise(small))
    screen.close()
    screen.close()
    for use in (lambda: screen.show(noise(small)), lambda: next(screen.play([noise(small)]))):
        with pytest.raises(ValueError, match="closed"):
            use()


def test_frames_are_pulled_one_by_one_in_the_callers_thread(screen, small):
    """A closed loop: each frame may depend on what the one before was answered with."""
    seen = []

    def frames():
        for number in range(5):
            assert threading.current_thread() is threading.main_thread()
            assert len(seen) == number
            yield noise(small, number)

    for flip in screen.play(frames(), paced=False):
        assert np.array_equal(shown(screen), noise(small, len(seen)))
        seen.append(flip.frame)
    assert seen == [1, 2, 3, 4, 5]


def test_lists_arrays_and_stored_videos_are_played(screen, small, tmp_path, video_maker):
    import chrmc

    stack = np.stack([noise(small, n) for n in range(3)])
    folder = video_maker(tmp_path / "video", small, 3)
    for frames in (list(stack), stack, folder, str(folder), chrmc.open_video(folder)):
        assert [flip.frame for flip in screen.play(frames, paced=False)] == [1, 2, 3]
    with pytest.raises(ValueError, match="frames, rows, columns"):
        screen.play(stack[0])
    looped = screen.play(iter(stack), loop=True, paced=False, seconds=60)
    assert len(list(looped)) == 3  # an iterator cannot begin again
    looped = screen.play(list(stack), loop=True, paced=False)
    assert [next(looped).frame for _ in range(7)] == [1, 2, 3, 1, 2, 3, 1]
    looped.close()


def test_every_frame_has_its_duration(screen, small):
    frames = [noise(small, n) for n in range(3)]
    flips = list(screen.play(frames, durations=[0.05, 0.2, 0.1]))
    counts = [sum(f.frame == n for f in flips) for n in (1, 2, 3)]
    assert counts == [3, 12, 6]  # of 60 Hz, kept by the clock
    with pytest.raises(ValueError, match="frame 3 has no duration"):
        list(screen.play(frames, durations=[0.02, 0.02]))
    for wrong in ({"durations": [0.0]}, {"durations": [1.0], "fps": 3}, {"durations": []}):
        with pytest.raises(ValueError):
            screen.play(frames, **wrong)


def test_shows_from_other_threads_take_turns(screen, small):
    pictures = [noise(small, n) for n in range(4)]
    flips, faults = [], []

    def work(picture):
        try:
            for _ in range(25):
                flips.append(screen.show(picture))
        except BaseException as error:
            faults.append(error)

    threads = [threading.Thread(target=work, args=(p,)) for p in pictures]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not faults
    assert sorted(f.flip for f in flips) == list(range(1, 101))
    assert any(np.array_equal(shown(screen), p) for p in pictures)


def test_a_show_between_the_flips_of_a_play(screen, small):
    flips = screen.play([noise(small, n) for n in range(3)], paced=False)
    next(flips)
    screen.show(noise(small, 99))
    assert np.array_equal(shown(screen), noise(small, 99))
    next(flips)
    assert np.array_equal(shown(screen), noise(small, 1))


def test_the_log_is_the_players(small, tmp_path):
    path = tmp_path / "flips.csv"
    with display.Screen(headless=True, slm=small, log=path, verify="frames") as screen:
        screen.show(noise(small, 1), name="first")
        list(screen.play([noise(small, 2), noise(small, 3)], paced=False))
        assert screen.summary().mismatches == 0 and screen.summary().flips == 3
    rows = list(csv.DictReader(path.open()))
    assert [r["file"] for r in rows] == ["first", "frame 1", "frame 2"]
    assert all(len(r["sha256"]) == 64 for r in rows)
    assert "versions" in json.loads((tmp_path / "flips.json").read_text())


def test_callback_and_trigger(small):
    seen = []
    trigger = display.Trigger("top-left", 8)
    with display.Screen(headless=True, slm=small, on_flip=seen.append, trigger=trigger) as screen:
        corners = []
        for _ in range(3):
            screen.show(np.full(small.shape, 7, np.uint8))
            corners.append(int(shown(screen)[0, 0]))
    assert corners == [255, 0, 255] and [f.flip for f in seen] == [1, 2, 3]


def test_a_datagram_at_every_new_frame(small):
    receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    receiver.bind(("127.0.0.1", 0))
    receiver.settimeout(240)
    mark = display.UDPMark(f"127.0.0.1:{receiver.getsockname()[1]}")
    with display.Screen(headless=True, slm=small, on_flip=mark) as screen:
        flips = list(screen.play([noise(small, n) for n in range(3)], every=2))
    new = [f.flip for f in flips if f.shown == "new"]
    assert [int(receiver.recv(100)) for _ in new] == new == [1, 3, 5]
    receiver.close()
    mark.close()
    for wrong in ("nowhere", "host:", ":5", "host:99999"):
        with pytest.raises(ValueError, match="host:port"):
            display.UDPMark(wrong)


def test_a_byte_on_a_serial_line(small):
    pytest.importorskip("serial")
    ours, theirs = pty.openpty()
    mark = display.SerialMark(os.ttyname(theirs), b"*")
    with display.Screen(headless=True, slm=small, on_flip=mark) as screen:
        for _ in range(3):
            screen.show(noise(small))
    came = b""
    while len(came) < 3:  # the terminal hands them on when it likes
        came += os.read(ours, 10)
    assert came == b"***"
    mark.close()
    with pytest.raises(OSError, match="nothing-here"):
        display.SerialMark("/dev/nothing-here")


def test_starting_at_a_time_and_after_a_countdown(screen, small):
    begin = time.time() + 0.5
    first = next(screen.play([noise(small)], start_on=begin))
    assert 0 <= time.time() - begin < 60 and first.flip == 1  # at once, but for a busy machine
    told = []
    with display.Screen(headless=True, slm=small, tell=told.append) as other:
        start = time.monotonic()
        list(other.play([noise(small)], countdown=1.2, paced=False))
        assert time.monotonic() - start >= 1.2
    assert told[-2:] == ["2", "1"]


def test_colour_frames_reach_the_three_channels(screen, small):
    frame = np.random.default_rng(0).integers(0, 256, (*small.shape, 3), dtype=np.uint8)
    screen.show(frame)
    assert np.array_equal(screen.read(), frame)
    screen.show(noise(small))  # and grey ones all of them again
    assert np.array_equal(shown(screen), noise(small))


def test_bit_planes_hold_binary_frames(small, tmp_path):
    """Unpacked by arithmetic: plane k is bit k % 8 of the colour k // 8 in the order given."""
    frames = [(noise(small, n) >= 128).astype(np.uint8) * np.uint8(255) for n in range(30)]
    for order in ("grb", "rgb"):
        packed = pack_planes(frames[:24], order)
        for plane in range(24):
            bits = packed[..., "rgb".index(order[plane // 8])] // 2 ** (plane % 8) % 2
            assert np.array_equal(bits * 255, frames[plane])
    with display.Screen(headless=True, slm=small, verify="frames") as screen:
        flips = list(screen.play(frames, planes=24, paced=False))
        assert len(flips) == 2 and screen.summary().mismatches == 0
        rest = screen.read()
        assert np.array_equal(rest[..., 1] % 2 * 255, frames[24])
        assert not rest[..., 0].any() and not (rest[..., 1] >> 6).any()  # six frames were left
    for wrong in ([noise(small)], frames[:25], []):
        with pytest.raises(ValueError):
            pack_planes(wrong)


def test_bit_planes_of_a_stored_video(small, tmp_path, video_maker, chrmc_command):
    import chrmc

    folder = video_maker(tmp_path / "video", small, 7)
    grey = subprocess.run(
        [*chrmc_command, "play", str(folder), "--headless", "--bit-planes", "3",
         "--on-bad-frame", "stop"],
        capture_output=True, text=True, timeout=240,
    )  # fmt: skip
    assert grey.returncode == 2 and "0 or 255 everywhere" in grey.stderr
    for path in folder.glob("*.tif"):
        write_grey(path, (read_grey(path) >= 128).astype(np.uint8) * np.uint8(255))
    manifest = json.loads((folder / "manifest.json").read_text())
    for entry in manifest["frames"]:
        entry["sha256"] = sha256(folder / entry["file"])
    (folder / "manifest.json").write_text(json.dumps(manifest))
    log = tmp_path / "log.csv"
    done = subprocess.run(
        [*chrmc_command, "play", str(folder), "--headless", "--bit-planes", "3", "--verify",
         "--log", str(log)],
        capture_output=True, text=True, timeout=240,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert [row["frame"] for row in csv.DictReader(log.open())] == ["1", "4", "7"]
    with display.Screen(headless=True, slm=small) as screen:
        flips = screen.play(chrmc.open_video(folder), planes=3, paced=False)
        assert [flip.frame for flip in flips] == [1, 4, 7]


def test_no_key_starts_a_headless_screen(screen, small):
    with pytest.raises(ValueError, match="no keys"):
        screen.play([noise(small)], start_on="key")


def test_times_are_read():
    noon = time.mktime((2026, 11, 21, 12, 0, 0, 0, 0, -1))
    assert parse_time("12:00:30", noon) == noon + 30
    assert parse_time("2026-11-22T12:00:00", noon) == pytest.approx(noon + 86400, abs=3601)
    assert parse_time(noon + 5, noon) == noon + 5
    for wrong in ("soon", "25:00", "11:59", "2020-01-01", noon - 10, float("nan"), [1]):
        with pytest.raises(ValueError, match="start on"):
            parse_time(wrong, noon)


def test_a_thousand_shows_leave_nothing_behind(screen, small):
    """Threads, handles and memory stay as they are; every frame is the one asked for."""
    pictures = [noise(small, 1), noise(small, 2)]

    def state():
        gc.collect()
        pages = int(open("/proc/self/statm").read().split()[1])  # noqa: PTH123, SIM115
        return len(os.listdir("/proc/self/fd")), threading.active_count(), pages  # noqa: PTH208

    for n in range(50):
        screen.show(pictures[n % 2])
    before = state()
    for n in range(1000):
        screen.show(pictures[n % 2])
        if n % 50 < 2:
            assert np.array_equal(shown(screen), pictures[n % 2])
    after = state()
    assert after[:2] == before[:2]
    assert (after[2] - before[2]) * 4096 < 20e6


SCRIPT = """
import sys, threading, time
import numpy as np
import display
from chrmc.slm import SLM
slm = SLM("panel", 640, 480, 8e-6)
a, b = (np.random.default_rng(n).integers(0, 256, slm.shape, dtype=np.uint8) for n in (1, 2))
with display.Screen("DUMMY1", slm=slm) as screen:
    wrong = 0
    for n in range(int(sys.argv[1])):
        picture = (a, b)[n % 2]
        flip = screen.show(picture)
        if n % 5 == 0:  # a look at the desktop costs more than a flip
            wrong += not np.array_equal(screen.read(), picture[..., None].repeat(3, axis=2))
    print("wrong", wrong, "flips", flip.flip, "threads", threading.active_count(), flush=True)
    worker = threading.Thread(target=screen.show, args=(a,))
    worker.start(); worker.join()
    print("from a thread", np.array_equal(screen.read()[..., 0], a), flush=True)
    time.sleep(1)  # alone for a while: its events are still taken in
    print("alive", np.array_equal(screen.read()[..., 0], a), screen.closed, flush=True)
print("closed", screen.closed, flush=True)
left = display.Screen("DUMMY0")  # never closed by its owner: the end of the program does it
print("size", left.slm.width, left.slm.height, flush=True)
"""


THOUSAND = """
import gc, os, sys
import numpy as np
import display
from chrmc.slm import SLM
slm = SLM("panel", 640, 480, 8e-6)
pictures = [np.random.default_rng(n).integers(0, 256, slm.shape, dtype=np.uint8) for n in (1, 2)]
def state():
    gc.collect()
    return len(os.listdir("/proc/self/fd")), int(open("/proc/self/statm").read().split()[1]) * 4096
with display.Screen("DUMMY1", slm=slm, log=sys.argv[1]) as screen:
    wrong = 0
    for n in range(1000):
        screen.show(pictures[n % 2])
        wrong += not np.array_equal(screen.read()[..., 1], pictures[n % 2])
        if n == 99:
            before = state()
    after = state()
print(wrong, after[0] - before[0], after[1] - before[1])
"""


@pytest.mark.long
@pytest.mark.parametrize("managed", ["openbox"], indirect=True)
def test_a_thousand_frames_under_a_window_manager(managed, tmp_path):
    server, _ = managed
    log = tmp_path / "flips.csv"
    done = subprocess.run(
        [sys.executable, "-c", THOUSAND, str(log)],
        env=server.environment, capture_output=True, text=True, timeout=1500,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    wrong, handles, memory = (int(v) for v in done.stdout.split())
    print(done.stdout)
    assert wrong == 0 and handles == 0 and memory < 20e6
    rows = list(csv.DictReader(log.open()))
    assert len(rows) == 1000 and {r["place"] for r in rows} == {"ok"}


@pytest.mark.parametrize("managed", ["openbox", "metacity"], indirect=True)
def test_a_script_shows_alternating_frames_under_a_window_manager(managed):
    server, _ = managed
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, "60"],
        env=server.environment, capture_output=True, text=True, timeout=250,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == [
        "wrong 0 flips 60 threads 2",
        "from a thread True",
        "alive True False",
        "closed True",
        "size 800 600",
    ]
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("paused", [False, True])
@pytest.mark.parametrize(
    ("keys", "wanted"),
    [
        (["right"], 22),
        (["left"], 20),
        (["right", "right", "left"], 22),
        (["page_down"], 31),
        (["page_up"], 11),
        (["home"], 1),
        (["end"], 40),
        (["7", "enter"], 7),
        (["3", "3", "enter"], 33),
        (["9", "9", "enter"], 40),
    ],
)
def test_keys_show_the_frame_asked_for(small, tmp_path, video_maker, keys, wanted, paused):
    """Paced and read ahead as on a panel: the frame is not there at once, but it comes."""
    folder = video_maker(tmp_path / "video", small, 40)
    log = tmp_path / "log.csv"
    with display.Screen(headless=True, slm=small, log=log) as screen:
        script = [["2", "1", "enter"], ["space"] if paused else []]
        screen.surface.pressed = lambda: script.pop(0) if script else []
        flips = screen.play(folder, fps=60, loop=True, ahead=2)
        until(flips, lambda flip: flip.frame == 21 and not script)
        script.append(keys)
        until(flips, lambda flip: flip.frame == wanted and flip.shown == "new")
        assert np.array_equal(shown(screen), frame_of(folder, wanted))
        stays = paused or keys[0] in ("left", "right")
        after = [next(flips) for _ in range(20)][-1]
        assert (after.frame == wanted and after.shown == "paused") == stays
        script.append(["space"])
        until(flips, lambda flip: flip.shown == ("new" if stays else "paused"))
        script.append(["escape"])
        assert len(list(flips)) <= 2
    frames = [row["frame"] for row in csv.DictReader(log.open())]
    assert str(wanted) in frames


def test_l_switches_the_loop(small, tmp_path, video_maker):
    folder = video_maker(tmp_path / "video", small, 3)
    with display.Screen(headless=True, slm=small) as screen:
        script = [["l"], [], []]
        screen.surface.pressed = lambda: script.pop(0) if script else []
        flips = screen.play(folder, fps=60)
        until(flips, lambda flip: flip.flip > 3 and flip.frame == 1)
        script.append(["l"])
        assert list(flips)[-1].frame == 3


def until(flips, condition):
    for _, flip in zip(range(600), flips, strict=False):
        if condition(flip):
            return
    raise AssertionError("600 flips, and never what was waited for")


def frame_of(folder, number):
    return read_grey(folder / f"frame_{number:04d}.tif")
