"""Real X servers for the player: one monitor (Xvfb), or two (Xorg with its dummy driver)."""

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

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

    @property
    def environment(self) -> dict[str, str]:
        """For programs that shall use it."""
        kept = {k: v for k, v in os.environ.items() if k != "WAYLAND_DISPLAY"}
        return kept | {"DISPLAY": self.display, "XDG_SESSION_TYPE": "x11"}

    def run(self, *command: str) -> str:
        """Output of a program on this display."""
        done = subprocess.run(
            command, env=self.environment, capture_output=True, text=True, timeout=60
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    def screenshot(self) -> NDArray[np.uint8]:
        """(rows, columns, 3) bytes of the whole desktop."""
        shot = subprocess.run(
            [program("import", "imagemagick"), "-window", "root", "-depth", "8", "rgb:-"],
            env=self.environment, capture_output=True, timeout=60,
        )  # fmt: skip
        assert shot.returncode == 0, shot.stderr
        size = self.run(program("xrandr", "x11-xserver-utils")).split("current ")[1].split(",")[0]
        width, height = (int(v) for v in size.split(" x "))
        return np.frombuffer(shot.stdout, dtype=np.uint8).reshape(height, width, 3)

    def start(self, *arguments: str) -> subprocess.Popen[str]:
        """`chrmc` with these arguments on this display."""
        return subprocess.Popen(
            [*CHRMC, *arguments],
            env=self.environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip


def start_server(command: list[str], log: Path) -> tuple[XServer, subprocess.Popen[bytes]]:
    """Start an X server on a display number of its own choice."""
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
    server, process = start_server(
        [program("Xvfb", "xvfb"), "-screen", "0", screen, "-nolisten", "tcp"], log
    )
    yield server
    process.terminate()
    process.wait()


@pytest.fixture
def x_server_without_opengl(tmp_path: Path) -> Iterator[XServer]:
    """Xvfb that has no GLX."""
    screen = f"{LC_R_1080.width}x{LC_R_1080.height}x24"
    options = ["-screen", "0", screen, "-nolisten", "tcp", "-extension", "GLX"]
    server, process = start_server([program("Xvfb", "xvfb"), *options], tmp_path / "log")
    yield server
    process.terminate()
    process.wait()


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
            *("-noreset", "-nolisten", "tcp", "-sharevts", "-novtswitch"),
        ],
        folder / "output",
    )
    xrandr = program("xrandr", "x11-xserver-utils")
    small = "25.175 640 656 752 800 480 490 492 525 -hsync -vsync"
    large = "40.0 800 840 968 1056 600 601 605 628 +hsync +vsync"
    for name, line, output in (("main", large, "DUMMY0"), ("slm", small, "DUMMY1")):
        server.run(xrandr, "--newmode", name, *line.split())
        server.run(xrandr, "--addmode", output, name)
    left = ["--output", "DUMMY0", "--mode", "main", "--pos", "0x0", "--primary"]
    server.run(xrandr, *left, *["--output", "DUMMY1", "--mode", "slm", "--pos", "800x0"])
    for _ in range(50):  # asking is also what makes the server look at its outputs again
        if "DUMMY1 connected 640x480+800+0" in server.run(xrandr):
            break
        time.sleep(0.1)
    yield server
    process.terminate()
    process.wait()


@pytest.fixture
def small() -> SLM:
    """An SLM of the second monitor's size."""
    return SMALL


@pytest.fixture
def chrmc_command() -> tuple[str, ...]:
    """How to call `chrmc` in a process of its own."""
    return CHRMC


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
