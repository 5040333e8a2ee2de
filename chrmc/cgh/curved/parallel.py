"""Many small matrix products on several cores: one task a core, one BLAS thread a task.

Products of a millisecond spend more time waiting for each other's threads than computing, and
BLAS threads that have nothing to do spin for some 0.1 s on the core that other work needs. So
BLAS stays at one thread here, and whole tasks run side by side.
"""

import threading
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache, wraps
from itertools import count
from typing import Any, TypeVar, cast

from threadpoolctl import ThreadpoolController

from chrmc.threads import workers

T = TypeVar("T")
R = TypeVar("R")
F = TypeVar("F", bound=Callable[..., Any])

_here = threading.local()


class _Limit:
    """BLAS at one thread while anybody asks for it; what it used before comes back after."""

    def __init__(self) -> None:
        self._controller = ThreadpoolController()
        self._lock = threading.Lock()
        self._askers = 0
        self._limit: Any = None

    def __enter__(self) -> None:
        with self._lock:
            if self._askers == 0:
                self._limit = self._controller.limit(limits=1, user_api="blas")
            self._askers += 1

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._askers -= 1
            if self._askers == 0:
                self._limit.restore_original_limits()


@lru_cache(maxsize=1)
def one_blas_thread() -> _Limit:
    """A context in which BLAS uses one thread; it may be entered from several threads at once."""
    return _Limit()


@lru_cache(maxsize=1)
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(workers(), thread_name_prefix="chrmc")


def spread(function: Callable[[T], R], items: Sequence[T]) -> list[R]:
    """[function(item) for item in items], side by side; in turn within a task of another spread.

    Every core takes the next item that is left, so the long ones should come first.
    """
    cores = min(workers(), len(items))
    if cores < 2 or getattr(_here, "inside", False):
        return [function(item) for item in items]
    done: list[Any] = [None] * len(items)
    left = count()

    def take() -> None:
        _here.inside = True
        try:
            while (number := next(left)) < len(items):
                done[number] = function(items[number])
        finally:
            _here.inside = False

    with one_blas_thread():
        others = [_pool().submit(take) for _ in range(1, cores)]
        try:
            take()
        finally:
            for other in others:
                other.result()
    return done


Pieces = list[Callable[[], None]]
"""Work that may be done in any order, or side by side."""


def run_all(pieces: Pieces) -> None:
    """Do all pieces, spread over the cores."""
    spread(lambda piece: piece(), pieces)


Steps = Generator[Pieces, None, T]
"""Work in steps: each yields pieces that may run side by side; what it returns is the result."""


def side_by_side(works: Sequence[Steps[T]]) -> Steps[list[T]]:
    """Several works as one, whose steps hold the pieces of all of them."""
    results: dict[int, T] = {}
    running = dict(enumerate(works))
    while running:
        pieces: Pieces = []
        for number, work in list(running.items()):
            try:
                pieces += next(work)
            except StopIteration as end:
                results[number] = end.value
                del running[number]
        if pieces:
            yield pieces
    return [results[number] for number in range(len(works))]


def finished(work: Steps[T]) -> T:
    """The result of a work, each step's pieces spread over the cores."""
    while True:
        try:
            pieces = next(work)
        except StopIteration as end:
            result: T = end.value
            return result
        run_all(pieces)


def alone(function: F) -> F:
    """A function during which BLAS uses one thread."""

    @wraps(function)
    def run(*args: Any, **options: Any) -> Any:
        with one_blas_thread():
            return function(*args, **options)

    return cast(F, run)
