"""Records and tables of benches that are damaged, or were put there by somebody else."""

import json
from pathlib import Path
from typing import Any

import pytest

from chrmc.bench.endurance import Endured
from chrmc.bench.kept import KeptRows
from chrmc.bench.tradeoff_table import COLUMNS, read_table

MADE = ["this machine"]
ROW = {"name": "a", "tolerance": 1e-3, "frames": 3, "error": 0.5, "early": 1.0, "late": 1.0,
       "keys": 1}  # fmt: skip
LINE = dict.fromkeys(COLUMNS, "1") | {"kind": "cgh", "refused": ""}


def record(folder: Path, content: Any) -> Path:
    path = folder / "r.json"
    path.write_text(json.dumps(content))
    return path


@pytest.mark.parametrize(
    "content",
    [
        [],
        {"made_with": None, "rows": []},
        {"made_with": MADE, "rows": {"a": 1}},
        {"made_with": MADE, "rows": [None]},
        *(
            {"made_with": MADE, "rows": [ROW | {key: value}]}
            for key, value in (
                ("name", 3), ("name", []), ("tolerance", []), ("error", "1"), ("keys", None),
                ("early", {}), ("other", 1), ("late", float("nan")),
            )
        ),
    ],
)  # fmt: skip
def test_a_record_of_other_things_is_refused(content: Any, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="is no record of a bench: remove it"):
        KeptRows(record(tmp_path, content), MADE, Endured)


def test_a_record_that_is_whole_is_read(tmp_path: Path) -> None:
    kept = KeptRows(record(tmp_path, {"made_with": MADE, "rows": [ROW]}), MADE, Endured)
    assert kept.of("a", 1e-3) == Endured(**ROW)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("column", "text"),
    [("runs", "1000000000000"), ("runs", "-1"), ("scene", " "), ("kind", "x"), ("seconds", "nan"),
     ("points", "9" * 5000), ("psnr_db", "dB")],
)  # fmt: skip
def test_a_table_of_other_things_is_refused(column: str, text: str, tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    lines = [",".join(COLUMNS), ",".join((LINE | {column: text}).values())]
    path.write_text("\n".join(["# made", *lines]) + "\n")
    with pytest.raises(ValueError, match="not what was written"):
        read_table(path)


def test_a_table_that_never_ends_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "t.csv").symlink_to("/dev/zero")
    with pytest.raises(OSError, match="is no file"):
        read_table(tmp_path / "t.csv")
