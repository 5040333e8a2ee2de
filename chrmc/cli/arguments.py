"""Arguments that several commands share, and what they mean."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from chrmc.cli.lengths import METRES, PITCH, WAVELENGTH, Length, Lengths, parse_length, split_length
from chrmc.cli.names import (
    Name,
    NamedOption,
    cgh_names,
    compensation_names,
    settings_listing,
)
from chrmc.encoding import CODINGS
from chrmc.panels import PANELS, encoding_for, panel_named
from chrmc.ranges import TOLERANCE_RANGE, Range, short
from chrmc.slm import SLM


def frames_between(text: str) -> tuple[int, int] | None:
    """First and last of A:B, or of A alone; None for anything else."""
    match = re.fullmatch(r"(\d{1,9})(?::(\d{1,9}))?", text.strip(), re.ASCII)
    return None if match is None else (int(match[1]), int(match[2] or match[1]))


class FrameRange(click.ParamType):
    """A:B, 1-based and inclusive; a single number is that frame alone."""

    name = "A:B"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        if isinstance(value, tuple):
            return value
        ends = frames_between(str(value))
        if ends is None:
            self.fail(f"{short(value)} is no frame range; write A:B, such as 1:80", param, ctx)
        return ends


class Quantity(click.ParamType):
    """A number in a range: refused before a scene is read."""

    name = "float"

    def __init__(self, within: Range) -> None:
        self.within = within

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        return self.within.of(click.FLOAT.convert(value, param, ctx))


class Paths(click.ParamType):
    """A file, or several parted by commas as a tuple; a comma in the name of one that is there
    parts nothing."""

    name = "FILE[,FILE…]"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if isinstance(value, Path | tuple):
            return value
        text = str(value)
        parts = [text] if Path(text).exists() else text.split(",")
        if not all(part.strip() for part in parts):
            self.fail(f"{text!r} has an empty name", param, ctx)
        found = tuple(Path(part.strip()) for part in parts)
        return found[0] if len(found) == 1 else found


PANEL = "chrmc.panel"
"""Of the panel that --slm named, in click's context."""


def by_panel(options: dict[str, Any]) -> dict[str, Any]:
    """A recipe's options with the encoding and the response of the panel that --slm named, where
    they were not given; ValueError for an encoding that it cannot show."""
    panel = click.get_current_context().meta.get(PANEL)
    chosen = dict(options)
    if panel is not None:
        chosen["encoding"] = encoding_for(panel.slm, options["encoding"])
    if panel is not None and options.get("gamma") is None and options.get("response") is None:
        chosen["response"] = panel.response
    return chosen


class SLMType(click.ParamType):
    """A panel's name, its TOML file, or WIDTHxHEIGHT:PITCH, such as 1920x1080:8um."""

    name = "SLM"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> SLM:
        if isinstance(value, SLM):
            return value
        try:
            panel = panel_named(str(value))
        except (OSError, ValueError) as error:
            self.fail(str(error), param, ctx)
        if panel is not None:
            if ctx is not None:
                ctx.meta[PANEL] = panel
            return panel.slm
        text = str(value).strip().lower()
        match = re.fullmatch(r"(\d{1,6})[x×](\d{1,6}):(.+)", text)
        if not match:
            self.fail(
                f"{value!r} is no SLM; write {', '.join(PANELS)} (chrmc panels lists them), a "
                "file such as panel.toml, or WIDTHxHEIGHT:PITCH, such as 1920x1080:8um or "
                "1920x1080:8e-6",
                param,
                ctx,
            )
        width, height = int(match[1]), int(match[2])
        try:
            pitch = parse_length(match[3], PITCH)
        except ValueError as error:
            self.fail(str(error), param, ctx)
        return SLM(f"{width} × {height} SLM", width, height, pitch)


class Setting(click.ParamType):
    """NAME=VALUE for a method; numbers, lengths (145mm), true, false and none are recognised."""

    name = "NAME=VALUE"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, Any]:
        if isinstance(value, tuple):
            return value
        key, _, text = str(value).partition("=")
        text = text.strip()
        if not key.strip() or not text:
            self.fail(f"{value!r} is no setting; write NAME=VALUE", param, ctx)
        key = key.strip().replace("-", "_")
        number = split_length(text)
        if number is None:
            return key, {"true": True, "false": False, "none": None}.get(text.lower(), text)
        digits, unit = number
        if abs(float(digits)) > 1e15:
            self.fail(f"{value!r}: {digits} is beyond what any setting can be", param, ctx)
        if unit:
            return key, float(digits) * METRES[unit]
        return key, float(digits) if set(digits) & set(".e") else int(digits)


class FigurePath(click.Path):
    """A file to draw: refused at once, not after the work, where its kind cannot be written."""

    name = "FILE"

    def __init__(self) -> None:
        super().__init__(path_type=Path, dir_okay=False)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        from chrmc.figures import check_figure

        try:
            return check_figure(str(super().convert(value, param, ctx)))
        except ValueError as error:
            self.fail(str(error), param, ctx)


def figure_option(name: str) -> Callable[[Any], Any]:
    """The figure that a bench puts into its folder."""
    return click.option(
        "--figure",
        type=FigurePath(),
        default=name,
        show_default=True,
        help="Name of the figure in that folder: a .png, .pdf or .svg.",
    )


frames_option = click.option(
    "--frames", type=FrameRange(), default=None, help="Frames A to B, inclusive, from 1. [all]"
)
slm_option = click.option(
    "--slm",
    type=SLMType(),
    default="lc-r-1080",
    show_default=True,
    help="A name (chrmc panels), a .toml file, or WIDTHxHEIGHT:PITCH such as 1920x1080:8um.",
)
wavelength_option = click.option(
    "--wavelength",
    type=Length(WAVELENGTH),
    default=None,
    help="Such as 532nm. [the scene's, else 532nm]",
)
wavelengths_option = click.option(
    "--wavelength",
    type=Lengths(WAVELENGTH),
    default=None,
    help="Such as 532nm, or 638nm,532nm,450nm for a video in colours. [the scene's, else 532nm]",
)
form_option = click.option(
    "--form",
    type=click.Choice(["points", "rgbd"]),
    default="points",
    show_default=True,
    help="points: body-fixed, exact; rgbd: quantised intensity and depth pictures. "
    "A folder without poses is rgbd.",
)


def stacked(*options: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Several options as one decorator, shown by --help in this order."""

    def decorate(function: Any) -> Any:
        for option in reversed(options):
            function = option(function)
        return function

    return decorate


method_options = stacked(
    click.option(
        "--cgh",
        cls=NamedOption,
        type=Name(cgh_names),
        listing=lambda: ", ".join(cgh_names()) + ", or FILE.py:NAME.",
        default=None,
        help="CGH method. [auto]",
    ),
    click.option(
        "--compensation",
        cls=NamedOption,
        type=Name(compensation_names),
        listing=lambda: ", ".join(compensation_names()) + ", or FILE.py:NAME.",
        default=None,
        help="Video method. [auto]",
    ),
    click.option(
        "--surface",
        type=Name(lambda: ("object", "paper")),
        default=None,
        help="Of ch-rmc: object (exact) or paper. [object]",
    ),
    click.option(
        "--tolerance",
        type=Quantity(TOLERANCE_RANGE),
        default=None,
        help="Largest relative field error against the exact truth. [1e-3]",
    ),
)

recipe_options = stacked(
    method_options,
    frames_option,
    click.option(
        "--encoding",
        type=click.Choice(CODINGS),
        default=None,
        help="[ssb; error-diffusion, double-phase on a panel known as binary, phase]",
    ),
    form_option,
    slm_option,
    wavelengths_option,
    click.option(
        "--gamma", type=float, default=None, help="Grey response: intensity = grey^GAMMA."
    ),
    click.option(
        "--response",
        type=Paths(),
        default=None,
        help="Grey response: CSV table of grey against intensity; of several wavelengths one for "
        "all, or red.csv,green.csv,blue.csv in their order.",
    ),
    click.option(
        "--set",
        "settings",
        cls=NamedOption,
        type=Setting(),
        multiple=True,
        listing=settings_listing,
        help="An option of the methods, such as --set radius=145mm. May be repeated. Of",
    ),
)
