"""Options that describe the optical bench, shared by the commands that reconstruct."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from chrmc.cli.lengths import DOT, FOCAL, ON_BENCH, PITCH, WIDTH, Length, parse_lengths

POSITIVE = click.FloatRange(0, min_open=True)
_OPTIONS = (
    click.option("--focal1", type=Length(FOCAL), default=0.15, help="Of lens 1. [150mm]"),
    click.option("--focal2", type=Length(FOCAL), default=0.15, help="Of lens 2. [150mm]"),
    click.option("--lens1", type=Length(WIDTH), default=None, help="Its clear diameter. [wide]"),
    click.option("--lens2", type=Length(WIDTH), default=None, help="Its clear diameter. [wide]"),
    click.option(
        "--aperture", default=None, help="In the Fourier plane: DIAMETER or HEIGHTxWIDTH."
    ),
    click.option(
        "--aperture-centre",
        default=None,
        help="Of that opening, from the axis: Y,X. [where the light is]",
    ),
    click.option(
        "--dc-block",
        type=Length(DOT),
        default=10e-6,
        help="Radius of the opaque dot. [10um]",
    ),
    click.option("--no-dc-block", is_flag=True, help="Let the zero order through."),
    click.option(
        "--filter-image",
        type=click.Path(path_type=Path),
        default=None,
        help="8-bit picture of the filter's transmission over the Nyquist square.",
    ),
    click.option("--tilt", default=None, help="Of the laser beam: Y,X in radians."),
    click.option(
        "--waist", type=Length(WIDTH), default=None, help="1/e² radius of a Gaussian beam."
    ),
    click.option(
        "--fill-factor",
        type=click.FloatRange(0, 1, min_open=True),
        default=None,
        help="Active share of a pixel's area. [1]",
    ),
    click.option(
        "--aberration",
        type=click.Path(path_type=Path),
        default=None,
        help="EXR of the panel's phase error in radians, a value per pixel.",
    ),
    click.option(
        "--edges", is_flag=True, help="Model the light that the panel's border diffracts."
    ),
)

BENCH_NAMES = (
    *("focal1", "focal2", "lens1", "lens2", "aperture", "aperture_centre", "dc_block"),
    *("no_dc_block", "filter_image", "tilt", "waist", "fill_factor", "aberration", "edges"),
)


def bench_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of `bench_from` to a command."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def numbers(text: str, sign: str, what: str) -> list[float]:
    """Numbers parted by a sign, or ValueError in the name of an option."""
    try:
        return [float(part) for part in text.lower().split(sign)]
    except ValueError:
        raise ValueError(f"{what}: {text!r} is not of the form that --help shows") from None


def _pair(text: str, what: str) -> tuple[float, float]:
    found = numbers(text, ",", what)
    if len(found) != 2:
        raise ValueError(f"{what}: {text!r} must be two numbers, Y,X")
    return found[0], found[1]


def bench_from(
    focal1: float,
    focal2: float,
    lens1: float | None,
    lens2: float | None,
    aperture: str | None,
    aperture_centre: str | None,
    dc_block: float,
    no_dc_block: bool,
    filter_image: Path | None,
    tilt: str | None,
    waist: float | None,
    fill_factor: float | None,
    aberration: Path | None,
    edges: bool,
) -> Any:
    """The bench that the options describe."""
    from chrmc.pictures import read_grey
    from reconstruct.bench import Bench, Filter, Illumination
    from reconstruct.images import read_image

    opening: float | tuple[float, float] | None = None
    if aperture is not None:
        sides = parse_lengths(aperture.lower().replace("×", "x"), "x", WIDTH, "--aperture")
        if len(sides) > 2:
            raise ValueError(f"--aperture: {aperture!r} has more than two sides")
        opening = sides[0] if len(sides) == 1 else (sides[0], sides[1])
    centre = None
    if aperture_centre is not None:
        if opening is None:
            raise ValueError("--aperture-centre needs an --aperture to place")
        places = parse_lengths(aperture_centre, ",", ON_BENCH, "--aperture-centre")
        if len(places) != 2:
            raise ValueError(f"--aperture-centre {aperture_centre}: must be two lengths, Y,X")
        centre = (places[0], places[1])
    light = None
    if tilt is not None or waist is not None:
        angles = (0.0, 0.0) if tilt is None else _pair(tilt, "--tilt")
        light = Illumination(tilt=angles, waist=waist)
    chosen = Filter(
        dc_block=None if no_dc_block else dc_block,
        aperture=opening,
        centre=centre,
        image=None if filter_image is None else read_grey(filter_image) / 255.0,
    )
    return Bench(
        focal1=focal1,
        focal2=focal2,
        filter=chosen,
        lens1=lens1,
        lens2=lens2,
        illumination=light,
        aberration=None if aberration is None else read_image(aberration)[0],
        fill_factor=fill_factor,
        edges=edges,
    )


def camera_from(text: str, full_scale: float | None) -> Any:
    """The camera that PITCH or PITCH:BITS says; full_scale : intensity that fills its range."""
    from reconstruct.camera import Camera

    pitch, _, bits = text.partition(":")
    if bits and not bits.isdecimal():
        raise ValueError(f"--camera {text}: {bits!r} is no number of bits")
    (pixel_pitch,) = parse_lengths(pitch, None, PITCH, "--camera")
    return Camera(pixel_pitch, bits=int(bits or 8), full_scale=full_scale)
