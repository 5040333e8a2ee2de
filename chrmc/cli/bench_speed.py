"""`chrmc bench speed`: the low-rank forms timed on this machine."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from chrmc.cli.arguments import slm_option, wavelength_option
from chrmc.slm import SLM

PARTS = ("frames", "points", "videos", "reuse", "endure")
_DENSE = 16  # frames of the dense scene

if TYPE_CHECKING:
    from chrmc.bench.reuse import Reuse
    from chrmc.bench.speed import Timed


@click.command("speed")
@click.option("--rounds", default=9, show_default=True, help="Of each single frame.")
@click.option("--last", default=80, show_default=True, help="Last frame of the videos.")
@click.option("--points", "most", default=1_000_000, show_default=True, help="Largest cloud.")
@click.option(
    "--endure",
    type=click.IntRange(0),
    default=0,
    show_default=True,
    help="Frames of long turns about three axes, and of ten bodies that cross.",
)
@click.option(
    "--only",
    type=click.Choice(PARTS),
    multiple=True,
    help="Part of the table; may be given several times. [all]",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    default=None,
    help="Write the table here too; long turns that are stopped go on from what lies beside it.",
)
@slm_option
@wavelength_option
def command(
    rounds: int,
    last: int,
    most: int,
    endure: int,
    only: tuple[str, ...],
    out: Path | None,
    slm: SLM,
    wavelength: float | None,
) -> None:
    """Time `curved` and object-centred CH-RMC, against a separable Fresnel product.

    Timed in turn on a fresh cloud each; medians, the least beside them. A busy machine spoils the
    times more than the ratios.
    """
    from chrmc.bench import speed
    from chrmc.files import replacing
    from chrmc.slm import WAVELENGTH

    wave = wavelength or WAVELENGTH
    lines = [f"{slm.name}, {slm.width} × {slm.height}, {speed.machine()}"]
    click.echo(lines[0])
    made = {
        "frames": partial(_single, max(1, rounds), slm, wave),
        "points": partial(_many, most, slm, wave),
        "videos": partial(_videos, max(1, min(last, 80)), most, slm, wave),
        "reuse": partial(_reuse, most, slm, wave),
        "endure": partial(_endured, endure, most, slm, wave, lines[0], out),
    }
    for part in PARTS:
        for line in made[part]() if part in only or not only else ():
            click.echo(line)
            lines.append(line)
    if out is not None:
        with replacing(out) as file:
            file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _single(rounds: int, slm: SLM, wave: float) -> Iterator[str]:
    """Single frames against their rivals, and how near the products are to the machine's rate."""
    from chrmc.bench import speed
    from chrmc.scene.load import load_scene

    cloud = load_scene("car-house").frame(21).cloud
    for timed in speed.single_frames(cloud, slm, wave, rounds):
        yield _line(timed)
    rate = speed.product_rate(cloud, slm, wave)
    yield (
        f"the two products: {rate.products / 1e9:.0f} Gflop/s, {rate.share:.0%} of a plain "
        f"product's {rate.peak / 1e9:.0f}"
    )


def _many(most: int, slm: SLM, wave: float) -> Iterator[str]:
    from chrmc.bench import speed

    for count in (100_000, 1_000_000):
        if count <= most:
            yield _line(speed.many_points(count, slm, wave))


def _videos(last: int, most: int, slm: SLM, wave: float) -> Iterator[str]:
    """Built-in scenes by the object surface."""
    from chrmc.bench import speed
    from chrmc.encoding import coding_for
    from chrmc.grey_levels import encode_signal, video_scale
    from chrmc.scene.load import load_scene

    runs = [(name, t, last) for name in ("car-house", "car-house-deep") for t in (1e-3, 1e-5)]
    if most >= 100_000:
        runs.append(("car-house-dense", 1e-3, min(last, _DENSE)))
    for name, tolerance, frames in runs:
        scene = load_scene(name)
        scale = video_scale(scene, slm, wave, coding_for("ssb", slm))
        encode = partial(encode_signal, scale=scale)
        yield _line(speed.videos(scene, slm, wave, encode, tolerance, frames))


def _reuse(most: int, slm: SLM, wave: float) -> Iterator[str]:
    """Frames looked up against frames afresh."""
    from chrmc.bench import reuse

    for case in reuse.CASES:
        if case.points <= most:
            yield _reused(reuse.reuse(case, slm, wave))


def _endured(
    frames: int, most: int, slm: SLM, wave: float, about: str, out: Path | None
) -> Iterator[str]:
    """A line for every long turn, and one for many bodies."""
    from chrmc.bench import endurance
    from chrmc.bench.kept import KeptRows
    from chrmc.progress import progress

    if not frames:
        return
    made_with = [about, f"{1e9 * wave:g} nm", f"{frames} frames", f"{most} points at most"]
    kept = KeptRows(out and out.with_suffix(".endured.json"), made_with, endurance.Endured)
    turns = [(endurance.spinning(min(most, 100_000), frames), t) for t in (1e-2, 1e-3, 1e-4, 1e-5)]
    for scene, tolerance in [*turns, (endurance.crossing(min(most, 10_000), frames), 1e-3)]:
        one = kept.of(scene.name, tolerance)
        done = one.frames if one is not None else 0
        made = endurance.endured(scene, slm, wave, tolerance, one)
        for one in progress(made, f"{scene.name} at {tolerance:g}", frames - done):
            if one.frames % endurance.GROUP == 0 or one.frames == frames:
                kept.take(one)
        assert one is not None
        line = (
            f"{one.name} at {one.tolerance:g}, {one.frames} frames, {one.keys} key: largest error "
            f"{one.error:.2f} of the tolerance, {one.late:.0f} MiB held at most, {one.early:.0f} "
            "in the first tenth"
        )
        yield line


def _reused(case: "Reuse") -> str:
    return (
        f"{case.name}: object surface {1e3 * case.later:.0f} ms, afresh {1e3 * case.fresh:.0f} ms, "
        f"first frame {1e3 * case.first:.0f} ms, all frames {case.ratio:.2f} of afresh, "
        f"{case.work:.2f} in processor time, "
        f"error {case.error:.1e} ({case.how[0]})"
    )


def _line(timed: "Timed") -> str:
    text = f"{timed.name}: {1e3 * timed.median:.1f} ms (least {1e3 * timed.least:.1f})"
    if timed.ratio is not None:
        text += f", {timed.ratio:.1f} × the rival's speed"
    if timed.error is not None:
        text += f", error {timed.error:.1e}"
    return text + (f", {timed.note}" if timed.note else "")
