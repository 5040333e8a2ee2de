"""Arguments that several commands share, and what they mean."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from chrmc.encoding import CODINGS
from chrmc.slm import LC_R_1080, SLM


class FrameRange(click.ParamType):
    """A:B, 1-based and inclusive; a single number is that frame alone."""

    name = "A:B"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        if isinstance(value, tuple):
            return value
        match = re.fullmatch(r"(\d+)(?::(\d+))?", str(value).strip())
        if not match:
            self.fail(f"{value!r} is no frame range; write A:B, such as 1:80", param, ctx)
        first = int(match[1])
        return first, int(match[2] or first)


class SLMType(click.ParamType):
    """`lc-r-1080`, or WIDTHxHEIGHT:PITCH with the pitch in metres."""

    name = "SLM"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> SLM:
        if isinstance(value, SLM):
            return value
        text = str(value).strip().lower()
        if text == "lc-r-1080":
            return LC_R_1080
        match = re.fullmatch(r"(\d+)x(\d+):([0-9.]+(?:e-?\d+)?)", text)
        if not match:
            self.fail(
                f"{value!r} is no SLM; write lc-r-1080 or WIDTHxHEIGHT:PITCH in metres, "
                "such as 1920x1080:8e-6",
                param,
                ctx,
            )
        width, height, pitch = int(match[1]), int(match[2]), float(match[3])
        return SLM(f"{width} × {height} SLM", width, height, pitch)


class Setting(click.ParamType):
    """NAME=VALUE for a method; numbers, true and false are recognised."""

    name = "NAME=VALUE"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, Any]:
        if isinstance(value, tuple):
            return value
        key, sign, text = str(value).partition("=")
        if not sign or not key.strip():
            self.fail(f"{value!r} is no setting; write NAME=VALUE", param, ctx)
        key = key.strip().replace("-", "_")
        for kind in (int, float):
            try:
                return key, kind(text)
            except ValueError:
                continue
        return key, {"true": True, "false": False, "none": None}.get(text.lower(), text)


frames_option = click.option(
    "--frames", type=FrameRange(), default=None, help="Frames A to B, inclusive, from 1. [all]"
)
slm_option = click.option(
    "--slm",
    type=SLMType(),
    default="lc-r-1080",
    show_default=True,
    help="lc-r-1080, or WIDTHxHEIGHT:PITCH with the pitch in metres.",
)
wavelength_option = click.option(
    "--wavelength", type=float, default=None, help="Metres. [the scene's, else 532e-9]"
)
form_option = click.option(
    "--form",
    type=click.Choice(["points", "rgbd"]),
    default="points",
    show_default=True,
    help="points: body-fixed, exact; rgbd: quantised intensity and depth pictures. "
    "A folder is always rgbd.",
)


def stacked(*options: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Several options as one decorator, shown by --help in this order."""

    def decorate(function: Any) -> Any:
        for option in reversed(options):
            function = option(function)
        return function

    return decorate


method_options = stacked(
    click.option("--cgh", default=None, help="CGH method. [curved]"),
    click.option("--compensation", default=None, help="Video method. [ch-rmc]"),
    click.option("--surface", default=None, help="Of ch-rmc: object (exact) or paper. [object]"),
    click.option(
        "--tolerance",
        type=float,
        default=None,
        help="Largest relative field error against the exact truth. [1e-3]",
    ),
)

recipe_options = stacked(
    method_options,
    frames_option,
    click.option("--encoding", type=click.Choice(CODINGS), default="ssb", show_default=True),
    form_option,
    slm_option,
    wavelength_option,
    click.option(
        "--gamma", type=float, default=None, help="Grey response: intensity = grey^GAMMA."
    ),
    click.option(
        "--response",
        type=click.Path(path_type=Path),
        default=None,
        help="Grey response: CSV table of grey against intensity.",
    ),
    click.option(
        "--set",
        "settings",
        type=Setting(),
        multiple=True,
        help="An option of the methods, such as --set radius=0.2. May be repeated.",
    ),
)
