"""Everything that decides what a video's frames look like: defaults, refusals, and the manifest."""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from itertools import cycle
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import numpy as np

from chrmc.cgh import Method
from chrmc.compensation import VideoMethod, chosen, frames_by, scene_wavelength
from chrmc.compensation.frame import VideoFrame
from chrmc.encoding import Coding, coding_for
from chrmc.generation.auto import Taken, is_auto, stored_manifest, taken
from chrmc.generation.checking import SHARE, SHARES, Check, check_within, stored_check
from chrmc.panels import encoding_for
from chrmc.planning.choices import GROUP
from chrmc.python_file import identity, is_python_name, one_line
from chrmc.ranges import Count, short
from chrmc.response import GreyResponse
from chrmc.scene.drawn import DrawnScene, drawn
from chrmc.scene.origin import Origin
from chrmc.scene.scene import Scene, as_scene, frame_range
from chrmc.slm import LC_R_1080, SLM, WAVELENGTH
from chrmc.store.manifest import FORMAT

CHECK_SEED = 20180101
"""Seed of the pixels that `error_reference` is measured on, recorded in the manifest."""
GROUP_COUNT = Count("group", 1, 1_000_000)
CHECK_COUNT = Count("check_pixels", 0, 1 << 24)


@dataclass(frozen=True)
class Recipe:
    """Everything that decides what a video's frames look like.

    source : what the scene was loaded from, FILE.py:NAME or files, for the manifest
    group : the video is cut after every so many frames; each group begins with a key frame and
        depends on nothing outside it
    auto : how the methods were chosen, where they were not named
    check_pixels, check_every : see `Check`
    """

    scene: Scene
    slm: SLM = LC_R_1080
    wavelength: float = WAVELENGTH
    cgh: str | Method = "rt"
    compensation: str | VideoMethod = "none"
    options: dict[str, Any] = field(default_factory=dict)
    encoding: str = "ssb"
    check_pixels: int = 256
    response: GreyResponse | None = None
    source: str | Origin | None = None
    group: int = GROUP
    auto: Taken | None = None
    check_every: int = 1

    @property
    def coding(self) -> Coding:
        """Passband and carrier of the encoding."""
        return coding_for(self.encoding, self.slm)

    @property
    def auto_line(self) -> str:
        """A line on what `auto` took, and why; empty where the methods were named."""
        return f"auto: {self.auto.why}" if self.auto is not None and self.auto.why else ""

    @property
    def looks(self) -> int:
        """Draws of the phases that follow one another."""
        return self.scene.looks if isinstance(self.scene, DrawnScene) else 1

    def video(self, first: int, last: int, **more: Any) -> Iterator[VideoFrame]:
        """Frames first … last, made one by one; `more` options, such as a cache.

        Every look is a video of its own, whose bodies keep their phases from frame to frame.
        """
        numbers, looks = frame_range(self.scene, (first, last)), self.looks
        videos = cycle(
            frames_by(
                self.scene,
                self.slm,
                self.wavelength,
                self.coding,
                numbers[look::looks],
                self.cgh,
                self.compensation,
                {**self.options, **more},
            )
            for look in range(min(looks, len(numbers)))
        )
        return (next(frames) for frames, _ in zip(videos, numbers, strict=False))

    def group_of(self, number: int) -> range:
        """The frames of the group that a frame belongs to."""
        first = (number - 1) // self.group * self.group + 1
        return range(first, min(first + self.group - 1, self.scene.frame_count) + 1)


def recipe_for(
    scene: Scene,
    slm: SLM = LC_R_1080,
    wavelength: float | None = None,
    *,
    cgh: str | Method | None = None,
    compensation: str | VideoMethod | None = None,
    surface: str | None = None,
    tolerance: float | None = None,
    encoding: str | None = None,
    gamma: float | None = None,
    response: GreyResponse | str | PathLike[str] | None = None,
    settings: tuple[tuple[str, Any], ...] | Mapping[str, Any] = (),
    check_pixels: int | None = None,
    check_share: float = SHARE,
    group: int | None = None,
    looks: int = 1,
    source: str | Origin | None = None,
    folder: Path | None = None,
) -> Recipe:
    """The recipe that these choices mean; ValueError where they do not fit together.

    encoding : default the usual one of the panel's kind
    check_pixels : on which each frame's error is measured; default as many, of as many frames, as
        `check_share` of the time allows
    group : of the scene's frames, each in all its looks
    looks : draws of the phases that are shown of each frame, one after the other
    folder : of the video, whose manifest says what `auto` and the check were when it was begun
    """
    scene = as_scene(scene)
    if not isinstance(slm, SLM):
        raise ValueError(f"slm must be an SLM, such as chrmc.LC_R_1080, not {short(slm)}")
    encoding = encoding_for(slm, encoding)
    coding = coding_for(encoding, slm)
    light = scene_wavelength(scene, wavelength)
    auto, before = None, stored_manifest(folder)
    if is_auto(cgh, compensation, surface, dict(settings)):
        with one_line(source):
            auto = taken(scene, slm, light, coding, tolerance, before.get("methods"))
        cgh, compensation, options = auto.cgh, auto.compensation, auto.options
    else:
        cgh, compensation, options = chosen(cgh, compensation, surface, tolerance, dict(settings))
    if gamma is not None and response is not None:
        raise ValueError("--gamma and --response both give the grey response; use one")
    grey = None
    if gamma is not None:
        grey = GreyResponse.from_gamma(gamma)
    elif isinstance(response, GreyResponse):
        grey = response
    elif response is not None:
        grey = GreyResponse.from_csv(fspath(response))
    if grey is not None:
        grey.check_wavelength(light)
    if group is None:
        # Frames that owe each other nothing are groups of their own.
        group = 1 if compensation == "none" else GROUP
    scene = drawn(scene, looks)
    if check_pixels is None:
        check = stored_check(before)
        if check is None:
            with one_line(source, cgh, compensation):
                check = check_within(
                    SHARES.of(check_share), scene, slm, light, coding.passband, cgh, compensation,
                    options,
                )  # fmt: skip
    else:
        check = Check(CHECK_COUNT.of(check_pixels))
    return Recipe(
        scene,
        slm,
        light,
        cgh,
        compensation,
        {name: python_number(value) for name, value in options.items()},
        encoding,
        check.pixels,
        grey,
        source,
        GROUP_COUNT.of(group) * looks,
        auto,
        check.every,
    )


def python_number(value: Any) -> Any:
    """A NumPy scalar as a Python number, so that its precision goes no further; others as is."""
    return value.item() if isinstance(value, np.generic) else value


def describe(recipe: Recipe) -> dict[str, Any]:
    """The manifest without its frames, scale, and what only a look at the points can tell."""
    coding = recipe.coding
    description: dict[str, Any] = {
        "format": FORMAT,
        "slm": asdict(recipe.slm),
        "wavelength": recipe.wavelength,
        "scene": {
            "name": str(recipe.scene.name),
            "form": recipe.scene.form,
            "frame_count": recipe.scene.frame_count,
            "pixel_pitch": float(recipe.scene.pixel_pitch),
            "objects": [str(name) for name in recipe.scene.object_names],
        },
        "methods": {
            "cgh": identity(getattr(recipe.cgh, "field", recipe.cgh)),
            "compensation": identity(recipe.compensation),
            "options": {name: _plain(name, v) for name, v in recipe.options.items()},
        },
        "encoding": coding.name,
        "carrier": coding.carrier,
        "passband": asdict(coding.passband),
        "group": recipe.group,
        "response": (recipe.response or GreyResponse.linear()).as_dict(),
        "error_check": {"pixels": recipe.check_pixels, "seed": CHECK_SEED}
        | ({"every": recipe.check_every} if recipe.check_every > 1 else {}),
    }
    if recipe.looks > 1:
        description["scene"]["looks"] = recipe.looks
    if is_python_name(recipe.source):
        description["scene"]["source"] = identity(recipe.source)
    return description


def _plain(name: str, value: Any) -> Any:
    """An option as JSON holds it; ValueError for what it cannot hold."""
    value = python_number(value)
    if isinstance(value, float) and not np.isfinite(value):
        return str(value)
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [_plain(name, entry) for entry in value]
    if isinstance(value, Mapping):
        return {str(key): _plain(name, entry) for key, entry in value.items()}
    if callable(value):
        return identity(value)
    raise ValueError(
        f"option {name} is {short(value)}, which no manifest can hold: give numbers, text, lists "
        "or a function"
    )
