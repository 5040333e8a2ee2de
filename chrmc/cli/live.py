"""`chrmc live`: generate and play at once, without files."""

import hashlib
from collections.abc import Iterator
from typing import Any

import click

from chrmc.cli.arguments import by_panel, recipe_options
from chrmc.cli.budget import Budget
from chrmc.cli.play import show, surface_options
from chrmc.cli.scene_options import SCENE_NAMES, scene_from, scene_options, things_argument
from chrmc.slm import SLM


@click.command("live")
@things_argument
@recipe_options
@scene_options
@click.option("--loop", is_flag=True, help="Begin again after the last frame.")
@click.option("--ahead", type=int, default=3, show_default=True, help="Frames made ahead.")
@click.option(
    "--budget",
    type=Budget(),
    default=None,
    help="Time per frame, or frames per second, that is kept by loosening the tolerance.",
)
@click.option(
    "--loosest",
    type=float,
    default=None,
    help="Largest tolerance that --budget may come to. [1e-2, or --tolerance]",
)
@surface_options
def command(
    sources: tuple[str, ...],
    frames: tuple[int, int] | None,
    slm: SLM,
    wavelength: float | tuple[float, ...] | None,
    form: str,
    loop: bool,
    ahead: int,
    budget: float | None,
    loosest: float | None,
    **rest: Any,
) -> int:
    """Generate SCENE and show it at once: on a monitor, in a window, or headless.

    SCENE is what `chrmc generate` takes.

    A thread makes the frames, the player shows each as soon as it is there and its flip has come.
    With --budget the tolerance of each frame lies between --tolerance and --loosest, as loose as
    the time asks for; the log names it beside the frame. At the end it says which rate was
    reached and what limited it.
    """
    from chrmc.generation.group import grey_levels
    from chrmc.generation.paced import pace_for, paced
    from chrmc.generation.recipe import recipe_for
    from chrmc.grey_levels import video_scale
    from chrmc.scene.scene import frame_range
    from display.live import LiveReel
    from display.playlist import Picture

    if ahead < 1:
        raise ValueError(f"--ahead must be at least 1 frame, not {ahead}")
    if isinstance(wavelength, tuple) or isinstance(rest["response"], tuple):
        raise ValueError("live shows one --wavelength: make a video in colours with generate")
    names = ("cgh", "compensation", "surface", "tolerance", "encoding", "gamma", "response")
    chosen = by_panel({name: rest.pop(name) for name in (*names, "settings")})
    sized = {name: rest.pop(name) for name in SCENE_NAMES}
    scene = scene_from(sources, form, slm, wavelength, sized)
    recipe = recipe_for(scene, slm, wavelength, check_pixels=0, **chosen)
    if recipe.auto_line:
        click.echo(recipe.auto_line)
    pace = None if budget is None else pace_for(recipe, budget, loosest)
    numbers = frame_range(recipe.scene, frames)
    scale = video_scale(recipe.scene, slm, recipe.wavelength, recipe.coding)
    stages: dict[str, float] = {}

    def make() -> Iterator[Picture]:
        if pace is None:
            frames = recipe.video(numbers[0], numbers[-1])
        else:
            frames = paced(recipe, numbers, pace)
        for frame in frames:
            levels = grey_levels(frame, recipe, scale)
            for name, seconds in frame.record.stage_seconds.items():
                stages[name] = stages.get(name, 0.0) + seconds
            # Only the log asks for it, and it costs milliseconds.
            digest = hashlib.sha256(levels.data).hexdigest() if rest["log"] else ""
            had = "" if pace is None else f" at {pace.tolerance:.2g}"
            yield Picture(frame.number, f"live {frame.number}{had}", digest, levels)

    with LiveReel(make, loop, ahead) as reel:
        reel.numbers = list(numbers)
        status = show(
            reel, slm, f"{recipe.scene.name}, live",
            loop=loop, hold=False, on_bad_frame="stop", **rest,
        )  # fmt: skip
        report = reel.report()
    if pace is not None and pace.frames:
        click.echo(pace.summary())
    for line in verdict(report, stages):
        click.echo(line)
    return status


def verdict(report: Any, stages: dict[str, float]) -> Iterator[str]:
    """The rate reached and what limits it, in words."""
    if not report.frames:
        return
    total = report.busy + report.blocked
    yield (
        f"generator: {report.frames} frames, {1e3 * report.busy / report.frames:.1f} ms each, so "
        f"up to {report.rate:.1f} frames per second"
    )
    if report.blocked > 0.2 * total:
        yield f"limit: the display; the generator waited for it {report.blocked / total:.0%}"
        return
    if stages:
        spent = ", ".join(
            f"{name} {1e3 * seconds / report.frames:.1f} ms"
            for name, seconds in sorted(stages.items(), key=lambda item: -item[1])
        )
        rest = max(0.0, report.busy - sum(stages.values())) / report.frames
        yield f"limit: the generator ({spent}, the rest {1e3 * rest:.1f} ms)"
    else:
        yield "limit: the generator"
