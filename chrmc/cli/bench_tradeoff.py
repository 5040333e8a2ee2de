"""`chrmc bench tradeoff`: what each method costs, and how wrong it is."""

from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from chrmc.cli.arguments import form_option, slm_option, wavelength_option
from chrmc.slm import SLM

if TYPE_CHECKING:
    from chrmc.bench.tradeoff import Entry


@click.command("tradeoff")
@click.argument("scene", default="car-house")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("tradeoff"),
    show_default=True,
    help="Folder for tradeoff.csv and tradeoff.png.",
)
@click.option("--points", "most", default=1_000_000, show_default=True, help="Largest cloud.")
@click.option("--rounds", default=3, show_default=True, help="Fresh clouds per size.")
@click.option("--frames", "last", default=4, show_default=True, help="Frames of the videos.")
@click.option("--limit", default=20.0, show_default=True, help="Seconds a frame may take.")
@click.option("--images/--no-images", default=True, show_default=True, help="Compare images too.")
@click.option("--encoding", default="ssb", show_default=True, help="ssb or real: the passband.")
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
    form: str,
    slm: SLM,
    wavelength: float | None,
) -> None:
    """Time per frame against error of every method and setting, on SCENE and on synthetic points.

    SCENE is a built-in scene or a folder. The synthetic clouds hold 1 to 1,000,000 points in a
    car-sized object. Methods take turns; times are medians.
    """
    from chrmc.bench import tradeoff
    from chrmc.bench.speed import machine
    from chrmc.cli.bench_tables import image_psnr
    from chrmc.cli.generation import scene_wavelength
    from chrmc.coding import coding_for
    from chrmc.files import replacing
    from chrmc.progress import progress
    from chrmc.scene.load import load_scene
    from chrmc.scene.scene import frame_range

    given = load_scene(scene, form=form)
    wave = scene_wavelength(given, wavelength)
    coding = coding_for(encoding, slm)
    compare = image_psnr(slm, wave) if images else None

    def watch(items: Sequence[Any], label: str) -> Iterable[Any]:
        return progress(items, label)

    run = partial(tradeoff.cgh_entries, slm=slm, wavelength=wave, coding=coding, limit=limit,
                  images=compare, watch=watch)  # fmt: skip
    about = f"{slm.name}, {slm.width} × {slm.height}, {encoding}; {machine()}"
    click.echo(about)
    cloud = given.frame((given.frame_count + 1) // 2).cloud
    entries = run(given.name, tradeoff.fresh_clouds(cloud, max(1, rounds)))
    numbers = frame_range(given, (1, max(1, min(last, given.frame_count))))
    entries += tradeoff.video_entries(
        given, slm, wave, coding, numbers, images=compare, limit=limit, watch=watch
    )
    count = 1
    while count <= most:
        turns = max(1, rounds if count <= 10_000 else 1)
        entries += run(f"{count} point{'s' * (count > 1)}", tradeoff.synthetic(count, slm, turns))
        count *= 10
    tradeoff.mark_front(entries)
    for entry in entries:
        click.echo(_line(entry))
    out.mkdir(parents=True, exist_ok=True)
    with replacing(out / "tradeoff.csv") as part:
        part.write_text(f"# {about}\n{tradeoff.to_csv(entries)}", encoding="utf-8")
    draw(entries, about, out / "tradeoff.png")
    click.echo(f"{out / 'tradeoff.csv'}, {out / 'tradeoff.png'}")


def _line(entry: "Entry") -> str:
    start = f"{entry.scene:>14}  {entry.kind:5} {entry.label:44}"
    if entry.refused:
        return f"{start} {entry.refused}"
    text = f"{start} {1e3 * entry.time:9.1f} ms  error {entry.error:.1e}"
    if entry.predicted is not None:
        text += f" (expected {entry.predicted:.1e})"
    if entry.psnr is not None:
        text += f"  {entry.psnr:.1f} dB"
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
