"""The progress bar of long work: in a notebook, or on stderr where somebody watches a terminal."""

import functools
import threading
from collections.abc import Iterable, Iterator
from typing import Any, TypeVar

T = TypeVar("T")


def progress(
    items: Iterable[T], label: str, total: int | None = None, unit: str = "frame"
) -> Iterator[T]:
    """The items, with a bar called `label`; `total` where the items have no length."""
    bar = _bar()
    # None: no bar in a log file, where errors must stay one line. A notebook is none, but says so.
    notebook = any(kind.__name__ == "tqdm_notebook" for kind in bar.__mro__)
    yield from bar(
        items,
        desc=label,
        total=total,
        unit=unit,
        disable=False if notebook else None,
        dynamic_ncols=True,
    )


@functools.cache
def _bar() -> Any:
    """tqdm with a lock between threads.

    Its own is between processes too: a semaphore, for which newer Pythons start a process that
    complains to the terminal when the program is ended by a signal.
    """
    from tqdm.auto import tqdm

    bar: Any = type("Bar", (tqdm,), {})
    bar.set_lock(threading.RLock())
    return bar
