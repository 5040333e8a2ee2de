"""`chrmc pattern`: test pictures for setting up a bench, as a file or on the screen."""

import hashlib
from math import radians
from pathlib import Path
from typing import Any

import click

from chrmc.cli.arguments import slm_option
from chrmc.cli.lengths import DEPTH, PLACE, Length
from chrmc.cli.lengths import WAVELENGTH as LIGHT
from chrmc.cli.play import show, surface_options
from chrmc.encoding import CODINGS
from chrmc.slm import SLM, WAVELENGTH

SETTINGS = (
    *("depth", "at", "encoding", "wavelength", "response", "period", "angle", "sine", "size"),
    *("count", "thickness", "level", "low", "high"),
)
KINDS = ("point", "grating", "checkerboard", "ramp", "steps", "cross-hair", "uniform")


@click.command("pattern")
@click.argument("kind", type=click.Choice(KINDS))
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    default=None,
    help="Write a .tif or .png instead of showing it.",
)
@click.option("--depth", type=Length(DEPTH), default="250mm", show_default=True, help="point.")
@click.option(
    "--at", type=(Length(PLACE), Length(PLACE)), default=(0.0, 0.0), help="point: x y. [0 0]"
)
@click.option(
    "--encoding",
    type=click.Choice(CODINGS),
    default=None,
    help="point. [ssb; error-diffusion, double-phase on a panel known as binary, phase]",
)
@click.option("--wavelength", type=Length(LIGHT), default=WAVELENGTH, help="point. [532nm]")
@click.option("--response", default=None, help="point: linear, gamma:G, or a CSV table.")
@click.option("--period", type=float, default=16.0, show_default=True, help="grating: pixels.")
@click.option("--angle", type=float, default=0.0, help="grating: degrees; 0 is upright lines.")
@click.option("--sine", is_flag=True, help="grating: sinusoidal instead of binary.")
@click.option("--size", type=int, default=100, show_default=True, help="checkerboard: pixels.")
@click.option("--count", type=int, default=16, show_default=True, help="steps: number of greys.")
@click.option("--thickness", type=int, default=2, show_default=True, help="cross-hair: pixels.")
@click.option("--level", type=int, default=128, show_default=True, help="uniform: grey.")
@click.option("--low", type=int, default=0, show_default=True, help="Darker grey of two.")
@click.option("--high", type=int, default=255, show_default=True, help="Brighter grey of two.")
@slm_option
@surface_options
def command(kind: str, out: Path | None, slm: SLM, **rest: Any) -> int:
    """Make a test picture: a point of light, grating, checkerboard, ramp, steps, or cross-hair.

    With --out it is written to a file, else shown as `chrmc play` shows a picture.
    """
    from chrmc.pictures import write_grey
    from display.playlist import Picture, check_levels
    from display.prefetch import Ring

    levels = draw(kind, slm, {name: rest.pop(name) for name in SETTINGS})
    check_levels(levels, slm, kind)
    if out is not None:
        if out.suffix.lower() not in (".tif", ".tiff", ".png"):
            raise ValueError(f"{out}: name the picture .tif or .png")
        write_grey(out, levels)
        click.echo(f"{out}: {kind}, {slm.width} × {slm.height}")
        return 0
    picture = Picture(1, kind, hashlib.sha256(levels.tobytes()).hexdigest(), levels)
    with Ring(lambda _: picture, 1) as ring:
        return show(ring, slm, kind, hold=not rest["headless"], **rest)


def draw(kind: str, slm: SLM, given: dict[str, Any]) -> Any:
    """The grey levels of a kind of pattern."""
    from chrmc.response import GreyResponse
    from display import patterns

    low, high = given["low"], given["high"]
    if kind == "point":
        response = GreyResponse.parse(given["response"])
        response.check_wavelength(given["wavelength"])
        x, y = given["at"]
        return patterns.point(
            slm, given["wavelength"], given["depth"], x, y, given["encoding"], response
        )
    if kind == "grating":
        shape = "sine" if given["sine"] else "binary"
        return patterns.grating(slm, given["period"], radians(given["angle"]), low, high, shape)
    if kind == "checkerboard":
        return patterns.checkerboard(slm, given["size"], low, high)
    if kind == "ramp":
        return patterns.ramp(slm)
    if kind == "steps":
        return patterns.steps(slm, given["count"])
    if kind == "cross-hair":
        return patterns.cross_hair(slm, given["thickness"], low, high)
    return patterns.uniform(slm, given["level"])
