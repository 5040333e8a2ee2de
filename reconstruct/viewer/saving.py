"""Files of what is seen: picture, intensities, figure, movies. Jobs for a worker, in steps."""

import json
from collections.abc import Iterator
from dataclasses import asdict, replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.store.colour import ColourVideo
from reconstruct.animation import check_animation, write_animation
from reconstruct.bench import Filter
from reconstruct.images import exposure, write_colour, write_image
from reconstruct.sequence import shrink
from reconstruct.viewer.compare import Comparison
from reconstruct.viewer.figure import FIGURES, write_figure
from reconstruct.viewer.lasers import Source, leading
from reconstruct.viewer.pipeline import Decoded, Picture, Request, pipeline_of
from reconstruct.viewer.shade import Look, shade, shade_difference
from reconstruct.viewer.sources import title_of
from reconstruct.viewer.worker import Progress, Said

MOVIE_WIDTH = 960
"""Columns that a movie has at most."""
STACK_COUNT = 60
"""Depths of a movie through the depths."""


def settings_of(video: Source, request: Request, look: Look) -> dict[str, Any]:
    """How a picture was made, in words and SI units: enough to make it again."""
    chosen = request.filter
    return {
        "source": title_of(video),
        "frame": request.number,
        "depth": request.depth,
        "wavelength": list(video.wavelengths)
        if isinstance(video, ColourVideo)
        else video.wavelength,
        "pixel_pitch": video.slm.pixel_pitch,
        "panel": video.slm.name,
        "encoding": leading(video).encoding,
        "half_plane": chosen.half_plane,
        "dc_block": chosen.dc_block,
        "aperture": chosen.aperture,
        **asdict(look),
        "program": f"chrmc {_version()}",
    }


def _version() -> str:
    try:
        return version("chrmc")
    except PackageNotFoundError:
        return "from its source"


def save_picture(
    path: Path, video: Source, decoded: Decoded, request: Request, look: Look
) -> Iterator[Progress | Said | None]:
    """The full picture: .exr intensities, .png as it looks, with its settings."""
    yield Progress(f"saving {path.name}", 0.0)  # one step: who leaves now still has the file
    picture = decoded.picture(request.depth)
    note = settings_of(video, request, look)
    if path.suffix.lower() != ".exr":
        write_colour(path, shade(picture.field, picture.white, look, picture.glow), note)
    elif picture.glow is None:
        write_image(path, picture.light, note)
    else:
        write_colour(path, picture.glow, note)
    yield Said(f"saved {path}")


def save_difference(
    path: Path, held: Comparison, look: Look, note: dict[str, Any]
) -> Iterator[Progress | Said | None]:
    """B less A: .exr signed intensities, .png as it looks, with what was measured."""
    yield Progress(f"saving {path.name}", 0.0)
    note = note | {"factor": held.factor, "psnr": held.psnr, "ssim": held.ssim}
    if not np.isfinite(held.psnr):
        note["psnr"] = None  # equal: JSON has no infinity
    if path.suffix.lower() == ".exr":
        write_image(path, held.difference, note)
    else:
        write_colour(path, shade_difference(held.difference, held.span, look), note)
    yield Said(f"saved {path}")


def save_figure(
    path: Path,
    video: Source,
    decoded: Decoded,
    request: Request,
    look: Look,
    part: tuple[slice, slice] = (slice(None), slice(None)),
) -> Iterator[Progress | Said | None]:
    """A part (rows, columns) of the full picture as a figure for a paper."""
    if path.suffix.lower() not in FIGURES:
        raise ValueError(f"{path}: figures are written as {', '.join(FIGURES)}")
    yield Progress(f"saving {path.name}", 0.0)
    picture = decoded.picture(request.depth)
    slm = video.slm
    x, y = slm.x()[part[1]], slm.y()[part[0]]
    note = settings_of(video, request, look)
    glow = None if picture.glow is None else picture.glow[part]
    origin = x[0], y[0]
    write_figure(
        path, picture.field[part], picture.white, look, slm.pixel_pitch, origin, note, glow
    )
    yield Said(f"saved {path}")


def save_frames(
    path: Path, video: Source, numbers: list[int], depths: list[float], chosen: Filter, look: Look,
    rate: float, note: dict[str, Any],
) -> Iterator[Progress | Said | None]:  # fmt: skip
    """A movie of frames, each at its depth; `note` and the depths are kept in the file."""
    check_animation(path)
    pipeline = pipeline_of(video, max(depths))
    shown: list[NDArray[np.uint8]] = []
    white = 0.0
    for i, (number, depth) in enumerate(zip(numbers, depths, strict=True)):
        yield Progress(f"movie {path.name}", i / len(numbers))
        picture = pipeline.decoded(number, chosen).picture(depth)
        # One white for all, from the first frame: a white per frame would flicker.
        white = white or picture.white
        shown.append(_small(*_halved(picture), white, look))
    note = note | {"frame": list(numbers), "depth": list(depths)}
    write_animation(path, shown, rate, json.dumps(note, default=float))
    yield Said(f"saved {path}: {len(shown)} frames at {rate:g} a second")


def save_stack(
    path: Path, decoded: Decoded, depths: tuple[float, float], look: Look, rate: float,
    note: dict[str, Any],
) -> Iterator[Progress | Said | None]:  # fmt: skip
    """A movie through the depths of a frame; `note` and the depths are kept in the file."""
    check_animation(path)
    z = np.linspace(*depths, STACK_COUNT)
    parts = []
    for i, depth in enumerate(z):
        yield Progress(f"movie {path.name}", i / len(z))
        parts.append(_halved(decoded.picture(float(depth))))
    white = float(np.median([exposure(np.abs(field) ** 2) for field, _ in parts]))
    note = note | {"depth": z.tolist()}
    write_animation(
        path, [_small(*part, white, look) for part in parts], rate, json.dumps(note, default=float)
    )
    low, high = (d * 1e3 for d in depths)
    yield Said(f"saved {path}: {low:.2f} to {high:.2f} mm")


def _halved(picture: Picture) -> tuple[NDArray[np.complex64], NDArray[np.float32] | None]:
    """As much of a picture's field and colours as a movie shows: a stack fits into memory."""
    if picture.glow is None:
        return _fewer(picture.field), None
    glow = np.stack([shrink(picture.glow[..., k], MOVIE_WIDTH) for k in range(3)], axis=-1)
    return _fewer(picture.field), glow


def _fewer(field: NDArray[np.complex64]) -> NDArray[np.complex64]:
    factor = max(1, -(-field.shape[1] // MOVIE_WIDTH))
    if factor == 1:
        return field
    light = shrink(np.abs(field) ** 2, MOVIE_WIDTH)
    middle = field[factor // 2 :: factor, factor // 2 :: factor][: light.shape[0], : light.shape[1]]
    size = np.maximum(np.abs(middle), 1e-30)
    return np.asarray(middle / size * np.sqrt(light), dtype=np.complex64)


def _small(
    field: NDArray[np.complex64], glow: NDArray[np.float32] | None, white: float, look: Look
) -> NDArray[np.uint8]:
    """(h, w) or (h, w, 3) for a movie."""
    colours = shade(field, white, replace(look), glow)
    grey = glow is None and look.colours == "grey" and look.mode != "phase"
    return np.ascontiguousarray(colours[..., 0]) if grey else colours
