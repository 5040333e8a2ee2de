"""A complex field for other programs: NumPy, OpenEXR or HDF5, by the file's suffix."""

from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.files import replacing
from chrmc.pictures import write_pixels
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
    write(array, target, notes)
    return target


def _npy(field: NDArray[Any], path: Path, notes: dict[str, float]) -> None:
    with replacing(path) as partial, partial.open("wb") as file:
        np.save(file, field)


def _exr(field: NDArray[Any], path: Path, notes: dict[str, float]) -> None:
    pixels = np.stack([field.real, field.imag], axis=-1).astype(np.float32)
    # As text: numbers would be cut to single precision.
    attributes = {name: repr(value) for name, value in notes.items()}
    attributes["compression"] = "zip"
    write_pixels(path, pixels, "float", ("real", "imag"), attributes=attributes)


def _hdf5(field: NDArray[Any], path: Path, notes: dict[str, float]) -> None:
    try:
        import h5py
    except ImportError:
        raise ImportError(f"{path.suffix} files need h5py: pip install h5py") from None
    with replacing(path) as partial, h5py.File(partial, "w") as file:
        data = file.create_dataset("field", data=field)
        data.attrs.update(notes)
