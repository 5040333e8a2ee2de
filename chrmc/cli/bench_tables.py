"""What `chrmc bench table1` and `chrmc bench table2` share."""

import platform
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from chrmc.bench.systems import Images
from chrmc.bench.tables import Pair
from chrmc.cli.arguments import FigurePath, frames_option, slm_option, wavelength_option
from chrmc.cli.lengths import OFFSET, Length
from chrmc.scene.scene import Scene, SceneFrame
from chrmc.slm import SLM

FORMS = ("rgbd", "points")

COLUMNS_HELP = """points: computed per frame; corrected: of them on frames that are not computed
whole; moving: without objects that stand still; tolerant: under the tolerant matching rule. pt·px:
points × pixels they were computed on. ACT: seconds per frame, from points to complex field. err
shown: relative field error against the points that the method says it shows; err scene: against the
scene's. PSNR: of the worst reconstruction, against the exact field of either. Eq. 14: the image of
the points shown against the scene's, dB."""
"""What the tables' columns mean, below --help."""


def table_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """The arguments of both commands."""
    for option in reversed(
        (
            click.argument("scene", default="car-house"),
            frames_option,
            click.option(
                "--form",
                type=click.Choice([*FORMS, "both"]),
                default="both",
                show_default=True,
                help="rgbd as in the paper, body-fixed points, or a table of each.",
            ),
            click.option(
                "--plane-spacing",
                type=Length(OFFSET),
                default=None,
                help="Depth planes so far apart, rgbd of car-house and car-house-deep; "
                "default 0.1mm.",
            ),
            click.option("--encoding", default="real", show_default=True, help="real or ssb."),
            click.option(
                "--only",
                default=None,
                help="Comma-separated systems, as the table names them; originals are kept.",
            ),
            click.option(
                "--pixels",
                type=click.IntRange(1),
                default=256,
                show_default=True,
                help="Pixels per frame on which field errors are measured.",
            ),
            click.option(
                "--image-every",
                type=click.IntRange(0),
                default=10,
                show_default=True,
                help="Compare reconstructions every so many frames; 0 for never.",
            ),
            slm_option,
            wavelength_option,
            click.option(
                "--out",
                type=click.Path(path_type=Path, file_okay=False),
                default=None,
                help="Folder for the table as text, CSV and figure.",
            ),
            click.option(
                "--figure",
                type=FigurePath(),
                default=None,
                help="Name of the figure in that folder: a .png, .pdf or .svg. [its name.png]",
            ),
        )
    ):
        function = option(function)
    return function


def run(
    name: str,
    pairs: Sequence[Pair],
    scene: str,
    frames: tuple[int, int] | None,
    form: str,
    plane_spacing: float | None,
    encoding: str,
    only: str | None,
    pixels: int,
    image_every: int,
    slm: SLM,
    wavelength: float | None,
    out: Path | None,
    figure: Path | None = None,
) -> int:
    """Measure, print and write a table."""
    from chrmc.bench import systems, tables
    from chrmc.bench.kept_scene import kept_scene
    from chrmc.encoding import coding_for
    from chrmc.generation.recipe import scene_wavelength
    from chrmc.progress import progress
    from chrmc.scene.car_house import HEADINGS, car_house_rgbd
    from chrmc.scene.load import load_scene

    coding = coding_for(encoding, slm)
    pairs = chosen(pairs, only)
    texts, rows_by_kind = [machine(slm, encoding)], {}
    for kind in FORMS if form == "both" else (form,):
        given: Scene = load_scene(scene, form=kind)
        if plane_spacing is not None and kind == "rgbd":
            if scene not in HEADINGS:
                raise ValueError(
                    f"--plane-spacing renders {' or '.join(HEADINGS)} anew; {scene} has its planes"
                )
            given = car_house_rgbd(scene, plane_spacing)
        if given.form != kind:
            if form != "both":
                raise ValueError(f"{scene} has no {kind} form; it is {given.form}")
            continue
        wave = scene_wavelength(given, wavelength)
        kept = kept_scene(given)
        wanted = tables.systems_of(pairs)
        measured = systems.measure(
            wanted,
            kept,
            slm,
            wave,
            coding,
            frames=frames,
            pixels=pixels,
            images=image_psnr(slm, wave) if image_every else None,
            image_every=max(1, image_every),
            watch=partial(progress, label=f"{name} {kind}"),
        )
        loose = tables.tolerant_points(wanted, kept, slm, wave, coding, frames)
        rows_by_kind[kind] = tables.rows(kind, pairs, measured, loose)
        texts.append(_section(name, kind, given, rows_by_kind[kind]))
    for text in texts:
        click.echo(text)
    if out is not None:
        _write(out, name, "\n".join(texts), rows_by_kind, scene, figure or Path(f"{name}.png"))
        click.echo(f"written to {out}")
    return 0


def chosen(pairs: Sequence[Pair], only: str | None) -> list[Pair]:
    """The pairs whose compensated system is named; ValueError for a name there is not."""
    if only is None:
        return list(pairs)
    names = [name.strip() for name in only.split(",")]
    labels = [pair.compensated.label for pair in pairs]
    for name in names:
        if name not in labels:
            raise ValueError(f"there is no system {name!r} in this table: {', '.join(labels)}")
    return [pair for pair in pairs if pair.compensated.label in names]


def machine(slm: SLM, encoding: str) -> str:
    """What the times were measured on and of."""
    from chrmc.threads import workers

    return (
        f"{slm.width} × {slm.height} pixels of {slm.pixel_pitch * 1e6:g} µm, encoding {encoding}; "
        f"{workers()} cores, {platform.machine()}, NumPy {np.__version__}; systems interleaved "
        "frame by frame"
    )


def _section(name: str, kind: str, scene: Scene, rows: Sequence[dict[str, Any]]) -> str:
    from chrmc.bench import tables

    return (
        f"\n{name}, {scene.name}, {kind}\n\n{tables.to_text(rows)}\n\n"
        f"{tables.stages_text(rows)}\n\n{tables.claims_text(rows)}"
    )


def _write(
    out: Path, name: str, text: str, rows_by_kind: dict[str, list[dict[str, Any]]], scene: str,
    figure: Path,
) -> None:  # fmt: skip
    from chrmc.bench import tables
    from chrmc.files import replacing

    out.mkdir(parents=True, exist_ok=True)
    rows = [row for table in rows_by_kind.values() for row in table]
    with replacing(out / f"{name}.txt") as path:
        path.write_text(text + "\n", encoding="utf-8")
    with replacing(out / f"{name}.csv") as path:
        path.write_text(tables.to_csv(rows), encoding="utf-8")
    tables.plot(
        dict(rows_by_kind), out / figure, f"Table {name[-1]} of the paper, made again on {scene}"
    )


def image_psnr(slm: SLM, wavelength: float) -> Images:
    """PSNR of each object's reconstruction at its depth against that of the exact field, dB.

    The complex field is propagated to the object's depth; the picture is the intensity on the
    object's extent and a tenth around it, at the SLM's pitch.
    """
    from chrmc.metrics import psnr
    from chrmc.optics.propagation import Patch, Propagator

    def compare(
        field: NDArray[np.complex64], exact: NDArray[np.complex64], scene_frame: SceneFrame
    ) -> Mapping[str, float]:
        found = {}
        for obj in scene_frame.objects:
            if len(obj.cloud) == 0:
                continue
            low, high = (f(obj.cloud.positions[:, :2], axis=0) for f in (np.min, np.max))
            size = 1.2 * (high - low) + 20 * slm.pixel_pitch
            middle = (low + high) / 2
            columns, rows = (int(n) for n in np.ceil(size / slm.pixel_pitch))
            patch = Patch((float(middle[1]), float(middle[0])), (rows, columns), slm.pixel_pitch)
            to_object = Propagator(slm.shape, slm.pixel_pitch, wavelength, obj.depth, patch)
            pictures = [np.abs(to_object(f, -obj.depth)) ** 2 for f in (field, exact)]
            found[obj.name] = psnr(pictures[0], pictures[1])
        return found

    return compare
