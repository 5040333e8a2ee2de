"""The progress bar of long work: on stderr, and only where somebody watches a terminal."""

from collections.abc import Iterable, Iterator
from typing import TypeVar

T = TypeVar("T")


def progress(
    items: Iterable[T], label: str, total: int | None = None, unit: str = "frame"
) -> Iterator[T]:
    """The items, with a bar called `label`; `total` where the items have no length."""
    from tqdm import tqdm

    # disable=None: no bar in a log file, where errors must stay one line.
    yield from tqdm(items, desc=label, total=total, unit=unit, disable=None, dynamic_ncols=True)
