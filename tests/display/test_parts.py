"""The player's parts that need no graphics: keys, ring, timing, log, playlist, monitors."""

import csv
import json
import queue
import resource
import threading
import time
from datetime import UTC, datetime

import numpy as np
import pytest

from chrmc.pictures import write_grey
from chrmc.slm import LC_R_1080, SLM
from display.edid import drm_labels, label_of
from display.log import COLUMNS, Flip, FlipLog
from display.monitors import Monitor, choose
from display.playlist import Picture, open_playlist
from display.prefetch import Fault, Ring
from display.timing import Refresh, Summary, judge, measure_refresh, pace_for
from display.transport import Transport


def picture(index):
    return Picture(index + 1, f"{index}", "hash", np.full((2, 2), index, np.uint8))


def drain(ring):
    taken = []
    while (item := ring.take(5.0)) is not None:
        taken.append(item)
    return taken


def test_ring_gives_everything_in_order_once():
    with Ring(picture, 25, ahead=3) as ring:
        taken = drain(ring)
    assert [i for i, _ in taken] == list(range(25))
    assert [p.number for _, p in taken] == list(range(1, 26))


def test_ring_is_bounded_and_reads_ahead():
    reads = []

    def read(index):
        reads.append(index)
        return picture(index)

    with Ring(read, 100, ahead=4) as ring:
        deadline = time.monotonic() + 240
        while len(reads) < 4 and time.monotonic() < deadline:
            time.sleep(0.005)
        time.sleep(0.05)
        assert reads == [0, 1, 2, 3]
        ring.take(1)
        ring.take(1)
        while len(reads) < 6 and time.monotonic() < deadline:
            time.sleep(0.005)
        time.sleep(0.05)
        assert reads == [0, 1, 2, 3, 4, 5]


def test_ring_seek_drops_what_was_read_and_what_is_being_read():
    gate = threading.Event()

    def read(index):
        if index == 2:
            gate.wait(240)
        return picture(index)

    with Ring(read, 50, ahead=8) as ring:
        assert ring.take(240)[0] == 0
        ring.seek(30)
        gate.set()
        assert [ring.take(240)[0] for _ in range(3)] == [30, 31, 32]
        ring.seek(-3)
        assert ring.take(240)[0] == 0
        ring.seek(99)
        assert ring.take(240)[0] == 49
        assert ring.take(5) is None


def test_ring_loops_and_can_be_told_to_stop_looping():
    with Ring(picture, 3, loop=True, ahead=2) as ring:
        assert [ring.take(240)[0] for _ in range(8)] == [0, 1, 2, 0, 1, 2, 0, 1]
        ring.loop = False
        rest = [i for i, _ in drain(ring)]
    assert rest and rest[-1] == 2 and len(rest) <= 4


def test_ring_hands_on_faults_and_does_not_wait_when_not_asked():
    gate = threading.Event()

    def read(index):
        gate.wait(240)
        if index == 1:
            raise OSError("frame 2: damaged")
        return picture(index)

    with Ring(read, 3) as ring:
        with pytest.raises(queue.Empty):
            ring.take()
        gate.set()
        kinds = [type(item) for _, item in drain(ring)]
    assert kinds == [Picture, Fault, Picture]


def test_keys():
    keys = Transport([1, 2, 5, 8], at=1)
    assert keys.press("right") == 2 and keys.paused
    assert keys.press("space") is None and not keys.paused
    assert keys.press("page_down") == 3 and not keys.paused
    assert keys.press("page_up") == 0
    assert keys.press("home") == 0 and keys.press("end") == 3
    assert [keys.press(k) for k in ("0", "7", "enter")][-1] == 3  # nearest to 7 is frame 8
    assert keys.press("enter") is None
    keys.at = 3
    assert keys.press("right") == 3
    assert keys.press("l") is None and keys.loop
    assert keys.press("right") == 0
    keys.press("escape")
    assert keys.quit


class Screen:
    """A clock that only flips and sleeps move on; flips wait for the next refresh, or not."""

    def __init__(self, period, drawing=0.001, vsync=True, jitter=0.0, seed=0):
        self.now, self.period, self.drawing, self.vsync = 0.0, period, drawing, vsync
        self.noise = np.random.default_rng(seed)
        self.jitter = jitter

    def flip(self):
        self.now += self.drawing
        if self.vsync:
            self.now = (np.floor(self.now / self.period) + 1) * self.period
        self.now += self.jitter * self.noise.random()

    def sleep(self, seconds):
        self.now += seconds

    def measure(self, reported=0.0):
        return measure_refresh(self.flip, reported, lambda: self.now, self.sleep)


def test_a_refresh_is_measured():
    for rate in (24.0, 59.94, 60.0, 144.0):
        found = Screen(1 / rate, jitter=2e-4).measure()
        assert found.period == pytest.approx(1 / rate, rel=0.03)


@pytest.mark.parametrize("drawing", [0.0002, 0.004, 0.0167])
def test_drawing_time_is_not_taken_for_a_refresh(drawing):
    assert Screen(1 / 60, drawing, vsync=False).measure().period is None


def test_a_wild_screen_has_no_refresh():
    screen = Screen(1 / 60, jitter=0.02)
    assert screen.measure().period is None
    assert screen.now < 2.1
    assert screen.measure(reported=60).period is None


@pytest.mark.parametrize("period", [0.07, 0.3, 0.9])
def test_a_slow_screen_costs_two_seconds_at_most(period):
    screen = Screen(period, jitter=0.3 * period)
    screen.measure()
    assert screen.now < 2 + 2.3 * period


def test_rates_that_divide_and_that_do_not():
    sixty = Refresh(1 / 60, 12)
    assert pace_for(sixty, fps=30).every == 2 and not pace_for(sixty, fps=30).warning
    assert pace_for(sixty, fps=60).every == 1
    assert pace_for(sixty, every=3).rate == pytest.approx(20)
    odd = pace_for(sixty, fps=25)
    assert odd.every == 2 and "25" in odd.warning and "30" in odd.warning
    assert pace_for(Refresh(1 / 59.94, 12), fps=30).warning == ""
    free = pace_for(Refresh(None, 240), fallback=60)
    assert free.rate == pytest.approx(60) and not free.waits
    assert pace_for(Refresh(None, 0)).period is None
    for wrong in (
        {"fps": 0},
        {"fps": 1e-320},
        {"every": 10**20},
        {"fps": -5},
        {"every": 0},
        {"fps": 30, "every": 2},
    ):
        with pytest.raises(ValueError):
            pace_for(sixty, **wrong)


def test_flips_are_judged_past_1_2_periods():
    t = 1 / 60
    assert judge(1.19 * t, t) == ("ok", 0)
    assert judge(1.21 * t, t) == ("late", 0)
    assert judge(2.01 * t, t) == ("dropped", 1)
    assert judge(4.9 * t, t) == ("dropped", 4)
    assert judge(0.5, None) == ("free", 0)


def test_a_run_is_summed_up_in_milliseconds():
    intervals = [0.0165] * 60 + [0.0167] * 38 + [0.0334, 0.05]
    words = Summary(101, 100, 1, 2, 3, 0, intervals, 1 / 60).lines()
    rate = 100 / sum(intervals)
    assert words[1] == (
        f"{rate:.2f} flips per second; interval median 16.50 ms, 99 % within 33.40 ms, "
        "longest 50.00 ms"
    )
    assert words[2] == "1 late, 2 after dropped refreshes (3 missed), 0 waited for a frame"
    quick = Summary(3, 3, 0, 0, 0, 0, [0.004, 0.006], None).lines()
    assert quick == [
        "3 frames in 3 flips",
        "200.00 flips per second; interval median 5.00 ms, 99 % within 6.00 ms, longest 6.00 ms",
    ]


def test_log_lines_are_on_disk_at_once(tmp_path):
    path = tmp_path / "deep" / "flips.csv"
    with FlipLog(path) as log:
        for n in range(1, 4):
            log.write(Flip(n, n, "a,b.tif", "ff", 1.5 * n, 1.5 if n > 1 else None, "new", "ok", 0))
            rows = list(csv.reader(path.open()))
            assert len(rows) == n + 1 and tuple(rows[0]) == COLUMNS
            assert rows[-1][:4] == [str(n), str(n), "a,b.tif", "ff"]


def test_a_log_on_a_full_disk_ends_with_a_whole_line(tmp_path):
    """A limit on the size of files stands for the disk: the line that does not fit is taken out."""
    path, before = tmp_path / "flips.csv", resource.getrlimit(resource.RLIMIT_FSIZE)
    flip = Flip(1, 1, "a.tif", "f" * 64, 1.5, None, "new", "ok", 0)
    with FlipLog(path) as log:
        resource.setrlimit(resource.RLIMIT_FSIZE, (300, before[1]))
        try:
            with pytest.raises(OSError, match=r"flips.csv: .*; the flips before are in it"):
                for _ in range(9):
                    log.write(flip)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
    text = path.read_text()
    assert text.endswith("\n") and {len(row) for row in csv.reader(path.open())} == {len(COLUMNS)}
    assert text.count("\n") == 3
    with pytest.raises(OSError, match="/dev/full: no space is left"):
        FlipLog("/dev/full")


def test_what_holds_for_all_flips_lies_beside_the_log(tmp_path):
    path = tmp_path / "flips.csv"
    with FlipLog(path) as log:
        log.describe(monitor={"name": "DP-1"}, window_manager="Openbox")
    facts = json.loads((tmp_path / "flips.json").read_text())
    assert facts["window_manager"] == "Openbox" and facts["monitor"]["name"] == "DP-1"
    stamp = datetime.fromisoformat(facts["utc"])
    assert abs((datetime.now(UTC) - stamp).total_seconds()) < 60
    assert abs(time.perf_counter() - facts["clock"]) < 60
    assert {"chrmc", "python", "numpy", "moderngl", "glfw", "system"} <= set(facts["versions"])


def edid(name=b"LC-R 1080", maker="HOL", product=0x1080):
    block = bytearray(128)
    block[:8] = b"\x00\xff\xff\xff\xff\xff\xff\x00"
    first, second, third = (ord(letter) - 64 for letter in maker)
    block[8:10] = (first << 10 | second << 5 | third).to_bytes(2, "big")
    block[10:12] = product.to_bytes(2, "little")
    if name is not None:
        block[90:108] = b"\x00\x00\x00\xfc\x00" + name.ljust(13, b"\n")[:13]
    return bytes(block)


def test_a_label_is_read_from_edid():
    assert label_of(edid()) == "LC-R 1080"
    assert label_of(edid(b"HOLOEYE PLUTO")) == "HOLOEYE PLUTO"  # 13 characters, no newline
    assert label_of(edid(None)) == "HOL 1080"
    for wrong in (b"", b"abc", bytes(128), edid()[:100], b"\x01" + edid()[1:]):
        assert label_of(wrong) == ""


def test_labels_from_the_graphics_driver(tmp_path):
    for output, data in (
        ("card0-DP-1", edid()),
        ("card1-HDMI-A-2", edid(None)),
        ("card0-VGA-1", b""),
    ):
        (tmp_path / output).mkdir()
        (tmp_path / output / "edid").write_bytes(data)
    assert drm_labels(tmp_path) == {"DP-1": "LC-R 1080", "HDMI-A-2": "HOL 1080"}


def test_playlist_names_what_is_wrong(tmp_path, video_maker, small):
    folder = video_maker(tmp_path / "video", small, 4)
    playlist = open_playlist(folder)
    assert len(playlist) == 4 and playlist.read(2).number == 3
    assert [e.number for e in open_playlist(folder, frames=(2, 3)).entries] == [2, 3]

    (folder / "frame_0002.tif").unlink()
    with pytest.raises(OSError, match=r"frame 2: .*missing"):
        playlist.read(1)
    whole = (folder / "frame_0003.tif").read_bytes()
    (folder / "frame_0003.tif").write_bytes(whole[:-100] + bytes(100))
    with pytest.raises(OSError, match=r"frame 3: .*SHA-256"):
        playlist.read(2)
    with pytest.raises(ValueError, match="nothing to play"):
        open_playlist(folder, frames=(7, 9))
    with pytest.raises(ValueError, match="generate it for that SLM"):
        open_playlist(folder, LC_R_1080)
    with pytest.raises(OSError, match="does not exist"):
        open_playlist(tmp_path / "nowhere")


def test_a_picture_must_have_the_slms_pixels(tmp_path, small):
    path = tmp_path / "picture.png"
    write_grey(path, np.zeros(small.shape, np.uint8))
    assert open_playlist(path, small).read(0).levels.shape == small.shape
    with pytest.raises(ValueError, match=r"640 × 480 pixels, but .* 1920 × 1200"):
        open_playlist(path)
    (tmp_path / "text.png").write_text("no picture")
    with pytest.raises((OSError, ValueError), match=r"text\.png"):
        open_playlist(tmp_path / "text.png", small)


def monitor(index, name, width=1920, height=1200, primary=False, modes=(), label=""):
    return Monitor(index, name, 0, 0, width, height, 60.0, (1.0, 1.0), primary, modes, label)


DESK = monitor(0, "DELL U2412M", primary=True)
PANEL = monitor(1, "HOLOEYE LC-R")
OTHER = monitor(2, "HOLOEYE PLUTO", 1920, 1080)


def test_monitors_are_chosen_by_name_part_or_index():
    all_three = [DESK, PANEL, OTHER]
    for wanted in ("HOLOEYE LC-R", "lc-r", "1", None):
        assert choose(all_three, wanted, LC_R_1080) is PANEL
    assert choose([DESK, OTHER], None, LC_R_1080) is DESK
    assert choose(all_three, "pluto", LC_R_1080, any_size=True) is OTHER


def test_monitors_are_chosen_by_their_label():
    desk = monitor(0, "DP-1", primary=True, label="DELL U2412M")
    panel, twin = (monitor(n, f"DP-{n + 1}", label="HOLOEYE LC-R") for n in (1, 2))
    assert choose([desk, panel], "holoeye", LC_R_1080) is panel
    assert choose([desk, panel], "HOLOEYE LC-R", LC_R_1080) is panel
    assert choose([desk, panel, twin], "DP-3", LC_R_1080) is twin
    with pytest.raises(ValueError, match=r"2 monitors match .*'HOLOEYE LC-R' on 'DP-2'.*index"):
        choose([desk, panel, twin], "holoeye", LC_R_1080)


@pytest.mark.parametrize(
    ("monitors", "wanted", "complaint"),
    [
        ([DESK, PANEL, OTHER], "holoeye", "2 monitors match .*HOLOEYE LC-R.*HOLOEYE PLUTO"),
        ([DESK, PANEL], "nec", "no monitor matches 'nec'; connected: .0. 'DELL.*; .1. 'HOLOEYE"),
        ([DESK, PANEL], "7", "no monitor matches '7'"),
        ([DESK, PANEL], "", "no monitor matches"),
        ([DESK, OTHER], "pluto", "1920 × 1080, but .* needs 1920 × 1200: choose another"),
        ([OTHER], None, "no monitor shows the 1920 × 1200"),
        ([PANEL, monitor(1, "twin")], None, "2 monitors have 1920 × 1200 pixels: say which"),
    ],
)
def test_a_wrong_monitor_is_refused_with_a_list(monitors, wanted, complaint):
    with pytest.raises(ValueError, match=complaint):
        choose(monitors, wanted, LC_R_1080)


def test_a_mode_on_offer_is_pointed_out():
    able = monitor(0, "panel", 1024, 768, modes=((1920, 1200, 60),))
    with pytest.raises(ValueError, match="offers that mode"):
        choose([able], "panel", SLM("s", 1920, 1200, 8e-6))
