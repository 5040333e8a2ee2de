"""Odd surroundings: no memory, no home, closed outputs, names that are no text."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from chrmc.cli.main import group, main
from chrmc.panels import all_panels
from chrmc.pictures import read_grey, write_grey
from chrmc.scene.exr import read_exr


def test_too_little_memory_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def ask(**_: object) -> None:
        raise MemoryError("Unable to allocate 7 TiB")

    monkeypatch.setattr(group, "main", ask)
    with pytest.raises(SystemExit) as ended:
        main(["panels"])
    told = capsys.readouterr().err
    assert ended.value.code == 2 and told.count("\n") == 1 and "not enough memory" in told


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="homes as POSIX has them")
def test_a_user_without_a_home_has_panels(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("HOME", "XDG_CONFIG_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(os, "getuid", lambda: 54321)
    assert "lc-r-1080" in all_panels()


@pytest.mark.skipif(sys.platform != "linux", reason="names of any bytes")
def test_names_that_are_no_text_are_one_line(tmp_path: Path) -> None:
    for name, read in ((b"\xff.png", read_grey), (b"\xff.exr", read_exr)):
        path = Path(os.fsdecode(os.fsencode(tmp_path) + b"/" + name))
        path.write_bytes(b"x")
        with pytest.raises(OSError, match="rename it"):
            read(path)
    with pytest.raises(OSError, match="rename it"):
        write_grey(path.with_suffix(".tif"), np.zeros((4, 4), np.uint8))
    assert not list(tmp_path.glob(".*partial*"))


@pytest.mark.long
@pytest.mark.skipif(os.name != "posix", reason="closes it as a shell does")
def test_progress_without_an_error_output(tmp_path: Path) -> None:
    run = subprocess.run(
        ["sh", "-c", '"$@" 2>&-', "sh", sys.executable, "-m", "chrmc", "scene", "car-house",
         "--out", "s", "--frames", "1:1"],
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])},
        stdout=subprocess.DEVNULL,
    )  # fmt: skip
    assert run.returncode == 0 and (tmp_path / "s" / "frame_0001.exr").exists()


@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
def test_a_second_signal_while_it_ends_changes_nothing() -> None:
    """Between the message and the end of the process a thread is waited for."""
    code = (
        "import threading, time\n"
        "from chrmc.cli.main import group, main\n"
        "def work(**_):\n"
        "    threading.Thread(target=time.sleep, args=(0.5,)).start()\n"
        "    print('ready', flush=True)\n"
        "    time.sleep(60)\n"
        "group.main = work\n"
        "main([])\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])},
    )  # fmt: skip
    assert process.stdout is not None and process.stderr is not None
    process.stdout.readline()
    process.send_signal(signal.SIGTERM)
    told = process.stderr.readline()
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        process.send_signal(number)
    _, rest = process.communicate(timeout=250)
    assert process.returncode == 130 and told.endswith("is kept\n") and not rest
