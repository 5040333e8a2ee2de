"""Every command that writes, while its folder fills up, vanishes, or takes no more files.

One line, status 2, nothing half written; then the same command goes on.
"""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from display.log import COLUMNS

ROOT = Path(__file__).parents[3]
PANEL = ["--slm", "192x120:81um"]
OWN = '''
import time
from pathlib import Path
import numpy as np
import chrmc

HERE = Path(__file__).parent
rng = np.random.default_rng(3)
cloud = chrmc.PointCloud(rng.uniform(-5e-4, 5e-4, (60, 3)), np.ones(60), rng.uniform(0, 6, 60))
poses = [chrmc.Pose.from_rotvec([0, 0.004 * k, 0], [0, 0, 0.25]) for k in range(8)]
scene = chrmc.PointScene("turning", {"car": cloud}, {"car": poses})

def field(cloud, slm, wavelength, window, passband):
    """Stands still after some frames until there is a file "go"."""
    with (HERE / "made").open("a") as file:
        file.write(".")
    while (HERE / "made").stat().st_size > 3 and not (HERE / "go").exists():
        time.sleep(0.01)
    return chrmc.compute_field(cloud, slm, wavelength, "rt", window=window, passband=passband)

def light(grey):
    with (HERE / "measured").open("a") as file:
        file.write(".")
    return grey**2 + 1
'''
RECIPE = """
scenes = ["own.py:scene"]
methods = [{ cgh = "own.py:field", compensation = "none" }]
encodings = ["ssb", "real"]
slms = "192x120:40um"
frames = "1:2"
"""
# Commands that write for long: what shows that they are in the middle, what they leave.
LONG = {
    "generate": (["generate", "own.py:scene", "--out", "place/v", "--cgh", "own.py:field",
                  "--compensation", "none", *PANEL], "place/v/frame_0002.tif", "place/v/*.tif", 8),
    "workers": (["generate", "own.py:scene", "--out", "place/v", "--cgh", "own.py:field",
                 "--compensation", "none", "--group", "2", *PANEL, "--workers", "2"],
                "place/v/frame_*.tif", "place/v/*.tif", 8),
    "sweep": (["sweep", "r.toml", "--folder", "place/v"], "place/v/rows/*.json",
              "place/v/rows/*.json", 2),
    "scene": (["scene", "car-house", "--out", "place/v", "--frames", "1:40"],
              "place/v/frame_0002.exr", "place/v/*.exr", 40),
    "reconstruct": (["reconstruct", "video", "--depths", "245mm:270mm:200", "--frame", "1",
                     "--out", "place/v"], "place/v/*2*.png", "place/v/depth_0*.png", 200),
    "tradeoff": (["bench", "tradeoff", "own.py:scene", *PANEL, "--points", "10", "--rounds", "1",
                  "--frames", "1", "--no-images", "--out", "place/v"], "place/v/tradeoff.csv",
                 "place/v/tradeoff.*", 2),
    "extremes": (["bench", "extremes", "--minutes", "0.1", "--seed", "7", "--out", "place/v"],
                 "place/v/extremes.csv", "place/v/extremes.*", 2),
}  # fmt: skip
# Commands that write one file in the end.
SHORT = {
    "check": ["check", "video", "--plot", "place/f.png"],
    "panorama": ["panorama", "video", "--out", "place/f.png"],
    "inspect": ["inspect", "car-house", *PANEL, "--out", "place/f.png"],
    "pattern": ["pattern", "point", *PANEL, "--out", "place/f.png"],
    "movie": ["reconstruct", "video", "--depth", "252mm", "--movie", "place/f.gif"],
    "image": ["reconstruct", "video", "--frame", "1", "--depth", "252mm", "--out", "place/f.exr"],
    "points": ["generate", "own.py:scene", "--out", "v", "--frames", "1:1", *PANEL,
               "--export-points", "place/f.npz"],
    "log": ["play", "video", "--headless", "--log", "place/f.csv"],
    "plot": ["sweep", "r.toml", "--plot", "encoding,psnr", "--out", "place/f.pdf"],
    "response": ["calibrate-response", "--headless", *PANEL, "--measure", "own.py:light",
                 "--steps", "9", "--repeats", "2", "--settle", "0", "--out", "place/f.csv"],
    "encodings": ["bench", "encodings", "own.py:scene", *PANEL, "--out", "place/f.csv"],
    "rmc": ["bench", "rmc", "own.py:scene", *PANEL, "--frames", "1:2", "--out", "place/f.png"],
}  # fmt: skip
LIVE = ["live", "own.py:scene", "--headless", "--loop", "--cgh", "rt", "--compensation", "none",
        *PANEL, "--log", "place/f.csv"]  # fmt: skip
quick = [pytest.param("generate", "full"), pytest.param("pattern", "closed")]
UNPRIVILEGED = ["setpriv", "--bounding-set", "-all"]
"""The superuser writes wherever it likes; without its capabilities it is as anybody."""


@pytest.fixture
def work(tmp_path: Path, stored_video: Path) -> Path:
    (tmp_path / "own.py").write_text(OWN)
    (tmp_path / "r.toml").write_text(RECIPE)
    (tmp_path / "place").mkdir()
    shutil.copytree(stored_video, tmp_path / "video")
    return tmp_path


def started(arguments: list[str], work: Path, *prefix: str) -> "subprocess.Popen[str]":
    plain = UNPRIVILEGED if os.geteuid() == 0 and not prefix else prefix
    return subprocess.Popen(
        [*plain, sys.executable, "-m", "chrmc", *arguments],
        cwd=work,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def finished(process: "subprocess.Popen[str]", work: Path, status: int) -> str:
    """What was said on stderr; AssertionError for another exit status."""
    (work / "go").touch()
    _, told = process.communicate(timeout=250)
    assert process.returncode == status, told
    if status == 2:
        assert told.count("\n") == 1, told
        assert "Traceback" not in told and "[Errno" not in told, told
    return told


def in_the_middle(process: "subprocess.Popen[str]", work: Path, sign: str) -> None:
    while not any(work.glob(sign)):
        assert process.poll() is None, process.communicate()[1]
        time.sleep(0.005)


def goes_on(name: str, work: Path) -> None:
    """The same command ends well, and all is there."""
    arguments = LONG[name][0] if name in LONG else SHORT[name]
    (work / "go").touch()
    finished(started(arguments, work), work, 0)
    if name in LONG:
        assert len(list(work.glob(LONG[name][2]))) == LONG[name][3]
    else:
        assert (work / arguments[-1]).stat().st_size > 10
    assert not list(work.rglob("*.partial*"))


def full(
    arguments: list[str], work: Path, kilobytes: int, spare: int = 0, setting: str = ""
) -> tuple[int, str]:
    """Run a command with a small disk of its own in place of `place`; what it left is in `left`.

    spare : kilobytes that it holds already; setting : NAME=VALUE for the command
    """
    script = (
        f"mount -t tmpfs -o size={kilobytes}k none place || exit; "
        f"head -c {1024 * spare} /dev/zero >place/spare; "
        '"$@" >/dev/null 2>told; status=$?; cp -a place left; exit $status'
    )
    (work / "go").touch()
    # The superuser needs no namespace of users, which a system in a folder does not give.
    apart = ["unshare", "-m" if os.geteuid() == 0 else "-rm"]
    own = ["env", setting] if setting else []
    command = [*apart, "sh", "-c", script, "sh", *own, sys.executable, "-m", "chrmc"]
    run = subprocess.run(
        [*command, *arguments], cwd=work, env={**os.environ, "PYTHONPATH": str(ROOT)}
    )
    if not (work / "told").exists():
        pytest.skip("this system lets no namespace mount a disk")
    return run.returncode, (work / "told").read_text()


def chosen(names: dict, disturbances: list[str]) -> list:  # type: ignore[type-arg]
    cases = [pytest.param(n, d, marks=pytest.mark.long) for n in names for d in disturbances]
    first = [c for c in quick if c.values[0] in names and c.values[1] in disturbances]
    return first + [c for c in cases if all(c.values != f.values for f in first)]


@pytest.mark.timeout(600)
@pytest.mark.parametrize(("name", "how"), chosen(LONG, ["full", "removed", "closed", "linked"]))
def test_long_work_that_is_disturbed_keeps_what_is_finished(
    name: str, how: str, work: Path
) -> None:
    arguments, sign, made, _ = LONG[name]
    if how == "full":
        status, told = full(arguments, work, 40 if name == "extremes" else 84)
        assert status == 2, told
        assert told.count("\n") == 1 and "[Errno" not in told, told
        assert "no space" in told.lower() and "partial" not in told, told
        assert not list((work / "left").rglob("*.partial*"))
        shutil.rmtree(work / "place")
        (work / "left").rename(work / "place")
        if name in ("generate", "workers"):
            from chrmc.store.video import open_video

            kept = {p.name for p in work.glob(made)}
            assert 0 < len(kept) < 8
            assert kept == {f["file"] for f in open_video(work / "place/v").frames}
        goes_on(name, work)
        return
    if how == "linked":
        (work / "elsewhere").mkdir()
        (work / "place").rmdir()
        (work / "place").symlink_to(work / "nowhere")
        finished(started(arguments, work), work, 2)
        assert not list((work / "elsewhere").iterdir())
        assert not (work / "nowhere").exists()
        (work / "place").unlink()
        goes_on(name, work)
        return
    process = started(arguments, work)
    in_the_middle(process, work, sign)
    if how == "removed":
        (work / "place").rename(work / "away")
    else:
        for folder in [p for p in work.glob("place/**/") if p.is_dir()]:
            folder.chmod(0o555)
    finished(process, work, 2)
    if how == "removed":
        assert not (work / "place").exists()
        (work / "away").rename(work / "place")
    for folder in [work / "place", *(p for p in work.rglob("place/**/") if p.is_dir())]:
        folder.chmod(0o755)
    assert any(work.glob(sign))
    goes_on(name, work)


@pytest.mark.timeout(600)
@pytest.mark.parametrize(("name", "how"), chosen(SHORT, ["full", "closed", "linked", "folder"]))
def test_a_file_that_cannot_be_written_is_one_line(name: str, how: str, work: Path) -> None:
    arguments = SHORT[name]
    target = work / next(word for word in arguments if word.startswith("place/"))
    if how == "full":
        small = name in ("log", "response", "encodings")  # all of it fits a page
        status, told = full(arguments, work, 4, 4 if small else 0)
        if status == 0:
            return  # it was small enough
        assert status == 2, told
        assert told.count("\n") == 1 and "[Errno" not in told, told
        assert not list((work / "left").rglob("*.partial*"))
        return
    (work / "go").touch()
    if how == "closed":
        (work / "place").chmod(0o555)
    elif how == "linked":
        (work / "place").rmdir()
        (work / "place").symlink_to(work / "nowhere")
    else:
        target.mkdir()
    finished(started(arguments, work), work, 2)
    assert not (work / "nowhere").exists()
    if how == "closed":
        (work / "place").chmod(0o755)
    elif how == "linked":
        (work / "place").unlink()
    else:
        target.rmdir()
    assert not list(work.rglob("*.partial*"))
    assert not (work / "measured").exists() or how == "full"  # told before a panel is measured


@pytest.mark.long
@pytest.mark.timeout(600)
@pytest.mark.parametrize("how", ["full", "removed", "SIGINT", "SIGTERM", "SIGHUP", "SIGKILL"])
def test_a_live_log_is_whole_up_to_its_last_flip(how: str, work: Path) -> None:
    if how == "full":
        status, told = full(LIVE, work, 12)
        assert status == 2 and told.count("\n") == 1, told
        assert "place/f.csv: no space is left" in told
        log = work / "left/f.csv"
    else:
        process = started(LIVE, work)
        log = work / "place/f.csv"
        while not log.exists() or log.read_text().count("\n") < 20:
            assert process.poll() is None, process.communicate()[1]
            time.sleep(0.005)
        if how == "removed":
            (work / "place").rename(work / "away")
            process.send_signal(signal.SIGINT)
            assert "place is gone" in finished(process, work, 2)
            assert not (work / "place").exists()
            log = work / "away/f.csv"
        else:
            process.send_signal(signal.Signals[how])
            killed = how == "SIGKILL"
            told = finished(process, work, -signal.SIGKILL if killed else 130)
            assert killed or told.endswith("chrmc: interrupted; what was finished is kept\n")
            assert killed or (work / "place/f.png").stat().st_size > 5000
    text = log.read_text()
    assert text.endswith("\n") and text.count("\n") > 10
    assert {line.count(",") for line in text.splitlines()} == {len(COLUMNS) - 1}
    assert [int(line.split(",")[0]) for line in text.splitlines()[1:]] == list(
        range(1, text.count("\n"))
    )


@pytest.mark.long
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_calibration_that_is_ended_leaves_the_one_before(
    number: signal.Signals, work: Path
) -> None:
    arguments = SHORT["response"]
    finished(started(arguments, work), work, 0)
    before = (work / "place/f.csv").read_bytes()
    (work / "measured").unlink()
    process = started([*arguments, "--settle", "0.5"], work)
    in_the_middle(process, work, "measured")
    process.send_signal(number)
    finished(process, work, 130 if number != signal.SIGKILL else -number)
    assert (work / "place/f.csv").read_bytes() == before
    assert [p.name for p in (work / "place").iterdir()] == ["f.csv"]


@pytest.mark.long
@pytest.mark.parametrize("how", ["full", "closed"])
def test_rates_that_cannot_be_kept_are_not_said_to_be(how: str, work: Path) -> None:
    cache = f"XDG_CACHE_HOME={work / 'place'}"
    if how == "full":
        status, told = full(["calibrate"], work, 4, 4, cache)
        assert status == 2 and told.count("\n") == 1 and "rates-" in told, told
        return
    (work / "place").chmod(0o555)
    process = started(["calibrate"], work, *UNPRIVILEGED[: 3 * (os.geteuid() == 0)], "env", cache)
    assert "place" in finished(process, work, 2)


@pytest.mark.long
@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    "number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL], ids=lambda n: n.name
)
@pytest.mark.parametrize("name", LONG)
def test_long_work_that_is_ended_goes_on(name: str, number: signal.Signals, work: Path) -> None:
    arguments, sign, _, _ = LONG[name]
    process = started(arguments, work)
    in_the_middle(process, work, sign)
    process.send_signal(number)
    _, told = process.communicate(timeout=250)
    if number == signal.SIGKILL:
        assert process.returncode == -signal.SIGKILL
    else:
        assert process.returncode == 130, told
        assert told.lstrip("\n") == "chrmc: interrupted; what was finished is kept\n"
        assert not list(work.rglob("*.partial*"))
    goes_on(name, work)
