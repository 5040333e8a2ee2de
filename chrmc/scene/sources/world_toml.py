"""`scene.toml`: a world of entries in a file that one edits by hand."""

from math import hypot
from pathlib import Path
from typing import Any

from chrmc.files import read_toml, replacing
from chrmc.ranges import Count
from chrmc.scene.sources.model import MOST_FRAMES, UP
from chrmc.scene.sources.world import MOTIONS, SHADINGS, Entry, Turning, World, number, triple
from chrmc.scene.surface.shading import Lamp

_WORLD = ("name", "frames", "rate", "wavelength", "shading", "lamp", "ambient", "density",
          "points", "object")  # fmt: skip
_ENTRY = ("file", "text", "name", "size", "scale", "up", "place", "turn", "motion")
_MOTION = ("kind", "axis", "degrees", "file", "scale")


def read_world(path: Path) -> World:
    """A scene.toml, its files beside it; OSError or ValueError in one line."""
    content = read_toml(path)
    try:
        return _world(content, path)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def _known(content: dict[str, Any], words: tuple[str, ...], where: str) -> None:
    odd = sorted(set(content) - set(words))
    if odd:
        raise ValueError(f"{where} has no {odd[0]!r}; it knows {', '.join(words)}")


def _world(content: dict[str, Any], path: Path) -> World:
    _known(content, _WORLD, "a scene")
    objects = content.get("object")
    if not isinstance(objects, list) or not objects:
        raise ValueError('nothing in it: write [[object]] and file = "…"')
    entries = tuple(_entry(table, path.parent) for table in objects)
    names = [t.name for t in entries]
    twice = next((n for n in names if names.count(n) > 1), None)
    if twice is not None:
        raise ValueError(f"two objects are called {twice!r}; give each a name of its own")

    def optional(key: str) -> float | None:
        return number(content[key], key, positive=True) if key in content else None

    shading = content.get("shading", "diffuse")
    if shading not in SHADINGS:
        raise ValueError(f"unknown shading {shading!r}: choose one of {', '.join(SHADINGS)}")
    plain = Lamp()
    return World(
        name=str(content.get("name", path.stem)),
        entries=entries,
        frames=_whole(content, "frames", MOST_FRAMES),
        rate=optional("rate"),
        wavelength=optional("wavelength"),
        shading=shading,
        lamp=Lamp(
            triple(content.get("lamp", plain.towards), "lamp"),
            number(content.get("ambient", plain.ambient), "ambient"),
        ),
        density=optional("density"),
        points=_whole(content, "points"),
    )


def _whole(content: dict[str, Any], key: str, most: int = 10**9) -> int | None:
    return Count(key, 1, most).of(content[key]) if key in content else None


def _entry(table: Any, folder: Path) -> Entry:
    if not isinstance(table, dict):
        raise ValueError('an object is a table: [[object]] and file = "…"')
    _known(table, _ENTRY, "an object")
    if ("file" in table) == ("text" in table):
        raise ValueError("an object needs a file or a text, and not both")
    source = f"text:{table['text']}" if "text" in table else str(folder / str(table["file"]))
    if "size" in table and "scale" in table:
        raise ValueError("size and scale both say how large an object is; keep one")
    up = table.get("up")
    if up is not None and up not in tuple(UP):
        raise ValueError(f"up is {up!r}; choose one of {', '.join(UP)}")

    def optional(key: str) -> float | None:
        return number(table[key], key, positive=True) if key in table else None

    return Entry(
        source=source,
        name=str(table.get("name", table.get("text", Path(source).stem))),
        size=optional("size"),
        scale=optional("scale"),
        up=up,
        place=triple(table["place"], "place") if "place" in table else (None, None, None),
        turn=triple(table.get("turn", (0, 0, 0)), "turn"),
        motion=_motion(table.get("motion", {}), folder),
    )


def _motion(table: Any, folder: Path) -> Turning:
    if isinstance(table, str):
        table = {"kind": table}
    if not isinstance(table, dict):
        raise ValueError('motion is a table, such as { kind = "turntable", degrees = 6 }')
    _known(table, _MOTION, "a motion")
    plain = Turning()
    kind = table.get("kind", plain.kind)
    if kind not in MOTIONS:
        raise ValueError(f"unknown motion {kind!r}: choose one of {', '.join(MOTIONS)}")
    if (kind == "poses") != ("file" in table):
        raise ValueError('the motion "poses", and no other, needs the file of a track')
    axis = triple(table.get("axis", plain.axis), "axis")
    if not hypot(*axis) > 1e-9:
        raise ValueError("axis must have a direction, not 0, 0, 0")
    return Turning(
        kind,
        axis,
        number(table.get("degrees", plain.degrees), "degrees"),
        folder / str(table["file"]) if "file" in table else None,
        number(table["scale"], "scale", positive=True) if "scale" in table else None,
    )


def write_toml(world: World, path: Path) -> None:
    """A world with a comment on every word, its files as absolute paths or beside the file."""
    lines = [
        "# A scene of chrmc. Lengths are metres; x runs right, y down, z away from the SLM.",
        f"name = {_text(world.name)}",
        _line("frames", world.frames, "how many; without it as many as the longest motion"),
        _line("rate", world.rate, "frames a second, at which tracks and animations are taken"),
        _line("wavelength", world.wavelength, "without it the command line's"),
        f"shading = {_text(world.shading)}  # diffuse, or unlit",
        f"lamp = {_numbers(world.lamp.towards)}  # direction to the lamp (y down)",
        f"ambient = {world.lamp.ambient:.9g}  # share of light from everywhere",
        _line("density", world.density, "resolution cells of the SLM per point"),
        _line("points", world.points, "or: points on all surfaces together"),
    ]
    for entry in world.entries:
        lines += ["", "[[object]]", f"name = {_text(str(entry.name))}", _source(entry, path)]
        lines += [
            _line("size", entry.size, "of its largest side; or scale: metres per unit"),
            _line(
                "scale", entry.scale, "metres per unit of the file; or size: of its largest side"
            ),
            _line("up", entry.up, "axis of the file that points up"),
            f"place = {_numbers(entry.place)}  # of its middle",
            f"turn = {_numbers(entry.turn)}  # degrees about x, y, z",
            _motion_line(entry.motion, path),
        ]
    with replacing(path) as partial:
        partial.write_text("\n".join(line for line in lines) + "\n", "utf-8")


def _text(value: str) -> str:
    escaped = value.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _numbers(values: Any) -> str:
    return (
        "[" + ", ".join(f"{v or 0:.9g}" if (v or 0) % 1 else f"{v or 0:.1f}" for v in values) + "]"
    )


def _line(key: str, value: Any, comment: str) -> str:
    if value is None:
        return f"# {key} = …  # {comment}"
    shown = _text(value) if isinstance(value, str) else f"{value:.9g}"
    return f"{key} = {shown}  # {comment}"


def _source(entry: Entry, path: Path) -> str:
    if entry.source.startswith("text:"):
        return f"text = {_text(entry.source[5:])}"
    return f"file = {_text(_relative(Path(entry.source), path))}"


def _relative(file: Path, path: Path) -> str:
    file, folder = file.resolve(), path.resolve().parent
    return (file.relative_to(folder) if file.is_relative_to(folder) else file).as_posix()


def _motion_line(motion: Turning, path: Path) -> str:
    if motion.kind == "turntable":
        axis = _numbers(motion.axis)
        return f'motion = {{ kind = "turntable", axis = {axis}, degrees = {motion.degrees:.9g} }}'
    if motion.kind == "poses" and motion.file is not None:
        scale = "" if motion.scale is None else f", scale = {motion.scale:.9g}"
        return f'motion = {{ kind = "poses", file = {_text(_relative(motion.file, path))}{scale} }}'
    kinds = "own, none, turntable (axis, degrees per frame), poses (file of a track, scale)"
    return f'motion = {{ kind = "{motion.kind}" }}  # {kinds}'
