"""A manifest's content, checked in one place: types, ranges, and nothing outside its folder."""

import re
from collections.abc import Mapping
from dataclasses import asdict, fields
from math import isfinite
from types import UnionType
from typing import Any, get_origin

from chrmc.encoding import CODINGS
from chrmc.ranges import WAVELENGTH_RANGE, Count, Range, real, short
from chrmc.record import FrameRecord
from chrmc.response import GreyResponse
from chrmc.slm import SLM

FORMAT = 1
SCENE_PITCH = Range("the scene's pixel_pitch", 1e-9, 10.0)
SCALE = Range("scale", 1e-22, 1e15, unit="")
"""Amplitude that fills the grey range: what that comes to in a focus fits single precision."""
POWER = Range("an object's power", 0.0, 1e60, unit="")
FRAME = Count("frame number", 1, 10**9)
GROUP = Count("group", 1, 10**9)
MANY = 10**18
"""No frame takes more points, or points times pixels."""
_SUFFIXES = (".tif", ".tiff", ".png")


def checked(content: Any) -> dict[str, Any]:
    """The manifest with Python's plain types; ValueError names what is missing or wrong.

    Keys that are not known here are kept as they are.
    """
    manifest = _mapping("it", content)
    if manifest.get("format") != FORMAT:
        raise ValueError(f"it has format {short(manifest.get('format'))}; this version reads 1")
    slm = _mapping("slm", _needed(manifest, "slm"))
    unknown = sorted(set(slm) - {f.name for f in fields(SLM)})
    if unknown or not {"name", "width", "height", "pixel_pitch"} <= set(slm):
        raise ValueError("slm must have name, width, height, pixel_pitch and what else an SLM has")
    scene = _mapping("scene", _needed(manifest, "scene"))
    encoding = _needed(manifest, "encoding")
    if not (isinstance(encoding, str) and encoding in CODINGS):
        raise ValueError(f"encoding {short(encoding)} is none of {', '.join(CODINGS)}")
    made_on = manifest.get("made_on", [])
    if not isinstance(made_on, list) or len(made_on) > 10_000:
        raise ValueError(f"made_on must be a list of machines, not {short(made_on)}")
    frames = _needed(manifest, "frames")
    if not isinstance(frames, list):
        raise ValueError(f"frames must be a list, not {short(frames)}")
    checked_frames = [checked_frame(entry) for entry in frames]
    numbers = [entry["number"] for entry in checked_frames]
    if len(set(numbers)) != len(numbers):
        raise ValueError("a frame is listed twice")
    known = {
        **manifest,
        "slm": SLM(**{**slm, "name": _text("slm's name", slm["name"])}),
        "wavelength": WAVELENGTH_RANGE.of(_needed(manifest, "wavelength")),
        "scene": {
            **scene,
            "name": _text("the scene's name", scene.get("name", "")),
            "form": _text("the scene's form", scene.get("form", "points")),
            "pixel_pitch": SCENE_PITCH.of(_needed(scene, "pixel_pitch")),
        },
        "methods": _methods(_needed(manifest, "methods")),
        "scale": SCALE.of(_needed(manifest, "scale")),
        "group": GROUP.of(manifest.get("group", GROUP.high)),
        "response": _response(manifest.get("response")),
        "frames": sorted(checked_frames, key=lambda entry: int(entry["number"])),
    }
    for key, value in known.items():
        _finite(key, value)
    return known


def _finite(name: str, value: Any) -> None:
    """ValueError for NaN and infinity anywhere in a value: JSON has neither."""
    if isinstance(value, dict):
        for key, entry in value.items():
            _finite(f"{name}: {short(key)}", entry)
    elif isinstance(value, list):
        for entry in value:
            _finite(name, entry)
    elif isinstance(value, float) and not isfinite(value):
        raise ValueError(f"{name} must be finite, not {value}")


def plain_file(name: Any) -> str:
    """The name of a frame's file, a plain one; ValueError otherwise."""
    plain = isinstance(name, str) and len(name) < 256 and name.lower().endswith(_SUFFIXES)
    if not plain or re.search(r'[\x00-\x1f/\\:*?"<>|]', name) or name.startswith("."):
        raise ValueError(f"{short(name)} is not a plain file name of a frame")
    return str(name)


def _methods(value: Any) -> dict[str, Any]:
    methods = _mapping("methods", value)
    for kind in ("cgh", "compensation"):
        named = methods.get(kind, "")
        if isinstance(named, dict):
            for key, text in named.items():
                _text(f"methods' {kind} {key}", text)
        else:
            _text(f"methods' {kind}", named)
    return methods


def checked_frame(entry: Any) -> dict[str, Any]:
    """A frame's entry with plain types, as `FrameRecord` declares them; what is missing was not
    measured. ValueError names what is wrong.
    """
    frame = _mapping("a frame", entry)
    number = FRAME.of(_needed(frame, "number"))
    frame = {**asdict(FrameRecord(number)), **frame}
    for field in fields(FrameRecord):
        _declared(f"frame {number}: {field.name}", frame[field.name], field.type)
    for stage, seconds in frame["stage_seconds"].items():
        real(f"frame {number}: seconds of {stage}", seconds)
    for name, reason in frame["reuse"].items():
        _text(f"frame {number}: reuse of {name}", reason)
    return {
        **frame,
        "number": number,
        "file": plain_file(_needed(frame, "file")),
        "sha256": _text("sha256", frame.get("sha256", "")),
        "objects": [_object(number, o) for o in frame["objects"]],
    }


def _declared(name: str, value: Any, declared: Any) -> None:
    """ValueError where a value is not of a field's declared type."""
    kind = get_origin(declared) or declared
    if kind is int:
        Count(name, 0, MANY).of(value)
    elif kind is float or (kind is UnionType and value is not None):
        real(name, value)
    elif kind is bool and not isinstance(value, bool):
        raise ValueError(f"{name} must be true or false, not {short(value)}")
    elif kind is list and not isinstance(value, list):
        raise ValueError(f"{name} must be a list, not {short(value)}")
    elif kind is dict:
        _mapping(name, value)


def _object(number: int, entry: Any) -> dict[str, Any]:
    obj = dict(_mapping(f"frame {number}: an object", entry))
    where = f"frame {number}: an object's"
    obj["name"] = _text(f"{where} name", obj.get("name"))
    if obj.get("position") is not None:
        obj["position"] = _numbers(f"{where} position", obj["position"], 3)
    if obj.get("depth") is not None:
        obj["depth"] = real(f"{where} depth", obj["depth"])
    if "points" in obj:
        obj["points"] = Count(f"{where} points", 0, MANY).of(obj["points"])
    if "coverage" in obj:
        obj["coverage"] = real(f"{where} coverage", obj["coverage"])
    if obj.get("power") is not None:
        obj["power"] = POWER.of(obj["power"])
    if obj.get("box") is not None:
        corners = obj["box"]
        if not isinstance(corners, list) or len(corners) != 2:
            raise ValueError(f"{where} box must be two corners, not {short(corners)}")
        obj["box"] = [_numbers(f"{where} box", corner, 3) for corner in corners]
    return obj


def _response(value: Any) -> dict[str, Any]:
    if value is None:
        return {}
    response = _mapping("response", value)
    try:
        GreyResponse.from_dict(dict(response))
    except (ValueError, TypeError, IndexError, OverflowError) as error:
        raise ValueError(f"response: {error}") from None
    return dict(response)


def _needed(mapping: Mapping[str, Any], key: str) -> Any:
    if key not in mapping:
        raise ValueError(f"{key} is missing")
    return mapping[key]


def _mapping(name: str, value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ValueError(f"{name} must be an object, not {short(value)}")
    return value


def _text(name: str, value: Any) -> str:
    if not isinstance(value, str) or len(value) > 1000:
        raise ValueError(f"{name} must be text, not {short(value)}")
    return value


def _numbers(name: str, value: Any, count: int) -> list[float]:
    if not isinstance(value, list) or len(value) != count:
        raise ValueError(f"{name} must be {count} numbers, not {short(value)}")
    return [real(name, entry) for entry in value]
