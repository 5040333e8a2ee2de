"""Workers of one machine and of several make the same bytes, also when they die."""

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import chrmc
from chrmc.generation.recipe import recipe_for

pytest.importorskip("distributed")

from chrmc.generation.cluster import _recipe_file

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
    (HERE / "trimming").write_text(os.environ.get("MALLOC_TRIM_THRESHOLD_", "as it is"))
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


@pytest.fixture
def own(tmp_path: Path) -> Path:
    (tmp_path / "own.py").write_text(OWN)
    return tmp_path


def start(
    folder: Path,
    out: str,
    cgh: str,
    *more: str,
    on: "Machine | None" = None,
) -> "subprocess.Popen[str]":
    command = [*(on.prefix if on else ()), sys.executable, "-m", "chrmc", "generate"]
    command += ["own.py:scene", "--out", out]
    command += ["--slm", "320x96:16e-6", "--check-pixels", "8", "--cgh", f"own.py:{cgh}"]
    return subprocess.Popen(
        [*command, "--group", "2", "--compensation", "tr-nlut", *more],
        cwd=folder,
        env=ENVIRONMENT,
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
    # What Dask sets there more than doubles the processor time.
    assert (own / "trimming").read_text() == os.environ.get("MALLOC_TRIM_THRESHOLD_", "as it is")
    assert bytes_of(own / "both") == bytes_of(own / "alone")
    entries = [
        [{k: v for k, v in e.items() if k != "stage_seconds"} for e in
         json.loads((own / name / "manifest.json").read_text())["frames"]]
        for name in ("both", "alone")
    ]  # fmt: skip
    assert entries[0] == entries[1]
    assert len(list((own / "both").iterdir())) == 9


@dataclass(frozen=True)
class Machine:
    """A host of its own: an address, what a command on it begins with, and a temporary folder."""

    address: str
    prefix: tuple[str, ...]
    folder: Path

    def start(self, *arguments: str, paths: Sequence[Path] = ()) -> "subprocess.Popen[bytes]":
        found = os.pathsep.join([*map(str, paths), ENVIRONMENT["PYTHONPATH"]])
        return subprocess.Popen(
            [*self.prefix, sys.executable, *arguments],
            cwd=self.folder,
            env=ENVIRONMENT | {"TMPDIR": str(self.folder), "PYTHONPATH": found},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )


@pytest.fixture
def machines(tmp_path: Path) -> Iterator[list[Machine]]:
    """Two hosts: network namespaces joined by a cable where the rights are there, else two
    addresses of this one."""
    names = [f"chrmc{os.getpid()}{end}" for end in "ab"]
    folders = [tmp_path / f"machine{k}" for k in range(2)]
    for folder in folders:
        folder.mkdir()

    def ip(*words: str) -> bool:
        try:
            return subprocess.run(["ip", *words], capture_output=True).returncode == 0
        except FileNotFoundError:
            return False

    cable = ["link", "add", "cable0", "netns", names[0], "type", "veth",
             "peer", "name", "cable1", "netns", names[1]]  # fmt: skip
    apart = all([ip("netns", "add", name) for name in names]) and ip(*cable)
    for k, name in enumerate(names):
        apart = (
            apart
            and ip("-n", name, "address", "add", f"10.77.0.{k + 1}/24", "dev", f"cable{k}")
            and ip("-n", name, "link", "set", f"cable{k}", "up")
            and ip("-n", name, "link", "set", "lo", "up")
        )
    try:
        yield [
            Machine(f"10.77.0.{k + 1}", ("ip", "netns", "exec", names[k]), folders[k])
            if apart
            else Machine(f"127.0.0.{k + 1}", (), folders[k])
            for k in range(2)
        ]
    finally:
        for name in names:
            ip("netns", "delete", name)


@pytest.fixture
def cluster(
    machines: list[Machine], tmp_path: Path
) -> Iterator[tuple[str, list["subprocess.Popen[bytes]"]]]:
    """A scheduler on the first machine; its address, and the processes, the scheduler first."""
    file = tmp_path / "scheduler.json"
    words = ["--scheduler-file", str(file), "--port", "0", "--host", machines[0].address]
    words += ["--no-dashboard", "--no-show"]
    running = [machines[0].start("-m", "distributed.cli.dask_scheduler", *words)]
    try:
        while not (file.exists() and file.read_text().rstrip().endswith("}")):
            assert running[0].poll() is None
        yield json.loads(file.read_text())["address"], running
    finally:
        for process in reversed(running):
            process.send_signal(signal.SIGINT)
        for process in running:
            try:
                process.wait(timeout=240)
            except subprocess.TimeoutExpired:
                process.kill()


def worker(machine: Machine, address: str, *paths: Path) -> "subprocess.Popen[bytes]":
    return machine.start(
        "-m", "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard",
        "--host", machine.address, "--memory-limit", "0", "--local-directory",
        str(machine.folder), paths=paths,
    )  # fmt: skip


def wait_for_workers(machine: Machine, address: str, count: int) -> None:
    code = (
        "import sys; from distributed import Client; "
        "Client(sys.argv[1], timeout=240).wait_for_workers(int(sys.argv[2]), timeout=240)"
    )
    assert machine.start("-c", code, address, str(count)).wait() == 0


def test_two_machines_do_the_same_and_say_what_fails(
    own: Path, machines: list[Machine], cluster: tuple[str, list["subprocess.Popen[bytes]"]]
) -> None:
    address, running = cluster
    alone = start(own, "alone", "field")
    running += [worker(machine, address) for machine in machines]
    wait_for_workers(machines[0], address, 2)
    run = start(own, "v", "field", "--scheduler", address, on=machines[0])
    told = run.communicate()
    assert (run.returncode, told[1]) == (0, "")
    assert alone.wait() == 0
    assert bytes_of(own / "v") == bytes_of(own / "alone")

    # A group that fails three times is named, and the rest is finished.
    failing = start(own, "part", "failing", "--scheduler", address, on=machines[0])
    _, told_part = failing.communicate()
    assert failing.returncode == 2
    assert told_part.count("\n") == 1
    assert "failed 3 times (this frame will not do); the others are finished" in told_part
    assert (own / "tries").stat().st_size == 3
    assert chrmc.open_video(own / "part").numbers == [1, 2, 5, 6, 7, 8]

    # The scheduler's end is told, and what was finished is kept.
    lost = start(own, "lost", "waiting", "--scheduler", address, on=machines[0])
    while not list((own / "lost").glob("frame_*")):
        assert lost.poll() is None, lost.communicate()
    running[0].kill()
    _, told_lost = lost.communicate(timeout=240)
    assert lost.returncode == 2, told_lost
    assert told_lost.count("\n") == 1
    assert "is gone; what was finished is kept" in told_lost
    kept = chrmc.open_video(own / "lost").numbers
    assert 0 < len(kept) < 8


@pytest.mark.long
def test_a_worker_of_another_version_is_named_and_nothing_is_left(
    own: Path, machines: list[Machine], cluster: tuple[str, list["subprocess.Popen[bytes]"]]
) -> None:
    address, running = cluster
    other = own / "other"
    shutil.copytree(Path(chrmc.__file__).parent, other / "chrmc")
    face = other / "chrmc" / "__init__.py"
    face.write_text(face.read_text().replace(f'"{chrmc.__version__}"', '"0.0.1"'))
    running += [worker(machines[0], address), worker(machines[1], address, other)]
    wait_for_workers(machines[0], address, 2)
    run = start(own, "v", "field", "--scheduler", address, on=machines[0])
    _, told = run.communicate()
    assert run.returncode == 2
    assert told.count("\n") == 1
    assert f"has chrmc 0.0.1, not {chrmc.__version__}: install the same" in told
    assert machines[1].address in told
    assert not (own / "v").exists()


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
    run = start(own, "v", "field", *more)
    _, told = run.communicate()
    assert run.returncode == 2
    assert told.count("\n") == 1
    assert words in told
    assert not (own / "v").exists()


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="reads children of Linux")
@pytest.mark.parametrize("later", [0.2, 0.6])
def test_an_interrupt_while_workers_start_is_one_line(own: Path, later: float) -> None:
    run = start(own, "v", "field", "--workers", "2")
    tasks = Path(f"/proc/{run.pid}/task")
    while not any(one.read_text() for one in tasks.glob("*/children")):
        assert run.poll() is None, run.communicate()
        time.sleep(0.01)
    time.sleep(later)
    run.send_signal(signal.SIGTERM)
    _, told = run.communicate(timeout=120)
    assert run.returncode == 130
    assert told.strip() == "chrmc: interrupted; what was finished is kept"


@pytest.mark.long
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


@pytest.mark.parametrize("form", ["points", "rgbd"])
def test_a_scene_that_was_looked_at_travels(form: str, tmp_path: Path) -> None:
    """Meshes hold an OpenGL context and frames kept for the next call."""
    import cloudpickle

    mesh = tmp_path / "a.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n")
    scene = chrmc.load_scene(mesh, form, slm=chrmc.SLM("s", 160, 100, 32e-6), points=300)
    here = scene.frame(1).cloud
    there = cloudpickle.loads(cloudpickle.dumps(scene)).frame(1).cloud
    assert len(here)
    np.testing.assert_array_equal(there.positions, here.positions)
    np.testing.assert_array_equal(there.phase, here.phase)


def test_what_cannot_travel_is_one_line(tmp_path: Path) -> None:
    cloud = chrmc.PointCloud(np.array([[0, 0, 0.25]]), np.ones(1), np.zeros(1))
    scene = chrmc.PointScene("s", {"a": cloud}, {"a": [chrmc.Pose(np.eye(3), np.zeros(3))]})
    held = threading.Lock()

    def method(cloud: Any, slm: Any, *_: Any, **__: Any) -> Any:
        return np.zeros(slm.shape, np.complex64) if held else None

    with (
        pytest.raises(ValueError, match="cannot be sent to other processes"),
        _recipe_file(recipe_for(scene, cgh=method, compensation="none"), tmp_path),
    ):
        pass
    assert not list(tmp_path.iterdir())
