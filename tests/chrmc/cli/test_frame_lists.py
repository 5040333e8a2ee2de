"""Frames on the command line, as --frames takes them."""

import click
import pytest

from chrmc.cli.arguments import FrameRange
from chrmc.cli.check import FrameList


def test_lists_and_ranges() -> None:
    assert FrameList().convert("1,21,51:60", None, None) == [(1, 1), (21, 21), (51, 60)]
    assert FrameList().convert("all", None, None) == []
    assert FrameRange().convert("3:80", None, None) == (3, 80)


@pytest.mark.parametrize("text", ["1:99999999999", "1:999999999", "9" * 5000, "²", "1,", "60:51"])
def test_lists_that_no_video_has(text: str) -> None:
    with pytest.raises(click.BadParameter) as raised:
        FrameList().convert(text, None, None)
    assert len(raised.value.message) < 120


@pytest.mark.parametrize("text", ["9" * 5000, "²", "1:99999999999"])
def test_ranges_that_no_scene_has(text: str) -> None:
    with pytest.raises(click.BadParameter):
        FrameRange().convert(text, None, None)
