"""In what a stored video is another than the one that is wanted, in words."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from chrmc.ranges import short


def refuse_another(folder: Path, before: Mapping[str, Any], wanted: Mapping[str, Any]) -> None:
    """ValueError that names what differs, unless `before` agrees with all that `wanted` says."""
    # What manifests of before these were written mean without saying it.
    slm = {"kind": wanted["slm"].get("kind"), **before["slm"]} if "slm" in wanted else {}
    whole = {"response": {"name": "linear"}, **before, "slm": slm}
    # What two methods were both given differs once.
    found = list(dict.fromkeys(differences(whole, wanted)))
    if found:
        more = f" and {len(found) - 3} more" if len(found) > 3 else ""
        raise ValueError(
            f"{folder} holds another video ({'; '.join(found[:3])}{more}): choose another --out, "
            "or replace it with --force"
        )


def differences(before: Any, wanted: Any, name: str = "") -> Iterator[str]:
    """What differs, such as "tolerance 0.001, not 0.01"; only what `wanted` says counts."""
    if isinstance(before, Mapping) and isinstance(wanted, Mapping):
        for key, value in wanted.items():
            of = f"{name} " if key == "name" else ""
            yield from differences(before.get(key), value, _WORDS.get(key) or f"{of}{key}")
        if name == "options":
            for key in before.keys() - wanted.keys():
                yield f"{key} {short(before[key])}, not given"
    elif before != wanted:
        if name in _WORDS.values():
            yield f"{name} differ"
        else:
            yield f"{name} {_said(name, before)}, not {_said(name, wanted)}"


_WORDS = {"fingerprint": "the scene's points", "spot_check": "the scene's points"}


_UNITS = {"wavelength": (1e9, "nm"), "pixel_pitch": (1e6, "um")}


def _said(name: str, value: Any) -> str:
    if name in _UNITS and isinstance(value, float):
        per_metre, unit = _UNITS[name]
        return f"{per_metre * value:.9g}{unit}"
    return value if isinstance(value, str) and len(value) <= 60 else short(value)
