"""Arguments of every command that takes a scene, and the scene that they mean."""

from typing import Any

import click

from chrmc.cli.arguments import stacked
from chrmc.cli.names import Name, scene_names
from chrmc.scene.scene import Scene
from chrmc.slm import SLM

things_argument = click.argument(
    "sources", metavar="SCENE...", type=Name(scene_names), nargs=-1, required=True
)

scene_options = stacked(
    click.option(
        "--density",
        type=float,
        default=None,
        help="Of surfaces: resolution cells of the SLM per point. [0.5]",
    ),
    click.option(
        "--points", type=int, default=None, help="Of surfaces: points on all, instead of --density."
    ),
    click.option(
        "--fit", is_flag=True, help="Scale and shift so that no frame leaves what the SLM shows."
    ),
)
SCENE_NAMES = ("density", "points", "fit")


def scene_from(
    sources: tuple[str, ...],
    form: str,
    slm: SLM,
    wavelength: float | None,
    options: dict[str, Any],
    quiet: bool = False,
) -> Scene:
    """The scene of a command line; says what was done to files to get there, unless quiet."""
    from chrmc.scene.load import load_scene

    chosen = {name: options[name] for name in SCENE_NAMES}
    scene = load_scene(
        sources[0] if len(sources) == 1 else sources, form, slm=slm, wavelength=wavelength, **chosen
    )
    if not quiet:
        tell_notes(scene)
    return scene


def tell_notes(scene: Scene, err: bool = False) -> None:
    """Say what was done to files to get a scene, on stderr if asked."""
    for note in getattr(scene, "notes", ()):
        click.echo(note, err=err)
