"""`chrmc check`: the verdict on a hologram video."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from chrmc.cli.arguments import FigurePath, frames_between, stacked
from chrmc.cli.lengths import OFFSET, Length
from chrmc.ranges import short

MOST_ASKED = 100_000
"""Frames that a list may name."""


class FrameList(click.ParamType):
    """1,21,51:60 or all."""

    name = "LIST"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> list[tuple[int, int]]:
        if isinstance(value, list):
            return value
        chosen: list[tuple[int, int]] = []
        if value == "all":
            return chosen
        for part in str(value).split(","):
            ends = frames_between(part)
            if ends is None:
                what = f"{short(value)} is no list of frames; write 1,21,51:60 or all"
                self.fail(what, param, ctx)
            if ends[0] > ends[1]:
                self.fail(f"{part.strip()} runs backwards; write 51:60", param, ctx)
            chosen.append(ends)
        if sum(last - first + 1 for first, last in chosen) > MOST_ASKED:
            self.fail(f"{short(value)} names more than {MOST_ASKED} frames", param, ctx)
        return chosen


def chosen_frames(asked: list[tuple[int, int]] | None, video: Any) -> list[int]:
    """Frame numbers to judge, all for an empty list; ValueError where one is not in the video."""
    from reconstruct.checking import chosen_frames

    if asked is None:
        return chosen_frames(None, video)
    numbers = [n for first, last in asked for n in range(first, last + 1)]
    return chosen_frames(numbers or list(video.numbers), video)


def drawn_video(frames: str) -> Callable[[Any], Any]:
    """Arguments of a command that draws frames of a video; frames : what --help says of them."""
    return stacked(
        click.argument("video", metavar="DIR", type=click.Path(path_type=Path)),
        click.option("--out", type=FigurePath(), required=True, help="A .png, .pdf or .svg."),
        click.option("--frames", type=FrameList(), default=None, help=frames),
    )


@click.command("check")
@click.argument("video", metavar="DIR", type=click.Path(path_type=Path))
@click.option(
    "--frames",
    type=FrameList(),
    default=None,
    help="Such as 1,21,51:60, or all. [1,21,51,80 where all are there, else four spread evenly]",
)
@click.option(
    "--depth-tolerance",
    type=Length(OFFSET),
    default=None,
    help="How far a focus may be off. [0.5mm, or half the depth of focus where that is more]",
)
@click.option(
    "--lateral-tolerance",
    type=Length(OFFSET),
    default=None,
    help="How far an object may be off sideways. [a scene pixel, or the resolution]",
)
@click.option(
    "--truth",
    is_flag=True,
    help="PSNR and SSIM too, against the reconstruction of the scene's own field.",
)
@click.option(
    "--scene",
    default=None,
    help="Name, file or folder of the scene, or FILE.py:NAME, for --truth. [the video's]",
)
@click.option(
    "--metrics", is_flag=True, help="Also where published focus metrics of each region peak."
)
@click.option("--json", "as_json", is_flag=True, help="Print everything as JSON.")
@click.option(
    "--plot",
    type=click.Path(path_type=Path),
    default=None,
    help="Draw the focus curves: .png, .pdf or .svg.",
)
def command(
    video: Path,
    frames: list[tuple[int, int]] | None,
    depth_tolerance: float | None,
    lateral_tolerance: float | None,
    truth: bool,
    scene: str | None,
    metrics: bool,
    as_json: bool,
    plot: Path | None,
) -> int:
    """Is every object of the video in DIR in focus where the scene says?

    Each object's best focus is looked for in the numeric 4-f reconstruction of the 8-bit frames
    themselves, and its picture is compared with the scene's map of its light: alike is the
    correlation of the light per cell, relief the depth found over the depth expected (blank where
    an object is too small or too shallow to tell). Exit status 0 when all is as it should be, 1
    when not.
    """
    from chrmc.figures import check_figure
    from chrmc.store.colour import open_video
    from reconstruct import report
    from reconstruct.checking import check, scene_of

    if plot is not None:
        check_figure(plot)
    stored = open_video(video)
    verdicts = check(
        stored,
        chosen_frames(frames, stored),
        scene=scene_of(stored, scene) if truth or scene else None,
        depth_tolerance=depth_tolerance,
        lateral_tolerance=lateral_tolerance,
        metrics=metrics,
    )
    if plot is not None:
        report.plot_curves(verdicts, plot)
    if as_json:
        click.echo(json.dumps(report.as_dict(verdicts), indent=1, allow_nan=False))
    else:
        for line in report.table(verdicts):
            click.echo(line)
        for line in report.metric_table(verdicts) if metrics else ():
            click.echo(line)
    return 0 if all(v.passed for v in verdicts) else 1
