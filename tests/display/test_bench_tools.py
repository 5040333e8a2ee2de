"""Patterns, the bench sheet, and live play."""

import csv

import numpy as np
import pytest

from chrmc.optics.propagation import propagate
from chrmc.slm import LC_R_1080, SLM
from display import patterns
from display.bench_sheet import Sheet, Target
from display.gl import Offscreen
from display.live import LiveReel
from display.log import FlipLog
from display.player import Options, Player
from display.playlist import Picture

SLM_512 = SLM("square", 512, 512, 8.1e-6)


def test_a_point_comes_to_a_focus_where_it_was_put():
    depth, x, y = 0.08, 4e-4, -3e-4
    frame = patterns.point(SLM_512, 532e-9, depth, x, y)
    assert frame.min() < 20 and frame.max() > 235  # the whole grey range, nothing cut
    # Decoded independently: positive frequencies of y, carrier off, back to the point.
    spectrum = np.fft.fft(frame / 255 - 0.5, axis=0)
    spectrum[np.fft.fftfreq(512) <= 0] = 0
    carrier = np.exp(2j * np.pi * SLM_512.y() / (4 * SLM_512.pixel_pitch))[:, None]
    field = np.fft.ifft(spectrum, axis=0) / carrier
    image = np.abs(propagate(field, SLM_512.pixel_pitch, 532e-9, -depth)) ** 2
    row, column = np.unravel_index(np.argmax(image), image.shape)
    assert abs(SLM_512.y(row) - y) <= SLM_512.pixel_pitch
    assert abs(SLM_512.x(column) - x) <= SLM_512.pixel_pitch


def test_a_gratings_lines_have_their_period_and_direction():
    for angle, axis in ((0.0, 1), (np.pi / 2, 0)):
        for shape in ("binary", "sine"):
            frame = patterns.grating(SLM_512, 16, angle, 40, 200, shape)
            assert frame.min() == 40 and frame.max() == 200
            line = np.take(frame, 0, axis=1 - axis).astype(float)
            spectrum = np.abs(np.fft.rfft(line - line.mean()))
            assert np.argmax(spectrum) == 512 // 16
            assert np.all(np.take(frame, [0], axis=1 - axis) == frame)
    slanted = patterns.grating(SLM_512, 8 * np.sqrt(2), np.pi / 4, shape="sine")
    assert np.array_equal(slanted[:-1, 1:], slanted[1:, :-1])  # constant along x + y
    assert not np.array_equal(slanted[1:, 1:], slanted[:-1, :-1])


def test_plain_patterns():
    slm = SLM("odd", 130, 70, 8e-6)
    board = patterns.checkerboard(slm, 10)
    assert board[0, 0] == 255 and np.array_equal(board[10:, :], 255 - board[:-10, :])
    ramp = patterns.ramp(LC_R_1080)
    assert set(np.unique(ramp)) == set(range(256)) and (np.diff(ramp[5].astype(int)) >= 0).all()
    bars = patterns.steps(slm, 5)
    assert np.unique(bars).tolist() == [0, 64, 128, 191, 255]
    cross = patterns.cross_hair(slm)
    assert np.array_equal(cross, cross[::-1]) and np.array_equal(cross, cross[:, ::-1])
    assert cross[35, 20] == 255 and cross[20, 65] == 255 and cross[20, 20] == 0
    assert np.all(patterns.uniform(slm, 7) == 7)


@pytest.mark.parametrize(
    "make",
    [
        lambda: patterns.uniform(SLM_512, 256),
        lambda: patterns.grating(SLM_512, 1),
        lambda: patterns.grating(SLM_512, np.nan),
        lambda: patterns.grating(SLM_512, shape="square"),
        lambda: patterns.checkerboard(SLM_512, 0),
        lambda: patterns.steps(SLM_512, 1),
        lambda: patterns.cross_hair(SLM_512, 0),
        lambda: patterns.point(SLM_512, 532e-9, -0.1),
        lambda: patterns.point(SLM_512, 532e-9, 0.1, x=1.0),
    ],
)
def test_impossible_patterns_are_refused(make):
    with pytest.raises(ValueError):
        make()


def test_the_bench_sheet_has_the_known_numbers():
    sheet = Sheet(LC_R_1080, 532e-9)
    assert 1e3 * sheet.order_spacing == pytest.approx(9.85, abs=0.005)
    assert 1e3 * sheet.carrier == pytest.approx(2.46, abs=0.005)
    assert np.degrees(sheet.half_angle) == pytest.approx(1.882, abs=0.001)
    place = sheet.place(Target("it", 0.25, 1e-3, 2e-3))
    assert place.resolution[0] == pytest.approx(8.55e-6, rel=0.01)
    assert (place.x, place.y) == (-1e-3, -2e-3)


def test_the_bench_sheet_of_a_phase_panel_leaves_the_zero_order():
    crystal = SLM("crystal", 1920, 1080, 8e-6, kind="phase")
    sheet = Sheet(crystal, 532e-9)
    side = 532e-9 * 0.15 / 8e-6 / 2  # half the band in both directions, about the axis
    assert sheet.carrier == 0 and sheet.opening == pytest.approx((side, side))
    told = "\n".join(sheet.lines([Target("it", 0.25)]))
    assert "double-phase" in told and "leave it" in told
    assert "conjugate" not in told and "sensor" not in told
    # Its footprint, not the panel, is what resolves in x: ±0.95° of 250 mm.
    assert sheet.place(Target("it", 0.25)).resolution[0] == pytest.approx(16.0e-6, rel=0.01)
    mirrors = SLM("mirrors", 1920, 1080, 8e-6, 1, kind="binary")
    assert Sheet(mirrors, 532e-9).carrier == pytest.approx(side / 2)
    with pytest.raises(ValueError, match="kind phase"):
        Sheet(crystal, 532e-9, encoding="ssb")


def test_image_places_obey_the_lens_equation():
    sheet = Sheet(LC_R_1080, 532e-9, 0.2, 0.1)

    def lens(object_distance, focal):
        return 1 / (1 / focal - 1 / object_distance)

    for depth in (0.05, 0.25, 1.0):
        place = sheet.place(Target("it", depth))
        for before_panel, wanted in ((depth, place.camera), (-depth, place.sensor)):
            first = lens(sheet.focal1 + before_panel, sheet.focal1)
            second = lens(sheet.focal1 + sheet.focal2 - first, sheet.focal2)
            assert second == pytest.approx(wanted)


def test_impossible_benches_are_refused():
    for arguments in ((0.0,), (532e-9, -1.0), (532e-9, 0.15, float("inf")), (1e-4,)):
        with pytest.raises(ValueError):
            Sheet(LC_R_1080, *arguments)
    with pytest.raises(ValueError, match="z > 0"):
        Sheet(LC_R_1080, 532e-9).place(Target("it", 0.0))


def pictures(slm, count):
    for n in range(1, count + 1):
        yield Picture(n, f"live {n}", "hash", np.full(slm.shape, n, np.uint8))


def test_live_frames_are_shown_as_they_are_made(small, tmp_path):
    surface = Offscreen(small.shape)
    with LiveReel(lambda: pictures(small, 6)) as reel, FlipLog(tmp_path / "log.csv") as log:
        options = Options(paced=False, verify=True)
        summary = Player(surface, reel, range(1, 7), small.shape, options, log).run()
        report = reel.report()
    surface.close()
    assert summary.mismatches == 0 and summary.frames == 6 and report.frames == 6
    rows = list(csv.DictReader((tmp_path / "log.csv").open()))
    assert [int(r["frame"]) for r in rows] == [1, 2, 3, 4, 5, 6]


def test_live_loops_until_told_to_stop(small):
    surface = Offscreen(small.shape)
    for seconds in (0.3, 3, 30):  # in which a busy machine shows few frames
        with LiveReel(lambda: pictures(small, 3), loop=True) as reel:
            options = Options(paced=False, loop=True, seconds=seconds)
            summary = Player(surface, reel, [1, 2, 3], small.shape, options).run()
        if summary.frames > 3:
            break
    surface.close()
    assert summary.frames > 3


def test_what_the_generator_raises_ends_play(small):
    def make():
        yield from pictures(small, 2)
        raise ValueError("frame 3: points behind the hologram")

    surface = Offscreen(small.shape)
    with LiveReel(make) as reel, pytest.raises(ValueError, match="behind the hologram"):
        Player(surface, reel, [1, 2, 3], small.shape, Options(paced=False)).run()
    surface.close()


def test_live_never_runs_far_ahead(small):
    made = []

    def make():
        for picture in pictures(small, 50):
            made.append(picture.number)
            yield picture

    with LiveReel(make, ahead=2) as reel:
        assert reel.take(5.0)[1].number == 1
        assert reel.take(5.0)[1].number == 2
        assert len(made) <= 6


def test_the_command_line_makes_them(tmp_path, chrmc_here):
    run = chrmc_here
    small = ("--slm", "256x160:8.1e-6")
    for kind in ("point", "grating", "cross-hair"):
        done = run("pattern", kind, *small, "--out", tmp_path / f"{kind}.tif")
        assert done.returncode == 0, done.stderr
    done = run("play", tmp_path / "point.tif", *small, "--headless", "--verify")
    assert done.returncode == 0, done.stderr
    done = run("pattern", "ramp", *small, "--headless", "--verify")
    assert done.returncode == 0, done.stderr

    done = run("bench-sheet", "--out", tmp_path / "sheet.png")
    assert done.returncode == 0, done.stderr
    assert "9.85 mm" in done.stdout and "2.46 mm" in done.stdout
    assert (tmp_path / "sheet.png").read_bytes()[:4] == b"\x89PNG"

    plain = ("--cgh", "fresnel", "--compensation", "none")
    done = run(
        "live", "car-house", "--headless", "--frames", "1:2", *plain, "--verify",
        "--slm", "320x200:40um",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "limit:" in done.stdout and "2 frames in 2 flips" in done.stdout

    for arguments in (
        ("pattern", "grating", "--period", "1", *small, "--out", tmp_path / "x.tif"),
        ("pattern", "ramp", *small, "--out", tmp_path / "x.jpg"),
        ("bench-sheet", "--out", tmp_path / "x.doc"),
        ("live", "no-such-scene", "--headless"),
    ):
        done = run(*arguments)
        assert done.returncode == 2 and len(done.stderr.strip().splitlines()) == 1, done.stderr
