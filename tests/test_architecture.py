"""The direction of data is the direction of imports."""

import ast
import importlib.util
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SOURCES = sorted(
    p for package in ("chrmc", "display", "reconstruct") for p in (ROOT / package).rglob("*.py")
)

# layer: what its modules may import of this project's top level and of chrmc's parts
FORBIDDEN = {
    "chrmc/__main__.py": [],
    "chrmc/cli": [],
    "display": ["reconstruct", "chrmc.cli"],
    "reconstruct": ["display", "chrmc.cli"],
    "chrmc/scene": [
        "display",
        "reconstruct",
        "chrmc.cli",
        "chrmc.cgh",
        "chrmc.compensation",
        "chrmc.bench",
    ],
    "chrmc/cgh": ["display", "reconstruct", "chrmc.cli", "chrmc.compensation", "chrmc.bench"],
    "chrmc/compensation": ["display", "reconstruct", "chrmc.cli", "chrmc.bench"],
    "chrmc": ["display", "reconstruct", "chrmc.cli"],
}


def layer_of(path: Path) -> str:
    name = path.relative_to(ROOT).as_posix()
    return next(layer for layer in FORBIDDEN if (name + "/").startswith(layer + "/"))


@cache
def nodes(path: Path) -> list[ast.AST]:
    return list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


@cache
def imported(path: Path) -> set[str]:
    names: set[str] = set()
    for node in nodes(path):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: write imports in full"
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_imports_follow_the_data(path: Path) -> None:
    for name in imported(path):
        for forbidden in FORBIDDEN[layer_of(path)]:
            assert not (name + ".").startswith(forbidden + "."), f"{path} imports {name}"


def test_importing_the_packages_loads_no_window_and_no_plots() -> None:
    heavy = ["glfw", "moderngl", "matplotlib", "imgui_bundle", "skimage", "OpenImageIO"]
    code = (
        f"import sys, chrmc, display, reconstruct; print([m for m in {heavy} if m in sys.modules])"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.strip() == "[]"


def test_files_hold_one_idea() -> None:
    long = {p.name: n for p in SOURCES if (n := len(p.read_text("utf-8").splitlines())) > 350}
    assert not long


def test_parts_use_each_other_in_one_direction() -> None:
    spec = importlib.util.spec_from_file_location("architecture", ROOT / "scripts/architecture.py")
    assert spec is not None and spec.loader is not None
    drawing = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(drawing)
    assert drawing.layers(drawing.uses())  # which names a circle


def test_the_page_names_files_that_exist() -> None:
    page = (ROOT / "ARCHITECTURE.md").read_text("utf-8")
    for name in re.findall(r"`((?:chrmc|display|reconstruct|tests)/[\w./-]+)`", page):
        assert (ROOT / name).exists(), name


def test_methods_are_known_by_what_they_are_not_by_name() -> None:
    """`curved` is named by itself, where methods are registered, and by what builds on it."""
    own = ("chrmc/cgh/curved/", "chrmc/compensation/ch_rmc_object/")
    named = {
        "chrmc/cgh/method.py",  # its line, and the default
        "chrmc/compensation/__init__.py",  # the object surface works on it
        "chrmc/bench/rivals.py",  # takes its wave apart
        "chrmc/bench/speed.py",  # times its parts
    }
    for path in SOURCES:
        place = path.relative_to(ROOT).as_posix()
        if place.startswith(own) or place in named:
            continue
        assert not any(name.startswith("chrmc.cgh.curved") for name in imported(path)), place
        words = [n.value for n in nodes(path) if isinstance(n, ast.Constant)]
        assert "curved" not in words, place


def test_the_object_surface_takes_what_curved_offers() -> None:
    for path in (ROOT / "chrmc/compensation/ch_rmc_object").glob("*.py"):
        inside = {n for n in imported(path) if n.startswith("chrmc.cgh.curved")}
        assert all(n.startswith("chrmc.cgh.curved.interface.") for n in inside), path
