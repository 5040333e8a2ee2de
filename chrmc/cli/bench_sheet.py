"""`chrmc bench-sheet`: what to build on the optical table."""

from pathlib import Path

import click

from chrmc.cli.arguments import FigurePath, form_option, slm_option, wavelength_option
from chrmc.cli.lengths import FOCAL, Length
from chrmc.encoding import CODINGS
from chrmc.slm import SLM


@click.command("bench-sheet")
@click.argument("scene", default="car-house")
@click.option("--frame", type=int, default=None, help="Whose objects to photograph. [middle one]")
@click.option("--focal1", type=Length(FOCAL), default="150mm", show_default=True, help="Lens 1.")
@click.option("--focal2", type=Length(FOCAL), default="150mm", show_default=True, help="Lens 2.")
@click.option(
    "--out",
    type=FigurePath(),
    default=None,
    help="Draw it: a .png, .pdf or .svg.",
)
@click.option(
    "--encoding", type=click.Choice(CODINGS), default=None, help="[the panel's usual one]"
)
@form_option
@slm_option
@wavelength_option
def command(
    scene: str,
    frame: int | None,
    focal1: float,
    focal2: float,
    out: Path | None,
    encoding: str | None,
    form: str,
    slm: SLM,
    wavelength: float | None,
) -> None:
    """Print and draw the 4-f bench: lenses, orders, which half to block, camera distances.

    The objects are those of a frame of SCENE.
    """
    from chrmc.generation.recipe import scene_wavelength
    from chrmc.scene.load import load_scene
    from display.bench_sheet import Sheet, Target

    given = load_scene(scene, form=form)
    number = frame if frame is not None else (given.frame_count + 1) // 2
    targets = [
        Target(o.name, o.depth, float(o.position[0]), float(o.position[1]))
        for o in given.frame(number).objects
        if len(o.cloud)
    ]
    sheet = Sheet(slm, scene_wavelength(given, wavelength), focal1, focal2, encoding)
    for line in sheet.lines(targets):
        click.echo(line)
    if out is not None:
        from display.bench_drawing import draw

        draw(sheet, targets, out)
        click.echo(f"drawn in {out}")
