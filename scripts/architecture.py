"""Draw the house from its imports: docs/images/architecture.png, parts above what they use.

usage: python scripts/architecture.py
"""

import ast
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("chrmc", "display", "reconstruct")
SHOWN_APART = ("chrmc/cgh/curved", "chrmc/compensation/ch_rmc_object")
"""Folders deep enough inside a part to be a part of their own."""
PLUMBING = 0
"""Height of the parts that use no other: named in a line below instead of drawn with arrows."""


def modules() -> dict[str, Path]:
    """Dotted name to file of every module."""
    found = {}
    for package in PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            parts = path.relative_to(ROOT).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def part_of(path: Path) -> str:
    """The part that a file belongs to: its folder, or itself where it lies in chrmc's top."""
    inside = path.relative_to(ROOT)
    for part in SHOWN_APART:
        if inside.is_relative_to(part):
            return part
    if len(inside.parts) == 2 and inside.parts[0] == "chrmc":
        return inside.as_posix()
    return "/".join(inside.parts[: 2 if inside.parts[0] == "chrmc" or len(inside.parts) > 2 else 1])


def uses() -> dict[str, set[str]]:
    """Each part and the parts that its modules import."""
    every = modules()
    graph: dict[str, set[str]] = {}
    for path in every.values():
        part = part_of(path)
        if part in ("chrmc/__init__.py", "chrmc/__main__.py"):
            continue
        found = graph.setdefault(part, set())
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                names = [f"{node.module}.{alias.name}" for alias in node.names]
            for name in names:
                while name and name not in every:
                    name = name.rpartition(".")[0]
                if name:
                    found.add(part_of(every[name]))
        found.discard(part)
        found.discard("chrmc/__init__.py")
    return graph


def reachable(graph: dict[str, set[str]], start: str) -> set[str]:
    """All that a part needs, directly or not."""
    seen: set[str] = set()
    waiting = [start]
    while waiting:
        for other in graph.get(waiting.pop(), set()) - seen:
            seen.add(other)
            waiting.append(other)
    return seen


def reduced(graph: dict[str, set[str]]) -> dict[str, set[str]]:
    """Without the arrows that follow from others."""
    return {
        part: {
            other
            for other in used
            if not any(other in reachable(graph, third) for third in used - {other})
        }
        for part, used in graph.items()
    }


def layers(graph: dict[str, set[str]]) -> dict[str, int]:
    """Height of each part: one more than the highest that it uses."""
    height: dict[str, int] = {}

    def of(part: str, above: tuple[str, ...] = ()) -> int:
        if part in above:
            raise ValueError("a circle of imports: " + " → ".join((*above, part)))
        if part not in height:
            height[part] = 1 + max((of(p, (*above, part)) for p in graph.get(part, ())), default=-1)
        return height[part]

    for part in graph:
        of(part)
    return height


def draw(path: Path) -> None:
    """Write the picture."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    every = uses()
    plumbing = {part for part, level in layers(every).items() if level == PLUMBING}
    graph = {part: used - plumbing for part, used in every.items() if part not in plumbing}
    height = layers(graph)
    arrows = reduced(graph)
    rows: dict[int, list[str]] = {}
    for part in sorted(height):
        rows.setdefault(height[part], []).append(part)
    place: dict[str, float] = {}
    for level in sorted(rows):
        wish = {
            part: sum(place[p] for p in arrows[part]) / len(arrows[part]) if arrows[part] else 0.0
            for part in rows[level]
        }
        row = sorted(rows[level], key=lambda part: (wish[part], part))
        for k, part in enumerate(row):
            # Half a step aside in every other row, so that long arrows pass between the boxes.
            place[part] = k - (len(row) - 1) / 2 + (0.25 if level % 2 else -0.25)
    widest = max(len(row) for row in rows.values()) + 1
    figure = Figure(figsize=(2.2 * widest, 0.8 * len(rows) + 0.6), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    axes.set_axis_off()
    for part, used in arrows.items():
        for other in used:
            bend = 0.0 if height[part] - height[other] == 1 else 0.12
            axes.annotate(
                "",
                (place[other], height[other] + 0.22),
                (place[part], height[part] - 0.22),
                arrowprops={
                    "arrowstyle": "-|>",
                    "color": "#777777",
                    "lw": 0.9,
                    "connectionstyle": f"arc3,rad={bend}",
                },
            )
    colours = {"chrmc": "#dbe8f5", "display": "#fbe3c4", "reconstruct": "#dcefd6"}
    for part, x in place.items():
        box = {"boxstyle": "round", "fc": colours[part.split("/")[0]], "ec": "#555555"}
        axes.text(x, height[part], short(part), ha="center", va="center", fontsize=10, bbox=box)
    below = "used by all: " + ", ".join(sorted(short(part) for part in plumbing))
    axes.text(0, -0.8, below, ha="center", va="center", fontsize=10, color="#555555")
    axes.set_xlim(-widest / 2, widest / 2)
    axes.set_ylim(-1.1, max(rows) + 0.5)
    figure.savefig(path, dpi=110)


def short(part: str) -> str:
    """A part's name in the picture."""
    return part.removesuffix(".py").removeprefix("chrmc/")


if __name__ == "__main__":
    draw(ROOT / "docs" / "images" / "architecture.png")
