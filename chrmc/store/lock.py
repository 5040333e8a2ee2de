"""One writer per folder: a lock that the system lets go when its process ends, however it ends."""

import json
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path
from typing import IO

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

LOCK = ".writer.lock"
_FAR = 1 << 20  # Windows locks bytes for readers too: one far behind the text


@contextmanager
def writer_lock(folder: Path) -> Iterator[None]:
    """Hold the folder as its only writer; it is made when absent, and removed if left empty.

    BlockingIOError names the process that has it, the machine, and since when. The lock of a
    process that died is nobody's: the system released it.
    """
    new = not folder.exists()
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / LOCK
    file = _held(path)
    try:
        holder = {
            "pid": os.getpid(),
            "host": socket.gethostname(),
            "since": datetime.now().astimezone().isoformat(timespec="seconds"),
        }
        file.seek(0)
        file.truncate()
        file.write(json.dumps(holder))
        file.flush()
        yield
    finally:
        # Unlinked while it is held: who opened it before finds that out, see `_held`.
        if fcntl is not None:
            with suppress(OSError):
                path.unlink()
        file.close()
        if fcntl is None:
            with suppress(OSError):
                path.unlink()
        if new:
            with suppress(OSError):
                folder.rmdir()


def _held(path: Path) -> IO[str]:
    """The lock file, open and locked."""
    while True:
        if path.is_symlink():
            raise ValueError(f"{path} is a link, which no writer's lock is: remove it")
        file = path.open("a+", encoding="utf-8")
        try:
            _lock(file)
        except OSError:
            told = _holder(file)
            file.close()
            raise BlockingIOError(f"{path.parent} is being written {told}") from None
        with suppress(OSError):
            if fcntl is None or os.path.samestat(os.fstat(file.fileno()), path.stat()):
                return file
        file.close()  # its holder has just removed it: that file locks nothing any more


def _lock(file: IO[str]) -> None:
    if fcntl is not None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return
    import msvcrt

    file.seek(_FAR)
    msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)


def _holder(file: IO[str]) -> str:
    try:
        file.seek(0)
        holder = json.loads(file.read())
        return (
            f"by process {int(holder['pid'])} on {holder['host']} since {holder['since']}: wait "
            "for it, or choose another folder"
        )
    except (OSError, ValueError, KeyError, TypeError):
        return "by another process: wait for it, or choose another folder"
