"""What work costs, counted in operations, so that a machine's rates turn it into seconds."""

from collections.abc import Mapping
from dataclasses import dataclass, fields


@dataclass(frozen=True)
class OperationCounts:
    """How often something is done.

    products : multiply-adds of real float32 matrix products, see `product`
    phasors : phases worked out, reduced, and their cosine and sine taken
    lookups : complex values read, multiplied and added
    transforms : samples of complex FFTs, each times log2 of their number
    bytes : read and written elsewhere, out of the cache
    calls : steps of Python, each a small array operation
    memory : most bytes held at once; of two works one after the other the larger
    """

    products: float = 0.0
    phasors: float = 0.0
    lookups: float = 0.0
    transforms: float = 0.0
    bytes: float = 0.0
    calls: float = 0.0
    memory: float = 0.0

    def __add__(self, other: "OperationCounts") -> "OperationCounts":
        sums = {name: getattr(self, name) + getattr(other, name) for name in KINDS}
        return OperationCounts(**sums, memory=max(self.memory, other.memory))

    def times(self, number: float) -> "OperationCounts":
        """So often one after the other."""
        more = {name: number * getattr(self, name) for name in KINDS}
        return OperationCounts(**more, memory=self.memory)

    def onward(self, before: "OperationCounts", steps: float) -> "OperationCounts":
        """So many steps farther on the straight line through `before` and these."""
        return OperationCounts(
            **{
                name: (now := getattr(self, name)) + steps * max(now - getattr(before, name), 0.0)
                for name in (*KINDS, "memory")
            }
        )


KINDS = tuple(field.name for field in fields(OperationCounts) if field.name != "memory")
"""What a machine has a rate for."""

_TRAFFIC = 10.0  # multiply-adds in the time that an entry of a product's matrices takes


def product(rows: float, inner: float, columns: float) -> float:
    """Of (rows, inner) by (inner, columns): multiply-adds, and the entries that are moved, which
    count where a side is short."""
    moved = rows * inner + inner * columns + rows * columns
    return rows * inner * columns + _TRAFFIC * moved


@dataclass(frozen=True)
class Rates:
    """Operations per second of one core, and what sharing costs.

    alone : kind to rate of one core while the others rest
    together : kind to rate of each core while all work
    threads : cores that work is shared by
    brief : measured in passing, at first use
    """

    alone: Mapping[str, float]
    together: Mapping[str, float]
    threads: int
    brief: bool = False

    def seconds(self, counts: OperationCounts, shared: bool = True) -> float:
        """Time of some work.

        shared : between all cores, calls aside, which hold Python's lock
        """
        total = counts.calls / self.alone["calls"]
        for kind in KINDS:
            if kind != "calls":
                rate = self.threads * self.together[kind] if shared else self.alone[kind]
                total += getattr(counts, kind) / rate
        return total


_SPEEDS = {
    "products": 7.5e10, "phasors": 1.6e8, "lookups": 5e8, "transforms": 2e9, "bytes": 4e10,
    "calls": 1.8e6,
}  # fmt: skip
STATED = Rates(_SPEEDS, _SPEEDS, 2)
"""Of 2 cores of a server, for decisions that have to be the same on every machine."""
