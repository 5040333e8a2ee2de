"""Point clouds: XYZ, CSV and NPZ (PLY comes through the mesh reader)."""

import csv
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.colour import LUMINANCE, hue, linear
from chrmc.files import read_text
from chrmc.scene.points import PointCloud
from chrmc.scene.sources.model import Model, only_line

SEED = 20180917
"""Of random phases where a file has none."""
AXES = ("x", "y", "z")
NAMES = {
    "amplitude": ("amplitude", "amp", "a"),
    "intensity": ("intensity", "i", "grey", "gray"),
    "phase": ("phase", "phi"),
}
"""What columns are called."""
MOST_EMPTY = 100
"""Cells of a table for each that is there: one long row would make room for as many in all."""
MOST_BYTES = 1 << 31
"""Of the arrays of an .npz: some megabytes may unpack to any size."""
_COLOURS = (("r", "red"), ("g", "green"), ("b", "blue"))


def cloud_of(
    positions: Any,
    intensity: Any = None,
    *,
    amplitude: Any = None,
    phase: Any = None,
    colour: Any = None,
) -> PointCloud:
    """Points whose missing amplitudes are 1 and whose missing phases are random.

    positions : (N, 3); intensity, amplitude : (N,) ≥ 0; phase : (N,) radians
    colour : (N, 3) sRGB 0 … 1, whose luminance is the intensity where none is given
    """
    place = _real("positions", positions).reshape(-1, 3)
    finite = np.asarray(np.isfinite(place).all(axis=1))
    shown = None
    if colour is not None:
        srgb = np.nan_to_num(_real("colours", colour))
        if srgb.size and not (srgb.min() >= 0 and srgb.max() <= 1):
            raise ValueError(
                f"colours run from {srgb.min():g} to {srgb.max():g}; they are 0 to 1, or 0 to 255"
            )
        rgb = linear(srgb)
        shown = hue(rgb)
        intensity = rgb @ LUMINANCE if intensity is None else intensity
    if amplitude is None:
        light = np.ones(len(place)) if intensity is None else _real("intensity", intensity)
        if (light < 0).any():
            raise ValueError(f"intensity is negative (down to {light.min():.4g})")
        amplitude = np.sqrt(light)
    if phase is None:
        phase = np.random.default_rng(SEED).uniform(0, 2 * np.pi, len(place))
    cloud = PointCloud(np.where(finite[:, None], place, 0), amplitude, phase, shown)
    return cloud if finite.all() else cloud.select(finite)


def _real(name: str, values: Any) -> NDArray[np.float64]:
    """Real numbers as float64, be they NaN; ValueError for others."""
    array = np.asarray(values)
    if array.dtype.kind not in "fiub":
        raise ValueError(f"{name} are {array.dtype}: real numbers are needed")
    with np.errstate(over="ignore"):
        return array.astype(np.float64, copy=False)


def read_cloud(path: Path) -> Model:
    """A cloud as columns x, y, z and more, or an .npz with `positions`.

    Columns go by a header's names (x y z, amplitude or intensity, r g b, phase), else by their
    number: x y z, x y z intensity, x y z r g b. Lines of NaN are left out, and counted.
    """
    if not path.is_file():
        raise FileNotFoundError(f"{path} is missing")
    names, table = read_table(path)
    column = _columns(path, names, table.shape[1])
    place = table[:, [column[a] for a in AXES]]
    finite = np.isfinite(table[:, sorted(set(column.values()))]).all(axis=1)
    notes: tuple[str, ...] = ()
    if not finite.all():
        notes = (f"{path.name}: {(~finite).sum()} lines without all numbers left out",)
        table, place = table[finite], place[finite]
    if not len(table):
        raise ValueError(f"{path} holds no point; write lines of x y z")
    light: dict[str, Any] = {
        k: table[:, column[k]] for k in ("amplitude", "intensity", "phase") if k in column
    }
    if "red" in column:
        colour = table[:, [column[c] for c in ("red", "green", "blue")]]
        light["colour"] = colour / (255 if colour.max() > 1 else 1)
    try:
        return Model({path.stem: cloud_of(place, **light)}, notes=notes)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def read_table(path: Path) -> tuple[list[str], NDArray[np.float64]]:
    """Names of the columns, if there, and (N, K) numbers; NaN where there is none."""
    text = read_text(path)
    lines = [line for line in text.splitlines() if line.strip() and line.lstrip()[0] not in "#%"]
    if not lines:
        raise ValueError(f"{path} holds no point; write lines of x y z")
    if len(lines) > 1 and lines[0].strip().isdecimal() and len(lines) - 1 >= int(lines[0]):
        lines = lines[1:]  # a count of points, as some programs begin their .xyz
    try:
        rows = _split(lines)
    except csv.Error as error:
        raise ValueError(f"{path} is no table: {error}") from None
    names: list[str] = []
    if any(_number(word) is None for word in rows[0][:3]):
        names = [word.strip().lower() for word in rows[0]]
        rows = rows[1:]
    width = len(names) or max((len(r) for r in rows), default=0)
    if len(rows) * width > MOST_EMPTY * (1 + sum(map(len, rows))):
        raise ValueError(f"{path} has a row of {width} columns where others have few: mend it")
    table = np.full((len(rows), width), np.nan)
    for k, row in enumerate(rows):
        for c, word in enumerate(row[:width]):
            value = _number(word)
            if value is not None:
                table[k, c] = value
    return names, table


def _split(lines: list[str]) -> list[list[str]]:
    for sign in ("\t", ";", ","):
        if sign in lines[0]:
            return [row for row in csv.reader(lines, delimiter=sign) if row]
    return [line.split() for line in lines]


def _number(word: str) -> float | None:
    try:
        return float(word)
    except ValueError:
        return None


def _columns(path: Path, names: list[str], width: int) -> dict[str, int]:
    """What stands in which column."""
    if not names:
        order = {3: "xyz", 4: "xyzi", 6: "xyzrgb"}.get(width)
        if order is None:
            raise ValueError(
                f"{path} has {width} columns and no header: give it one (x,y,z,amplitude,phase), "
                "or write x y z, x y z intensity or x y z r g b"
            )
        long = {"i": "intensity", "r": "red", "g": "green", "b": "blue"}
        return {long.get(c, c): k for k, c in enumerate(order)}
    column = {a: names.index(a) for a in AXES if a in names}
    if len(column) < 3:
        raise ValueError(f"{path} has columns {', '.join(names)}; x, y and z are needed")
    for key, called in NAMES.items():
        find_column(column, names, key, called)
    colours = [next((names.index(c) for c in pair if c in names), None) for pair in _COLOURS]
    if None not in colours:
        column.update(zip(("red", "green", "blue"), (c or 0 for c in colours), strict=True))
    return column


def find_column(
    column: dict[str, Any], names: list[str], key: str, called: tuple[str, ...]
) -> None:
    """Note the column of the first name that is there."""
    for name in called:
        if name in names:
            column[key] = names.index(name)
            return


def read_npz(path: Path) -> Model:
    """Positions (N, 3), and amplitude or intensity, sRGB colors and phase, if they are there."""
    arrays = load_arrays(path)
    if "positions" not in arrays:
        raise ValueError(f"{path} holds {', '.join(arrays) or 'nothing'}; positions are needed")
    light: dict[str, Any] = {
        k: arrays[k] for k in ("amplitude", "intensity", "phase") if k in arrays
    }
    if "amplitude" in light:
        light.pop("intensity", None)
    shown = next((k for k in ("colors", "colours") if k in arrays), None)
    try:
        if shown is not None:
            colour = _real("colours", arrays[shown])[:, :3]
            light["colour"] = colour / (255 if colour.max(initial=0) > 1 else 1)
        return Model({path.stem: cloud_of(arrays["positions"], **light)})
    except (ValueError, IndexError) as error:
        raise ValueError(f"{path}: {only_line(error)}") from None


def load_arrays(path: Path) -> dict[str, NDArray[Any]]:
    """All arrays of an .npz; OSError in one line."""
    if not path.is_file():
        raise FileNotFoundError(f"{path} is missing")
    try:
        # NumPy leaves a file open that it opened and cannot read.
        with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
            size = sum(part.file_size for part in stored.zip.infolist())
            if size > MOST_BYTES:
                raise OSError(
                    f"it unpacks to {size / 1e9:.1f} GB, more than {MOST_BYTES / 1e9:.1f}"
                )
            return {name: stored[name] for name in stored.files}
    except Exception as error:  # zip, header and pickle errors alike
        raise OSError(f"{path} cannot be read as .npz ({only_line(error)})") from None
