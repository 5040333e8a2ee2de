"""`chrmc bench propagation`: the reconstruction's propagation against independent ones."""

import time
from pathlib import Path

import click
import numpy as np

from chrmc.cli.lengths import DEPTH, Length


@click.command("propagation")
@click.argument("video", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--frame", "number", type=int, default=None, help="Frame number. [the first]")
@click.option(
    "--depth", type=Length(DEPTH), default=None, help="Such as 252mm. [of the first object]"
)
@click.option(
    "--pixels",
    type=click.IntRange(1),
    default=24,
    show_default=True,
    help="Bright pixels that the direct sum is taken at.",
)
def command(video: Path, number: int | None, depth: float | None, pixels: int) -> int:
    """Propagate one frame of the video in DIR by independent means and print the differences.

    A direct Rayleigh–Sommerfeld sum over all SLM pixels in float64, at bright pixels of the
    image; and the angular spectrum of the package HCIPy, where it is installed
    (pip install "chrmc[crosscheck]"). Differences are relative L2, absolute phase included.
    """
    from chrmc.metrics import psnr
    from chrmc.optics.propagation import Patch
    from chrmc.reference import relative_error
    from chrmc.response import GreyResponse
    from chrmc.store.video import open_video
    from reconstruct import crosscheck
    from reconstruct.four_f_system import FourF, check_distance, intensity
    from reconstruct.verdict import Target, inside

    stored = open_video(video)
    if not stored.numbers:
        raise ValueError(f"{video} has no frames yet: run `chrmc generate` first")
    number = stored.numbers[0] if number is None else number
    frame = stored.read(number)
    targets = [Target.of_record(o) for o in stored.entry(number).get("objects", [])]
    seen = [t for t in targets if t is not None]
    if depth is None:
        if not seen:
            raise ValueError(f"frame {number} is empty: give a --depth")
        depth = float(seen[0].position[2])
    check_distance(depth)
    slm, wave = stored.slm, stored.wavelength
    system = FourF(
        slm,
        wave,
        stored.encoding,
        response=GreyResponse.from_dict(stored.response),
        scale=stored.scale,
    )
    field = system.field(frame)
    start = time.perf_counter()
    ours = system.at(field, depth)
    spent = time.perf_counter() - start
    click.echo(f"frame {number} at {depth * 1e3:.3f} mm, {slm.width} × {slm.height} pixels")
    click.echo(f"{'chrmc, band-limited angular spectrum':<44}{spent:>8.2f} s")

    # Pixels from the brightest thousandth, evenly over their ranks.
    bright = np.argsort(intensity(ours), axis=None)[::-1][: max(ours.size // 1000, pixels)]
    chosen = bright[np.linspace(0, len(bright) - 1, min(pixels, len(bright))).astype(int)]
    rows, columns = np.unravel_index(chosen, ours.shape)
    start = time.perf_counter()
    direct = crosscheck.rayleigh_sommerfeld(field, slm.pixel_pitch, wave, depth, rows, columns)
    spent = time.perf_counter() - start
    difference = relative_error(ours[rows, columns], direct)
    words = f"direct sum, {len(rows)} bright pixels"
    click.echo(f"{words:<44}{spent:>8.2f} s   difference {difference:.2e}")

    if not crosscheck.package_there():
        click.echo("HCIPy is not installed: pip install 'chrmc[crosscheck]' to compare with it")
        return 0
    start = time.perf_counter()
    theirs = crosscheck.package_propagate(field, slm.pixel_pitch, wave, depth)
    spent = time.perf_counter() - start
    likeness = psnr(intensity(ours), intensity(theirs.astype(np.complex64)))
    click.echo(
        f"{'HCIPy, angular spectrum':<44}{spent:>8.2f} s   "
        f"difference {relative_error(ours, theirs):.2e}, image {likeness:.1f} dB"
    )
    whole = Patch((0.0, 0.0), slm.shape, slm.pixel_pitch)
    for target in seen:
        where = inside(whole, target)
        if where.any():
            difference = relative_error(ours[where], theirs[where])
            words = f"  inside the {target.name}'s box"
            click.echo(f"{words:<44}{'':>10}   difference {difference:.2e}")
    return 0
