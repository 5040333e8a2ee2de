"""Options of methods: known by name, and numbers where numbers are declared."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import chrmc
from chrmc.cgh.wrp import field as wrp
from chrmc.compensation.ch_rmc_paper.paper import frames as paper
from chrmc.compensation.nlut.mpeg_nlut import frames as mpeg
from chrmc.options import check_options


@pytest.mark.parametrize(
    ("method", "option", "value"),
    [
        (mpeg, "group", 1e15),
        (mpeg, "search", "x"),
        (wrp, "guard", "nan"),
        (wrp, "guard", float("nan")),
        (paper, "snr_threshold", "nan"),
        (paper, "rekey_image", True),
    ],
)
def test_what_is_no_number_is_refused(method: Any, option: str, value: Any) -> None:
    with pytest.raises(ValueError, match=f"option {option} must be a"):
        check_options("it", method, {option: value})


def test_numbers_of_any_kind_are_taken() -> None:
    check_options("it", mpeg, {"group": np.int64(3)})
    check_options("it", wrp, {"guard": 3})
    check_options("it", paper, {"snr_threshold": float("inf"), "rekey_image": None})


def test_a_bad_option_is_answered_before_its_work_is_counted(tmp_path: Path) -> None:
    scene = chrmc.load_scene("car-house")
    with pytest.raises(ValueError, match="option guard must be a finite number, not 'nan'"):
        chrmc.generate(scene, tmp_path / "video", cgh="wrp", compensation="none", guard="nan")
