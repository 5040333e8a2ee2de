"""Pictures through OpenImageIO, with every return value looked at: the one place that opens
and writes them, and the reader of 8-bit grey ones."""

import errno
import os
import zlib
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from shutil import disk_usage
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.files import replacing


def write_pixels(
    path: Path,
    pixels: NDArray[Any],
    kind: str,
    names: Sequence[str] = (),
    kinds: Sequence[str] = (),
    attributes: Mapping[str, str] | None = None,
    *,
    new_folder: bool = True,
) -> None:
    """Write (h, w, channels) samples by the suffix, whole or not at all; OSError when it fails.

    kind : of the samples, "uint8", "uint16" or "float"
    names, kinds : of each channel in the file, where they are not the format's own and `kind`
    attributes : metadata, such as ImageDescription
    """
    import OpenImageIO as oiio

    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, kind)
    if names:
        spec.channelnames = tuple(names)
    if kinds:
        spec.channelformats = tuple(kinds)
    for name, value in (attributes or {}).items():
        spec.attribute(name, value)

    def write(partial: Path) -> None:
        out = oiio.ImageOutput.create(file_name(partial))
        if out is None:
            raise OSError(f"{path}: no writer for this kind of file; use .tif, .png or .exr")
        if not out.open(file_name(partial), spec):
            raise OSError(f"{path}: {_line(out.geterror())}")
        written = out.write_image(np.ascontiguousarray(pixels))
        closed = out.close()
        # The EXR writer says nothing of a disk that is full when the file is closed.
        if written and closed and (path.suffix.lower() != ".exr" or _whole(partial)):
            return
        if disk_usage(path.parent).free < pixels.nbytes:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
        raise OSError(f"{path}: {_line(out.geterror()) or 'could not be written whole'}")

    # Signals are the main thread's: libpng prints a line of its own where one comes after a file is
    # opened and before it has pixels.
    with replacing(path, new_folder=new_folder) as partial, ThreadPoolExecutor(1) as writer:
        writer.submit(write, partial).result()


def _whole(path: Path) -> bool:
    """Whether a picture can be read to its end."""
    import OpenImageIO as oiio

    source = oiio.ImageInput.open(file_name(path))
    if source is None:
        oiio.geterror()
        return False
    pixels = source.read_image()
    source.close()
    return pixels is not None


def file_name(path: Path) -> str:
    """A path as OpenImageIO takes it; OSError for bytes that are no text, which it cannot name."""
    name = str(path)
    try:
        name.encode()
    except UnicodeEncodeError:
        raise OSError(f"{name!a}: the name is no text in UTF-8; rename it") from None
    return name


def _line(text: str) -> str:
    return " ".join(text.split())


def write_grey(path: Path, levels: NDArray[np.uint8], *, new_folder: bool = True) -> None:
    """Write (H, W) uint8 as TIFF (uncompressed) or PNG, by the suffix; OSError when it fails."""
    if levels.dtype != np.uint8 or levels.ndim != 2:
        raise ValueError(f"{path.name}: grey levels must be (H, W) uint8, not {levels.dtype}")
    attributes = {}
    if path.suffix in (".tif", ".tiff"):
        # The writer would put the present time: equal frames must be equal files.
        attributes = {"compression": "none", "DateTime": "2000:01:01 00:00:00"}
    # (H, W, 1): a 2-D array is taken for something else and written scrambled.
    write_pixels(path, levels[:, :, None], "uint8", attributes=attributes, new_folder=new_folder)


MOST_PIXELS = 1 << 28
"""Of a picture, in all its channels: a header may claim any size, and memory is given on its
word."""
_PNG = b"\x89PNG\r\n\x1a\n"


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """A picture's OpenImageIO reader, closed in the end; OSError, or ValueError for one that is too
    large, in one line."""
    import OpenImageIO as oiio

    if not path.is_file():
        raise FileNotFoundError(f"{path} is missing")
    _check_png(path)
    source = oiio.ImageInput.open(file_name(path))
    if source is None:
        raise OSError(f"{path} cannot be read: {_line(oiio.geterror())[:160]}")
    try:
        spec = source.spec()
        if spec.width * spec.height * max(1, spec.depth) * spec.nchannels > MOST_PIXELS:
            raise ValueError(f"{path} has {spec.width} × {spec.height} pixels: shrink it first")
        yield source
    finally:
        source.close()


def _check_png(path: Path) -> None:
    """OSError for a PNG that is damaged or cut short, of which libpng would print lines of its own:
    every part of the file holds its checksum."""
    size = path.stat().st_size
    with path.open("rb") as file:
        kind = b"" if file.read(len(_PNG)) == _PNG else b"IEND"
        while kind != b"IEND":
            head = file.read(8)
            kind = head[4:]
            body = file.read(min(int.from_bytes(head[:4], "big"), size))
            if file.read(4) != zlib.crc32(body, zlib.crc32(kind)).to_bytes(4, "big"):
                raise OSError(f"{path} is damaged or cut short: write it again")


def read_grey(path: Path, shape: tuple[int, int] | None = None) -> NDArray[np.uint8]:
    """(H, W) uint8 of an 8-bit picture that is grey; OSError or ValueError in one line.

    shape : what it must have, looked at before anything is decoded
    """
    with opened(path) as source:
        spec = source.spec()
        if shape is not None and (spec.height, spec.width) != shape:
            raise ValueError(
                f"{path} is {spec.width} × {spec.height} pixels; {shape[1]} × {shape[0]} are needed"
            )
        if str(spec.format) != "uint8":
            raise ValueError(f"{path} holds {spec.format} samples; 8-bit grey levels are needed")
        pixels = source.read_image(format="uint8")
        if pixels is None:
            # A decoder may complain of every strip: the first complaint tells.
            complaint = (source.geterror().strip().splitlines() or ["it cannot be decoded"])[0]
            raise OSError(f"{path} is damaged: {complaint}")
    levels = np.asarray(pixels, dtype=np.uint8).reshape(spec.height, spec.width, spec.nchannels)
    colours = levels[:, :, : min(3, spec.nchannels)] if spec.nchannels != 2 else levels[:, :, :1]
    if not (colours == colours[:, :, :1]).all():
        raise ValueError(f"{path} is a colour picture; an amplitude SLM needs a grey one")
    return np.ascontiguousarray(colours[:, :, 0])
