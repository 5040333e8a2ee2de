"""A video whose tolerance follows the time that its frames take."""

import time
from collections.abc import Iterator
from dataclasses import replace

from chrmc.cgh import method_named
from chrmc.compensation.frame import VideoFrame
from chrmc.generation.recipe import Recipe
from chrmc.planning.choice import LATE
from chrmc.planning.choices import plan
from chrmc.planning.pace import Pace, first_tolerance

LOOSEST = 1e-2
"""How wrong frames may become to keep a rate, where nothing else is said."""


def pace_for(recipe: Recipe, budget: float, loosest: float | None = None) -> Pace:
    """A pace that begins with what is expected to keep the budget.

    loosest : bound; the other is the recipe's own tolerance
    """
    if "tolerance" not in recipe.options or not method_named(recipe.cgh).takes("tolerance"):
        raise ValueError("--budget needs methods with a tolerance that can be loosened, as auto's")
    tight = float(recipe.options["tolerance"])
    loose = max(LOOSEST, tight) if loosest is None else float(loosest)
    if not tight <= loose < 1:
        raise ValueError(f"--loosest {loose:g} must lie between --tolerance {tight:g} and 1")
    found = plan(
        recipe.scene, recipe.slm, tolerance=tight, budget=budget, wavelength=recipe.wavelength,
        encoding=recipe.coding, every=False,
    )  # fmt: skip
    expected = {
        choice.tolerance: LATE * choice.mean
        for choice in found.choices
        if choice.compensation == recipe.compensation and choice.tolerance is not None
    }
    return Pace(budget, tight, loose, first_tolerance(expected, budget, tight, loose))


def paced(recipe: Recipe, numbers: range, pace: Pace) -> Iterator[VideoFrame]:
    """The frames; where the tolerance becomes another one, from a new key frame on.

    A frame's time ends when the next one is asked for: what is made of it counts.
    """
    left = numbers
    while len(left):
        options = {**recipe.options, "tolerance": pace.tolerance}
        fresh = recipe.compensation != "none" and len(pace.frames) > 0
        frames = replace(recipe, options=options).video(left[0], left[-1])
        start = time.perf_counter()
        for frame in frames:
            yield frame
            changed = pace.took(frame.number, time.perf_counter() - start, fresh)
            fresh = False
            left = range(frame.number + 1, numbers[-1] + 1)
            if changed:
                break
            start = time.perf_counter()
        else:
            return
