"""`chrmc sweep`: one table of every combination that a recipe names."""

from collections.abc import Sequence
from contextlib import ExitStack
from math import hypot
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from chrmc.scene.scene import Scene
    from chrmc.store.video import Video


@click.command("sweep")
@click.argument("recipe", metavar="RECIPE.toml", type=click.Path(path_type=Path))
@click.option(
    "--folder",
    type=click.Path(path_type=Path, file_okay=False),
    default=None,
    help="For the table and what is still being made. [the recipe's name without .toml]",
)
@click.option("--plot", "columns", default=None, metavar="X,Y", help="Draw a column over another.")
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=None,
    help="The plot: .pdf, .png or .svg. [X-Y.png in the folder]",
)
@click.option("--workers", type=int, default=None, help="Processes that share the work.")
@click.option(
    "--scheduler", default=None, help="A running Dask cluster that does it, tcp://HOST:PORT."
)
@click.option("--keep-videos", is_flag=True, help="Leave the rows' videos in the folder.")
@click.option("--force", is_flag=True, help="Measure anew what the folder holds.")
def command(
    recipe: Path,
    folder: Path | None,
    columns: str | None,
    out: Path | None,
    workers: int | None,
    scheduler: str | None,
    keep_videos: bool,
    force: bool,
) -> int:
    """Make, measure and judge a video of every combination that RECIPE.toml names: scenes ×
    methods × tolerances × encodings × SLMs.

    Writes sweep.csv and sweep.txt with times, errors, focus and PSNR, whole after every row. A
    sweep that was stopped is continued by the same command; a recipe that has grown makes only
    what is new.
    """
    from chrmc.bench.speed import machine
    from chrmc.cli.sweep_plot import draw, plotted_columns
    from chrmc.cli.sweep_recipe import read_recipe
    from chrmc.figures import check_figure
    from chrmc.sweep.run import TABLE, TEXT_TABLE, run_sweep
    from chrmc.sweep.table import to_text

    if out is not None and columns is None:
        raise ValueError("--out names the figure of --plot X,Y; the table goes to --folder")
    pair = None if columns is None else plotted_columns(columns)
    folder = folder or Path(recipe.stem)
    figure = out or (None if pair is None else folder / f"{pair[0]}-{pair[1]}.png")
    if figure is not None:
        check_figure(figure)
    cases = read_recipe(recipe)
    with ExitStack() as stack:
        if workers is not None:
            from chrmc.generation.connection import local_cluster

            if scheduler is not None:
                raise ValueError(
                    "--workers starts a cluster, --scheduler uses a running one: give one"
                )
            scheduler = stack.enter_context(local_cluster(workers))
        rows = run_sweep(
            cases, folder, judged, machine(), anew=force, keep_videos=keep_videos,
            scheduler=scheduler,
        )  # fmt: skip
    click.echo(to_text(rows), nl=False)
    click.echo(f"{len(rows)} rows: {folder / TABLE}, {folder / TEXT_TABLE}")
    if pair is not None and figure is not None:
        count = draw(rows, pair[0], pair[1], figure)
        click.echo(f"{figure}: {pair[1]} over {pair[0]}, {count} of {len(rows)} rows have both")
    return 0


def judged(video: "Video", numbers: Sequence[int], scene: "Scene") -> dict[str, Any]:
    """The worst of all objects of the judged frames, as `chrmc check --truth` finds them."""
    from reconstruct.checking import check

    objects = [o for v in check(video, numbers, scene=scene) for o in v.objects]
    if not objects:
        return {}
    shapes = [o.shape.picture for o in objects if o.shape is not None and o.shape.told]
    return {
        "in_focus": sum(o.passed for o in objects) / len(objects),
        "depth_error": _worst(abs(o.depth_error) for o in objects),
        "lateral_error": _worst(hypot(*o.lateral_error) for o in objects),
        "alike": min(shapes, default=None),
        "psnr": _least(o.psnr for o in objects),
        "ssim": _least(o.ssim for o in objects),
    }


def _worst(values: Any) -> float | None:
    """The largest; None where one was not found at all."""
    found = [float(v) for v in values]
    return max(found) if all(v < float("inf") for v in found) else None


def _least(values: Any) -> float | None:
    found = [float(v) for v in values if v is not None]
    return min((v for v in found if v < float("inf")), default=None)
