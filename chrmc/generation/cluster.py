"""Groups of a video on several processes or machines, through dask.distributed.

The folder is shared. The recipe lies in it while the run goes on, so that a worker that takes
another's place finds it too; a group's frames and record are written by the worker that makes it,
and only numbers travel over the network.
"""

import errno
import hashlib
import os
import shutil
import sys
from collections.abc import Generator, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from pickle import PicklingError
from typing import Any

from chrmc.cgh import method_named
from chrmc.compensation import compensation_named
from chrmc.files import NO_SPACE, replacing, still_there, sweep
from chrmc.generation.connection import connected, version
from chrmc.generation.group import groups_of, make_group
from chrmc.generation.recipe import Recipe
from chrmc.python_file import MODULE_PREFIX, is_python_name
from chrmc.store.video import MANIFEST, ranges
from chrmc.store.writer import VideoWriter

RECIPE = ".recipe.pickle"
ATTEMPTS = 3


def frames_on_cluster(
    recipe: Recipe,
    writer: VideoWriter,
    missing: list[int],
    workers: int | None,
    scheduler: str | None,
) -> Generator[int, None, None]:
    """Make the missing frames on a cluster; yields their numbers as they are stored.

    workers : processes of a cluster on this machine
    scheduler : address of a running one, tcp://HOST:PORT, whose workers see the folder

    A group whose worker dies is made again. Groups that fail three times are told at the end, in
    one line, when the others are finished.
    """
    folder = writer.folder.resolve()
    with _recipe_file(recipe, folder) as digest, connected(workers, scheduler) as client:
        from distributed import wait

        tasks = {}
        for group, wanted in groups_of(recipe, missing):
            arguments = (str(folder), digest, writer.description["scale"], group, sorted(wanted))
            task = client.submit(
                _make, *arguments, writer.suffix, version(), retries=ATTEMPTS - 1, pure=False
            )
            tasks[task] = group
        pending, failed = set(tasks), {}
        seen: set[int] = set()
        while pending:
            lost = False
            try:
                with client.as_current():
                    wait(list(pending), timeout=1, return_when="FIRST_COMPLETED")
            except TimeoutError:
                pass
            except CancelledError:
                lost = True
            still_there(folder)
            writer.take_in()
            if lost or client.status != "running":
                raise OSError(
                    f"the scheduler {scheduler or ''} is gone; what was finished is kept, the "
                    "same command goes on"
                )
            for task in [t for t in pending if t.done()]:
                pending.remove(task)
                if task.status == "finished":
                    if not task.result():
                        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
                else:
                    failed[tasks[task].start] = (tasks[task], _told(task))
            new = set(missing) & set(writer.entries) - seen
            seen |= new
            yield from sorted(new)
            if writer.due:
                writer.collect(busy=[tasks[task].start for task in pending])
        if failed:
            numbers = [n for group, _ in failed.values() for n in group if n in missing]
            why = next(iter(failed.values()))[1]
            raise OSError(
                f"frames {ranges(numbers)} failed {ATTEMPTS} times ({why}); the others are finished"
            )


def _make(
    folder: str,
    digest: str,
    scale: float,
    group: range,
    wanted: list[int],
    suffix: str,
    wanted_version: str,
) -> bool:
    """On a worker: make and store the wanted frames of a group; False where no space is left,
    which no further attempt mends."""
    if version() != wanted_version:
        raise ValueError(f"a worker has chrmc {version()}, not {wanted_version}: install the same")
    if not (Path(folder) / MANIFEST).exists():
        raise FileNotFoundError(f"a worker does not see {folder}: it must be a shared folder")
    recipe, options = _loaded(folder, digest)
    frames = make_group(recipe, Path(folder), scale, group, wanted, suffix, options)
    try:
        for _ in frames:
            pass
    except OSError as error:
        # The writer of pictures tells no number.
        frame = recipe.slm.width * recipe.slm.height
        if error.errno in NO_SPACE or shutil.disk_usage(folder).free < frame:
            return False
        raise
    return True


@lru_cache(maxsize=1)
def _loaded(folder: str, digest: str) -> tuple[Recipe, dict[str, Any]]:
    """The run's recipe and its methods' options, with a cache that is kept on this worker."""
    import cloudpickle

    content = (Path(folder) / RECIPE).read_bytes()
    if hashlib.sha256(content).hexdigest() != digest:
        raise ValueError(f"{Path(folder) / RECIPE} is not this run's")
    recipe, paths = cloudpickle.loads(content)
    sys.path.extend(path for path in paths if path not in sys.path)
    recipe = cloudpickle.loads(recipe)
    return recipe, method_named(recipe.cgh).with_cache(recipe.options)


@contextmanager
def _recipe_file(recipe: Recipe, folder: Path) -> Iterator[str]:
    """The recipe in the shared folder; its SHA-256, so that no other is taken for it.

    What comes from Python files of the user's goes along by value: workers need no such file.
    """
    import cloudpickle

    if is_python_name(recipe.cgh):
        recipe = replace(recipe, cgh=method_named(recipe.cgh))
    if is_python_name(recipe.compensation):
        recipe = replace(recipe, compensation=compensation_named(recipe.compensation))
    own = [module for name, module in sys.modules.items() if name.startswith(MODULE_PREFIX)]
    for module in own:
        cloudpickle.register_pickle_by_value(module)
    try:
        inner = cloudpickle.dumps(recipe)
    except (TypeError, AttributeError, PicklingError) as error:
        why = " ".join(str(error).split())[:160]
        raise ValueError(
            f"the scene or a method cannot be sent to other processes ({why}): leave --workers and "
            "--scheduler out"
        ) from None
    finally:
        for module in own:
            cloudpickle.unregister_pickle_by_value(module)
    paths = [str(Path(module.__file__).parent) for module in own if module.__file__]
    content = cloudpickle.dumps((inner, paths))
    path = folder / RECIPE
    with replacing(path, new_folder=False) as partial:
        partial.write_bytes(content)
    try:
        yield hashlib.sha256(content).hexdigest()
    finally:
        with suppress(OSError):
            path.unlink(missing_ok=True)
            sweep(folder)  # workers that were ended while they wrote


def _told(task: Any) -> str:
    """Why a task failed, in one line."""
    error = task.exception() if task.status == "error" else None
    if error is None:
        return "its worker was lost"
    if isinstance(error, OSError) and error.strerror is not None:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return " ".join(str(error).split())[:200] or type(error).__name__
