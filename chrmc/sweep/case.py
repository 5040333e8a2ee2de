"""One combination of a sweep: what is made, and what its row is found by again."""

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from chrmc.compensation import chosen
from chrmc.generation.recipe import Recipe, describe
from chrmc.ranges import TOLERANCE_RANGE


@dataclass(frozen=True, eq=False)
class Case:
    """A row to be made.

    names : its scene, method, tolerance (None where the method promises none), encoding and slm,
        as the table shows them
    recipe : of its video; None where the choices do not fit together
    frames : first and last, inclusive
    checked : the frames that are judged
    refused : why there is no recipe
    """

    names: dict[str, str | float | None]
    recipe: Recipe | None
    frames: tuple[int, int] = (1, 1)
    checked: tuple[int, ...] = ()
    refused: str = ""

    @property
    def label(self) -> str:
        """The names in one line."""
        return ", ".join(f"{value}" for value in self.names.values() if value is not None)

    def digest(self, *more: str) -> str:
        """SHA-256 of all that decides the row, times aside.

        more : what the recipe alone does not tell, such as the scene's spot check
        """
        assert self.recipe is not None
        content = [*more, describe(self.recipe), self.frames, self.checked]
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def tolerances_for(
    method: dict[str, Any], tolerances: list[float]
) -> Iterator[tuple[float | None, dict[str, Any]]]:
    """The tolerances that a method can promise, or None alone, each with what `recipe_for` takes.

    method : cgh, compensation, surface and settings. ValueError where they name what is not there.
    """
    words = (method.get("cgh"), method.get("compensation"), method.get("surface"))
    settings = dict(method.get("settings", {}))
    chosen(*words, None, settings)
    for tolerance in tolerances:
        TOLERANCE_RANGE.of(tolerance)
    try:
        chosen(*words, TOLERANCE_RANGE.high, settings)
    except ValueError:  # it promises none: one row serves for all of them
        yield None, method
        return
    for tolerance in tolerances:
        yield tolerance, method | {"tolerance": tolerance}
