"""`chrmc plan`: which method to take for a scene, and what it will cost."""

import json
from typing import Any

import click

from chrmc.cli.arguments import Quantity, form_option, frames_option, slm_option, wavelength_option
from chrmc.cli.budget import Budget
from chrmc.cli.scene_options import scene_from, scene_options, tell_notes, things_argument
from chrmc.encoding import CODINGS
from chrmc.panels import encoding_for
from chrmc.ranges import TOLERANCE_RANGE
from chrmc.slm import SLM


@click.command("plan")
@things_argument
@click.option(
    "--tolerance",
    type=Quantity(TOLERANCE_RANGE),
    default=None,
    help="Largest relative field error. [1e-3]",
)
@click.option("--budget", type=Budget(), default=None, help="Time per frame, or frames per second.")
@slm_option
@wavelength_option
@click.option(
    "--encoding", type=click.Choice(CODINGS), default=None, help="[the panel's usual one]"
)
@frames_option
@form_option
@scene_options
@click.option("--json", "as_json", is_flag=True, help="All of it, for programs.")
def command(
    sources: tuple[str, ...],
    tolerance: float | None,
    budget: float | None,
    slm: SLM,
    wavelength: float | None,
    encoding: str | None,
    frames: tuple[int, int] | None,
    form: str,
    as_json: bool,
    **options: Any,
) -> int:
    """Say which method to take for SCENE: expected time, error and memory of every sensible way.

    With --tolerance the cheapest that keeps it, with --budget the most accurate in that time, with
    both whether there is one, and the nearest if not (exit status 1). SCENE is what
    `chrmc generate` takes. Times are counts of operations over this machine's rates
    (chrmc calibrate).
    """
    from chrmc.planning.choice import Choice, spell
    from chrmc.planning.choices import plan

    scene = scene_from(sources, form, slm, wavelength, options, quiet=as_json)
    found = plan(
        scene, slm, tolerance=tolerance, budget=budget, wavelength=wavelength,
        encoding=encoding_for(slm, encoding), frames=frames,
    )  # fmt: skip
    if as_json:
        click.echo(json.dumps(found.as_dict(), indent=1))
        tell_notes(scene, err=True)
        return 0 if found.met else 1

    def line(choice: Choice) -> str:
        error = "unknown" if choice.error is None else f"{choice.error:.1e}"
        mark = "→" if choice is found.taken else " "
        return (
            f"{mark} {choice!s:38} {spell(choice.key):>9} {spell(choice.mean):>9} {error:>8} "
            f"{choice.memory / 2**20:6.0f} MiB {choice.group:5}"
        )

    click.echo(
        f"  {'method':38} {'key frame':>9} {'mean':>9} {'error':>8} {'memory':>10} {'group':>5}"
    )
    for choice in sorted(found.choices, key=lambda choice: choice.mean):
        click.echo(line(choice))
    for name, how in found.taken.objects.items():
        click.echo(f"{name}: {how}")
    click.echo(f"{found.why}.")
    return 0 if found.met else 1
