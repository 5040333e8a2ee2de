"""Files that are whole or absent: written under a temporary name, then renamed."""

import errno
import hashlib
import json
import os
import stat
import tomllib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")
NO_SPACE = (errno.ENOSPC, errno.EDQUOT)
"""Numbers of the errors of a full disk, or of a full share of it."""


@contextmanager
def replacing(path: Path, *, new_folder: bool = True) -> Iterator[Path]:
    """A temporary name beside `path`, of the same suffix, renamed to `path` when the block ends
    well and removed when it does not.

    new_folder : make the folder where it is absent; not where it must be the one that was there
    """
    if new_folder:
        path.parent.mkdir(parents=True, exist_ok=True)
    partial = _beside(path)
    try:
        yield partial
        partial.replace(path)
    except OSError as error:
        # A full disk names no file, and the temporary name is nobody's business.
        if error.errno is not None and error.filename in (None, str(partial), partial):
            error.filename = str(path)
        raise
    finally:
        partial.unlink(missing_ok=True)


def _beside(path: Path) -> Path:
    """A name for what is not whole yet, of the same suffix; `sweep` finds it."""
    return path.with_name(f".{path.stem}.{os.getpid()}.partial{path.suffix}")


def check_writable(path: Path) -> None:
    """OSError where `path` cannot be written, before what it is to hold takes long to measure."""
    if path.is_dir():
        raise IsADirectoryError(f"{path} is a folder: name a file")
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = _beside(path)
    try:
        partial.touch()
    except OSError as error:
        error.filename = str(path)
        raise
    finally:
        partial.unlink(missing_ok=True)


def write_json(path: Path, content: Any, *, new_folder: bool = True) -> None:
    """Write `content` as readable JSON, whole or not at all."""
    with replacing(path, new_folder=new_folder) as partial:
        partial.write_text(json_text(content) + "\n", encoding="utf-8")


def json_text(content: Any) -> str:
    """Readable JSON; ValueError for what is not finite."""
    return json.dumps(content, indent=1, allow_nan=False, default=_plain)


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no place in JSON")


def read_text(path: Path) -> str:
    """A file's text; OSError for what is no file (a device never ends), ValueError for no text."""
    if not stat.S_ISREG(path.stat().st_mode):
        raise OSError(f"{path} is no file: name one")
    try:
        return path.read_text("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(f"{path} is no text in UTF-8") from None


def read_toml(path: Path) -> dict[str, Any]:
    """Content of a TOML file; OSError or ValueError in one line."""
    try:
        return tomllib.loads(read_text(path))
    except FileNotFoundError:
        raise FileNotFoundError(f"{path} is missing") from None
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} is no TOML: {' '.join(str(error).split())[:200]}") from None


def read_json(path: Path, what: str) -> Any:
    """Content of a JSON file; OSError or ValueError in one line that calls it `what`."""
    try:
        return json.loads(read_text(path))
    except NotADirectoryError:
        raise NotADirectoryError(f"{path.parent} is a file, no {what}: name the folder") from None
    except FileNotFoundError:
        raise FileNotFoundError(f"{path} is missing: {path.parent} is no {what}") from None
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} is not valid JSON ({error}): restore or remake it") from None


def sweep(folder: Path) -> None:
    """Remove what writers that were killed left half-written; for the folder's only writer."""
    for path in folder.glob(".*.partial*"):
        path.unlink(missing_ok=True)


def sha256(path: Path) -> str:
    """Hexadecimal SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def inside(folder: Path, path: Path) -> Path:
    """The path; ValueError where it is a link, or lies behind one, that leads out of the folder."""
    if not path.resolve().is_relative_to(folder.resolve()):
        raise ValueError(f"{path} leads out of {folder}: put the file itself there")
    return path


def still_there(folder: Path) -> None:
    """FileNotFoundError for a folder that was removed while it was being written to."""
    if not folder.is_dir():
        raise FileNotFoundError(f"{folder} is gone: it was removed while it was being written to")


def into(folder: Path, items: Iterable[T]) -> Iterator[T]:
    """The items that are written to a folder, which is made for the first and must stay; what a
    run that was killed left half-written there is removed."""
    for index, item in enumerate(items):
        if index:
            still_there(folder)
        else:
            folder.mkdir(parents=True, exist_ok=True)
            sweep(folder)
        yield item


@contextmanager
def told_when_full(folder: Path) -> Iterator[None]:
    """A full disk in words."""
    try:
        yield
    except OSError as error:
        if error.errno not in NO_SPACE:
            raise
        raise OSError(
            f"{folder}: no space is left; what was finished is kept, the same command goes on"
        ) from None
