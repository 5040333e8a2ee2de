"""`chrmc inspect`: what the SLM will show of a scene."""

from pathlib import Path

import click

from chrmc.cli.arguments import FigurePath, form_option, slm_option, wavelength_option
from chrmc.cli.scene_options import scene_from, scene_options, things_argument
from chrmc.slm import SLM


@click.command("inspect")
@things_argument
@slm_option
@wavelength_option
@form_option
@scene_options
@click.option(
    "--out",
    type=FigurePath(),
    default=None,
    help="Picture (.png .pdf .svg): front and top view in the visible volume.",
)
def command(
    sources: tuple[str, ...],
    slm: SLM,
    wavelength: float | None,
    form: str,
    density: float | None,
    points: int | None,
    fit: bool,
    out: Path | None,
) -> None:
    """Say what the SLM will show of SCENE: size, resolution, focus, points, speckle, motion, cost.

    SCENE is what `chrmc generate` takes. Times are counts of operations over this machine's rates
    (chrmc calibrate), errors as expected from some of the points, under single sideband.
    """
    from chrmc.compensation import scene_wavelength
    from chrmc.inspection.picture import write_inspection
    from chrmc.inspection.report import sentences

    options = {"density": density, "points": points, "fit": fit}
    scene = scene_from(sources, form, slm, wavelength, options)
    light = scene_wavelength(scene, wavelength)
    if out is not None:
        write_inspection(scene, slm, light, out)
    for line in sentences(scene, slm, light):
        click.echo(line)
    if out is not None:
        click.echo(f"{out}: front and top view")
