"""Reconstructions as files: 8-bit PNG for the eye, float32 EXR for numbers, metadata in both."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.pictures import opened, write_pixels

SUFFIXES = (".png", ".exr")


def exposure(image: NDArray[np.floating]) -> float:
    """Intensity to show as white: 2·ΣI²/ΣI, twice the brightness that the average photon sees.

    Bright enough for a lattice of points and for speckle alike, at most the largest intensity.
    """
    values = np.asarray(image, dtype=np.float64)
    total = float(values.sum())
    if not total > 0:
        return 0.0
    return min(2 * float(np.sum(values * values)) / total, float(values.max()))


MOST = 1e37
"""Intensity that full_scale may be, of what single precision holds."""


def to_grey(
    image: NDArray[np.floating], full_scale: float | None = None, gamma: float = 2.2
) -> NDArray[np.uint8]:
    """Intensity as display grey levels: 255·(I/full_scale)^(1/gamma), clipped.

    full_scale : intensity shown as 255, default `exposure`; give one for a sequence
    gamma : of the display; 1 makes grey proportional to intensity
    """
    if not (np.isfinite(gamma) and gamma > 0):
        raise ValueError(f"gamma must be positive, not {gamma}")
    top = exposure(image) if full_scale is None else float(full_scale)
    if not 0 <= top <= MOST:
        raise ValueError(f"full_scale must be a finite intensity of 0 to {MOST:g}, not {top}")
    if top < 1 / MOST:
        return np.zeros(image.shape, dtype=np.uint8)
    level = np.clip(np.asarray(image, dtype=np.float32) / np.float32(top), 0, 1)
    return np.rint(255 * level ** np.float32(1 / gamma)).astype(np.uint8)


def check_suffix(path: str | Path) -> Path:
    """The path, or ValueError when its suffix is neither .png nor .exr."""
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise ValueError(f"{path}: reconstructions are written as .png or .exr")
    return path


def write_image(
    path: str | Path,
    image: NDArray[np.floating],
    metadata: dict[str, Any] | None = None,
    full_scale: float | None = None,
    gamma: float = 2.2,
) -> None:
    """Write (h, w) intensities by the suffix: .png as `to_grey` shows them, .exr unchanged.

    metadata : anything JSON holds; kept as the ImageDescription, with full_scale and gamma of a
        PNG, so that its levels can be turned back into intensities
    """
    path = check_suffix(path)
    if image.ndim != 2 or image.size == 0:
        raise ValueError(f"{path}: an image must be (h, w) and not empty, not {image.shape}")
    note = dict(metadata or {})
    if path.suffix.lower() == ".png":
        top = exposure(image) if full_scale is None else float(full_scale)
        note |= {"full_scale": top, "gamma": gamma}
        _write(path, to_grey(image, top, gamma)[:, :, None], "uint8", note)
    else:
        _write(path, np.asarray(image, dtype=np.float32)[:, :, None], "float", note)


def write_counts(
    path: str | Path,
    counts: NDArray[np.uint8] | NDArray[np.uint16],
    metadata: dict[str, Any] | None = None,
) -> None:
    """Write (h, w) camera counts unchanged as a PNG of 8 or 16 bits."""
    path = Path(path)
    if path.suffix.lower() != ".png":
        raise ValueError(f"{path}: a camera's counts are written as .png")
    _write(path, counts[:, :, None], str(counts.dtype), dict(metadata or {}))


def write_colour(
    path: str | Path,
    image: NDArray[np.uint8] | NDArray[np.float32],
    metadata: dict[str, Any] | None = None,
) -> None:
    """Write (h, w, 3): uint8 as a .png, float32 as an .exr; metadata as `write_image` keeps it."""
    path = Path(path)
    kind, suffix = ("uint8", ".png") if image.dtype == np.uint8 else ("float", ".exr")
    if path.suffix.lower() != suffix:
        raise ValueError(f"{path}: colour pictures of {image.dtype} are written as {suffix}")
    _write(path, image, kind, dict(metadata or {}))


def _write(path: Path, pixels: NDArray[Any], kind: str, note: dict[str, Any]) -> None:
    attributes = {"ImageDescription": json.dumps(note)} if note else {}
    names = ("Y",) if pixels.shape[2] == 1 else ("R", "G", "B") if kind == "float" else ()
    write_pixels(path, pixels, kind, names, attributes=attributes)


def read_image(path: str | Path) -> tuple[NDArray[np.float32], dict[str, Any]]:
    """(h, w) values and metadata of a written image; PNG levels come back as they are."""
    path = Path(path)
    with opened(path) as source:
        spec = source.spec()
        kind = str(spec.format) if str(spec.format) in ("uint8", "uint16") else "float"
        pixels = source.read_image(format=kind)
        if pixels is None:
            raise OSError(f"{path} is damaged: {source.geterror().strip()}")
        note = spec.get_string_attribute("ImageDescription", "")
    values = np.asarray(pixels, dtype=np.float32).reshape(spec.height, spec.width, spec.nchannels)
    try:
        metadata = json.loads(note) if note else {}
    except json.JSONDecodeError:
        metadata = {"description": note}
    return values[:, :, 0], metadata
