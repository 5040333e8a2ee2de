"""Panels by name: those shipped here, those in the user's folder, and TOML files.

A panel's file says what its data sheet says:

    name = "my panel"
    width = 1920            # pixels
    height = 1080
    pixel_pitch = 8e-6      # metres
    bits = 8                # optional, as are refresh (Hz) and fill_factor (0 to 1)
    kind = "amplitude"      # optional: "amplitude", "binary" or "phase"
    response = "grey.csv"   # optional: its measured grey response, beside this file
    source = "data sheet of 2024"
"""

import os
import sys
from dataclasses import dataclass, fields
from pathlib import Path

from chrmc.files import read_toml
from chrmc.slm import LC_R_1080, SLM


@dataclass(frozen=True)
class Panel:
    """A panel and where its figures come from.

    source : what names the figures
    unconfirmed : figures that it does not name, such as "refresh"
    response : table of its measured grey response, or None
    """

    slm: SLM
    source: str
    unconfirmed: tuple[str, ...] = ()
    response: Path | None = None


ENCODINGS = {
    "amplitude": ("ssb", "real", "bipolar", "burch", "offaxis", "error-diffusion", "lee"),
    "binary": ("error-diffusion", "lee"),
    "phase": ("double-phase", "kinoform"),
}
"""What a kind of panel can show, the usual one first."""
PANELS = {
    "lc-r-1080": Panel(
        LC_R_1080, "the CH-RMC paper's section on its experiment", ("refresh", "fill factor")
    ),
    "pluto": Panel(
        SLM("HOLOEYE PLUTO-2.1", 1920, 1080, 8e-6, 8, 60.0, 0.93, "phase"),
        "size and pitch: the class PLUTO_2 of the package pySLM2",
        ("bits", "refresh", "fill factor"),
    ),
    "leto": Panel(
        SLM("HOLOEYE LETO-3", 1920, 1080, 6.4e-6, 8, 60.0, 0.93, "phase"),
        "size, pitch and bits: a laboratory's driver (slmutils, of the LETO-II)",
        ("the LETO-3's figures", "refresh", "fill factor"),
    ),
    "p1920": Panel(
        SLM("Meadowlark 1920 × 1152", 1920, 1152, 9.2e-6, 8, 60.0, kind="phase"),
        "size: Meadowlark's press release of 2016, with up to 500 Hz; pitch: a laboratory's code "
        "(10.7 mm over 1152 rows in another, which cites the data sheet)",
        ("bits", "refresh of its video input", "fill factor"),
    ),
    "x15213": Panel(
        SLM("Hamamatsu LCOS-SLM X15213", 1272, 1024, 12.5e-6, 8, 60.0, kind="phase"),
        "size, pitch and bits: slmsuite's driver; LidkeLab's matlab-instrument-control agrees",
        ("refresh", "fill factor"),
    ),
    "slm-200": Panel(
        SLM("Santec SLM-200", 1920, 1200, 8e-6, 10, 60.0, kind="phase"),
        "size and bits: Santec's programmer's guide 2.5, whose library converts to 10 bit on the "
        "way to the panel; pitch: slmsuite's driver",
        ("refresh (there is a model of 120 Hz)", "fill factor", "grey frames of a plain monitor"),
    ),
    "dlp4710": Panel(
        SLM("TI DLP4710", 1920, 1080, 5.4e-6, 1, kind="binary"),
        "size and pitch: the package mcsim",
        ("refresh of its video input", "fill factor"),
    ),
    "dlp6500": Panel(
        SLM("TI DLP6500", 1920, 1080, 7.56e-6, 1, kind="binary"),
        "size and pitch: the package mcsim",
        ("refresh of its video input", "fill factor"),
    ),
    "dlp7000": Panel(
        SLM("TI DLP7000", 1024, 768, 13.68e-6, 1, kind="binary"),
        "size and pitch: the package mcsim; size: ViALUX's header of ALP",
        ("refresh of its video input", "fill factor"),
    ),
    "dlp9500": Panel(
        SLM("TI DLP9500", 1920, 1080, 10.8e-6, 1, kind="binary"),
        "size and pitch: the package pySLM2; size: ViALUX's header of ALP",
        ("refresh of its video input", "fill factor"),
    ),
}
"""Makers' own data sheets were not at hand: compare with yours. What no source names is a usual
value."""

_KEYS = (*(f.name for f in fields(SLM)), "source", "response")


def encoding_for(slm: SLM, asked: str | None = None) -> str:
    """The encoding to take on a panel: the one asked for, else the usual one of its kind.

    ValueError for one that the panel cannot show; one of unknown kind is taken for one of amplitude
    that shows anything.
    """
    if slm.kind is None:
        return asked or ENCODINGS["amplitude"][0]
    able = ENCODINGS[slm.kind]
    if asked is not None and asked not in able:
        raise ValueError(
            f"{slm.name} is a panel of kind {slm.kind}, which shows {', '.join(able)}, not {asked}"
        )
    return asked or able[0]


def user_folder() -> Path:
    """Where a user's own panels lie, as NAME.toml."""
    home = Path(os.path.expanduser("~"))  # noqa: PTH111 - a user of a container may have none
    if sys.platform == "win32":
        base = Path(os.environ.get("APPDATA", home))
    elif sys.platform == "darwin":
        base = home / "Library" / "Application Support"
    else:
        base = Path(os.environ.get("XDG_CONFIG_HOME") or home / ".config")
    return base / "chrmc" / "panels"


def all_panels() -> dict[str, Panel | str]:
    """Shipped and own panels by name; a complaint in place of a file that cannot be read."""
    found: dict[str, Panel | str] = dict(PANELS)
    folder = user_folder()
    for path in sorted(folder.glob("*.toml")) if folder.is_dir() else []:
        try:
            found[path.stem.lower()] = read_panel(path)
        except (OSError, ValueError) as error:
            found[path.stem.lower()] = str(error)
    return found


def panel_named(text: str) -> Panel | None:
    """The panel of a name or of a TOML file; None for something else.

    Raises OSError or ValueError for a file that is missing or wrong.
    """
    if text.lower().endswith(".toml"):
        return read_panel(Path(text))
    name = text.strip().lower()
    if name in PANELS:
        return PANELS[name]
    path = user_folder() / f"{name}.toml"
    if name.replace("-", "").replace("_", "").isalnum() and path.is_file():
        return read_panel(path)
    return None


def read_panel(path: Path) -> Panel:
    """The panel of a TOML file; OSError or ValueError, in one line, for a bad one."""
    values = read_toml(path)
    unknown = [key for key in values if key not in _KEYS]
    if unknown:
        raise ValueError(f"{path}: no such key {unknown[0]!r}; a panel has {', '.join(_KEYS)}")
    missing = [key for key in ("width", "height", "pixel_pitch") if key not in values]
    if missing:
        raise ValueError(f"{path}: {missing[0]} is missing")
    values.setdefault("kind", "amplitude")
    if values["kind"] == "binary":
        values.setdefault("bits", 1)
    source = str(values.pop("source", path))
    response = values.pop("response", None)
    if response is not None:
        if not isinstance(response, str) or not (path.parent / response).is_file():
            raise ValueError(f"{path}: response names no file: {response!r}")
        response = path.parent / response
    name = values.pop("name", path.stem)
    if not isinstance(name, str) or not name.strip():
        raise ValueError(f"{path}: name must be text")
    try:
        return Panel(SLM(name, **values), source, (), response)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{path}: {error}") from None
