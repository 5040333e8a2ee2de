"""A frame's bytes and record depend on its group alone: not on order, kills or other runs."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import chrmc
from chrmc.scene.path import rotation_y

PANEL = chrmc.SLM("panel", 320, 96, 16e-6)
COUNT = 8


def driving_scene(count: int = COUNT) -> chrmc.PointScene:
    """One body that goes to and fro on an arc, whose points come and go, and one that stands
    still."""
    rng = np.random.default_rng(3)
    car, house = (
        chrmc.PointCloud(
            rng.uniform(-2e-4, 2e-4, (40, 3)), rng.uniform(0.5, 1, 40), rng.uniform(0, 6, 40)
        )
        for _ in range(2)
    )
    angles = 0.006 * (7 - np.abs(np.arange(count) % 14 - 7))
    poses = [
        chrmc.Pose(rotation_y(a), np.array([2e-2 * np.sin(a), 1e-4, 0.24 + 2e-2 * np.cos(a)]))
        for a in angles
    ]
    shown = np.random.default_rng(4).random((count, 40)) < 0.9
    return chrmc.PointScene(
        "drive",
        {"car": car, "house": house},
        {"car": poses, "house": [chrmc.Pose(np.eye(3), np.array([-3e-4, 0, 0.27]))]},
        {"car": list(shown)},
    )


METHODS: dict[str, dict[str, Any]] = {
    "none": {"compensation": "none"},
    "object": {"compensation": "ch-rmc-object"},
    "paper": {"compensation": "ch-rmc-paper", "cgh": "fresnel", "radius": 0.24},
    "paper, keys": {"compensation": "ch-rmc-paper", "cgh": "fresnel", "radius": 0.24,
                    "rekey_every": 2},
    "tr": {"compensation": "tr-nlut", "cgh": "fresnel"},
    "mc": {"compensation": "mc-nlut", "cgh": "nlut"},
    "mpeg": {"compensation": "mpeg-nlut", "cgh": "fresnel"},
    "3dmc": {"compensation": "3dmc-nlut", "cgh": "fresnel"},
}  # fmt: skip


def timeless(folder: Path) -> list[dict[str, Any]]:
    """The manifest's entries without times, and what the files hold."""
    entries = json.loads((folder / "manifest.json").read_text())["frames"]
    for entry in entries:
        entry.pop("stage_seconds")
        entry["bytes"] = (folder / entry["file"]).read_bytes()
    return entries  # type: ignore[no-any-return]


@pytest.mark.parametrize("name", METHODS)
def test_frames_made_in_any_order_are_the_same(name: str, tmp_path: Path) -> None:
    options: dict[str, Any] = {"slm": PANEL, "group": 3, "check_pixels": 20} | METHODS[name]
    chrmc.generate(driving_scene(), tmp_path / "whole", **options)
    for frames in ((8, 8), (2, 5), (1, 8)):
        chrmc.generate(driving_scene(), tmp_path / "parts", frames=frames, **options)
    whole, parts = timeless(tmp_path / "whole"), timeless(tmp_path / "parts")
    assert whole == parts
    keys = [entry["number"] for entry in whole if entry["key"]]
    assert set(keys) >= {1, 4, 7}


@pytest.mark.parametrize("threads", [1, 3])
def test_threads_of_the_matrix_product_change_nothing(threads: int, tmp_path: Path) -> None:
    from threadpoolctl import threadpool_limits

    options: dict[str, Any] = {"slm": chrmc.SLM("s", 700, 500, 16e-6), "cgh": "fresnel"}
    chrmc.generate(driving_scene(), tmp_path / "a", frames=(1, 1), **options)
    with threadpool_limits(threads, user_api="blas"):
        chrmc.generate(driving_scene(), tmp_path / "b", frames=(1, 1), **options)
    assert timeless(tmp_path / "a") == timeless(tmp_path / "b")


SLOW = """
import time
from pathlib import Path
from dataclasses import replace
from test_groups import PANEL, driving_scene, driving_scene as scene
import chrmc

def short():
    return long(30)

def long(count=120):
    made = driving_scene(count)

    def shown(number):
        time.sleep(0.01)
        return made.visible["car"][number - 1]

    return replace(made, visible={"car": shown})

def field(cloud, slm, wavelength, window, passband):
    time.sleep(0.02)
    return chrmc.compute_field(cloud, slm, wavelength, "fresnel", window=window, passband=passband)

made = 0

def waiting(cloud, slm, wavelength, window, passband, after=0):
    # Stands still until there is a file "go".
    global made
    made += 1
    while made > after and not Path("go").exists():
        time.sleep(0.01)
    return chrmc.compute_field(cloud, slm, wavelength, "fresnel", window=window, passband=passband)

def halting(*arguments):
    return waiting(*arguments, after=3)
"""


@pytest.fixture
def slow(tmp_path: Path) -> Path:
    """A folder with a scene and slow methods of one's own, for runs that are killed."""
    (tmp_path / "slow.py").write_text(SLOW)
    return tmp_path


def start(
    folder: Path, out: str, *more: str, cgh: str = "field", scene: str = "scene"
) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "chrmc", "generate", f"slow.py:{scene}", "--out", out]
    command += [
        "--slm",
        "320x96:16e-6",
        "--check-pixels",
        "8",
        "--cgh",
        f"slow.py:{cgh}" if cgh in ("field", "waiting", "halting") else cgh,
        *more,
    ]
    paths = [str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]
    return subprocess.Popen(
        command,
        cwd=folder,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def wait_for(condition: Callable[[], bool], process: subprocess.Popen[str]) -> None:
    end = time.monotonic() + 240
    while not condition():
        assert time.monotonic() < end
        if process.poll() is not None:
            return
        time.sleep(0.005)


def killed_and_resumed(folder: Path, kills: int, *more: str, **how: str) -> list[dict[str, Any]]:
    """Entries of a video whose run was killed again and again, each time a little later."""
    out, rng = folder / "killed", np.random.default_rng()

    def made() -> int:
        return len(list(out.glob("frame_*")))

    for _ in range(kills):
        goal = made() + rng.integers(0, 3)
        process = start(folder, "killed", *more, **how)
        wait_for(lambda: out.exists() and made() >= goal, process)  # noqa: B023
        time.sleep(rng.uniform(0, 0.05))
        assert process.poll() is None, "finished before it was killed often enough"
        process.send_signal(signal.SIGKILL)
        process.communicate()
    process = start(folder, "killed", *more, **how)
    told = process.communicate()
    assert process.returncode == 0, told
    assert not [p.name for p in out.iterdir() if not p.name.startswith(("frame_", "manifest"))]
    return timeless(out)


def test_a_run_that_is_killed_ends_in_the_same_bytes(slow: Path) -> None:
    more = ("--compensation", "tr-nlut", "--group", "3")
    how = {"cgh": "fresnel", "scene": "short"}
    start(slow, "whole", *more, **how).communicate()
    assert killed_and_resumed(slow, 3, *more, **how) == timeless(slow / "whole")


@pytest.mark.long
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("name", METHODS)
def test_thirty_kills_end_in_the_same_bytes(slow: Path, name: str) -> None:
    chosen = METHODS[name]
    more = ["--compensation", chosen["compensation"], "--group", "3"]
    more += [f"--set={k}={v}" for k, v in chosen.items() if k in ("radius", "rekey_every")]
    how = {"cgh": "curved" if name == "object" else chosen.get("cgh", "fresnel"), "scene": "long"}
    whole = start(slow, "whole", *more, **how)
    told = whole.communicate()
    assert whole.returncode == 0, told
    assert killed_and_resumed(slow, 30, *more, **how) == timeless(slow / "whole")


def test_the_second_of_two_writers_is_told_who_has_the_folder(slow: Path) -> None:
    out = slow / "v"
    first = start(slow, "v", cgh="waiting")
    try:
        wait_for(lambda: (out / "manifest.json").exists(), first)
        before = {p.name: p.read_bytes() for p in out.iterdir()}
        second = start(slow, "v", cgh="waiting")
        _, told = second.communicate(timeout=240)
        assert second.returncode == 2
        assert told.count("\n") == 1
        assert f"process {first.pid} on " in told
        assert " since 20" in told
        assert {p.name: p.read_bytes() for p in out.iterdir()} == before
    finally:
        first.kill()
        first.communicate()
    # A dead process's lock is nobody's.
    (slow / "go").touch()
    third = start(slow, "v", cgh="waiting")
    told_third = third.communicate(timeout=240)
    assert third.returncode == 0, told_third
    assert chrmc.open_video(out).numbers == list(range(1, COUNT + 1))
    assert {p.name for p in out.iterdir()} == {
        "manifest.json", *(f"frame_{n:04d}.tif" for n in range(1, COUNT + 1))
    }  # fmt: skip


def test_a_run_cut_off_lists_all_that_was_finished(slow: Path) -> None:
    process = start(slow, "v", "--compensation", "tr-nlut", cgh="halting")
    wait_for(lambda: len(list((slow / "v").glob("frame_*"))) > 2, process)
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=240)
    assert process.returncode == 130
    assert told.strip().splitlines()[-1] == "chrmc: interrupted; what was finished is kept"
    video = chrmc.open_video(slow / "v")
    assert video.numbers == [int(p.stem[6:]) for p in sorted((slow / "v").glob("frame_*"))]


def test_what_a_killed_run_left_is_taken_in_and_swept(tmp_path: Path) -> None:
    options: dict[str, Any] = {"slm": PANEL, "cgh": "fresnel", "compensation": "tr-nlut"}
    chrmc.generate(driving_scene(), tmp_path, group=4, **options)
    path = tmp_path / "manifest.json"
    manifest = json.loads(path.read_text())
    late = [entry for entry in manifest["frames"] if entry["number"] > 4]
    # As a kill leaves it between a group's last record and the manifest, and in a picture.
    (tmp_path / "group_000005.json").write_text(json.dumps({"frames": late}))
    path.write_text(json.dumps(manifest | {"frames": manifest["frames"][:4]}))
    (tmp_path / ".frame_0009.1234.partial.tif").write_bytes(b"half")
    before = {p: p.stat().st_mtime_ns for p in tmp_path.glob("frame_*")}
    assert chrmc.open_video(tmp_path).numbers == list(range(1, 9))
    chrmc.generate(driving_scene(), tmp_path, group=4, **options)
    assert json.loads(path.read_text()) == manifest
    assert {p: p.stat().st_mtime_ns for p in tmp_path.glob("*.tif")} == before
    assert {p.name for p in tmp_path.iterdir()} == {"manifest.json", *(p.name for p in before)}


def test_a_folder_that_is_removed_meanwhile_is_told_and_not_made_again(slow: Path) -> None:
    process = start(slow, "v", "--compensation", "tr-nlut", cgh="halting")
    # It stands still, and no frame is half written.
    wait_for(lambda: len(list((slow / "v").glob("frame_*"))) > 2, process)
    (slow / "v").rename(slow / "away")
    (slow / "go").touch()
    _, told = process.communicate(timeout=240)
    assert process.returncode == 2
    assert told.count("\n") == 1
    assert "is gone" in told
    assert not (slow / "v").exists()
    assert not list((slow / "away").glob(".*.partial*"))


def test_a_full_disk_is_told_and_what_was_finished_is_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    resource = pytest.importorskip("resource")
    options: dict[str, Any] = {"slm": PANEL, "cgh": "fresnel", "check_pixels": 0}
    chrmc.generate(driving_scene(), tmp_path, frames=(1, 2), **options)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:  # a file may not grow: as good as a full disk
        resource.setrlimit(resource.RLIMIT_FSIZE, (8000, before[1]))
        with pytest.raises(OSError) as caught:
            chrmc.generate(driving_scene(), tmp_path, **options)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)
    assert "\n" not in str(caught.value).strip()
    video = chrmc.open_video(tmp_path)
    assert video.numbers == [1, 2]
    assert not list(tmp_path.glob(".*"))
    assert chrmc.generate(driving_scene(), tmp_path, **options).numbers == list(range(1, 9))
