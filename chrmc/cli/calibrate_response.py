"""`chrmc calibrate-response`: measure what a panel's grey levels do to light."""

import re
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from chrmc.cli.arguments import slm_option
from chrmc.cli.lengths import WAVELENGTH, Length
from chrmc.cli.surface import place_options, screen_on
from chrmc.slm import SLM


@click.command("calibrate-response")
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    required=True,
    help="CSV table to write, for --response.",
)
@click.option("--measure", default=None, help="FILE.py:NAME, a function grey → intensity.")
@click.option(
    "--camera",
    default=None,
    help="Number of a camera, or a name that OpenCV opens, as /dev/video2 or a stream "
    "(chrmc[camera]).",
)
@click.option(
    "--csv",
    "table",
    type=click.Path(path_type=Path),
    default=None,
    help="Readings taken elsewhere: columns grey,intensity; nothing is shown.",
)
@place_options
@slm_option
@click.option("--steps", type=int, default=33, show_default=True, help="Grey levels shown.")
@click.option("--repeats", type=int, default=4, show_default=True, help="Times that each is shown.")
@click.option(
    "--settle", type=float, default=0.1, show_default=True, help="Seconds before measuring."
)
@click.option(
    "--map",
    "degree",
    type=click.IntRange(0, 2),
    default=0,
    show_default=True,
    help="Degree in x and y of a map over the panel; needs pictures.",
)
@click.option(
    "--wavelength",
    type=Length(WAVELENGTH),
    default=None,
    help="Of the laser, as 638nm: kept in the table, which then is refused for others.",
)
@click.option("--region", default=None, help="X,Y,WIDTH,HEIGHT of the panel in the camera's view.")
@click.option(
    "--plot", type=click.Path(path_type=Path), default=None, help="A .png, .pdf or .svg to draw."
)
def command(
    out: Path,
    measure: str | None,
    camera: str | None,
    table: Path | None,
    slm: SLM,
    region: str | None,
    plot: Path | None,
    wavelength: float | None,
    steps: int,
    repeats: int,
    settle: float,
    degree: int,
    **place: Any,
) -> None:
    """Measure a panel's grey response: show levels, take their light, fit a monotone curve.

    \b
    chrmc calibrate-response --monitor HOLOEYE --measure meter.py:power --out response.csv
    chrmc calibrate-response --csv readings.csv --out response.csv --plot response.png
    chrmc generate SCENE --response response.csv --out DIR
    chrmc calibrate-response --camera 0 --wavelength 638nm --out red.csv
    chrmc generate SCENE --wavelength 638nm,532nm,450nm --response red.csv,green.csv,blue.csv …

    The light is a function of yours (called with the grey level once it is on; it returns an
    intensity in any unit, or a picture of the panel), a camera, or a table of readings. The panel
    must modulate amplitude as in use: polarisers in place, the beam on the whole panel.
    """
    from chrmc.figures import check_figure
    from chrmc.files import check_writable

    if sum(given is not None for given in (measure, camera, table)) != 1:
        raise click.UsageError("say where the light comes from: --measure, --camera or --csv")
    if out.suffix.lower() != ".csv":
        raise ValueError(f"{out}: a response is written as .csv")
    if plot is not None:
        check_figure(plot)
    check_writable(out)
    if table is not None:
        from chrmc.response_fit import fit_response
        from chrmc.response_table import read_readings

        grey, readings = read_readings(table)
        fit = fit_response(grey.tolist(), readings.tolist())
    else:
        how = {"steps": steps, "repeats": repeats, "settle": settle, "degree": degree}
        fit = _measured(measure, camera, region, place, slm, how)
    fit = replace(fit, wavelength=wavelength)
    fit.response  # noqa: B018 - refuses what is no response before anything is written
    fit.write(out)
    share = fit.uncertainty / fit.intensity.max()
    contrast = fit.intensity.max() / max(fit.intensity.min(), 1e-12 * fit.intensity.max())
    click.echo(
        f"{out}: {len(fit.grey)} readings, uncertainty {share.mean():.2%} of the brightest "
        f"(worst {share.max():.2%}), contrast {contrast:.3g}:1"
    )
    if fit.tilt is not None:
        varies = abs(fit.tilt[fit.intensity.argmax()]).max() / fit.intensity.max()
        click.echo(f"  over the panel its largest term is {varies:.1%} of the brightest")
    if plot is not None:
        draw(fit, plot)
        click.echo(f"{plot}: readings and curve")


def _measured(
    measure: str | None,
    camera: str | None,
    region: str | None,
    place: dict[str, Any],
    slm: SLM,
    how: dict[str, Any],
) -> Any:
    from chrmc.python_file import from_python_file, one_line
    from display import calibrate

    part: Any = None
    if region is not None:
        if not re.fullmatch(r"\d{1,6}(,\d{1,6}){3}", region):
            raise ValueError(f"--region {region}: write X,Y,WIDTH,HEIGHT in the camera's pixels")
        part = tuple(int(n) for n in region.split(","))

    with ExitStack() as stack:
        if measure is not None:
            function = from_python_file(measure)
            stack.enter_context(one_line(measure))
        else:
            assert camera is not None
            source = int(camera) if camera.isdecimal() else camera
            function = stack.enter_context(calibrate.camera(source, part))
        screen = stack.enter_context(screen_on(place, slm, "chrmc calibrate-response"))
        return calibrate.calibrate_response(screen, function, **how)


def draw(fit: Any, path: Path) -> None:
    """Readings, curve and its uncertainty; below, what is left between them."""
    import numpy as np

    from chrmc.figures import new_figure, save

    top = float(fit.intensity.max())
    figure, axes = new_figure((6.4, 5.6), 2, 1, height_ratios=[3, 1], squeeze=False)
    curve, rest = axes[0][0], axes[1][0]
    every = np.arange(256)
    low, high = (fit.intensity + s * 2 * fit.uncertainty for s in (-1, 1))
    curve.plot(fit.grey, fit.readings / top, ".", ms=4, color="0.35", label="readings")
    curve.plot(every, fit.intensity / top, color="#b2182b", lw=1.4, label="curve")
    curve.fill_between(
        every, low / top, high / top, color="#b2182b", alpha=0.25, lw=0, label="± 2 deviations"
    )
    curve.set(ylabel="intensity, brightest = 1", xlim=(0, 255))
    curve.legend(frameon=False, fontsize=8)
    left = fit.readings - np.interp(fit.grey, every, fit.intensity)
    rest.plot(fit.grey, 100 * left / top, ".", ms=4, color="0.35")
    rest.fill_between(
        every, 100 * (low - fit.intensity) / top, 100 * (high - fit.intensity) / top,
        color="#b2182b", alpha=0.25, lw=0,
    )  # fmt: skip
    rest.axhline(0, color="#b2182b", lw=1)
    rest.set(xlabel="grey level", ylabel="rest (%)", xlim=(0, 255))
    save(figure, path)
