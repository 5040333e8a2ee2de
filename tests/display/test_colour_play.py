"""Videos in colours on a panel: which laser's frame is on, at which rate, with which squares."""

import socket
from pathlib import Path

import numpy as np
import pytest

import chrmc
import display
from chrmc.cli.main import main
from display.colours import colour_of, laser_bytes

PANEL = chrmc.SLM("tiny", 64, 48, 8e-6)
LASERS = (638e-9, 532e-9, 450e-9)


@pytest.fixture(scope="module")
def video(tmp_path_factory: pytest.TempPathFactory) -> chrmc.ColourVideo:
    dots = chrmc.PointCloud(
        [[0, 0, 0], [5e-5, 0, 0]], [1.0, 1], [0.0, 1], [[1, 0.5, 0.5], [0.5, 1, 1]]
    )
    poses = [chrmc.Pose(np.eye(3), [0, 0, z]) for z in (0.01, 0.011)]
    folder = tmp_path_factory.mktemp("play") / "video"
    scene = chrmc.PointScene("dots", {"dots": dots}, {"dots": poses})
    made = chrmc.generate(scene, folder, slm=PANEL, wavelength=LASERS, check_pixels=0)
    assert isinstance(made, chrmc.ColourVideo)
    return made


def shown_frames(video: chrmc.ColourVideo, **how: object) -> tuple[list, list]:
    flips, pictures = [], []
    with display.Screen(headless=True, slm=PANEL) as screen:
        for flip in screen.play(video, paced=False, **how):
            flips.append(flip)
            pictures.append(screen.read())
    return flips, pictures


def test_lasers_follow_each_other(video: chrmc.ColourVideo) -> None:
    flips, pictures = shown_frames(video, order=(532e-9, 638e-9, 450e-9))
    assert [f.frame for f in flips] == [1, 1, 1, 2, 2, 2]
    assert [colour_of(f) for f in flips] == ["532nm", "638nm", "450nm"] * 2
    for k, channel in enumerate((1, 0, 2)):
        assert np.array_equal(pictures[3 + k][..., 0], video.read(2)[..., channel])


def test_or_each_drives_a_channel(video: chrmc.ColourVideo) -> None:
    flips, pictures = shown_frames(video, colours="channels")
    assert [f.frame for f in flips] == [1, 2] and colour_of(flips[0]) == ""
    for picture, number in zip(pictures, (1, 2), strict=True):
        assert np.array_equal(picture, video.read(number))


@pytest.mark.parametrize("corner", ["top-left", "bottom-right"])
def test_a_square_says_which_laser(video: chrmc.ColourVideo, corner: str) -> None:
    trigger = display.Trigger(corner, 5)
    with display.Screen(headless=True, slm=PANEL, trigger=trigger) as screen:
        seen = [screen.read()[..., 0] for _ in screen.play(video, paced=False)]
    for index, picture in enumerate(seen):
        strip = picture[:5] if corner == "top-left" else picture[-5:, ::-1]
        for k in range(3):  # the first square toggles with every picture
            square = strip[:, 5 * (k + 1) : 5 * (k + 2)]
            assert (square == (255 if k == index % 3 else 0)).all()
        assert (strip[:, :5] == (255 if index % 2 == 0 else 0)).all()


def test_rates_are_of_whole_frames(video: chrmc.ColourVideo) -> None:
    with display.Screen(headless=True, slm=PANEL) as screen:
        flips = list(screen.play(video, fps=20))
        assert flips[-1].time - flips[0].time > 0.9 * 5 / 60
        with pytest.raises(ValueError, match=r"need 90 pictures a second.*at most 20 frames"):
            next(screen.play(video, fps=30))
        list(screen.play(video, fps=50, colours="channels", every=None))


def test_a_byte_for_each_laser(video: chrmc.ColourVideo) -> None:
    flips, _ = shown_frames(video)
    say = laser_bytes(["638nm", "532nm", "450nm"])
    assert b"".join(say(f) for f in flips) == b"\1\2\3\1\2\3"


def test_refusals(video: chrmc.ColourVideo) -> None:
    with display.Screen(headless=True, slm=PANEL) as screen:
        with pytest.raises(ValueError, match="names each laser once: 638, 532, 450 nm, not 532"):
            screen.play(video, order=(532e-9,))
        with pytest.raises(ValueError, match="sequence or channels"):
            screen.play(video, colours="mixed")
        with pytest.raises(ValueError, match="one colour"):
            screen.play(str(video.folder / "532nm"), order=(532e-9,))
        with pytest.raises(ValueError, match="exclude each other"):
            screen.play(video, planes=3)
    with (
        display.Screen(headless=True, slm=PANEL, trigger=display.Trigger(size=30)) as screen,
        pytest.raises(OSError, match="wider than the panel"),
    ):
        list(screen.play(video, paced=False))


def test_the_command(
    video: chrmc.ColourVideo, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as heard:
        heard.bind(("127.0.0.1", 0))
        heard.settimeout(60)
        address = f"127.0.0.1:{heard.getsockname()[1]}"
        log = tmp_path / "flips.csv"
        words = [str(video.folder), "--headless", "--verify", "--log", str(log), "--udp", address]
        with pytest.raises(SystemExit) as ended:
            main(["play", *words, "--order", "450nm,638nm,532nm", "--trigger", "top-left",
                  "--trigger-size", "5"])  # fmt: skip
        assert ended.value.code == 0
        assert [heard.recv(8) for _ in range(6)] == [b"\1", b"\2", b"\3"] * 2
    assert "450nm/frame_0001.tif" in log.read_text("utf-8")
    with pytest.raises(SystemExit) as ended:
        main(["play", str(video.folder), "--headless", "--fps", "30"])
    assert ended.value.code == 2
    assert "at most 20 frames" in capsys.readouterr().err
