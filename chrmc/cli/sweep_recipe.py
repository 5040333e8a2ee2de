"""A sweep's recipe, a TOML file, and the cases that it means."""

from collections.abc import Iterable, Mapping
from itertools import product
from pathlib import Path
from typing import Any

import click

from chrmc.cli.arguments import FrameRange, Setting, SLMType
from chrmc.cli.check import FrameList
from chrmc.cli.lengths import WAVELENGTH, parse_length
from chrmc.encoding import CODINGS, coding_for
from chrmc.files import read_toml
from chrmc.options import meant
from chrmc.panels import encoding_for
from chrmc.ranges import real, short
from chrmc.slm import SLM
from chrmc.sweep.case import Case

AXES = ("scenes", "methods", "tolerances", "encodings", "slms")
SINGLE = ("frames", "check", "form", "wavelength", "check_pixels", "group", "response", "gamma")
METHOD = ("name", "cgh", "compensation", "surface", "set")


def read_recipe(path: Path) -> list[Case]:
    """The cases of a recipe, scene by scene; OSError or ValueError in one line for a bad one."""
    content = read_toml(path)
    try:
        return _cases(content, path.parent)
    except (ValueError, click.BadParameter) as error:
        said = error.format_message() if isinstance(error, click.BadParameter) else error
        raise ValueError(f"{path}: {said}") from None


def _known(content: Mapping[str, Any], words: Iterable[str], where: str) -> None:
    words = list(words)
    for key in content:
        if key not in words:
            raise ValueError(
                f"{where} has no {key!r}{meant(key, words)}; it knows {', '.join(words)}"
            )


def _list(content: Mapping[str, Any], key: str, default: list[Any]) -> list[Any]:
    """An axis: a list without repeats, or one value for a list of it."""
    value = content.get(key, default)
    values = value if isinstance(value, list) else [value]
    if not values:
        raise ValueError(f"{key} is empty: name one at least")
    return [v for k, v in enumerate(values) if v not in values[:k]]


def _cases(content: dict[str, Any], folder: Path) -> list[Case]:
    from chrmc.generation.recipe import recipe_for
    from chrmc.scene.scene import frame_range
    from chrmc.sweep.case import tolerances_for

    _known(content, (*AXES, *SINGLE), "a sweep")
    if "scenes" not in content:
        raise ValueError('scenes are missing: write scenes = ["car-house"]')
    slms = [_slm(value, folder) for value in _list(content, "slms", ["lc-r-1080"])]
    encodings = [
        None if value is None else _encoding(value, slms[0])
        for value in _list(content, "encodings", [None])
    ]
    tolerances = [real("a tolerance", v) for v in _list(content, "tolerances", [1e-3])]
    methods = [_method(value) for value in _list(content, "methods", ["ch-rmc-object"])]
    settled = [
        (label, tolerance, choices)
        for label, method in methods
        for tolerance, choices in _named(label, lambda m=method: tolerances_for(m, tolerances))
    ]
    common = _common(content, folder)
    form, asked = content.get("form", "points"), content.get("frames")
    frames = None if asked is None else FrameRange().convert(asked, None, None)
    cases = []
    for text, slm in product(_list(content, "scenes", []), slms):
        scene = _scene(text, form, slm, common["wavelength"], folder)
        numbers = frame_range(scene, frames)
        checked = _checked(content.get("check"), numbers)
        for (label, tolerance, choices), encoding in product(settled, encodings):
            names = {"scene": _shown(text), "method": label, "tolerance": tolerance,
                     "encoding": encoding or encoding_for(slm), "slm": slm.name}  # fmt: skip
            try:
                recipe = recipe_for(scene, slm, encoding=encoding, **common, **choices)
            except ValueError as refusal:
                cases.append(Case(names, None, refused=str(refusal)))
                continue
            cases.append(Case(names, recipe, (numbers[0], numbers[-1]), checked))
    if all(case.recipe is None for case in cases):
        raise ValueError(f"nothing fits together: {cases[0].refused}")
    return cases


def _named(label: str, make: Any) -> list[Any]:
    try:
        return list(make())
    except ValueError as error:
        raise ValueError(f"method {label}: {error}") from None


def _common(content: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """What all cases share, as `recipe_for` takes it."""
    found: dict[str, Any] = {"wavelength": None}
    if "wavelength" in content:
        found["wavelength"] = parse_length(content["wavelength"], WAVELENGTH)
    for key in ("check_pixels", "group", "gamma"):
        if key in content:
            found[key] = content[key]
    if "response" in content:
        found["response"] = _beside(_text("response", content["response"]), folder)
    return found


def _text(name: str, value: Any) -> str:
    if not isinstance(value, str) or not value.strip():
        raise ValueError(f"{name} must be text, not {short(value)}")
    return value


def _beside(text: str, folder: Path) -> str:
    """A file's name as the recipe means it: beside the recipe; other words as they are."""
    head, sign, tail = text.partition("@")
    name, colon, rest = text.rpartition(":")
    for part, end in ((text, ""), (head, sign + tail), (name, colon + rest)):
        if part and (folder / part).exists():
            return str(folder / part) + end
    return text


def _slm(value: Any, folder: Path) -> SLM:
    return SLMType().convert(_beside(_text("an SLM", value), folder), None, None)


def _encoding(value: Any, slm: SLM) -> str:
    name = _text("an encoding", value)
    if name not in CODINGS:
        raise ValueError(
            f"unknown encoding {name!r}{meant(name, CODINGS)}: choose of {', '.join(CODINGS)}"
        )
    return coding_for(name, slm).name


def _scene(value: Any, form: Any, slm: SLM, wavelength: float | None, folder: Path) -> Any:
    from chrmc.scene.load import BUILT_IN, load_scene

    words = value if isinstance(value, list) else [value]
    names = [_text("a scene", word) for word in words]
    names = [name if name in BUILT_IN else _beside(name, folder) for name in names]
    sources: Any = names[0] if len(names) == 1 else names
    return load_scene(sources, _text("form", form), slm=slm, wavelength=wavelength)


def _shown(value: Any) -> str:
    return " ".join(value) if isinstance(value, list) else str(value)


def _checked(asked: Any, numbers: range) -> tuple[int, ...]:
    """The frames to judge, of those that are made; by default the first and the last."""
    if asked is None:
        return tuple(sorted({numbers[0], numbers[-1]}))
    if isinstance(asked, list) and all(type(n) is int for n in asked):
        chosen = asked
    else:
        text = str(asked) if type(asked) is int else _text("check", asked)
        chosen = [n for a, b in FrameList().convert(text, None, None) for n in range(a, b + 1)]
        chosen = chosen or list(numbers)
    outside = [n for n in chosen if n not in numbers]
    if outside:
        raise ValueError(f"check names frame {outside[0]}; made are {numbers[0]} to {numbers[-1]}")
    return tuple(sorted(set(chosen)))


def _method(value: Any) -> tuple[str, dict[str, Any]]:
    """A method's label and its choices: a name alone is a CGH method without compensation, or a
    video method with its usual CGH method."""
    from chrmc.cli.names import cgh_names, compensation_names

    if isinstance(value, str):
        known = [*cgh_names(), *(n for n in compensation_names() if n != "none")]
        if value in compensation_names():
            return value, {"compensation": value}
        if value not in known and ":" not in value:
            raise ValueError(
                f"unknown method {value!r}{meant(value, known)}: choose of {', '.join(known)}, or "
                'write { cgh = "…", compensation = "…" }'
            )
        return value, {"cgh": value, "compensation": "none"}
    if not isinstance(value, dict):
        raise ValueError(f"a method is a name or a table, not {short(value)}")
    _known(value, METHOD, "a method")
    method: dict[str, Any] = {k: _text(k, value[k]) for k in METHOD[1:4] if k in value}
    if not method:
        raise ValueError("a method needs a cgh, a compensation or both")
    settings = value.get("set", {})
    if not isinstance(settings, dict):
        raise ValueError(f'set is a table, such as {{ radius = "145mm" }}, not {short(settings)}')
    if "tolerance" in settings:
        raise ValueError("a tolerance stands in tolerances, not in a method's set")
    pairs = {key: _setting(key, v) for key, v in settings.items()}
    if pairs:
        method["settings"] = pairs
    told = [str(method[key]) for key in METHOD[1:4] if key in method]
    told += [f"{key}={v}" for key, v in settings.items()]
    return _text("name", value.get("name", " ".join(told))), method


def _setting(key: str, value: Any) -> Any:
    if isinstance(value, str):
        return Setting().convert(f"{key}={value}", None, None)[1]
    if isinstance(value, bool):
        return value
    real(key, value)
    return value
