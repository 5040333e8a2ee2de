"""`chrmc bench rmc`: where along a video the published method is good enough."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from chrmc.cgh import DEFAULT_METHOD
from chrmc.cli.arguments import (
    FigurePath,
    form_option,
    frames_option,
    slm_option,
    wavelength_option,
)
from chrmc.slm import SLM

if TYPE_CHECKING:
    from chrmc.bench.rmc import Run

SCENES = ("car-house", "car-house-deep")


@click.command("rmc")
@click.argument("scenes", nargs=-1)
@click.option(
    "--out",
    type=FigurePath(),
    default="rmc.png",
    show_default=True,
    help="Figure to write: a .png, .pdf or .svg.",
)
@frames_option
@form_option
@click.option("--cgh", default=DEFAULT_METHOD, show_default=True, help="CGH method.")
@click.option("--encoding", default="ssb", show_default=True, help="ssb or real: the passband.")
@click.option("--radius", type=float, default=None, help="Of the curved hologram, m. [0.145]")
@click.option(
    "--matching", default="strict", show_default=True, help="strict or tolerant error correction."
)
@click.option("--rekey-error", type=float, default=None, help="Field error that makes a key. [0.1]")
@click.option("--rekey-image", type=float, default=None, help="PSNR in dB that makes a key.")
@click.option("--rekey-every", type=int, default=None, help="A key every so many frames.")
@slm_option
@wavelength_option
def command(
    scenes: tuple[str, ...],
    out: Path,
    frames: tuple[int, int] | None,
    form: str,
    cgh: str,
    encoding: str,
    radius: float | None,
    matching: str,
    rekey_error: float | None,
    rekey_image: float | None,
    rekey_every: int | None,
    slm: SLM,
    wavelength: float | None,
) -> None:
    """Field error and PSNR of the published CH-RMC along SCENES, with and without re-keying.

    Default scenes: car-house and car-house-deep; takes some minutes. Fields are compared with
    recomputed ones before any grey levels.
    """
    from chrmc.bench.rmc import runs
    from chrmc.progress import progress
    from chrmc.scene.load import load_scene
    from chrmc.slm import WAVELENGTH

    limits = {"rekey_error": rekey_error, "rekey_image": rekey_image, "rekey_every": rekey_every}
    rekey = {name: value for name, value in limits.items() if value is not None} or None
    options: dict[str, Any] = {"matching": matching}
    if radius is not None:
        options["radius"] = radius
    loaded = [load_scene(name, form=form) for name in scenes or SCENES]
    found = []

    def watch(items: Iterable[Any], label: str) -> Iterator[Any]:
        return progress(items, label)

    for run in runs(
        loaded,
        slm,
        wavelength or loaded[0].wavelength or WAVELENGTH,
        cgh=cgh,
        encoding=encoding,
        frames=frames,
        rekey=rekey,
        watch=watch,
        **options,
    ):
        found.append(run)
        for line in _lines(run, form, matching):
            click.echo(line)
    draw(found, out)
    click.echo(f"{out}: field error and PSNR along the frames")


def _lines(run: "Run", form: str, matching: str) -> Iterator[str]:
    s = run.summary()
    yield f"{run.scene}, {run.label} ({form} form, {matching} matching), {len(run.records)} frames:"
    yield (
        f"  {s['keys']:.0f} keys; carried frames: error median {s['error_median']:.1%}, worst "
        f"{s['error_worst']:.1%} (worst object alone {s['own_median']:.1%}, {s['own_worst']:.1%}); "
        f"PSNR median {s['psnr_median']:.1f} dB, worst "
        f"{s['psnr_worst']:.1f} dB; SSIM worst {s['ssim_worst']:.3f}; "
        f"shift up to {s['shift_worst'] * 1e6:.1f} µm"
    )
    yield (
        f"  per frame: {s['points']:.0f} points, {s['point_pixels']:.2e} point·pixels, "
        f"{1e3 * s['seconds']:.0f} ms; blank of carried frames {s['blank']:.1%}"
    )


def draw(found: "Sequence[Run]", path: Path) -> None:
    """Error above, PSNR below, one column per scene; key frames are marked between."""
    import matplotlib

    from chrmc.figures import new_figure, save, series

    scenes = list(dict.fromkeys(run.scene for run in found))
    labels = list(dict.fromkeys(run.label for run in found))
    with matplotlib.rc_context({"font.size": 9}):
        figure, axes = new_figure(
            (1.5 + 4.6 * len(scenes), 7.0), 3, len(scenes), sharex="col", sharey="row",
            squeeze=False, height_ratios=[1, 0.1 * len(labels), 1],
        )  # fmt: skip
        lines: dict[str, Any] = {}
        for column, scene in enumerate(scenes):
            above, between, below = axes[:, column]
            for run in (run for run in found if run.scene == scene):
                place = labels.index(run.label)
                style = series(place) | {"lw": 1}
                # A key frame repeats the truth: shown as a mark, not as a dip of the curve.
                keep = [not r.key for r in run.records]
                for axis, values, look, label in (
                    (above, run.errors, {"ls": "-", "ms": 4}, f"{run.label}: whole frame"),
                    (above, run.own_errors, {"ls": ":", "ms": 4, "mfc": "white"},
                     f"{run.label}: the moving object alone"),
                    (below, run.measure("psnr"), {"ls": "-", "ms": 4}, ""),
                ):  # fmt: skip
                    shown = [v if k else float("nan") for v, k in zip(values, keep, strict=True)]
                    line = axis.plot(run.numbers, shown, **style, **look)[0]
                    if label:
                        lines[label] = line
                between.plot(run.keys, [place] * len(run.keys), "|", ms=9, color=style["color"])
                between.annotate(
                    f"{len(run.keys)}", (1.01, place), xycoords=("axes fraction", "data"),
                    va="center", color=style["color"],
                )  # fmt: skip
            above.set_title(scene)
            below.set_xlabel("frame")
            between.set_yticks(range(len(labels)), [f"keys, {label}" for label in labels])
            between.set_ylim(len(labels) - 0.4, -0.6)
            for axis in (above, below):
                axis.grid(alpha=0.3)
            for axis in (above, between, below):
                axis.tick_params(labelbottom=True, labelleft=column == 0 or axis is not between)
        axes[0, 0].set_ylabel("relative error of the field")
        axes[2, 0].set_ylabel("PSNR of the moving object's image, dB")
        axes[0, 0].set_ylim(bottom=0)
        # Below the panels: inside it would hide curves.
        figure.legend(
            lines.values(), lines.keys(), loc="outside lower center", ncols=2, frameon=False
        )
        save(figure, path)
