"""`chrmc bench tradeoff`: what each method costs, and how wrong it is."""

from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from chrmc.cli.arguments import form_option, slm_option, wavelength_option
from chrmc.slm import SLM

if TYPE_CHECKING:
    from chrmc.bench.tradeoff import Optics
    from chrmc.bench.tradeoff_table import Entry
    from chrmc.scene.scene import Scene

MANY = 100_000  # points up to which every size is measured on several clouds


@click.command("tradeoff")
@click.argument("scene", default="car-house")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("tradeoff"),
    show_default=True,
    help="Folder for tradeoff.csv and tradeoff.png.",
)
@click.option(
    "--points",
    "most",
    type=click.IntRange(0),
    default=1_000_000,
    show_default=True,
    help="Largest synthetic cloud; a later run may ask for more or fewer.",
)
@click.option(
    "--rounds",
    type=click.IntRange(1),
    default=3,
    show_default=True,
    help="Fresh clouds per size; one past 100,000 points, and for a method that takes more than "
    "a quarter of the limit.",
)
@click.option(
    "--frames",
    "last",
    type=click.IntRange(1),
    default=4,
    show_default=True,
    help="Frames of the videos.",
)
@click.option(
    "--limit",
    type=click.FloatRange(0, min_open=True),
    default=10.0,
    show_default=True,
    help="Seconds a frame may take by any method but curved. What would take longer, as reckoned "
    "from fewer points, is left out and says so.",
)
@click.option(
    "--images/--no-images",
    default=True,
    show_default=True,
    help="PSNR of the worst object's reconstruction at its depth, too.",
)
@click.option("--encoding", default="ssb", show_default=True, help="ssb or real: the passband.")
@click.option("--force", is_flag=True, help="Measure anew what the folder holds.")
@form_option
@slm_option
@wavelength_option
def command(
    scene: str,
    out: Path,
    most: int,
    rounds: int,
    last: int,
    limit: float,
    images: bool,
    encoding: str,
    force: bool,
    form: str,
    slm: SLM,
    wavelength: float | None,
) -> None:
    """Time per frame against error of every method and setting, on SCENE and on synthetic points.

    SCENE is a built-in scene or a folder. The synthetic clouds hold 1, 10, 100, … points in a
    car-sized object. Methods take turns; times are medians, errors the largest of all runs, on
    512 pixels, fewer past 15,000 points (32 at a million). A star marks what nothing else beats
    in both time and error.

    Every scene's rows are printed and kept as soon as it is done: a stopped run is continued by
    the same command. A table of another machine, scene or setting is refused.
    """
    from chrmc.bench import tradeoff
    from chrmc.bench.tradeoff_table import Table
    from chrmc.cli.bench_tables import image_psnr
    from chrmc.encoding import coding_for
    from chrmc.generation.recipe import scene_wavelength
    from chrmc.progress import progress
    from chrmc.scene.load import load_scene
    from chrmc.scene.scene import frame_range

    given = load_scene(scene, form=form)
    wave = scene_wavelength(given, wavelength)
    optics = tradeoff.Optics(slm, wave, coding_for(encoding, slm))
    numbers = frame_range(given, (1, min(last, given.frame_count)))
    about = made_with(given, optics, rounds, len(numbers), limit, images)
    table = Table(out / "tradeoff.csv", about, force)
    out.mkdir(parents=True, exist_ok=True)  # told now, not after the first scene, if it cannot be
    click.echo("; ".join(about))
    if table.kept:
        click.echo(f"{table.path}: {len(table.kept)} rows kept; --force measures them anew")

    def watch(items: Sequence[Any], label: str) -> Iterable[Any]:
        return progress(items, label, unit="run")

    options: dict[str, Any] = {
        "limit": limit, "images": image_psnr(slm, wave) if images else None, "watch": watch,
    }  # fmt: skip

    def one_frame() -> "list[Entry]":
        cloud = given.frame((given.frame_count + 1) // 2).cloud
        clouds = tradeoff.fresh_clouds(cloud, rounds)
        return tradeoff.cgh_entries(given.name, clouds, optics, **options)

    def videos() -> "list[Entry]":
        return tradeoff.video_entries(given, optics, numbers, **options)

    def points(count: int, smaller: "Sequence[Entry]") -> "list[Entry]":
        clouds = tradeoff.synthetic(count, slm, rounds if count <= MANY else 1)
        return tradeoff.cgh_entries(
            tradeoff.cloud_name(count), clouds, optics, smaller=smaller, **options
        )

    show(table.take(given.name, "cgh", tradeoff.cgh_labels(), one_frame))
    show(table.take(given.name, "video", tradeoff.video_labels(), videos))
    smaller: list[Entry] = []
    for power in range(len(str(most)) if most else 0):
        name = tradeoff.cloud_name(10**power)
        mine = table.take(
            name, "cgh", tradeoff.cgh_labels(), partial(points, 10**power, list(smaller))
        )
        show(mine)
        smaller += mine
    draw(table.entries, "; ".join(about), out / "tradeoff.png")
    click.echo(f"{table.path}, {out / 'tradeoff.png'}")


def made_with(
    scene: "Scene", optics: "Optics", rounds: int, frames: int, limit: float, images: bool
) -> list[str]:
    """What two runs must agree in for one to go on where the other stopped."""
    from chrmc import __version__
    from chrmc.bench.speed import machine
    from chrmc.survey import fingerprint

    slm = optics.slm
    return [
        f"{slm.name}, {slm.width} × {slm.height} pixels of {1e6 * slm.pixel_pitch:g} µm, "
        f"{optics.coding.name}",
        machine(),
        f"chrmc {__version__}",
        f"{scene.name} in {scene.form} ({fingerprint(scene)[:12]})",
        f"{1e9 * optics.wavelength:g} nm",
        f"rounds {rounds}",
        f"frames {frames}",
        f"limit {limit:g} s",
        "images" if images else "no images",
    ]


def show(entries: "Sequence[Entry]") -> None:
    """Print the rows of a scene."""
    for entry in entries:
        start = f"{entry.scene:>14}  {entry.kind:5} {entry.label:44}"
        click.echo(f"{start} {entry.refused}" if entry.refused else f"{start} {figures(entry)}")


def figures(entry: "Entry") -> str:
    """Time, error and PSNR in words."""
    text = f"{1e3 * entry.time:9.1f} ms  error {entry.error:.1e}"
    if entry.predicted is not None:
        text += f" (expected {entry.predicted:.1e})"
    if entry.psnr is not None:
        text += f"  {entry.psnr:.1f} dB"
    if entry.note:
        text += f"  {entry.note}"
    return text + ("  *" if entry.front else "")


def draw(entries: "Sequence[Entry]", about: str, path: Path) -> None:
    """Error over time, one panel for each scene and kind, the Pareto front joined."""
    import matplotlib
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter

    from chrmc.files import replacing

    shown = [e for e in entries if e.seconds and not e.refused and e.error > 0]
    groups = list(dict.fromkeys((e.scene, e.kind) for e in shown))
    names = list(dict.fromkeys(e.method for e in shown))
    marks = "os^vDP"
    colours = {name: f"C{number % 10}" for number, name in enumerate(names)}
    shapes = {name: marks[number // 10 % len(marks)] for number, name in enumerate(names)}
    columns = min(3, max(1, len(groups)))
    rows = -(-len(groups) // columns)
    with matplotlib.rc_context({"font.size": 8}):
        figure = Figure(figsize=(4.2 * columns, 3.2 * rows + 0.6), layout="constrained")
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for panel, (scene, kind) in zip(panels, groups, strict=False):
            mine = [e for e in shown if (e.scene, e.kind) == (scene, kind)]
            for name in dict.fromkeys(e.method for e in mine):
                own = [e for e in mine if e.method == name]
                panel.plot([e.time for e in own], [e.error for e in own], shapes[name], ms=5,
                           color=colours[name], label=name)  # fmt: skip
            best = sorted((e for e in mine if e.front), key=lambda e: e.time)
            panel.plot([e.time for e in best], [e.error for e in best], "-", lw=1, color="0.5",
                       zorder=0, label="nothing better")  # fmt: skip
            panel.set(
                xscale="log",
                yscale="log",
                title=f"{scene}, {'video' if kind == 'video' else 'one frame'}",
            )
            panel.grid(alpha=0.3)
            panel.xaxis.set_minor_formatter(NullFormatter())
            panel.legend(fontsize=6)
        for panel in panels[len(groups) :]:
            panel.set_axis_off()
        figure.supxlabel("seconds per frame (median)")
        figure.supylabel("relative field error")
        figure.suptitle(about, fontsize=7)
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as partial:
            figure.savefig(partial, dpi=130, format="png")
