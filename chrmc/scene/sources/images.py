"""Samples of a picture file as they are, through OpenImageIO."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from chrmc.pictures import opened


def read_samples(path: Path) -> NDArray[np.unsignedinteger]:
    """(H, W, C) of 8 or 16 bits; OSError or ValueError in one line."""
    with opened(path) as source:
        spec = source.spec()
        kind = "uint16" if str(spec.format) == "uint16" else "uint8"
        pixels = source.read_image(kind)
        if pixels is None:
            error = " ".join(source.geterror().split())[:160]
            raise OSError(f"{path} is damaged or cut short: {error}")
    return np.asarray(pixels).reshape(spec.height, spec.width, spec.nchannels)
