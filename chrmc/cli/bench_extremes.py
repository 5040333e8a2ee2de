"""`chrmc bench extremes`: promises tried at the ends of every range."""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from chrmc.cli.arguments import figure_option

if TYPE_CHECKING:
    from chrmc.bench.extremes_table import Summary


@click.command("extremes")
@click.option(
    "--minutes",
    type=click.FloatRange(0, min_open=True),
    default=10.0,
    show_default=True,
    help="How long to go on; the case in hand is finished, or ended at its limit.",
)
@click.option("--seed", type=click.IntRange(0), default=None, help="Of the first case. [fresh]")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("extremes"),
    show_default=True,
    help="Folder for extremes.csv and the figure; a later run goes on with its seeds.",
)
@figure_option("extremes.png")
@click.option("--force", is_flag=True, help="Begin anew in a folder that holds cases.")
@click.pass_context
def command(
    ctx: click.Context, minutes: float, seed: int | None, out: Path, figure: Path, force: bool
) -> None:
    """Try random scenes at the ends of every range against the float64 truth.

    Depth 1 mm to 100 m, wavelength 200 nm to 10.6 µm, pitch 0.5 to 100 µm, panels of 1 × 1, one
    row or one column to 8192 × 8192, 1 to ten million points: spread out, coincident, regular,
    cancelling, grazing, in clusters far apart, deep, of amplitudes 24 decades apart; videos by
    every method that turn, approach, flicker, go and come back, cancel. Each case is within what
    its method promises and within 40 processor seconds (12 more for each million points, 8 for each
    frame of a video), or refused in one line. Exit status 1 where one is not; `--seed` repeats it.
    """
    from chrmc.bench import extremes, extremes_table
    from chrmc.bench.extremes_worker import Worker
    from chrmc.cgh import DEFAULT_METHOD
    from chrmc.files import replacing, still_there, sweep
    from chrmc.progress import progress

    path = out / "extremes.csv"
    rows = [] if force else extremes_table.read(path)
    if seed is None:
        seed = 1 + max(int(r["seed"]) for r in rows) if rows else int(time.time())
    done = {int(row["seed"]) for row in rows}
    end = time.monotonic() + 60 * minutes

    def seeds() -> Any:
        number = seed
        while True:
            if number not in done:
                yield number
                if time.monotonic() > end:
                    return
            number += 1

    out.mkdir(parents=True, exist_ok=True)
    sweep(out)
    faults = 0
    with Worker() as worker:
        for number in progress(seeds(), "extremes", unit="case"):
            outcome = worker.run(extremes.case_of(number))
            rows.append(outcome.row())
            if outcome.fault:
                faults += 1
                click.echo(f"seed {number}, {outcome.case.kind}: {outcome.fault}")
            still_there(out)
            with replacing(path) as part:
                part.write_text(extremes_table.to_csv(rows), encoding="utf-8")
    for line in table(list(extremes_table.summaries(rows)), DEFAULT_METHOD):
        click.echo(line)
    draw(rows, out / figure)
    click.echo(f"{path}, {out / figure}")
    if faults:
        ctx.exit(1)


def table(found: "Sequence[Summary]", default: str) -> list[str]:
    """One line for each kind of frame with the default method, each other method, and each way to
    make a video."""
    lines = [
        f"{'':12} {'cases':>6} {'refused':>8} {'faults':>7} {'error/promised':>15} "
        f"{'error/expected':>15} {'processor':>9}"
    ]
    for one in found:
        lines.append(
            f"{one.name:12} {one.cases:6d} {one.refused:8d} {one.faults:7d} {one.ratio:15.2g} "
            f"{one.blind:15.2g} {one.cpu:8.1f}s"
        )
        lines += [f"{'':12} refused, {n} ×: {words}" for words, n in one.words.items()]
    lines.append(f"kinds of scenes are computed by {default}; other methods have a line each")
    return lines


def draw(rows: "Sequence[dict[str, Any]]", path: Path) -> None:
    """Error over what was promised, over depth and tolerance: the worst of each cell."""
    import matplotlib
    import numpy as np
    from matplotlib.figure import Figure

    from chrmc.bench.extremes_table import promises
    from chrmc.figures import save

    shown = [r for r in rows if promises(r) and np.isfinite(float(r["error"]))]
    axes = (
        ("depth", "depth, m", -3, 2), ("wavelength", "wavelength, m", -6.7, -4.97),
        ("pitch", "pixel pitch, m", -6.3, -4), ("points", "points", 0, 7),
    )  # fmt: skip
    with matplotlib.rc_context({"font.size": 8}):
        figure = Figure(figsize=(9, 6.4), layout="constrained")
        for panel, (name, label, low, high) in zip(
            figure.subplots(2, 2).ravel(), axes, strict=True
        ):
            across, down = np.linspace(low, high, 13), np.linspace(-6, -1, 11)
            worst = np.full((10, 12), np.nan)
            for row in shown:
                i = int(np.searchsorted(down, np.log10(float(row["tolerance"])))) - 1
                j = int(np.searchsorted(across, np.log10(float(row[name])))) - 1
                i, j = min(max(i, 0), 9), min(max(j, 0), 11)
                worst[i, j] = np.fmax(worst[i, j], float(row["error"]) / promises(row))
            image = panel.pcolormesh(across, down, worst, vmin=0, vmax=1.2, cmap="viridis")
            panel.set(xlabel=f"log10 {label}", ylabel="log10 tolerance")
            panel.set_facecolor("0.9")
        figure.colorbar(image, ax=figure.axes, label="worst error over what is promised")
        figure.suptitle(f"{len(rows)} cases, {sum(bool(r['refused']) for r in rows)} refused")
        save(figure, path)
