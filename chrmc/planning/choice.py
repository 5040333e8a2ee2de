"""One way to make a scene's holograms, and which of several to take."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import log
from typing import Any

from chrmc.planning.errors import SAFE

LATE = 1.3
"""How much longer than expected a frame may take."""
_MUCH, _LITTLE = 0.67, 0.01  # of the time, and seconds: what an error check alone is not worth
_WORTH = 0.9  # of the time, from which another way than the first is taken


@dataclass(frozen=True)
class Choice:
    """One way to make a scene's holograms.

    cgh, compensation : methods by name; options : of theirs, the tolerance among them
    group : frames that share a key frame
    key, mean : expected seconds from points to 8 bits, of a key frame and of one on the average
    error : expected relative L2 error of the field; None where nothing is known
    sure : the method keeps the tolerance by itself
    memory : bytes held while a frame is made, about
    objects : what is done with each object, and why, where objects are told apart
    """

    cgh: str
    compensation: str
    options: Mapping[str, Any]
    group: int
    key: float
    mean: float
    error: float | None
    sure: bool
    memory: float
    objects: Mapping[str, str] = field(default_factory=dict)

    @property
    def tolerance(self) -> float | None:
        """That it is made with, if it takes one."""
        return self.options.get("tolerance")

    def meets(self, tolerance: float) -> bool:
        """Whether its error will stay below a tolerance."""
        return self.within(tolerance) <= 1 + 1e-9

    def keeps(self, budget: float) -> bool:
        """Whether a frame will be made in so many seconds, on the average."""
        return LATE * self.mean <= budget

    def within(self, tolerance: float) -> float:
        """How far it comes from meeting a tolerance: at most 1 where it does."""
        if self.sure and self.tolerance is not None:
            return self.tolerance / tolerance
        return float("inf") if self.error is None else SAFE * self.error / tolerance

    def __str__(self) -> str:
        said = "" if self.tolerance is None else f" at {self.tolerance:.2g}"
        others = {name: value for name, value in self.options.items() if name != "tolerance"}
        said += "".join(f" {name}={value}" for name, value in others.items())
        return f"{self.cgh}{said}, {self.compensation}"


def pick(
    choices: tuple[Choice, ...], tolerance: float | None, budget: float | None
) -> tuple[Choice, bool]:
    """The choice to take, and whether it meets what was asked for."""
    if not choices:
        raise ValueError("no method can make this scene's holograms: see chrmc inspect")
    fit = [c for c in choices if tolerance is None or c.meets(tolerance)]
    if budget is None:
        if fit:
            return _cheapest(fit), True
        return min(choices, key=lambda c: (c.within(tolerance or 1.0), c.mean)), False
    quick = [c for c in fit if c.keeps(budget)]
    if quick:
        if tolerance is not None:
            return _cheapest(quick), True
        best = min(_worst(c) for c in quick)
        return _cheapest([c for c in quick if _worst(c) <= best]), True

    def off(choice: Choice) -> tuple[float, float]:
        late = max(log(LATE * choice.mean / budget), 0.0)
        if tolerance is None:
            return late, _worst(choice)
        wrong = choice.within(tolerance)
        return max(late, log(max(wrong, 1.0))) if wrong < float("inf") else 1e9, choice.mean

    return min(choices, key=off), False


def _worst(choice: Choice) -> float:
    """The error to reckon with."""
    return choice.within(1.0)


def _cheapest(choices: list[Choice]) -> Choice:
    """The quickest; the first, as the default is, where others hardly are quicker, and one that
    keeps its tolerance by itself where others save little."""
    least = min(choices, key=lambda c: c.mean)
    sure = [c for c in choices if c.sure]
    if sure and not least.sure:
        best = min(c.mean for c in sure)
        if least.mean > min(_MUCH * best, best - _LITTLE):
            choices = sure
    quickest = min(c.mean for c in choices)
    return next(choice for choice in choices if _WORTH * choice.mean <= quickest)


def sentence(
    taken: Choice,
    met: bool,
    choices: tuple[Choice, ...],
    tolerance: float | None,
    budget: float | None,
) -> str:
    """What is taken, and why."""
    asked = []
    if tolerance is not None:
        asked.append(f"an error of {tolerance:.2g}")
    if budget is not None:
        asked.append(f"{spell(budget)} a frame")
    said = f"{taken}: {spell(taken.mean)} a frame"
    if taken.key > 1.3 * taken.mean:
        said += f" ({spell(taken.key)} a key frame)"
    if taken.error is not None:
        said += f", expected error {taken.error:.1e}"
    if not met:
        if budget is not None and taken.mean <= budget:
            said += f"; a frame may take {LATE:g} times as long, {spell(LATE * taken.mean)}"
        return f"nothing meets {' and '.join(asked)}; nearest is {said}"
    if tolerance is None:
        return f"{said}, the most accurate within {asked[0]}"
    others = [
        c for c in choices
        if (c.cgh, c.compensation) != (taken.cgh, taken.compensation) and c.meets(tolerance)
    ]  # fmt: skip
    if not others:
        return f"{said}, the only way to {asked[0]}"
    other = min(others, key=lambda c: c.mean)
    within = f"within {' and '.join(asked)}"
    if other.mean < taken.mean:
        return f"{said}, {within}; {other} would hardly be quicker: {spell(other.mean)}"
    return f"{said}, the cheapest {within}; the next is {other}: {spell(other.mean)}"


def spell(seconds: float) -> str:
    """Seconds in words."""
    return f"{seconds:.3g} s" if seconds >= 1 else f"{1e3 * seconds:.3g} ms"
