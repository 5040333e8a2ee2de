"""`chrmc bench tradeoff`: what each method costs, and how wrong it is."""

from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from chrmc.cli.arguments import figure_option, form_option, slm_option, wavelength_option
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
    help="Folder for tradeoff.csv and the figure.",
)
@figure_option("tradeoff.png")
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
@click.option(
    "--draw-only", is_flag=True, help="Draw the rows that the folder holds; measure nothing."
)
@form_option
@slm_option
@wavelength_option
def command(
    scene: str,
    out: Path,
    figure: Path,
    most: int,
    rounds: int,
    last: int,
    limit: float,
    images: bool,
    encoding: str,
    force: bool,
    draw_only: bool,
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
    the same command, and a finished one is only drawn anew. A table of another machine, scene or
    setting is refused; --draw-only draws it whatever it was made with.
    """
    from chrmc.bench.tradeoff_table import Table, read_table

    if draw_only:
        stored_with, entries = read_table(out / "tradeoff.csv")
        draw(entries, "; ".join(stored_with), out / figure)
        click.echo(f"{out / figure}")
        return

    from chrmc.bench import tradeoff
    from chrmc.cli.bench_tables import image_psnr
    from chrmc.encoding import coding_for
    from chrmc.files import sweep
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
    sweep(out)
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
    draw(table.entries, "; ".join(about), out / figure)
    click.echo(f"{table.path}, {out / figure}")


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
    from matplotlib.ticker import NullFormatter

    from chrmc.figures import log_ticks, new_figure, save, seconds, series

    shown = [e for e in entries if e.seconds and not e.refused and e.error > 0]
    groups = list(dict.fromkeys((e.scene, e.kind) for e in shown))
    names = {
        kind: list(dict.fromkeys(e.method for e in shown if e.kind == kind))
        for kind in dict.fromkeys(e.kind for e in shown)
    }
    columns = min(3, max(1, len(groups)))
    rows = -(-len(groups) // columns)
    with matplotlib.rc_context({"font.size": 9}):
        figure, panels = new_figure((4.4 * columns + 1.6, 3.3 * rows + 0.8), rows, columns,
                                    squeeze=False, sharey=True)  # fmt: skip
        drawn: dict[str, dict[str, Any]] = {kind: {} for kind in names}
        for panel, (scene, kind) in zip(panels.ravel(), groups, strict=False):
            mine = [e for e in shown if (e.scene, e.kind) == (scene, kind)]
            best = sorted((e for e in mine if e.front), key=lambda e: e.time)
            panel.set(xscale="log", yscale="log", title=title_of(scene, kind))
            drawn[kind]["nothing is both\nfaster and better"] = panel.plot(
                [e.time for e in best], [e.error for e in best], "-", lw=1, color="0.5", zorder=0
            )[0]
            for name in dict.fromkeys(e.method for e in mine):
                own = [e for e in mine if e.method == name]
                drawn[kind][name] = panel.plot(
                    [e.time for e in own], [e.error for e in own], ls="", ms=6, alpha=0.85,
                    **series(names[kind].index(name)),
                )[0]  # fmt: skip
            panel.grid(alpha=0.3)
        for panel in panels.ravel()[: len(groups)]:
            log_ticks(panel.xaxis, seconds)
            panel.yaxis.set_minor_formatter(NullFormatter())
            panel.tick_params(labelleft=True)  # shared, and still told at each
        for panel in panels.ravel()[len(groups) :]:
            panel.set_axis_off()
        # Beside the panels: inside it would hide points.
        for kind, place in zip(
            names, ("outside right upper", "outside right center"), strict=False
        ):
            title = "one frame" if kind == "cgh" else "video"
            lines = {name: drawn[kind][name] for name in [*names[kind], *drawn[kind]]}
            figure.legend(
                lines.values(), lines.keys(), loc=place, title=title, frameon=False,
                alignment="left",
            )  # fmt: skip
        figure.supxlabel(f"time per frame (median)\n{about}", fontsize=9)
        figure.supylabel("relative error of the field, worst run", fontsize=9)
        save(figure, path)


def title_of(scene: str, kind: str) -> str:
    """A panel's title, counts of points readable."""
    words = scene.split()
    if words[0].isdigit():
        scene = " ".join([f"{int(words[0]):,}", *words[1:]])
    return f"{scene}, {'video' if kind == 'video' else 'one frame'}"
