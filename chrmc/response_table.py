"""Measured grey responses, as instruments and spreadsheets write them.

A text table with a line of column names: grey (or gray, level, index …), beside intensity (power,
counts …) in any unit, or amplitude with or without phase. Parted by commas, semicolons, tabs or
blanks; decimal commas where semicolons or tabs part; lines before the names and lines that start
with #, % or // are passed over, but for "# wavelength 638 nm", the laser it was measured with.
"""

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from chrmc.ranges import WAVELENGTH_RANGE
from chrmc.response_map import TERMS

LARGEST = 1 << 20
"""Bytes that a table may have; 256 rows take some 10 kB."""
SMOOTHED = 0.03
"""Share of the full range that a reading may be moved by to make the table monotone: more than the
noise of a power meter, less than a real turn of the curve."""
LAST_STEP = 16
"""Grey levels at either end that a table may leave out; the curve goes on straight there."""
_NAMES = {
    "grey": r"(gr[ea]y|gl\b|level|index|value$|input)",
    "intensity": r"(intensity|power|counts?\b|irradiance|brightness|luminance|signal|i$|p$)",
    "amplitude": r"(amplitude|modulus|amp$)",
    "phase": r"(phase|phi$)",
}


def read_table(path: str | Path) -> tuple[NDArray[np.float64], NDArray[np.complex128], float]:
    """Grey (n,), complex amplitude (n,) and how far readings were moved, a share of the range.

    Raises OSError for no file, ValueError in one line for a bad one.
    """
    source = Path(path)
    columns, head = _columns(source)
    grey = np.array(columns["grey"])
    power = "intensity" in columns
    values = np.array(columns["intensity" if power else "amplitude"])
    moved = 0.0
    if "phase" not in columns and len(values) > 2 and np.isfinite(values).all():
        values, moved = monotone(values)
    if power:
        low = -SMOOTHED * float(np.max(values, initial=0.0))
        if (values < low).any():
            raise ValueError(f"{source}: negative intensity; subtract less dark current")
        values = np.sqrt(np.maximum(values, 0))
    amplitude = values + 0j
    if "phase" in columns:
        turn = np.array(columns["phase"])
        degrees = "deg" in head["phase"].lower()
        amplitude = amplitude * np.exp(1j * (np.radians(turn) if degrees else turn))
    return grey, amplitude, moved


def read_readings(path: str | Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Grey (n,) and intensity (n,) as they were read: any order, levels as often as they come."""
    columns, _ = _columns(Path(path))
    if "intensity" not in columns:
        raise ValueError(f"{path}: readings need the columns grey,intensity")
    return np.array(columns["grey"]), np.array(columns["intensity"])


def read_tilt(path: str | Path) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Grey (n,) and the map's terms (n, 2 or 5), in the table's unit of intensity; None without."""
    columns, _ = _columns(Path(path))
    terms = [name for name in TERMS if name in columns]
    if not terms:
        return None
    if "intensity" not in columns or len(terms) not in (2, 5):
        raise ValueError(f"{path}: a map has the columns intensity and {', '.join(TERMS)}")
    return np.array(columns["grey"]), np.array([columns[name] for name in terms]).T


def read_wavelength(path: str | Path) -> float | None:
    """Metres, of the laser that a table names in a line such as "# wavelength 638 nm"; None where
    it names none."""
    for line in _text(Path(path)).splitlines()[:60]:
        match = re.match(r"\s*(?:#|%|//)\s*wavelength\W*([\d.]+)\s*nm\b", line, re.IGNORECASE)
        if match:
            try:
                return WAVELENGTH_RANGE.of(float(match[1]) * 1e-9)
            except ValueError as error:
                raise ValueError(f"{path}: {error}") from None
    return None


def _columns(source: Path) -> tuple[dict[str, list[float]], dict[str, str]]:
    """The columns that are known, and their headings."""
    lines = [line for line in map(str.strip, _text(source).splitlines()) if line]
    lines = [line for line in lines if not line.startswith(("#", "%", "//"))]
    start = next(
        (i for i, line in enumerate(lines[:60]) if _is_head(_cells(line, _sign(line)))), None
    )
    if start is None:
        first = lines[0][:60] if lines else "nothing"
        raise ValueError(
            f"{source}: first line must name the columns grey,intensity or "
            f"grey,amplitude[,phase], not {first}"
        )
    sign = _sign(lines[start])
    head = _cells(lines[start], sign)
    names = [_name(cell) for cell in head]
    columns: dict[str, list[float]] = {name: [] for name in names if name}
    for count, line in enumerate(lines[start + 1 :], start + 2):
        try:
            for name, cell in zip(names, _cells(line, sign), strict=True):
                if name:
                    columns[name].append(_number(cell))
        except ValueError:
            raise ValueError(f"{source}, row {count}: {line[:60]} is not a table row") from None
    return columns, {name: text for name, text in zip(names, head, strict=True) if name}


def monotone(values: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """The nearest monotone values (isotonic regression), rising or falling as the ends do, and the
    largest move as a share of their range; unchanged where the move would pass `SMOOTHED`."""
    from scipy.optimize import isotonic_regression

    size = float(np.ptp(values))
    if not size > 0:
        return values, 0.0
    smooth = isotonic_regression(values, increasing=bool(values[-1] >= values[0])).x
    moved = float(np.abs(smooth - values).max()) / size
    return (smooth, moved) if moved <= SMOOTHED else (values, 0.0)


def to_both_ends(
    grey: NDArray[np.float64], values: NDArray[np.complex128], last: int
) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """The table with rows at grey 0 and `last`, on the straight line through the two rows beside,
    where no more than `LAST_STEP` levels are missing there."""
    if len(grey) < 3 or (np.diff(grey) <= 0).any():
        return grey, values
    for at, near, end in ((0, 1, 0.0), (-1, -2, float(last))):
        missing = abs(grey[at] - end)
        if 0 < missing <= min(LAST_STEP, 2 * abs(grey[at] - grey[near])) and 0 <= grey[at] <= last:
            slope = (values[at] - values[near]) / (grey[at] - grey[near])
            # An amplitude does not fall through zero.
            beyond = values[at] + slope * (end - grey[at])
            if (beyond * np.conj(values[at])).real < 0:
                beyond = 0j * beyond
            place = 0 if at == 0 else len(grey)
            grey, values = np.insert(grey, place, end), np.insert(values, place, beyond)
    return grey, values


def _text(source: Path) -> str:
    """The file's text; a device, a pipe or a huge file is not read."""
    if not source.exists():
        raise FileNotFoundError(f"{source} is missing: a response table is a text file")
    if not source.is_file():
        raise ValueError(f"{source} is not a file: a response table is a text file")
    if source.stat().st_size > LARGEST:
        raise ValueError(
            f"{source} has {source.stat().st_size / 1e6:.1f} MB; a response table has 256 rows"
        )
    data = source.read_bytes()
    codings = ("utf-16",) if data[:2] in (b"\xff\xfe", b"\xfe\xff") else ("utf-8-sig", "cp1252")
    for coding in codings:
        try:
            text = data.decode(coding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    raise ValueError(f"{source} is not a text file: a CSV table is needed")


def _sign(line: str) -> str | None:
    """What parts a line's cells; None for blanks."""
    return next((sign for sign in ";\t," if sign in line), None)


def _cells(line: str, sign: str | None) -> list[str]:
    cells = line.rstrip(sign).split(sign) if sign in (";", "\t") else line.split(sign)
    return [cell.strip().strip('"') for cell in cells]


def _number(cell: str) -> float:
    """A number, with a point or a comma before its decimals."""
    return float(cell.replace(",", "."))


def _name(cell: str) -> str:
    """The column that a heading means, "" for others."""
    text = re.sub(r"[(\[].*", "", cell.strip().lower()).replace("_", " ").strip()
    if text in TERMS:
        return text
    return next((name for name, form in _NAMES.items() if re.search(form, text)), "")


def _is_head(row: list[str]) -> bool:
    names = [name for name in map(_name, row) if name]
    return (
        "grey" in names
        and bool({"intensity", "amplitude"} & set(names))
        and (len(names) == len(set(names)))
    )
