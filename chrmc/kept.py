"""Results kept for the next call, the least recently used out first."""

from collections import OrderedDict
from collections.abc import Callable, Hashable
from functools import lru_cache
from typing import Any

from numpy.typing import NDArray


class Kept:
    """Arrays by key. Hold one for as long as what it holds may be wanted again.

    limit : bytes; an array larger than that is not kept
    most : arrays, default any number
    """

    def __init__(self, limit: int = 1 << 29, most: int | None = None) -> None:
        if limit <= 0:
            raise ValueError(f"what is kept needs a positive memory limit, not {limit} bytes")
        self.limit, self.most = int(limit), most
        self._kept: OrderedDict[Hashable, NDArray[Any]] = OrderedDict()

    @property
    def nbytes(self) -> int:
        """Bytes held."""
        return sum(array.nbytes for array in self._kept.values())

    def __len__(self) -> int:
        return len(self._kept)

    def __contains__(self, key: Hashable) -> bool:
        return key in self._kept

    def get(self, key: Hashable, build: Callable[[], NDArray[Any]]) -> NDArray[Any]:
        """The array of a key, built when it is not there."""
        if key in self._kept:
            self._kept.move_to_end(key)
            return self._kept[key]
        return self.put(key, build())

    def put(self, key: Hashable, array: NDArray[Any]) -> NDArray[Any]:
        """Keep an array in place of what its key had, as far as the limits allow."""
        self._kept.pop(key, None)
        if array.nbytes > self.limit or self.most == 0:
            return array
        while self._kept and (self.nbytes + array.nbytes > self.limit or len(self) == self.most):
            self._kept.popitem(last=False)
        self._kept[key] = array
        return array

    def __str__(self) -> str:
        return (
            f"{len(self)} arrays, {self.nbytes / 2**20:.3g} MiB of at most "
            f"{self.limit / 2**20:.3g} MiB"
        )


class KeptFrames:
    """A function of a frame's number whose last few results are kept; another process that it is
    sent to begins with none.

    most : results
    """

    def __init__(self, function: Callable[[int], Any], most: int) -> None:
        self._function, self._most = function, most
        self._kept = lru_cache(maxsize=most)(function)

    def __call__(self, number: int) -> Any:
        return self._kept(number)

    def __reduce__(self) -> tuple[Any, ...]:
        return KeptFrames, (self._function, self._most)
