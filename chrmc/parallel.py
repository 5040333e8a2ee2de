"""Many small matrix products on several cores: one task a core, one BLAS thread a task.

Products of a millisecond spend more time waiting for each other's threads than computing, and
BLAS threads that have nothing to do spin for some 0.1 s on the core that other work needs. So
BLAS stays at one thread here, and whole tasks run side by side.
"""

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from functools import wraps
from typing import Any, TypeVar, cast

from chrmc.threads import ONE_BLAS_THREAD, workers

T = TypeVar("T")
R = TypeVar("R")
F = TypeVar("F", bound=Callable[..., Any])

_MANY = 4  # tasks for each core, from which a task's own need no other core


_helpers = ThreadPoolExecutor(max(1, workers() - 1), thread_name_prefix="chrmc")
_this = threading.local()


def in_parallel(function: Callable[[T], R], items: Sequence[T]) -> list[R]:
    """[function(item) for item in items] on all cores; a task may have its own.

    Every core takes the next item that is left, so the long ones should come first. The caller
    takes items too, and waits only for helpers that have begun: those for which no core was free
    are called off.
    """
    outer = getattr(_this, "many", False)
    helpers = min(workers(), len(items)) - 1
    if helpers < 1 or outer:
        return [function(item) for item in items]
    done: list[Any] = [None] * len(items)
    left = iter(range(len(items)))
    many = len(items) >= _MANY * workers()

    def take() -> None:
        before = getattr(_this, "many", False)
        _this.many = many
        try:
            for number in left:
                done[number] = function(items[number])
        finally:
            _this.many = before
            for _ in left:  # nothing more to do, or no use in it
                pass

    with ONE_BLAS_THREAD:
        others = [_helpers.submit(take) for _ in range(helpers)]
        try:
            take()
        finally:
            begun = [other for other in others if not other.cancel()]
            wait(begun)
        for other in begun:
            other.result()
    return done


def run_all(pieces: Sequence[Callable[[], T]]) -> list[T]:
    """What all pieces return, worked on by all cores."""
    return in_parallel(lambda piece: piece(), pieces)


def alone(function: F) -> F:
    """A function during which BLAS uses one thread."""

    @wraps(function)
    def run(*args: Any, **options: Any) -> Any:
        with ONE_BLAS_THREAD:
            return function(*args, **options)

    return cast(F, run)
