"""The drawing code on a real OpenGL context without a screen (EGL)."""

import csv
import os
import subprocess
import sys

import moderngl
import numpy as np
import pytest

from chrmc.slm import LC_R_1080
from display.gl import Offscreen, Painter, Trigger, headless_context
from display.log import FlipLog
from display.player import Options, Player, play_together
from display.playlist import open_playlist
from display.prefetch import Ring


@pytest.fixture
def screen(small):
    """A headless surface; OpenGL must report no error before and after the test."""
    surface = Offscreen(small.shape)
    assert surface.context.error == "GL_NO_ERROR"
    yield surface
    assert surface.context.error == "GL_NO_ERROR"
    surface.close()


def every_level(shape):
    """All 256 levels in an order that shows mirrored, turned or shifted pictures."""
    rows, columns = np.indices(shape)
    return ((rows * 7 + columns * 3 + rows * columns) % 256).astype(np.uint8)


@pytest.mark.parametrize("channel", ["all", "red", "green", "blue"])
def test_frames_are_drawn_to_the_pixel(screen, small, channel):
    painter = Painter(screen.context, small.shape, channel)
    frame = every_level(small.shape)
    painter.upload(frame)
    painter.draw(screen.size)
    drawn = screen.read()
    for index, name in enumerate(("red", "green", "blue")):
        wanted = frame if channel in ("all", name) else np.zeros_like(frame)
        assert np.array_equal(drawn[:, :, index], wanted)


def test_srgb_encoding_stays_off(screen, small):
    painter = Painter(screen.context, small.shape)
    painter.upload(np.full(small.shape, 100, np.uint8))
    painter.draw(screen.size)
    assert np.all(screen.read() == 100)


def test_full_size_frames_are_exact():
    surface = Offscreen(LC_R_1080.shape)
    painter = Painter(surface.context, LC_R_1080.shape)
    frame = np.random.default_rng(1).integers(0, 256, LC_R_1080.shape, dtype=np.uint8)
    painter.upload(frame)
    painter.draw(surface.size)
    assert np.array_equal(surface.read(), frame[:, :, None].repeat(3, axis=2))
    assert surface.context.error == "GL_NO_ERROR"
    surface.close()


@pytest.mark.parametrize(
    ("corner", "rows", "columns"),
    [
        ("top-left", slice(0, 9), slice(0, 9)),
        ("top-right", slice(0, 9), slice(-9, None)),
        ("bottom-left", slice(-9, None), slice(0, 9)),
        ("bottom-right", slice(-9, None), slice(-9, None)),
    ],
)
def test_the_trigger_is_a_square_in_its_corner(screen, small, corner, rows, columns):
    painter = Painter(screen.context, small.shape, trigger=Trigger(corner, 9))
    frame = every_level(small.shape)
    painter.upload(frame)
    for on in (False, True):
        painter.draw(screen.size, on)
        wanted = frame.copy()
        wanted[rows, columns] = 255 * on
        assert np.array_equal(screen.read()[:, :, 1], wanted)
        assert np.array_equal(painter.expected(frame, on), screen.read())


def preview(screen, shape, frame, size):
    """(height, width) levels of a frame on a framebuffer of another size."""
    buffer = screen.context.simple_framebuffer(size, components=4)
    buffer.use()
    painter = Painter(screen.context, shape)
    painter.upload(frame)
    painter.draw(size)
    raw = np.frombuffer(buffer.read(components=1, alignment=1), np.uint8)
    screen.bind()
    buffer.release()
    return raw.reshape(size[::-1])[::-1]


def test_a_smaller_preview_averages_neighbourhoods(screen, small):
    frame = every_level(small.shape)
    for size in ((small.width // 2, small.height // 2), (200, 150), (576, 432)):
        seen = preview(screen, small.shape, frame, size)
        weights = [raised_cosine(n, m) for n, m in zip(small.shape, size[::-1], strict=True)]
        wanted = weights[0] @ frame.astype(float) @ weights[1].T
        assert np.abs(seen - wanted).max() <= 0.6
        assert seen.mean() == pytest.approx(frame.mean(), abs=0.5)


def raised_cosine(count, to):
    """(to, count) weights of 3 pixels' width, each row's sum 1."""
    ratio = count / to
    away = (np.arange(count) + 0.5 - (np.arange(to)[:, None] + 0.5) * ratio) / (1.5 * ratio)
    weights = np.where(np.abs(away) <= 1, 1 + np.cos(np.pi * away), 0)
    return weights / weights.sum(axis=1, keepdims=True)


def test_a_preview_keeps_the_aspect(screen, small):
    white = np.full(small.shape, 255, np.uint8)
    wide = preview(screen, small.shape, white, (500, 150))
    assert np.array_equal(np.flatnonzero(wide.any(axis=0)), np.arange(150, 350))
    assert wide[:, 150:350].all()
    tall = preview(screen, small.shape, white, (320, 700))
    assert np.array_equal(np.flatnonzero(tall.any(axis=1)), np.arange(230, 470))


def test_a_shrunk_zone_plate_shows_no_ghosts(screen, small):
    """Where the rings are finer than the preview's pixels it is grey, not rings again."""
    rows, columns = small.shape
    y, x = np.indices(small.shape) - np.array([(rows - 1) / 2, (columns - 1) / 2])[:, None, None]
    radius = np.hypot(x, y)
    # radius/640 rings to a pixel: at 213 pixels from the middle a ring is as wide as a pixel of
    # this preview, and single samples show a second centre there.
    frame = np.rint(127.5 + 127.5 * np.cos(np.pi * radius**2 / 640)).astype(np.uint8)
    seen = preview(screen, small.shape, frame, (213, 160))
    far = np.hypot(*(np.indices(seen.shape) - np.array([80, 106])[:, None, None])) > 62
    assert seen[far].std() < 0.06 * seen[~far].std()
    assert frame[1::3, 1::3][:160][radius[1::3, 1::3][:160] > 186].std() > 80  # samples do


def test_a_larger_preview_repeats_pixels(screen, small):
    frame = every_level(small.shape)
    seen = preview(screen, small.shape, frame, (small.width * 2, small.height * 2))
    assert np.array_equal(seen[::2, ::2], frame) and np.array_equal(seen[1::2, 1::2], frame)


def test_wrong_frames_are_refused(screen, small):
    painter = Painter(screen.context, small.shape)
    for wrong in (np.zeros((4, 4), np.uint8), np.zeros(small.shape, np.uint16)):
        with pytest.raises(ValueError):
            painter.upload(wrong)
    with pytest.raises(ValueError):
        Painter(screen.context, small.shape, "ultraviolet")
    with pytest.raises(ValueError):
        Trigger("middle")


def test_a_broken_context_is_noticed(screen, small):
    painter = Painter(screen.context, small.shape)
    screen.context.enable_direct(0xFFFF)  # no such thing: OpenGL raises an error
    with pytest.raises(OSError, match="OpenGL reports"):
        painter.check()


def play(screen, folder, path, **options):
    playlist = open_playlist(folder)
    told = []
    reel = Ring(playlist.read, len(playlist), options.get("loop", False))
    with reel as ring, FlipLog(path) as log:
        numbers = [e.number for e in playlist.entries]
        choices = Options(**({"paced": False, "verify": True} | options))
        player = Player(screen, ring, numbers, playlist.slm.shape, choices, log, told.append)
        summary = player.run()
    return summary, list(csv.DictReader(path.open())), told


def test_a_video_plays_once_through_and_every_flip_is_logged(screen, small, tmp_path, video_maker):
    folder = video_maker(tmp_path / "video", small, 12)
    summary, rows, _ = play(screen, folder, tmp_path / "log.csv")
    assert summary.mismatches == 0 and summary.frames == summary.flips == 12
    assert [int(r["frame"]) for r in rows] == list(range(1, 13))
    hashes = {e.number: e.sha256 for e in open_playlist(folder).entries}
    assert all(r["sha256"] == hashes[int(r["frame"])] for r in rows)
    times = [float(r["time"]) for r in rows]
    gaps = [float(r["interval"]) for r in rows[1:]]
    assert rows[0]["interval"] == "" and np.allclose(np.diff(times), gaps, atol=2e-6)


def test_a_rate_is_kept_and_frames_are_held(screen, small, tmp_path, video_maker):
    folder = video_maker(tmp_path / "video", small, 5)
    summary, rows, _ = play(screen, folder, tmp_path / "log.csv", every=3, paced=True)
    assert [int(r["frame"]) for r in rows] == [n for n in range(1, 6) for _ in range(3)]
    assert [r["shown"] for r in rows[:6]] == ["new", "held", "held"] * 2
    assert summary.intervals[-1] > 0 and sum(summary.intervals) >= 14 / 60 * 0.95


@pytest.mark.parametrize("damage", ["missing", "altered"])
def test_bad_frames_are_skipped_or_stop(screen, small, tmp_path, video_maker, damage):
    folder = video_maker(tmp_path / "video", small, 5)
    bad = folder / "frame_0003.tif"
    if damage == "missing":
        bad.unlink()
    else:
        bad.write_bytes(bad.read_bytes()[:-5] + b"wrong")
    summary, rows, told = play(screen, folder, tmp_path / "log.csv", on_bad_frame="skip")
    assert [int(r["frame"]) for r in rows] == [1, 2, 4, 5]
    assert len(summary.faults) == 1 and "frame 3" in summary.faults[0]
    assert any("frame 3" in line for line in told)
    with pytest.raises(OSError, match=r"frame 3: .*log saved in"):
        play(screen, folder, tmp_path / "log.csv", on_bad_frame="stop")
    rows = list(csv.DictReader((tmp_path / "log.csv").open()))
    assert [int(r["frame"]) for r in rows] == [1, 2]


def test_a_loop_of_bad_frames_ends(screen, small, tmp_path, video_maker):
    folder = video_maker(tmp_path / "video", small, 3)
    for path in folder.glob("frame_*"):
        path.unlink()
    with pytest.raises(OSError, match=r"no frame can be shown|missing"):
        play(screen, folder, tmp_path / "log.csv", loop=True)


def test_a_loop_ends_after_its_seconds(screen, small, tmp_path, video_maker):
    folder = video_maker(tmp_path / "video", small, 2)
    for seconds in (0.5, 5, 50):  # in which a busy machine shows few frames
        summary, rows, _ = play(
            screen, folder, tmp_path / "log.csv",
            loop=True, seconds=seconds, trigger=Trigger(size=8),
        )  # fmt: skip
        if len(rows) > 4:
            break
    assert summary.mismatches == 0
    assert [int(r["frame"]) for r in rows[:4]] == [1, 2, 1, 2]


def test_keys_steer(screen, small, tmp_path, video_maker):
    folder = video_maker(tmp_path / "video", small, 9)
    script = [[], ["4", "enter"], ["space"], [], ["right"], ["left"], ["end"], ["space"]]
    flip, flips, given = screen.flip, [], []

    def pressed() -> list[str]:
        # The next key when the last one's frame is on the screen, however slow the disk is.
        if len(given) > len(flips) or len(given) == len(script):
            return []
        given.append(script[len(given)])
        return given[-1]

    screen.pressed = pressed
    screen.flip = lambda: (flips.append(1), flip())[1]
    _, rows, _ = play(screen, folder, tmp_path / "log.csv")
    shown = [(int(r["frame"]), r["shown"]) for r in rows]
    assert shown == [
        (1, "new"), (4, "new"), (4, "paused"), (4, "paused"), (5, "new"), (4, "new"), (9, "new"),
    ]  # fmt: skip


def test_two_players_at_once(small, tmp_path, video_maker):
    players, logs, rings = [], [], []
    for seed in (1, 2):
        folder = video_maker(tmp_path / f"video{seed}", small, 8, seed)
        playlist = open_playlist(folder)
        ring = Ring(playlist.read, len(playlist))
        rings.append(ring.__enter__())
        logs.append(FlipLog(tmp_path / f"{seed}.csv"))
        numbers = [e.number for e in playlist.entries]
        options = Options(verify=True, fps=40)
        surface = Offscreen(small.shape)
        players.append(Player(surface, ring, numbers, small.shape, options, logs[-1]))
    summaries = play_together(players)
    assert [s.mismatches for s in summaries] == [0, 0] and [s.frames for s in summaries] == [8, 8]
    for player, log, ring in zip(players, logs, rings, strict=True):
        ring.__exit__()
        log.__exit__(None, None, None)
        player.surface.bind()
        player.surface.close()
    for seed in (1, 2):
        assert len((tmp_path / f"{seed}.csv").read_text().splitlines()) == 9


def test_no_egl_is_one_line_that_names_the_package(monkeypatch):
    def refuse(*_args, **_settings):
        raise Exception("libEGL.so not loaded")

    monkeypatch.setattr(moderngl, "create_context", refuse)
    with pytest.raises(OSError, match="libegl1"):
        headless_context()


def test_without_a_display_it_is_one_line(small, tmp_path, video_maker, chrmc_command):
    folder = video_maker(tmp_path / "video", small, 1)
    environment = {k: v for k, v in os.environ.items() if "DISPLAY" not in k}
    for arguments in (("play", str(folder)), ("monitors",)):
        done = subprocess.run(
            [*chrmc_command, *arguments],
            env=environment, capture_output=True, text=True, timeout=240,
        )  # fmt: skip
        assert done.returncode == 2, arguments
        assert len(done.stderr.strip().splitlines()) == 1, done.stderr


def test_command_line(small, tmp_path, video_maker, chrmc_here):
    folder = video_maker(tmp_path / "video", small, 3)
    run = chrmc_here
    log = tmp_path / "log.csv"
    done = run("play", folder, "--headless", "--verify", "--log", log)
    assert done.returncode == 0, done.stderr
    assert "equals its file to the pixel" in done.stdout
    assert len(log.read_text().splitlines()) == 4
    assert (tmp_path / "log.png").read_bytes()[:4] == b"\x89PNG"
    picture = tmp_path / "intervals.pdf"
    assert run("play", folder, "--headless", "--log", log, "--plot", picture).returncode == 0
    assert picture.read_bytes()[:4] == b"%PDF"

    for arguments in (
        ("play", folder, "--headless", "--slm", "1024x768:8e-6"),
        ("play", folder, "--headless", "--fps", "30", "--every", "2"),
        ("play", folder, "--headless", "--monitor", "0"),
        ("play", tmp_path / "nowhere", "--headless"),
        ("play", folder, "--headless", "--colour", "red"),
        ("play", folder, "--headless", "--plot", tmp_path / "intervals.doc"),
    ):
        done = run(*arguments)
        assert done.returncode == 2, arguments
        assert len(done.stderr.strip().splitlines()) == 1, done.stderr
        assert "Traceback" not in done.stderr and "Usage" not in done.stderr

    (folder / "frame_0002.tif").unlink()
    assert run("play", folder, "--headless").returncode == 1
    assert run("play", folder, "--headless", "--on-bad-frame", "stop").returncode == 2


def test_importing_loads_no_graphics():
    code = (
        "import sys, display, display.playlist, display.timing, display.monitors;"
        "print([m for m in ('glfw', 'moderngl', 'matplotlib', 'OpenImageIO') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.strip() == "[]", done.stdout + done.stderr
