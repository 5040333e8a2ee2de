"""`auto`: the methods that the plan takes, or those that a stored video was begun with."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from chrmc import compensation as videos
from chrmc.cgh import Method
from chrmc.compensation import AUTO, DEFAULT_TOLERANCE, VideoMethod, scene_wavelength
from chrmc.compensation.frame import VideoFrame
from chrmc.encoding import Coding, coding_for
from chrmc.files import read_json
from chrmc.planning.choices import plan
from chrmc.ranges import TOLERANCE_RANGE
from chrmc.scene.scene import Scene, as_scene
from chrmc.slm import SLM
from chrmc.store.video import MANIFEST


@dataclass(frozen=True)
class Taken:
    """What was chosen by itself.

    options : of the methods; asked : the tolerance that it was chosen for
    why : in one sentence
    """

    cgh: str | Method
    compensation: str | VideoMethod
    options: dict[str, Any]
    asked: float
    why: str


def stored_manifest(folder: Path | None) -> Mapping[str, Any]:
    """The manifest that a folder holds; empty without one that can be read."""
    try:
        content = None if folder is None else read_json(folder / MANIFEST, "video")
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}


def is_auto(
    cgh: str | Method | None,
    compensation: str | VideoMethod | None,
    surface: str | None,
    options: Mapping[str, Any],
) -> bool:
    """Whether both methods are left open, and nothing is said that only some of them take."""
    free = (None, AUTO)
    named = callable(cgh) or callable(compensation)
    return not named and cgh in free and compensation in free and surface is None and not options


def taken(
    scene: Scene,
    slm: SLM,
    wavelength: float,
    coding: Coding,
    tolerance: float | None,
    before: Any = None,
) -> Taken:
    """The methods of a manifest that was begun for the same, so that a video that is continued
    does not depend on the machine that does it; else those of the plan.

    before : the `methods` of a manifest, if there is one
    """
    wanted = DEFAULT_TOLERANCE if tolerance is None else TOLERANCE_RANGE.of(tolerance)
    if isinstance(before, dict):
        names = before.get("cgh"), before.get("compensation")
        options = before.get("options")
        options = dict(options) if isinstance(options, dict) else {}
        known = all(isinstance(name, str) for name in names)
        auto = before.get("auto")
        auto = auto if isinstance(auto, dict) else {"tolerance": options.get("tolerance")}
        if known and auto.get("tolerance") == wanted:
            return Taken(str(names[0]), str(names[1]), options, wanted, str(auto.get("why", "")))
    try:
        found = plan(
            scene, slm, tolerance=wanted, wavelength=wavelength, encoding=coding, every=False
        )
    except ValueError:  # the methods themselves say why they cannot do it
        cgh, compensation, options = videos.chosen(tolerance=tolerance)
        return Taken(cgh, compensation, options, wanted, "")
    if not found.met:
        cgh, compensation, options = videos.chosen(tolerance=tolerance)
        return Taken(cgh, compensation, options, wanted, found.why)
    choice = found.taken
    cgh, compensation, options = videos.chosen(
        choice.cgh, choice.compensation, options=dict(choice.options)
    )
    return Taken(cgh, compensation, options, wanted, found.why)


def video(
    scene: Scene,
    slm: SLM,
    wavelength: float | None = None,
    *,
    cgh: str | Method | None = AUTO,
    compensation: str | VideoMethod | None = AUTO,
    tolerance: float | None = None,
    frames: tuple[int, int] | None = None,
    coding: Coding | str | None = None,
    **options: Any,
) -> Iterator[VideoFrame]:
    """Frames of a hologram video, one after the other.

    scene : from `load_scene`, or any object with the `Scene` attributes
    wavelength : metres; default the scene's, else 532 nm
    cgh : CGH method; compensation : video method; each a name, FILE.py:NAME or a function.
        "auto" takes what `chrmc.plan` finds cheapest; beside a named method, or options, it means
        "curved", and "ch-rmc" with it, "none" with another
    tolerance : largest relative field error, default 1e-3 where the methods promise one
    frames : (first, last), inclusive, from 1; default all
    coding : an encoding ("ssb" limits the field to its half band) or its name; default the
        full band without a carrier
    options : what the video method and the CGH method take

    Yields VideoFrame with .number, .cloud, .field (complex64 (H, W), made when asked for) and
    .record.
    """
    scene = as_scene(scene)
    if not isinstance(coding, Coding):
        coding = coding_for("real" if coding is None else coding, slm)
    if is_auto(cgh, compensation, None, options):
        light = scene_wavelength(scene, wavelength)
        found = taken(scene, slm, light, coding, tolerance)
        cgh, compensation, options = found.cgh, found.compensation, dict(found.options)
        tolerance = options.pop("tolerance", None)
    return videos.video(
        scene, slm, wavelength, cgh=cgh, compensation=compensation, tolerance=tolerance,
        frames=frames, coding=coding, **options,
    )  # fmt: skip
