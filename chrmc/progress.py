"""The progress bar of long work: in a notebook, or on stderr where somebody watches a terminal."""

from collections.abc import Iterable, Iterator
from typing import TypeVar

T = TypeVar("T")


def progress(
    items: Iterable[T], label: str, total: int | None = None, unit: str = "frame"
) -> Iterator[T]:
    """The items, with a bar called `label`; `total` where the items have no length."""
    from tqdm.auto import tqdm

    # None: no bar in a log file, where errors must stay one line. A notebook is none, but says so.
    notebook = any(kind.__name__ == "tqdm_notebook" for kind in tqdm.__mro__)
    yield from tqdm(
        items,
        desc=label,
        total=total,
        unit=unit,
        disable=False if notebook else None,
        dynamic_ncols=True,
    )
