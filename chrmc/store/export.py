"""A complex field for other programs: NumPy, OpenEXR or HDF5, by the file's suffix."""

from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.files import replacing
from chrmc.ranges import WAVELENGTH_RANGE
from chrmc.slm import SLM


def export_field(
    field: NDArray[np.complexfloating],
    path: str | PathLike[str],
    *,
    slm: SLM | None = None,
    wavelength: float | None = None,
) -> Path:
    """Write a field, whole or not at all.

    field : (H, W) complex
    path : ".npy" (complex as it is), ".exr" (float32 channels "real" and "imag"), or ".h5" and
        ".hdf5" (a dataset "field"; needs h5py)
    slm, wavelength : written beside it as pixel_pitch and wavelength, metres (not into ".npy")

    Returns the path. Raises ValueError for what is no field or another suffix, OSError where it
    cannot be written.
    """
    array, target = np.asarray(field), Path(path)
    if array.ndim != 2 or not np.iscomplexobj(array):
        raise ValueError(f"a field is (H, W) complex, not {array.dtype} {array.shape}")
    notes: dict[str, float] = {}
    if slm is not None:
        notes["pixel_pitch"] = slm.pixel_pitch
    if wavelength is not None:
        notes["wavelength"] = WAVELENGTH_RANGE.of(wavelength)
    writers = {".npy": _npy, ".exr": _exr, ".h5": _hdf5, ".hdf5": _hdf5}
    write = writers.get(target.suffix.lower())
    if write is None:
        raise ValueError(f"{target}: a field is written as .npy, .exr, .h5 or .hdf5")
    with replacing(target) as partial:
        write(array, partial, notes)
    return target


def _npy(field: NDArray[Any], path: Path, notes: dict[str, float]) -> None:
    with path.open("wb") as file:
        np.save(file, field)


def _exr(field: NDArray[Any], path: Path, notes: dict[str, float]) -> None:
    import OpenImageIO as oiio

    spec = oiio.ImageSpec(field.shape[1], field.shape[0], 2, "float")
    spec.channelnames = ("real", "imag")
    spec.attribute("compression", "zip")
    for name, value in notes.items():
        spec.attribute(name, f"{value!r}")  # as text: numbers would be cut to single precision
    out = oiio.ImageOutput.create(str(path))
    if out is None or not out.open(str(path), spec):
        raise OSError(f"{path}: {oiio.geterror() if out is None else out.geterror()}")
    pixels = np.stack([field.real, field.imag], axis=-1).astype(np.float32)
    written = out.write_image(np.ascontiguousarray(pixels))
    closed = out.close()
    if not (written and closed):
        raise OSError(f"{path}: {out.geterror()}")


def _hdf5(field: NDArray[Any], path: Path, notes: dict[str, float]) -> None:
    try:
        import h5py
    except ImportError:
        raise ImportError(f"{path.suffix} files need h5py: pip install h5py") from None
    with h5py.File(path, "w") as file:
        data = file.create_dataset("field", data=field)
        data.attrs.update(notes)
