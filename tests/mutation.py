"""Small wrong changes to the core files, and the share of them that the tests notice.

A change is made in a copy of the tree, one at a time: a sign, an operator, a comparison, a number,
a function for its like, a statement left out. Messages, annotations and docstrings are left alone,
and so is what cannot be seen by its nature (UNSEEN). A first run of a group's tests notes which of
them run which lines; a change then meets the tests that run it, the quickest first, and after them
the others that run its file. It counts as caught when one fails, or takes far too long. Run by
scripts/mutate.sh; the sample is drawn by seed, so that it can be repeated.
"""

import argparse
import ast
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil
from pathlib import Path

# For the forks that run the tests.
import hypothesis  # noqa: F401
import numpy  # noqa: F401
import pytest
import scipy.fft
import scipy.ndimage
import scipy.special  # noqa: F401
import threadpoolctl  # noqa: F401
from mutation_unseen import UNSEEN

ROOT = Path(__file__).parents[1]
# group: (files, tests that must notice)
GROUPS: dict[str, tuple[list[str], list[str]]] = {
    "curved": (["chrmc/cgh/curved/*.py"], ["tests/chrmc/cgh/test_curved*.py"]),
    "ch-rmc-object": (
        ["chrmc/compensation/ch_rmc_object/*.py"],
        ["tests/chrmc/compensation/test_object*.py"],
    ),
    "ch-rmc-paper": (
        ["chrmc/compensation/ch_rmc_paper/*.py"],
        [
            "tests/chrmc/compensation/test_paper*.py",
            "tests/chrmc/planning/test_expected_videos.py",
        ],
    ),
    "optics": (
        ["chrmc/optics/*.py"],
        ["tests/chrmc/optics", "tests/chrmc/test_conventions.py", "tests/chrmc/test_reference.py"],
    ),
    "encoding": (
        ["chrmc/grey_levels.py", "chrmc/encoding.py", "chrmc/encodings/*.py"],
        [
            "tests/display/test_enc*.py",
            "tests/reconstruct/test_four_f.py",
            "tests/chrmc/test_grey_levels.py",
        ],
    ),
    "four-f": (["reconstruct/four_f_system.py"], ["tests/reconstruct/test_four_f.py"]),
    "focus": (["reconstruct/focus*.py"], ["tests/reconstruct/test_focus*.py"]),
}
COMPARED: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
}  # fmt: skip
COMPUTED: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult, ast.Pow: ast.Mult, ast.MatMult: ast.Mult,
}  # fmt: skip
ALIKE = {
    "sin": "cos", "cos": "sin", "max": "min", "min": "max", "real": "imag", "imag": "real",
    "maximum": "minimum", "minimum": "maximum", "ceil": "floor", "floor": "ceil", "any": "all",
    "all": "any", "argmax": "argmin", "argmin": "argmax", "rows": "columns", "columns": "rows",
}  # fmt: skip


# Arguments that guard or save, and change nothing.
_ASIDE = ("in_place", "overwrite_x", "workers", "strict", "copy", "check_finite")


@dataclass(frozen=True)
class Change:
    """One wrong change: where, and the text that stands there instead.

    lines : first of its statement, first and last of its own
    """

    path: str
    lines: tuple[int, int, int]
    start: int
    end: int
    text: str
    was: str

    @property
    def what(self) -> str:
        return f"{self.was} → {self.text}"

    def __str__(self) -> str:
        return f"{self.path}:{self.lines[1]}: {self.what}"


def changes(path: str) -> list[Change]:
    """All changes of a file that this module knows of and that can be seen."""
    source = (ROOT / path).read_text()
    lines = source.splitlines()
    # Columns of the syntax tree count bytes.
    raw = source.encode()
    starts = [0]
    for line in raw.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    found = []
    for node, instead, statement in _wrong(ast.parse(source), 0):
        start = starts[node.lineno - 1] + node.col_offset
        end = starts[(node.end_lineno or 0) - 1] + (node.end_col_offset or 0)
        was = raw[start:end].decode()
        text = "pass" if isinstance(node, ast.stmt) else f"({ast.unparse(instead)})"
        if isinstance(instead, ast.Constant | ast.Attribute | ast.Name):
            text = ast.unparse(instead)
        place = (statement, node.lineno, node.end_lineno or node.lineno)
        change = Change(path, place, start, end, text, was)
        here = {lines[number - 1].strip() for number in place[:2]}
        if not any(
            what in ("", change.what) and any(line.startswith(begins) for line in here)
            for begins, what, _ in UNSEEN.get(path, [])
        ):
            found.append(change)
    for begins, _, _ in UNSEEN.get(path, []):
        if not any(line.strip().startswith(begins) for line in lines):
            raise SystemExit(f"{path} has no line that begins with {begins!r}: mend UNSEEN")
    return found


def _wrong(tree: ast.AST, statement: int) -> Iterator[tuple[ast.expr | ast.stmt, ast.AST, int]]:
    """Nodes, what to put in their place, and their statement's line.

    Nothing inside messages, annotations, docstrings.
    """
    if isinstance(tree, ast.Raise | ast.JoinedStr | ast.Assert | ast.Import | ast.ImportFrom):
        return
    if isinstance(tree, ast.keyword) and tree.arg in _ASIDE:
        return
    if isinstance(tree, ast.stmt):
        statement = tree.lineno
    for node, instead in _instead(tree):
        yield node, instead, statement
    for name, value in ast.iter_fields(tree):
        if name in ("annotation", "returns", "decorator_list", "type_params", "format_spec"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield from _wrong(child, statement)


def _instead(node: ast.AST) -> Iterator[tuple[ast.expr | ast.stmt, ast.AST]]:
    if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in COMPARED:
        yield node, ast.Compare(node.left, [COMPARED[type(node.ops[0])]()], node.comparators)
    elif isinstance(node, ast.BinOp) and type(node.op) in COMPUTED:
        if not isinstance(node.left, ast.Constant | ast.JoinedStr) or not isinstance(
            getattr(node.left, "value", 0), str
        ):
            yield node, ast.BinOp(node.left, COMPUTED[type(node.op)](), node.right)
    elif isinstance(node, ast.BoolOp):
        other = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        yield node, ast.BoolOp(other, node.values)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
        yield node, node.operand
    elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield node, ast.Constant(not node.value)
    elif isinstance(node, ast.Constant) and isinstance(node.value, int):
        # One more of thousands is no change.
        yield node, ast.Constant(node.value + 1 if node.value < 100 else 2 * node.value)
    elif isinstance(node, ast.Constant) and isinstance(node.value, float):
        yield node, ast.Constant(2 * node.value or 1.0)
    elif isinstance(node, ast.Attribute) and node.attr in ALIKE:
        yield node, ast.Attribute(node.value, ALIKE[node.attr], node.ctx)
    elif isinstance(node, ast.Name) and node.id in ALIKE and isinstance(node.ctx, ast.Load):
        yield node, ast.Name(ALIKE[node.id], node.ctx)
    elif isinstance(node, ast.AugAssign):
        yield node, ast.Pass()


def expanded(patterns: list[str]) -> list[str]:
    return sorted({str(p.relative_to(ROOT)) for pattern in patterns for p in ROOT.glob(pattern)})


@dataclass(frozen=True)
class Map:
    """What a first run of a group's tests showed.

    seconds : processor time of each test
    lines : of each file, the tests that run each line
    """

    seconds: dict[str, float]
    lines: dict[str, dict[int, set[str]]]

    def tests(self, change: Change) -> list[str]:
        """The tests to try on a change: those that run it, the quickest first, then the others."""
        lines = self.lines[change.path]
        statement, first, last = change.lines
        direct = set().union(*(lines.get(n, set()) for n in (statement, *range(first, last + 1))))
        every = set().union(*lines.values())
        return sorted(every, key=lambda test: (test not in direct, self.seconds[test]))


def run(tree: Path, arguments: list[str], seconds: float, **environment: str) -> bool:
    """Whether pytest passes in a tree within so many seconds of processor time.

    In a fork of this process, which has the libraries loaded: that takes longer than most tests.
    """
    child = os.fork()
    if child:
        return os.waitpid(child, 0)[1] == 0
    status = 1
    try:
        for stream in (1, 2):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
        os.chdir(tree)
        os.environ.update(environment, PYTHONPATH=str(tree))
        sys.dont_write_bytecode = True
        sys.path[:0] = [str(tree), str(tree / "tests")]
        resource.setrlimit(resource.RLIMIT_CPU, (ceil(seconds), ceil(seconds)))
        signal.alarm(
            600 + ceil(10 * seconds)
        )  # for what waits for ever; pytest-timeout has its own
        without = ["-p", "no:cacheprovider", "-p", "no:timeout"]  # whose alarm is the same
        status = int(pytest.main([*without, "-q", "-x", "--hypothesis-seed=1", *arguments]))
    finally:
        os._exit(status)


def mapped(tree: Path, files: list[str], tests: list[str]) -> Map | None:
    """Which tests run which lines; None where they fail as they are."""
    written = tree / "mutation_map.json"
    listed = os.pathsep.join(str(tree / file) for file in files)
    here = {"MUTATION_FILES": listed, "MUTATION_MAP": str(written)}
    if not run(tree, ["-p", "mutation_map", *tests], 1200, **here):
        return None
    data = json.loads(written.read_text())
    lines = {
        file: {int(n): set(names) for n, names in data["lines"][str(tree / file)].items()}
        for file in files
    }
    return Map(data["seconds"], lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("groups", nargs="*", help="default all")
    parser.add_argument("--minutes", type=float, default=30)
    parser.add_argument("--sample", type=int, default=20, help="changes per group")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--list", action="store_true", help="groups, and how many changes each has")
    asked = parser.parse_args()
    unknown = sorted(set(asked.groups) - set(GROUPS))
    if unknown:
        parser.error(f"no group {unknown[0]}; there are {', '.join(GROUPS)}")
    end = time.monotonic() + 60 * asked.minutes
    chosen = asked.groups or list(GROUPS)
    pools = {g: [c for path in expanded(GROUPS[g][0]) for c in changes(path)] for g in chosen}
    if asked.list:
        for group, pool in pools.items():
            print(f"{group}: {len(pool)} changes in {len(expanded(GROUPS[group][0]))} files")
        return 0
    with tempfile.TemporaryDirectory(prefix="mutate") as place:
        tree = Path(place)
        listed = subprocess.run(
            ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True
        )
        for name in listed.stdout.splitlines():
            if (ROOT / name).is_file():
                (tree / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / name, tree / name)
        for group, pool in pools.items():
            tried(group, pool, tree, asked.sample, asked.seed, end)
    return 0


def tried(group: str, pool: list[Change], tree: Path, sample: int, seed: int, end: float) -> None:
    """Try a sample of a group's changes and print what was found."""
    known = mapped(tree, expanded(GROUPS[group][0]), expanded(GROUPS[group][1]))
    if known is None:
        print(f"{group}: its tests fail as they are: nothing to measure", flush=True)
        return
    caught = count = 0
    for change in random.Random(seed).sample(pool, min(sample, len(pool))):
        if time.monotonic() > end:
            break
        tests = known.tests(change)
        allowed = 3 * sum(known.seconds[test] for test in tests) + 10
        path = tree / change.path
        good = path.read_bytes()
        try:
            path.write_bytes(good[: change.start] + change.text.encode() + good[change.end :])
            survived = not tests or run(tree, tests, allowed)
        finally:
            path.write_bytes(good)
        count += 1
        caught += not survived
        if survived:
            print(f"  survived  {change}", flush=True)
    share = f"{caught / count:.0%}" if count else "none tried"
    print(f"{group}: {caught} of {count} caught, {share} (of {len(pool)} changes)", flush=True)


if __name__ == "__main__":
    sys.exit(main())
