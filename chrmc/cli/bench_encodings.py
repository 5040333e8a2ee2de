"""`chrmc bench encodings`: one frame through every encoding, read by the same 4-f system."""

from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from chrmc.cli.arguments import form_option, slm_option, wavelength_option
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM


@click.command("encodings")
@click.argument("scene", default="car-house")
@click.option("--frame", type=int, default=1, show_default=True, help="Frame of the scene.")
@click.option("--object", "obj", default=None, help="Whose depth images are compared at. [first]")
@click.option("--cgh", default=None, help="CGH method. [curved]")
@form_option
@slm_option
@wavelength_option
@click.option(
    "--out", type=click.Path(path_type=Path), default=None, help="Also write the table as CSV."
)
def command(
    scene: str,
    frame: int,
    obj: str | None,
    cgh: str | None,
    form: str,
    slm: SLM,
    wavelength: float | None,
    out: Path | None,
) -> int:
    """Compare the encodings on one frame of SCENE.

    light: share of the laser's light that reaches the image. clipped: pixels at the end of the
    grey range. error: of the decoded complex field, relative L2, the best complex factor taken
    off. PSNR: of the object's picture at its depth. Both against the same field before encoding,
    limited to the band that the encoding keeps, once for a
    field that the generator limited and once for one that fills the panel's whole band.
    """
    from chrmc.generation.recipe import recipe_for, scene_wavelength
    from chrmc.scene.load import load_scene

    given = load_scene(scene, form=form)
    recipe = recipe_for(given, slm, wavelength, cgh=cgh)
    wave = scene_wavelength(given, wavelength)
    scene_frame = given.frame(frame)
    names = [o.name for o in scene_frame.objects if len(o.cloud)]
    if not names:
        raise ValueError(f"frame {frame} of {given.name} is empty: nothing to compare")
    obj = obj or names[0]
    if obj not in names:
        raise ValueError(f"frame {frame} has no object {obj!r}; it has {', '.join(names)}")
    shown = next(o for o in scene_frame.objects if o.name == obj)
    depth = shown.depth
    box = around(shown.cloud, slm)
    rows = measure(scene_frame.cloud, slm, wave, depth, box, recipe.cgh, recipe.options)
    click.echo(f"frame {frame} of {given.name}, images at the {obj}, {depth * 1e3:.2f} mm")
    click.echo(
        f"{'encoding':<16}{'light':>9}{'clipped':>9}{'error':>9}{'PSNR':>10}"
        f"{'error':>12}{'PSNR':>10}"
    )
    click.echo(f"{'':<16}{'':>9}{'':>9}{'field kept to half band':>19}{'whole band':>18}")
    for row in rows:
        click.echo(
            f"{row['encoding']:<16}{row['light']:>9.3%}{row['clipped']:>9.2%}"
            f"{row['error']:>9.2%}{row['psnr']:>7.1f} dB"
            f"{row['error_whole']:>12.2%}{row['psnr_whole']:>7.1f} dB"
        )
    if out is not None:
        from chrmc.files import replacing

        with replacing(out) as partial:
            lines = [",".join(rows[0]), *(",".join(str(v) for v in r.values()) for r in rows)]
            partial.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return 0


def around(cloud: PointCloud, slm: SLM) -> tuple[slice, slice]:
    """Rows and columns of the panel that an object's points lie on, with a tenth around it."""
    parts = []
    for axis, count in ((1, slm.height), (0, slm.width)):
        low, high = cloud.positions[:, axis].min(), cloud.positions[:, axis].max()
        margin = 0.1 * (high - low) + 10 * slm.pixel_pitch
        ends = np.array([low - margin, high + margin]) / slm.pixel_pitch + (count - 1) / 2
        first, last = (int(v) for v in np.clip(np.rint(ends), 0, count))
        if last - first < 2:
            raise ValueError("the object lies beside the panel: choose another with --object")
        parts.append(slice(first, last))
    return parts[0], parts[1]


def measure(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    depth: float,
    box: tuple[slice, slice],
    cgh: Any,
    options: dict[str, Any],
) -> list[dict[str, Any]]:
    """One row of figures for each encoding; images are compared in `box`."""
    from chrmc.cgh import compute_field
    from chrmc.encoding import CODINGS, coding_for
    from chrmc.grey_levels import encode, limit_band
    from chrmc.metrics import psnr
    from chrmc.optics.passband import full_band
    from chrmc.progress import progress
    from reconstruct.four_f_system import FourF, intensity
    from reconstruct.metrics import scale_to

    half = coding_for("ssb", slm)
    # Methods of a video's kind take options that a single field does not need.
    wanted = {k: v for k, v in options.items() if k == "tolerance"}
    limited = compute_field(cloud, slm, wavelength, cgh, passband=half.passband, **wanted)
    whole = compute_field(cloud, slm, wavelength, cgh, passband=full_band(slm), **wanted)
    rows = []
    for name in progress(CODINGS, "bench encodings", unit="encoding"):
        system = FourF(slm, wavelength, name)
        row: dict[str, Any] = {"encoding": name}
        for suffix, field in (("", limited), ("_whole", whole)):
            frame = encode(field, slm, name)
            truth = limit_band(field, slm, coding_for(name, slm))
            decoded = system.field(frame)
            if not suffix:
                row["light"] = system.energy(frame).efficiency
                row["clipped"] = float(np.mean((frame == 0) | (frame == 255)))
            row["error" + suffix] = field_error(decoded, truth)
            image = intensity(system.at(decoded, depth))[box]
            wanted_image = intensity(system.at(truth, depth))[box]
            row["psnr" + suffix] = psnr(image * scale_to(image, wanted_image), wanted_image)
        rows.append(row)
    return rows


def field_error(decoded: NDArray[np.complex64], truth: NDArray[np.complex64]) -> float:
    """Relative L2 error once the best complex factor is taken off."""
    a, b = decoded.ravel().astype(np.complex128), truth.ravel().astype(np.complex128)
    power, norm = float(np.vdot(a, a).real), float(np.linalg.norm(b))
    factor = complex(np.vdot(a, b)) / power if power > 0 else 0j
    return float(np.linalg.norm(factor * a - b)) / norm if norm > 0 else 0.0
