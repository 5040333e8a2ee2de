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
        ["tests/chrmc/compensation/test_paper*.py"],
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
# file: (how a line begins, the change there or "" for any, why no test can see it)
UNSEEN: dict[str, list[tuple[str, str, str]]] = {
    "chrmc/optics/propagation.py": [
        ("return ceil(2 * sqrt(", "2 → 3", "a wider margin costs time"),
        ("walk = spread(self.wavelength, f_max", "1 → 2", "a wider margin costs time"),
        ("walk = spread(self.wavelength, f_max", "spread(self.wavelength, f_max, self.longest) / p "
         "+ 1 → (spread(self.wavelength, f_max, self.longest) / p - 1)", "a sample of a soft cut"),
        ("padded.append(", "False → True", "another quick length of a transform"),
        ("if rows * x.grid", "", "which of two equal products is quicker"),
        ("if self.grid[0] * self.grid[1] >", "self.grid[0] * self.grid[1] > MOST_SAMPLES → "
         "(self.grid[0] * self.grid[1] >= MOST_SAMPLES)", "one grid of one size"),
        ("ramp = (np.arange(min(soft", "0.5 → 1.0", "half a sample along a soft cut"),
        ("ramp = (np.arange(min(soft", "np.arange(min(soft, count)) + 0.5 → "
         "(np.arange(min(soft, count)) - 0.5)", "the same"),
    ],
    "chrmc/encodings/binary.py": [
        ("lit = line >= 0.5", "line >= 0.5 → (line > 0.5)", "a dark field's even grey"),
        ("amplitude = np.minimum(", "1.0 → 2.0", "no light over any scale is none"),
    ],
    "chrmc/encodings/phase.py": [
        ("return levels_of(np.angle(field) + apart", "", "the checkerboard's other half"),
        ("amplitude = np.minimum(", "1.0 → 2.0", "no light over any scale is none"),
    ],
    "chrmc/grey_levels.py": [
        ("if coding.carrier == 0", "0 → 1", "the product with a carrier of 1 is the same"),
        ("_BLOCK = ", "", "rows at a time"),
        ("bits: int = 8,", "8 → 9", "frames hold 8 bits"),
        ("if bits < 8", "bits < 8 → (bits <= 8)", "of 256 levels all are allowed"),
    ],
    "chrmc/compensation/ch_rmc_paper/image_measures.py": [
        ("high = min(count, ceil(at.max())", "1 → 2", "a dark pixel of a margin of twelve"),
        ("high = min(count, ceil(at.max())", "ceil(at.max()) + MARGIN + 1 → "
         "(ceil(at.max()) + MARGIN - 1)", "two dark pixels of it"),
    ],
    "chrmc/compensation/ch_rmc_paper/cylinder.py": [
        ("_ROOM = ", "", "a column of padding"),
    ],
    "chrmc/compensation/ch_rmc_object/cost.py": [
        (f"_{name} = ", "", "a weight of a count, as measured: how long, not what")
        for name in ("CHOSEN", "SOME", "KEY", "FEW", "CHOOSE", "FOUND_OUT", "LOOK_UP", "WAVE")
    ],
    "chrmc/compensation/ch_rmc_object/grid.py": [
        ("ceil((high - low) / step) + 2", "1 → 2", "one place of room"),
    ],
    "chrmc/compensation/ch_rmc_object/sums.py": [
        ("_AT_ONCE, _RUN = ", "", "points at once"),
        ("_FEW = ", "", "the same"),
        ("half = (high - low)", "", "places farther apart, and more of them"),
        ("few = 4 + ceil(", "4 → 5", "a place more than are needed"),
    ],
    "chrmc/compensation/ch_rmc_object/promise.py": [
        ("if total.relative <= SURE", "total.relative <= SURE * self.tolerance * sqrt(kept) → "
         "(total.relative < SURE * self.tolerance * sqrt(kept))", "measured numbers are not equal"),
    ],
    "chrmc/compensation/ch_rmc_object/video.py": [
        ("later = [n for n in self._numbers", "n > number → (n >= number)", "a frame twice"),
    ],
    "chrmc/compensation/ch_rmc_paper/paper.py": [
        ("extraction = (time", "", "seconds of a stage"),
    ],
    "reconstruct/four_f_system.py": [
        ("rows, columns = (scipy.fft.next_fast_len(2 * n", "", "more dark room beside the light"),
        ("walk = ceil(spread(", "", "what would come round the grid, its transfer function cuts"),
        ("rows, columns = (scipy.fft.next_fast_len(n + 2 * walk", "", "the same"),
        ("(np.where(np.arange(g)", "np.arange(g) < (n + g) // 2 → (np.arange(g) <= (n + g) // 2)",
         "a sample in the middle of the dark"),
    ],
    "chrmc/cgh/curved/verify.py": [
        ("if relative < min(_OPEN", "2 → 3", "when more pixels are drawn, not what they say"),
        ("_WAVES = ", "", "how many pixels are drawn"),
    ],
    "chrmc/compensation/ch_rmc_object/sphere.py": [
        ("for _ in range(20):", "20 → 21", "Newton's steps past convergence"),
        ("(float(alpha[0]), float(alpha[-1]))", "0 → 1", "a series holds one place past its end"),
        ("if np.max(np.abs(step)) <= _EXACT", "np.max(np.abs(step)) <= _EXACT * self.grid.step[1]"
         " * np.max(r) → (np.max(np.abs(step)) < _EXACT * self.grid.step[1] * np.max(r))",
         "measured numbers are not equal"),
        ("if first.min() < 0 or", "first.max() + rows > grid.count[1] → "
         "(first.max() + rows >= grid.count[1])", "one place of room"),
        ("if 2 * len(change) <= ", "2 * len(change) <= np.count_nonzero(visible) → "
         "(2 * len(change) < np.count_nonzero(visible))", "which of two equal costs"),
    ],
    "chrmc/cgh/curved/series.py": [
        ("counts.append(1 + node_count(1.15", "1.15 → 2.3", "more samples cost time"),
        ("if not len(enough) or", "_TRIED - 2 → (_TRIED + 2)", "which of two ways counts samples"),
        ("if not len(enough) or", "2 → 3", "the same"),
    ],
    "reconstruct/focus.py": [
        ("if not np.isfinite(depth) or rise", "rise * sqrt(grains) < PROMINENCE → "
         "(rise * sqrt(grains) <= PROMINENCE)", "measured numbers are not equal"),
        ("floor = ", "", "keeps 0/0 away"),
    ],
}  # fmt: skip
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
    if isinstance(tree, ast.keyword) and tree.arg in ("in_place", "overwrite_x", "workers"):
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
        yield node, ast.Constant(node.value + 1)
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
