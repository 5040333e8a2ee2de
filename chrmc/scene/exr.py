"""Intensity, depth and object id in OpenEXR files, channels found by name."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.colour import LUMINANCE, hue
from chrmc.pictures import file_name, write_pixels
from chrmc.scene.rgbd import RGBDFrame

INTENSITY_NAMES = ("y", "i", "intensity", "grey", "gray", "luminance")
DEPTH_NAMES = ("z", "depth")
ID_NAMES = ("id", "object_id", "objectid", "object", "indexob")
COLOUR_NAMES = (("r", "red"), ("g", "green"), ("b", "blue"))
PICTURE_LAYERS = {"combined", "beauty", "rgba", "image"}
ALPHA_NAMES = ("a", "alpha")
NO_HIT = 1e9
"""Metres from which on a depth means that nothing was there: renderers write 1e10."""
HALF_EXACT = 2048
"""Whole numbers up to here are exact in half precision."""


def write_exr(path: Path, frame: RGBDFrame) -> None:
    """Write channels Y (float), Z (float, metres), id, and R, G, B (float) of what has colours;
    whole or not at all.

    Ids are half where that is exact, else float. Raises OSError when writing fails.
    """
    largest = int(frame.object_id.max())
    if largest > 2**24:
        raise ValueError(f"{path.name}: object id {largest} does not fit a float; number from 1")
    ids = "half" if largest <= HALF_EXACT else "float"
    parts: list[NDArray[Any]] = [frame.intensity, frame.depth, frame.object_id]
    names, kinds = ["Y", "Z", "id"], ["float", "float", ids]
    if frame.colour is not None:
        parts += list(np.moveaxis(frame.colour * frame.intensity[:, :, None], 2, 0))
        names, kinds = [*names, "R", "G", "B"], [*kinds, "float", "float", "float"]
    pixels = np.stack(parts, axis=2).astype(np.float32)
    write_pixels(path, pixels, "float", names, kinds, {"compression": "zip"})


MOST_PIXELS = 1 << 26
"""Of a frame: a header may claim any size, and memory is given on its word."""


def read_exr(path: Path) -> tuple[RGBDFrame, bool]:
    """The frame in a file of any tool, and whether it has object ids (else all are 0).

    Intensity is a channel named Y, I, intensity, grey or luminance, or the luminance of R, G, B,
    whose colour the frame keeps;
    depth Z or depth, in metres, 1e9 and more for background; alpha 0 is background too; ids id or
    object_id. Case and layers (`view.Depth.Z`) do not
    matter. A cropped data window is put in its place. Raises OSError for a file that cannot be
    read and ValueError for one that says nothing usable, both in one line.
    """
    import OpenImageIO as oiio

    if not path.is_file():
        raise FileNotFoundError(f"{path} is missing")
    source = oiio.ImageInput.open(file_name(path))
    if source is None:
        raise OSError(f"{path} cannot be read: {_line(oiio.geterror())}")
    try:
        channels = _channels(source, path)
        names = [name for name, _, _ in channels]
        depth = find_channel(names, DEPTH_NAMES)
        if depth is None:
            raise ValueError(
                f"{path} has channels {', '.join(names)}, none called Z or depth: "
                "add the depth in metres"
            )
        identity = find_channel(names, ID_NAMES)
        free = ["" if index in {depth, identity} else name for index, name in enumerate(names)]
        grey = find_channel(free, INTENSITY_NAMES)
        found = [find_channel(free, pair) for pair in COLOUR_NAMES]
        colours = [index for index in found if index is not None]
        if grey is None and len(colours) < 3:
            raise ValueError(
                f"{path} has channels {', '.join(names)}, no Y, intensity or R, G, B: "
                "add the intensity"
            )

        def pixels(channel: int) -> NDArray[Any]:
            _, part, index = channels[channel]
            return _read_channel(source, part, index, path)

        colour = None
        if len(colours) == 3:
            rgb = np.stack([pixels(c) for c in colours], axis=2).astype(np.float64)
            # What a renderer's wide gamut leaves negative, or lost, is no hue.
            colour = hue(np.where(np.isfinite(rgb), rgb, 0).clip(0))
        intensity = rgb @ LUMINANCE if grey is None else pixels(grey)
        z = pixels(depth)
        # Nothing was hit, or the pixel is transparent: background, whatever its colour.
        intensity = np.where(np.isfinite(z) & (z >= NO_HIT), 0, intensity)
        alpha = find_channel(names, ALPHA_NAMES)
        if alpha is not None:
            intensity = np.where(pixels(alpha) > 0, intensity, 0)
        object_id = np.zeros(z.shape, np.int32) if identity is None else pixels(identity)
        try:
            frame = RGBDFrame(np.asarray(intensity, dtype=np.float32), z, object_id, colour)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None
        return frame, identity is not None
    finally:
        source.close()


def find_channel(names: Sequence[str], wanted: Sequence[str]) -> int | None:
    """Index of the channel whose name, or else layer, is one of `wanted`.

    Layers called like a picture (`Combined`) come first, then short names. Components of vectors
    (`Normal.Z` beside `Normal.X` and `Normal.Y`) are none.
    """
    parts = [name.lower().replace("/", ".").split(".") for name in names]
    layers: dict[tuple[str, ...], set[str]] = {}
    for part in parts:
        layers.setdefault(tuple(part[:-1]), set()).add(part[-1])
    vectors = {layer for layer, members in layers.items() if layer and {"x", "y"} <= members}

    def ranked(depth: int) -> list[tuple[bool, int, int, int]]:
        """Candidates whose name at `depth` from the end is wanted, the best first."""
        return sorted(
            (PICTURE_LAYERS.isdisjoint(part), len(part), wanted.index(part[-depth]), index)
            for index, part in enumerate(parts)
            if len(part) >= depth
            and part[-depth] in wanted
            and tuple(part[:-1]) not in vectors
            and (depth == 1 or len(part[-1]) == 1)
        )

    # Renderers write a layer's only channel as `view.Depth.V` or `IndexOB.X`.
    found = ranked(1) or ranked(2)
    return found[0][3] if found else None


def _channels(source: Any, path: Path) -> list[tuple[str, int, int]]:
    """(name, part, index) of all channels; names of a part after the first start with its own."""
    channels = []
    part = 0
    while source.seek_subimage(part, 0):
        spec = source.spec()
        for width, height in ((spec.width, spec.height), (spec.full_width, spec.full_height)):
            if width * height > MOST_PIXELS:
                raise ValueError(f"{path} says it has {width} × {height} pixels: shrink it first")
        layer = "" if part == 0 else (spec.getattribute("name") or f"part{part}") + "."
        channels += [(layer + name, part, k) for k, name in enumerate(spec.channelnames)]
        part += 1
    return channels


def _read_channel(source: Any, part: int, index: int, path: Path) -> NDArray[Any]:
    """(H, W) of the display window, in the file's own numbers: a normalised read would scale
    whole numbers."""
    spec = source.spec(part)
    data = source.read_image(part, 0, index, index + 1, str(spec.channelformat(index)))
    if data is None:
        raise OSError(f"{path} is damaged or cut short: {_line(source.geterror())}; write it again")
    data = np.asarray(data).reshape(spec.height, spec.width)
    window = (spec.x - spec.full_x, spec.y - spec.full_y, spec.width, spec.height)
    if window == (0, 0, spec.full_width, spec.full_height):
        return data
    full = np.zeros((spec.full_height, spec.full_width), data.dtype)
    # A data window may also reach past the display window: only their overlap counts.
    x0, y0 = max(window[0], 0), max(window[1], 0)
    x1 = min(window[0] + window[2], spec.full_width)
    y1 = min(window[1] + window[3], spec.full_height)
    if x1 > x0 and y1 > y0:
        full[y0:y1, x0:x1] = data[y0 - window[1] : y1 - window[1], x0 - window[0] : x1 - window[0]]
    return full


def _line(message: str) -> str:
    return " ".join(message.split())[:160] or "no reason given"
