"""Real X servers for the player: one monitor (Xvfb), or two (Xorg with its dummy driver)."""

import contextlib
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from chrmc.files import sha256, write_json
from chrmc.pictures import write_grey
from chrmc.slm import LC_R_1080, SLM

SMALL = SLM("small SLM", 640, 480, 8.1e-6)
CHRMC = (sys.executable, "-c", "from chrmc.cli.main import main; main()")


def program(name: str, package: str) -> str:
    """Path of a program; the test fails, naming the Debian package, where it is missing."""
    for folder in ("/usr/lib/xorg", "/usr/libexec"):
        if (Path(folder) / name).exists():
            return str(Path(folder) / name)  # the server itself, not its console-only wrapper
    path = shutil.which(name)
    if path is None:
        pytest.fail(f"{name} is missing: install the Debian package {package}")
    return path


@dataclass(frozen=True)
class XServer:
    """A running X server."""

    display: str
    started: list[Any] = field(default_factory=list)

    @property
    def environment(self) -> dict[str, str]:
        """For programs that shall use it."""
        kept = {k: v for k, v in os.environ.items() if k != "WAYLAND_DISPLAY"}
        # Mesa's newer releases try Vulkan first, and complain where there is none.
        plain = {"LIBGL_ALWAYS_SOFTWARE": "1"}
        return kept | plain | {"DISPLAY": self.display, "XDG_SESSION_TYPE": "x11"}

    def run(self, *command: str) -> str:
        """Output of a program on this display."""
        done = subprocess.run(
            command, env=self.environment, capture_output=True, text=True, timeout=240
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    def screenshot(self) -> NDArray[np.uint8]:
        """(rows, columns, 3) bytes of the whole desktop."""
        shot = subprocess.run(
            [program("import", "imagemagick"), "-window", "root", "-depth", "8", "rgb:-"],
            env=self.environment, capture_output=True, timeout=240,
        )  # fmt: skip
        assert shot.returncode == 0, shot.stderr
        size = self.run(program("xrandr", "x11-xserver-utils")).split("current ")[1].split(",")[0]
        width, height = (int(v) for v in size.split(" x "))
        return np.frombuffer(shot.stdout, dtype=np.uint8).reshape(height, width, 3)

    def start(self, *arguments: str) -> subprocess.Popen[str]:
        """`chrmc` with these arguments on this display; it ends with the test at the latest."""
        player = subprocess.Popen(
            [*CHRMC, *arguments],
            env=self.environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip
        self.started.append(player)
        return player

    def until(
        self,
        condition: Callable[[], Any],
        player: subprocess.Popen[Any] | None = None,
        seconds: float = 240,
    ) -> Any:
        """Its first value that counts as true; the test fails with the player's words where that
        never comes or the player ends before."""
        deadline = time.monotonic() + seconds
        while True:
            ended = player is not None and player.poll() is not None
            if value := condition():  # which may have come just before the end
                return value
            if ended or time.monotonic() > deadline:
                break
            time.sleep(0.05)
        said: tuple[Any, ...] = ()
        if player is not None:
            player.kill()
            said = player.communicate()
        pytest.fail(f"{'it ended' if ended else f'not in {seconds} s'}; it said: {said}")

    def press(self, key: str, *windows: str) -> None:
        """Press a key for windows, or for what has the focus.

        A window may close at the press. The release goes to nobody in particular, so that it
        cannot fail: the server would hold the key down for every later window.
        """
        for window in windows or ("",):
            there = ("--window", window) if window else ()
            self.run("xdotool", "keydown", *there, key, "keyup", key)

    def run_beside(self, *command: str) -> subprocess.Popen[bytes]:
        """A program that runs on while the test does; its whole group ends with the test."""
        beside = subprocess.Popen(
            command, env=self.environment, start_new_session=True,
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        self.started.append(beside)
        return beside

    def restore(self) -> None:
        """The two monitors' own modes and places, whatever was made of them."""
        for _ in range(100):  # asking is also what makes the server look at its outputs again
            self.run(program("xrandr", "x11-xserver-utils"), *LAYOUT)
            found = self.run("xrandr")
            if all(place in found for place in PLACES):
                return
            time.sleep(0.1)
        pytest.fail("the X server does not take its monitors' modes: " + found)


def start_server(command: list[str], log: Path) -> tuple[XServer, subprocess.Popen[bytes]]:
    """Start an X server on a display number that no other has, chroots included.

    Low numbers are what every server takes first, and clients ask the abstract socket first, which
    file systems share: without one of its own, a server with such a number in a chroot would never
    be asked. Nor does it start anew when its last client leaves: the next would meet it halfway.
    """
    free = f":{random.randrange(1000, 50_000)}"
    command = [*command, free, "-nolisten", "tcp", "-nolisten", "local", "-noreset"]
    read, write = os.pipe()
    with log.open("wb") as output:
        server = subprocess.Popen(
            [*command, "-displayfd", str(write)], pass_fds=[write], stdout=output, stderr=output
        )
    os.close(write)
    with os.fdopen(read) as answer:
        number = answer.readline().strip()  # empty when the server ends instead
    if not number:
        server.wait()
        pytest.fail(f"{command[0]} does not start: {log.read_text()[-800:]}")
    return XServer(f":{number}"), server


@pytest.fixture(scope="session")
def one_monitor(tmp_path_factory: pytest.TempPathFactory) -> Iterator[XServer]:
    """Xvfb with a monitor of the LC-R 1080's size."""
    log = tmp_path_factory.mktemp("xvfb") / "log"
    screen = f"{LC_R_1080.width}x{LC_R_1080.height}x24"
    server, process = start_server([program("Xvfb", "xvfb"), "-screen", "0", screen], log)
    yield server
    process.terminate()
    process.wait()


@pytest.fixture
def x_server_without_opengl(tmp_path: Path) -> Iterator[XServer]:
    """Xvfb that has no GLX."""
    screen = f"{LC_R_1080.width}x{LC_R_1080.height}x24"
    options = ["-screen", "0", screen, "-extension", "GLX"]
    server, process = start_server([program("Xvfb", "xvfb"), *options], tmp_path / "log")
    yield server
    process.terminate()
    process.wait()


LAYOUT = (
    *("--output", "DUMMY0", "--mode", "main", "--pos", "0x0", "--primary"),
    *("--output", "DUMMY1", "--mode", "slm", "--pos", "800x0"),
)
PLACES = ("DUMMY0 connected primary 800x600+0+0", "DUMMY1 connected 640x480+800+0")

XORG = """
Section "Device"
    Identifier "dummy"
    Driver "dummy"
    VideoRam 256000
EndSection
Section "Monitor"
    Identifier "monitor"
    HorizSync 5.0-1000.0
    VertRefresh 5.0-200.0
EndSection
Section "Screen"
    Identifier "screen"
    Device "dummy"
    Monitor "monitor"
    DefaultDepth 24
    SubSection "Display"
        Depth 24
        Virtual 4096 2400
    EndSubSection
EndSection
"""


@pytest.fixture(scope="session")
def two_monitors(tmp_path_factory: pytest.TempPathFactory) -> Iterator[XServer]:
    """Xorg with DUMMY0 (800 × 600, primary) and right of it DUMMY1 (640 × 480)."""
    folder = tmp_path_factory.mktemp("xorg")
    (folder / "xorg.conf").write_text(XORG)
    if not list(Path("/usr/lib/xorg/modules/drivers").glob("dummy_drv.so")):
        pytest.fail("Xorg has no dummy driver: install the package xserver-xorg-video-dummy")
    server, process = start_server(
        [
            program("Xorg", "xserver-xorg-core"),
            *("-config", str(folder / "xorg.conf"), "-logfile", str(folder / "log")),
            *("-noreset", "-sharevts", "-novtswitch"),
        ],
        folder / "output",
    )
    xrandr = program("xrandr", "x11-xserver-utils")
    small = "25.175 640 656 752 800 480 490 492 525 -hsync -vsync"
    large = "40.0 800 840 968 1056 600 601 605 628 +hsync +vsync"
    for name, line, output in (("main", large, "DUMMY0"), ("slm", small, "DUMMY1")):
        server.run(xrandr, "--newmode", name, *line.split())
        server.run(xrandr, "--addmode", output, name)
    server.restore()
    yield server
    process.terminate()
    process.wait()


@pytest.fixture(autouse=True)
def nothing_left_behind(request: pytest.FixtureRequest) -> Iterator[None]:
    """End whatever a test started and did not end, passed or failed."""
    yield
    for name in ("one_monitor", "two_monitors"):
        if name in request.fixturenames:
            end_all(request.getfixturevalue(name).started)


def end_all(started: list[Any]) -> None:
    """Kill programs and what they started."""
    while started:
        process = started.pop()
        if process.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                if os.getpgid(process.pid) == process.pid:
                    os.killpg(process.pid, signal.SIGKILL)
            process.kill()
        process.wait()


PACKAGES = {"kwin_x11": "kwin-x11", "i3": "i3-wm"}


@pytest.fixture
def managed(
    request: pytest.FixtureRequest, two_monitors: XServer, tmp_path: Path
) -> Iterator[tuple[XServer, str]]:
    """The two monitors under the window manager that the test's parameter names."""
    name: str = request.param
    if shutil.which(name) is None and request.node.get_closest_marker("long"):
        pytest.skip(f"{name} is not installed")
    command = [program(name, PACKAGES.get(name, name))]
    if name in ("mutter", "metacity", "xfwm4", "kwin_x11"):
        command = [program("dbus-run-session", "dbus"), "--", *command]
    if name == "mutter":
        command.append("--x11")
    if name == "fluxbox":  # its defaults call a program for the wallpaper, which puts up a window
        (tmp_path / "overlay").write_text("background: none\n")
        (tmp_path / "init").write_text(f"session.styleOverlay: {tmp_path}/overlay\n")
        command += ["-rc", str(tmp_path / "init")]
    if name == "twm":  # it asks where each window shall go, and holds the server meanwhile
        (tmp_path / "twmrc").write_text("RandomPlacement\n")
        command += ["-f", str(tmp_path / "twmrc")]
    manager = two_monitors.run_beside(*command)
    check = ("xprop", "-root", "_NET_SUPPORTING_WM_CHECK")
    deadline = time.monotonic() + 30
    while name != "twm" and "window id" not in two_monitors.run(*check):
        if manager.poll() is not None or time.monotonic() > deadline:
            pytest.fail(f"{name} does not start")
        time.sleep(0.05)
    two_monitors.restore()  # some choose modes themselves
    yield two_monitors, name
    end_all(two_monitors.started)
    two_monitors.run("xprop", "-root", "-remove", "_NET_SUPPORTING_WM_CHECK")
    two_monitors.run("xprop", "-root", "-remove", "_NET_SUPPORTED")
    two_monitors.restore()


@contextlib.contextmanager
def labelled(server: XServer, output: str, label: str) -> Iterator[None]:
    """Give an output the EDID of a monitor of that name."""
    from Xlib import display

    block = bytearray(128)
    block[:8] = b"\x00\xff\xff\xff\xff\xff\xff\x00"
    block[72:90] = b"\x00\x00\x00\xfc\x00" + label.encode().ljust(13, b"\n")
    connection = display.Display(server.display)
    resources = connection.screen().root.xrandr_get_screen_resources()
    atom, kind = (connection.intern_atom(name) for name in ("EDID", "INTEGER"))
    for number in resources.outputs:
        info = connection.xrandr_get_output_info(number, resources.config_timestamp)
        if info.name == output:
            break
    connection.xrandr_change_output_property(number, atom, kind, 0, (8, list(block)))
    connection.sync()
    yield
    connection.xrandr_delete_output_property(number, atom)
    connection.sync()
    connection.close()


@pytest.fixture
def label_maker() -> Callable[..., Any]:
    """`label_maker(server, output, label)` as a context."""
    return labelled


@pytest.fixture
def small() -> SLM:
    """An SLM of the second monitor's size."""
    return SMALL


@pytest.fixture
def chrmc_command() -> tuple[str, ...]:
    """How to call `chrmc` in a process of its own."""
    return CHRMC


@pytest.fixture
def chrmc_here(
    capfd: pytest.CaptureFixture[str],
) -> Callable[..., subprocess.CompletedProcess[str]]:
    """`chrmc` in this process, which starts in no time: (status, output, errors) of arguments."""
    from chrmc.cli.main import main

    def run(*arguments: Any) -> subprocess.CompletedProcess[str]:
        capfd.readouterr()
        words = [str(a) for a in arguments]
        with pytest.raises(SystemExit) as ended:
            main(words)
        return subprocess.CompletedProcess(words, int(ended.value.code or 0), *capfd.readouterr())

    return run


@pytest.fixture
def video_maker() -> Callable[..., Path]:
    """`make_video(folder, slm, count, seed=0)`."""
    return make_video


def make_video(folder: Path, slm: SLM, count: int, seed: int = 0) -> Path:
    """A stored video of noise frames: every pixel of every frame is different from the next."""
    rng = np.random.default_rng(seed)
    entries = []
    for number in range(1, count + 1):
        path = folder / f"frame_{number:04d}.tif"
        write_grey(path, rng.integers(0, 256, slm.shape, dtype=np.uint8))
        entries.append({"number": number, "file": path.name, "sha256": sha256(path)})
    manifest = {
        "format": 1, "slm": asdict(slm), "wavelength": 532e-9, "scene": {"pixel_pitch": 4e-5},
        "methods": {}, "encoding": "ssb", "scale": 1.0, "frames": entries,
    }  # fmt: skip
    write_json(folder / "manifest.json", manifest)
    return folder
