"""The making of a stored hologram video: what its folder lacks, group by group."""

from collections.abc import Generator
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

from chrmc.cgh import method_named
from chrmc.files import told_when_full
from chrmc.generation.group import groups_of, make_group
from chrmc.generation.recipe import Recipe, describe
from chrmc.progress import progress
from chrmc.python_file import one_line
from chrmc.scene.origin import MADE_OF, Origin
from chrmc.scene.scene import frame_range
from chrmc.store.differences import differences, refuse_another
from chrmc.store.group import group_records
from chrmc.store.lock import writer_lock
from chrmc.store.manifest import SCALE
from chrmc.store.video import MANIFEST
from chrmc.store.writer import VideoWriter, existing_manifest, remove_video, replace_video
from chrmc.survey import Survey, spot_check, survey

REPLACEMENT = ".replacement"
"""Folder in which a video that replaces another is made; it takes its place when it stands."""


def make_video(
    recipe: Recipe,
    folder: Path,
    frames: tuple[int, int] | None = None,
    suffix: str = ".tif",
    *,
    force: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    seen: Survey | None = None,
    scale: float | None = None,
) -> int:
    """Make the frames that `folder` does not hold yet; the number made.

    seen : what a look at the scene told, where that was done before
    scale : signal at which the grey range ends, default by the scene's brightest frame

    A frame's bytes and record (times aside) depend on the recipe alone: its group is made from
    the group's first frame on, whichever of it are there already.
    """
    numbers = frame_range(recipe.scene, frames)
    own_code = one_line(recipe.source, recipe.cgh, recipe.compensation)
    look = (seen, scale)
    with told_when_full(folder), writer_lock(folder), own_code:
        if not (force and (folder / MANIFEST).exists()):
            return _fill(recipe, folder, numbers, suffix, workers, scheduler, look)
        new = folder / REPLACEMENT
        if is_another(new, recipe):
            remove_video(new)
        new.mkdir(exist_ok=True)
        try:
            count = _fill(recipe, new, numbers, suffix, workers, scheduler, look)
            replace_video(folder, new)
        finally:
            with suppress(OSError):
                new.rmdir()  # when it is empty
        return count


def is_another(folder: Path, recipe: Recipe) -> bool:
    """Whether a folder holds a video, and that of another recipe."""
    before = existing_manifest(folder)
    return before is not None and any(differences(before, wanted_of(recipe, before)))


def wanted_of(recipe: Recipe, before: dict[str, Any] | None) -> dict[str, Any]:
    """What the manifest `before` must say to be the recipe's."""
    description = describe(recipe)
    if before is not None and recipe.auto is not None and "auto" in before["methods"]:
        description["methods"]["auto"] = {"tolerance": recipe.auto.asked}
    return description


def whole_description(
    recipe: Recipe,
    before: dict[str, Any] | None,
    folder: Path,
    seen: Survey | None = None,
    scale: float | None = None,
) -> dict[str, Any]:
    """The manifest without its frames: from one look at the scene (or `seen`), or, where the
    folder holds this video already, from its manifest and a spot check."""
    from chrmc.grey_levels import scale_of

    description = wanted_of(recipe, before)
    scene: dict[str, Any] = description["scene"]
    if before is not None:
        refuse_another(folder, before, description)
        if "auto" in before["methods"]:
            description["methods"]["auto"] = before["methods"]["auto"]
        if "spot_check" in before["scene"]:
            scene["spot_check"] = spot_check(recipe.scene)
            refuse_another(folder, before, description)
            # The same points: where they came from is no difference.
            kept = {"fingerprint", MADE_OF} & before["scene"].keys()
            scene |= {key: before["scene"][key] for key in kept}
            return description | {"scale": before["scale"]}
    if recipe.auto is not None and recipe.auto.why:
        description["methods"]["auto"] = {"tolerance": recipe.auto.asked, "why": recipe.auto.why}
    found = seen or survey(recipe.scene, recipe.slm, recipe.wavelength, recipe.coding)
    scene |= {"fingerprint": found.fingerprint, "spot_check": found.spot_check}
    if isinstance(recipe.source, Origin):
        scene[MADE_OF] = recipe.source.described()
    # A video without any light is legal, and any scale shows it.
    if scale is None:
        scale = scale_of(found.power, recipe.slm, recipe.coding) or 1.0
    if not SCALE.low <= scale <= SCALE.high:
        raise ValueError(
            f"the brightest frame's amplitude on the panel is {scale:.3g}, and a video holds "
            f"{SCALE.low:g} to {SCALE.high:g}: scale the amplitudes"
        )
    return description | {"scale": scale}


def _fill(
    recipe: Recipe,
    folder: Path,
    numbers: range,
    suffix: str,
    workers: int | None = None,
    scheduler: str | None = None,
    look: tuple[Survey | None, float | None] = (None, None),
) -> int:
    """Make the missing ones of the frames `numbers`, group by group."""
    description = whole_description(recipe, existing_manifest(folder), folder, *look)
    writer = VideoWriter(folder, description, suffix)
    with closing(writer.entries):
        return _fill_missing(recipe, writer, numbers, workers, scheduler)


def _fill_missing(
    recipe: Recipe,
    writer: VideoWriter,
    numbers: range,
    workers: int | None,
    scheduler: str | None,
) -> int:
    missing = [n for n in numbers if n not in writer.entries]
    if missing or group_records(writer.folder):  # a run that was cut off may have left these
        writer.collect()
    if not missing:
        return 0
    if workers is None and scheduler is None:
        frames = _frames_of_groups(recipe, writer, missing)
    else:
        from chrmc.generation.cluster import frames_on_cluster

        frames = frames_on_cluster(recipe, writer, missing, workers, scheduler)
    try:
        with closing(frames):
            return sum(1 for _ in progress(frames, "generate", total=len(missing)))
    finally:
        writer.collect()
        writer.discard_if_empty()


def _frames_of_groups(
    recipe: Recipe, writer: VideoWriter, missing: list[int]
) -> Generator[int, None, None]:
    options = method_named(recipe.cgh).with_cache(recipe.options)
    scale = writer.description["scale"]
    for group, wanted in groups_of(recipe, missing):
        yield from make_group(recipe, writer.folder, scale, group, wanted, writer.suffix, options)
        if writer.due:
            writer.collect()
