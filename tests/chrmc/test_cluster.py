"""Workers of one machine and of several make the same bytes, also when they die."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import chrmc

pytest.importorskip("distributed")

OWN = '''
import os, signal, time
from pathlib import Path
from test_groups import PANEL, driving_scene as scene
import chrmc

HERE = Path(__file__).parent

def field(cloud, slm, wavelength, window, passband):
    return chrmc.compute_field(cloud, slm, wavelength, "fresnel", window=window, passband=passband)

def dying(cloud, slm, wavelength, window, passband):
    """The third call of all kills its worker."""
    with (HERE / "calls").open("a") as file:
        file.write(".")
    if (HERE / "calls").stat().st_size == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return field(cloud, slm, wavelength, window, passband)

def failing(cloud, slm, wavelength, window, passband):
    """Never makes what frame 3 shows."""
    if abs(cloud.centroid[0] - scene().frame(3).cloud.centroid[0]) < 1e-9:
        with (HERE / "tries").open("a") as file:
            file.write(".")
        raise RuntimeError("this frame\\nwill not do")
    return field(cloud, slm, wavelength, window, passband)

def waiting(cloud, slm, wavelength, window, passband):
    """Stands still after the first frames until there is a file "go"."""
    with (HERE / "made").open("a") as file:
        file.write(".")
    while (HERE / "made").stat().st_size > 5 and not (HERE / "go").exists():
        time.sleep(0.01)
    return field(cloud, slm, wavelength, window, passband)
'''
PATHS = [str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]
ENVIRONMENT = os.environ | {"PYTHONPATH": os.pathsep.join(PATHS)}
IMPATIENT = ENVIRONMENT | {"DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "1s"}
"""Of programs that look for a scheduler which is not there: users' look for ten seconds."""


@pytest.fixture
def own(tmp_path: Path) -> Path:
    (tmp_path / "own.py").write_text(OWN)
    return tmp_path


def start(
    folder: Path, out: str, cgh: str, *more: str, environment: dict[str, str] = ENVIRONMENT
) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "chrmc", "generate", "own.py:scene", "--out", out]
    command += ["--slm", "320x96:16e-6", "--check-pixels", "8", "--cgh", f"own.py:{cgh}"]
    return subprocess.Popen(
        [*command, "--group", "2", "--compensation", "tr-nlut", *more],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def bytes_of(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in sorted(folder.glob("frame_*.tif"))}


def test_two_workers_of_which_one_is_killed_make_the_same_bytes(own: Path) -> None:
    alone = start(own, "alone", "field")
    both = start(own, "both", "dying", "--workers", "2")
    told = both.communicate()
    assert both.returncode == 0, told
    assert told[1] == ""
    assert alone.wait() == 0
    assert (own / "calls").stat().st_size > 3
    assert bytes_of(own / "both") == bytes_of(own / "alone")
    entries = [
        [{k: v for k, v in e.items() if k != "stage_seconds"} for e in
         json.loads((own / name / "manifest.json").read_text())["frames"]]
        for name in ("both", "alone")
    ]  # fmt: skip
    assert entries[0] == entries[1]
    assert len(list((own / "both").iterdir())) == 9


def test_a_group_that_fails_three_times_is_named_and_the_rest_is_finished(own: Path) -> None:
    run = start(own, "v", "failing", "--workers", "2")
    _, told = run.communicate()
    assert run.returncode == 2
    assert told.count("\n") == 1
    assert "failed 3 times (this frame will not do); the others are finished" in told
    assert (own / "tries").stat().st_size == 3
    assert chrmc.open_video(own / "v").numbers == [1, 2, 5, 6, 7, 8]


@pytest.fixture
def scheduler(tmp_path: Path) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """A scheduler and two workers, each with a temporary folder of its own."""
    running: list[subprocess.Popen[bytes]] = []

    def run(*arguments: str) -> None:
        log = (tmp_path / f"log{len(running)}").open("wb")
        command = [sys.executable, "-m", *arguments]
        running.append(subprocess.Popen(command, env=ENVIRONMENT, stdout=log, stderr=log))

    file = tmp_path / "scheduler.json"
    run("distributed.cli.dask_scheduler", "--scheduler-file", str(file), "--port", "0",
        "--host", "127.0.0.1", "--no-dashboard", "--no-show")  # fmt: skip
    while not file.exists():
        assert running[0].poll() is None
    for k in range(2):
        (tmp_path / f"machine{k}").mkdir()
        run("distributed.cli.dask_worker", "--scheduler-file", str(file), "--nthreads", "1",
            "--local-directory", str(tmp_path / f"machine{k}"), "--no-dashboard",
            "--host", "127.0.0.1", "--memory-limit", "0")  # fmt: skip
    try:
        yield json.loads(file.read_text())["address"], running
    finally:
        for process in reversed(running):
            process.send_signal(signal.SIGINT)
        for process in running:
            try:
                process.wait(timeout=60)
            except subprocess.TimeoutExpired:
                process.kill()


def wait_for_workers(address: str, count: int) -> None:
    from distributed import Client

    with Client(address, set_as_default=False, timeout=240) as client:
        client.wait_for_workers(count, timeout=240)


def test_a_running_scheduler_does_the_same_and_its_end_is_told(
    own: Path, scheduler: tuple[str, list[subprocess.Popen[bytes]]]
) -> None:
    address, running = scheduler
    alone = start(own, "alone", "field")
    wait_for_workers(address, 2)
    run = start(own, "v", "field", "--scheduler", address)
    told = run.communicate()
    assert (run.returncode, told[1]) == (0, "")
    assert alone.wait() == 0
    assert bytes_of(own / "v") == bytes_of(own / "alone")

    lost = start(own, "lost", "waiting", "--scheduler", address)
    while not list((own / "lost").glob("frame_*")):
        assert lost.poll() is None, lost.communicate()
    running[0].kill()
    _, told_lost = lost.communicate(timeout=240)
    assert lost.returncode == 2, told_lost
    assert told_lost.count("\n") == 1
    assert "is gone; what was finished is kept" in told_lost
    kept = chrmc.open_video(own / "lost").numbers
    assert 0 < len(kept) < 8


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("--scheduler", "tcp://127.0.0.1:9"), "tcp://127.0.0.1:9"),
        (("--workers", "0"), "workers must lie between"),
        (("--workers", "1", "--scheduler", "tcp://127.0.0.1:9"), "give one"),
    ],
)
def test_a_cluster_that_cannot_be_is_told_and_nothing_is_left(
    own: Path, more: tuple[str, ...], words: str
) -> None:
    run = start(own, "v", "field", *more, environment=IMPATIENT)
    _, told = run.communicate()
    assert run.returncode == 2
    assert told.count("\n") == 1
    assert words in told
    assert not (own / "v").exists()


def test_an_interrupt_keeps_what_is_finished(own: Path) -> None:
    run = start(own, "v", "waiting", "--workers", "1")
    while not list((own / "v").glob("frame_*")):
        assert run.poll() is None, run.communicate()
    run.send_signal(signal.SIGINT)
    _, told = run.communicate(timeout=240)
    assert run.returncode == 130
    assert told.strip() == "chrmc: interrupted; what was finished is kept"
    assert 0 < len(chrmc.open_video(own / "v").numbers) < 8
    (own / "go").touch()
    assert start(own, "v", "waiting").wait() == 0
    assert chrmc.open_video(own / "v").numbers == list(range(1, 9))
