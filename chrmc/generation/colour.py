"""One scene in the light of several lasers: a video for each, on one scale, white in balance.

A laser's grey range ends at s = 3σ of what it would show were every point white, times one factor
for all lasers, so that the one that has most to show just fills its range. Light of the image is
(field/s)²: lasers of equal power then show white points white, however much of the panel their
footprints cover at each wavelength. Where the panel's grey response leaves a laser only a part of
its amplitude, s is that part of it, so that the balance holds. Balance the lasers by a uniform
frame that looks white.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from math import sqrt
from os import PathLike
from pathlib import Path
from typing import Any

from chrmc.files import told_when_full
from chrmc.generation.make import REPLACEMENT, is_another, make_video
from chrmc.generation.recipe import Recipe, recipe_for
from chrmc.grey_levels import scale_of
from chrmc.python_file import one_line
from chrmc.response import GreyResponse
from chrmc.scene.drawn import drawn, drawn_frames
from chrmc.scene.light import scenes_in_light
from chrmc.scene.scene import Scene, frame_range
from chrmc.slm import SLM
from chrmc.store.colour import Plan, lasers_of, read_plan, write_plan
from chrmc.store.lock import writer_lock
from chrmc.store.video import COLOUR, MANIFEST
from chrmc.store.writer import existing_manifest, remove_video
from chrmc.survey import Survey, surveys

Response = GreyResponse | str | PathLike[str] | None
Responses = Response | Sequence[Response]


def make_in_light(
    scene: Scene,
    slm: SLM,
    wavelength: float | Sequence[float] | None,
    choices: Mapping[str, Any],
    folder: Path,
    frames: tuple[int, int] | None = None,
    suffix: str = ".tif",
    *,
    force: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    tell: Callable[[str], object] | None = None,
) -> int:
    """Make a scene's video in light of one wavelength or several; the number of frames made.

    choices : of `recipe_for`, the response also one for each laser; the rest as in `make_video`
    tell : is given a line on what `auto` takes
    """
    responses = _responses(choices.get("response"), max(len(lasers_of(wavelength)), 1))
    how: dict[str, Any] = {"force": force, "workers": workers, "scheduler": scheduler}
    lasers = lasers_of(wavelength)
    looks = choices.get("looks", 1)
    frames = drawn_frames(frames, looks)
    there = (folder / MANIFEST).exists() or (folder / COLOUR).exists()
    begun = folder / REPLACEMENT if force and there else folder
    if not lasers:
        one_choice = {**choices, "response": responses[0]}
        recipe = recipe_for(scene, slm, wavelength, folder=begun, **one_choice)  # type: ignore[arg-type]
        _tell(tell, recipe)
        return make_video(recipe, folder, frames, suffix, **how)
    recipes = []
    lit = scenes_in_light(scene, lasers)
    for one, name, response in zip(lit, _folders(begun, lasers), responses, strict=True):
        recipes.append(recipe_for(one, slm, folder=name, **{**choices, "response": response}))
        _tell(tell, recipes[-1])
    scene = drawn(scene, looks)
    frame_range(scene, frames)
    with told_when_full(folder), writer_lock(folder):
        if not (force and there):
            _refuse_another(folder, lasers)
            return _fill(scene, recipes, folder, frames, suffix, how)
        new = folder / REPLACEMENT
        if _is_another(new, recipes):
            remove_colours(new)
        count = _fill(scene, recipes, new, frames, suffix, how)
        _replace(folder, new)
        return count


def _responses(given: Any, lasers: int) -> list[Any]:
    """A response for each laser; ValueError where there are more or fewer."""
    if isinstance(given, str | PathLike | GreyResponse) or given is None:
        return [given] * lasers
    found = list(given)
    if len(found) not in (1, lasers):
        raise ValueError(
            f"{len(found)} responses for {lasers} wavelength{'s' * (lasers > 1)}: give one for "
            "each, in their order, or one for all"
        )
    return found if len(found) == lasers else found * lasers


def _folders(folder: Path, lasers: Sequence[float]) -> list[Path | None]:
    """Where each laser's video was begun."""
    plan = read_plan(folder)
    if plan is None or len(plan.folders) != len(lasers):
        return [None] * len(lasers)
    return [folder / name for name in plan.folders]


def _tell(tell: Callable[[str], object] | None, recipe: Recipe) -> None:
    if tell is not None and recipe.auto_line:
        tell(recipe.auto_line)


def _refuse_another(folder: Path, lasers: Sequence[float]) -> None:
    plan = read_plan(folder)
    if plan is None:
        if existing_manifest(folder) is not None:
            raise ValueError(
                f"{folder} holds a video in one colour: choose another --out, or replace it with "
                "--force"
            )
    elif plan.wavelengths != tuple(lasers):
        stored = ", ".join(f"{w * 1e9:g}" for w in plan.wavelengths)
        raise ValueError(
            f"{folder} holds another video (of {stored} nm): choose another --out, or replace it "
            "with --force"
        )


def _is_another(folder: Path, recipes: Sequence[Recipe]) -> bool:
    plan = read_plan(folder)
    if plan is None:
        return False
    return plan.wavelengths != tuple(r.wavelength for r in recipes) or any(
        is_another(folder / name, recipe)
        for name, recipe in zip(plan.folders, recipes, strict=True)
    )


def _fill(
    scene: Scene,
    recipes: Sequence[Recipe],
    folder: Path,
    frames: tuple[int, int] | None,
    suffix: str,
    how: dict[str, Any],
) -> int:
    """Make what is missing, laser by laser."""
    plan = read_plan(folder)
    seen: list[Survey | None] = [None] * len(recipes)
    # A plan of which nothing was made may be of another scene.
    if plan is None or not any((folder / name / MANIFEST).exists() for name in plan.folders):
        with one_line(recipes[0].source):
            plan, seen = balanced(scene, recipes)
        write_plan(folder, plan)
    count = 0
    try:
        for name, recipe, look, scale in zip(plan.folders, recipes, seen, plan.scales, strict=True):
            count += make_video(
                recipe, folder / name, frames, suffix, **how | {"force": False}, seen=look,
                scale=scale,
            )  # fmt: skip
    finally:
        if not any((folder / name / MANIFEST).exists() for name in plan.folders):
            remove_colours(folder)
    return count


def balanced(scene: Scene, recipes: Sequence[Recipe]) -> tuple[Plan, list[Survey | None]]:
    """The scale of each laser, and what the one look at the scene told of each recipe's."""
    slm, coding = recipes[0].slm, recipes[0].coding
    wavelengths = tuple(r.wavelength for r in recipes)
    lit = [(r.scene, r.wavelength) for r in recipes] + [(scene, w) for w in wavelengths]
    found = surveys(lit, slm, coding)
    coloured, white = found[: len(recipes)], found[len(recipes) :]
    # A panel that is never quite dark gives that laser less light for the same signal.
    swings = [1.0 if coding.wave or r.response is None else r.response.swing for r in recipes]
    shares = [
        sqrt(c.power / w.power) / swing
        for c, w, swing in zip(coloured, white, swings, strict=True)
        if w.power
    ]
    factor = max(shares, default=0.0) or 1.0
    scales = tuple(
        factor * swing * scale_of(w.power, slm, coding) or 1.0
        for w, swing in zip(white, swings, strict=True)
    )
    return Plan(wavelengths, scales), list(coloured)


def remove_colours(folder: Path) -> None:
    """Delete a video in colours, and nothing else."""
    plan = read_plan(folder)
    if plan is not None:
        for name in plan.folders:
            remove_video(folder / name)
            with suppress(OSError):
                (folder / name).rmdir()
        (folder / COLOUR).unlink()


def _replace(folder: Path, new: Path) -> None:
    """Put the video in `new` in place of the one in `folder`, which goes only then."""
    remove_video(folder)
    remove_colours(folder)
    plan = read_plan(new)
    assert plan is not None
    (new / COLOUR).replace(folder / COLOUR)
    for name in plan.folders:
        (new / name).replace(folder / name)
    new.rmdir()
