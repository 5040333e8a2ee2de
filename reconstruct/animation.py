"""Moving pictures: animated GIF and PNG with Pillow, movies with an optional package."""

from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.files import replacing

Frames = Sequence[NDArray[np.uint8]]
ANIMATIONS = (".gif", ".png", ".apng")
MOVIES = (".mp4", ".mkv", ".mov")


def check_animation(path: Path) -> Path:
    """The path, or ValueError for an unknown suffix, OSError for a missing movie package."""
    suffix = path.suffix.lower()
    if suffix in MOVIES and not movies_there():
        raise OSError("movies need imageio-ffmpeg: pip install 'chrmc[movie]', or write a .gif")
    if suffix not in ANIMATIONS + MOVIES:
        raise ValueError(f"{path}: animations are {', '.join(ANIMATIONS + MOVIES)}")
    return path


def movies_there() -> bool:
    """Whether the optional movie package is installed."""
    return find_spec("imageio_ffmpeg") is not None


def write_animation(path: str | Path, frames: Frames, rate: float, comment: str = "") -> None:
    """Write uint8 frames of one shape, (h, w) or (h, w, 3), at `rate` a second, by the suffix.

    comment : kept in the file: a GIF's or a movie's comment, a PNG's text "Comment"
    """
    path = check_animation(Path(path))
    if not frames:
        raise ValueError(f"{path}: no frames to animate")
    if not rate > 0:
        raise ValueError(f"rate must be positive, not {rate}")
    with replacing(path) as partial:
        if path.suffix.lower() in MOVIES:
            _movie(partial, frames, rate, comment)
        else:
            _pictures(partial, frames, rate, path.suffix.lower(), comment)


def _pictures(path: Path, frames: Frames, rate: float, suffix: str, comment: str) -> None:
    from PIL import Image, PngImagePlugin

    pictures = [Image.fromarray(f) for f in frames]
    duration = round(1000 / rate)
    options: dict[str, Any] = {"save_all": True, "append_images": pictures[1:]}
    if suffix == ".gif":
        # GIF counts time in hundredths of a second.
        options |= {"duration": max(20, round(duration, -1)), "loop": 0}
        if comment:
            options["comment"] = comment.encode()
        pictures[0].save(path, format="GIF", **options)
    else:
        if comment:
            options["pnginfo"] = PngImagePlugin.PngInfo()
            options["pnginfo"].add_itxt("Comment", comment)
        pictures[0].save(path, format="PNG", duration=duration, loop=0, **options)


def _movie(path: Path, frames: Frames, rate: float, comment: str) -> None:
    from importlib import import_module

    ffmpeg: Any = import_module("imageio_ffmpeg")
    height, width = (n // 2 * 2 for n in frames[0].shape[:2])  # codecs want even sides
    samples = "gray" if frames[0].ndim == 2 else "rgb24"
    writer = ffmpeg.write_frames(
        str(path), (width, height), pix_fmt_in=samples, fps=rate, quality=8, macro_block_size=2,
        output_params=["-metadata", f"comment={comment}"] if comment else [],
    )  # fmt: skip
    writer.send(None)
    try:
        for frame in frames:
            writer.send(np.ascontiguousarray(frame[:height, :width]).tobytes())
    finally:
        writer.close()
