"""`chrmc play`: a video or picture on an SLM, a preview window, or headless."""

import contextlib
from pathlib import Path
from typing import Any

import click

from chrmc.cli.arguments import FigurePath, FrameRange, SLMType, stacked
from chrmc.cli.lengths import WAVELENGTH, Lengths
from chrmc.cli.signals import ended_by_signal
from chrmc.cli.surface import place_options, screen_on
from chrmc.slm import SLM

CHANNELS = ("all", "red", "green", "blue")
CORNERS = ("top-left", "top-right", "bottom-left", "bottom-right")


surface_options = stacked(
    place_options,
    click.option(
        "--log",
        type=click.Path(path_type=Path, dir_okay=False),
        default=None,
        help="One CSV line per flip; a histogram beside it.",
    ),
    click.option(
        "--plot",
        type=FigurePath(),
        default=None,
        help="The histogram of the intervals: a .png, .pdf or .svg. [beside --log, .png]",
    ),
    click.option("--fps", type=float, default=None, help="Frames per second."),
    click.option("--every", type=int, default=None, help="Flips per frame. [1]"),
    click.option("--seconds", type=float, default=None, help="Stop after so long."),
    click.option(
        "--channel",
        type=click.Choice(CHANNELS),
        default="all",
        show_default=True,
        help="Colour channel that the panel shows.",
    ),
    click.option(
        "--trigger",
        type=click.Choice(CORNERS),
        default=None,
        is_flag=False,
        flag_value="bottom-right",
        help="A square in a corner that toggles with every frame, for a photodiode.",
    ),
    click.option(
        "--trigger-size", type=int, default=40, show_default=True, help="Its side, pixels."
    ),
    click.option(
        "--verify",
        is_flag=True,
        help="Read every frame back from the graphics card and compare it to the pixel; exit 1 on "
        "a difference.",
    ),
    click.option(
        "--verify-screen",
        is_flag=True,
        help="The same with what the monitor's part of the desktop shows (X11).",
    ),
    click.option(
        "--start-on",
        metavar="key|TIME",
        default=None,
        help="Stay dark until a key, or a time such as 20:15:30 or 2026-11-21T20:15:30.",
    ),
    click.option("--countdown", type=float, default=0.0, help="Count down so many seconds first."),
    click.option("--udp", metavar="HOST:PORT", default=None, help="A datagram at every new frame."),
    click.option("--serial", metavar="PORT", default=None, help="A byte at every new frame."),
)


@click.command("play")
@click.argument("target", metavar="DIR|PICTURE", type=click.Path(path_type=Path))
@surface_options
@click.option("--loop", is_flag=True, help="Begin again after the last frame.")
@click.option(
    "--frames", type=FrameRange(), default=None, help="Frames A to B of a video, inclusive. [all]"
)
@click.option(
    "--slm",
    type=SLMType(),
    default=None,
    help="lc-r-1080, or WIDTHxHEIGHT:PITCH. [the video's; lc-r-1080 for a picture]",
)
@click.option(
    "--on-bad-frame",
    type=click.Choice(["skip", "stop"]),
    default="skip",
    show_default=True,
    help="A missing or corrupt frame is named, then skipped or the end.",
)
@click.option("--ahead", type=int, default=8, show_default=True, help="Frames read ahead.")
@click.option(
    "--bit-planes",
    type=click.IntRange(1, 24),
    default=None,
    help="So many binary frames in one colour frame, for micromirror controllers.",
)
@click.option(
    "--colours",
    type=click.Choice(["sequence", "channels"]),
    default="sequence",
    show_default=True,
    help="Of a video in colours: its lasers one after the other, --fps counting whole frames, or "
    "each in a colour channel.",
)
@click.option(
    "--order",
    type=Lengths(WAVELENGTH),
    default=None,
    help="Of its lasers, such as 532nm,638nm,450nm; in channels: red, green, blue. [its own]",
)
def command(
    target: Path,
    loop: bool,
    frames: tuple[int, int] | None,
    slm: SLM | None,
    on_bad_frame: str,
    ahead: int,
    bit_planes: int | None,
    colours: str,
    order: Any,
    **shown: Any,
) -> int:
    """Show a generated video (its folder) or a single picture, pixel for pixel.

    A video plays once, one frame per refresh, and ends; a picture stays until Esc (headless: for
    one flip). Keys: space pause, arrows step, page up and down 10 frames, home and end, digits and
    enter jump to a frame, l loop, Esc quit.

    Exit status 1 when a frame could not be shown, --verify found a difference, or the window was
    moved or covered while playing.
    """
    from display.playlist import open_playlist
    from display.reels import ring_of

    order = (order,) if isinstance(order, float) else order
    playlist = open_playlist(target, slm, frames, order)
    if ahead < 1:
        raise ValueError(f"--ahead must be at least 1 frame, not {ahead}")
    hold = not target.is_dir() and not shown["headless"]
    trigger = trigger_of(shown)
    with ring_of(playlist, loop, ahead, bit_planes or 0, colours, trigger) as ring:
        return show(
            ring, playlist.slm, playlist.name,
            loop=loop, hold=hold, on_bad_frame=on_bad_frame, **shown,
        )  # fmt: skip


def trigger_of(options: dict[str, Any]) -> Any:
    """The trigger square that the options mean, or None."""
    from display.gl import Trigger

    corner = options["trigger"]
    return None if corner is None else Trigger(corner, options["trigger_size"])


def show(
    reel: Any,
    slm: SLM,
    name: str,
    *,
    headless: bool,
    log: Path | None,
    plot: Path | None,
    **options: Any,
) -> int:
    """Open the surface that the options mean, play a reel on it, and report; the exit status."""
    from chrmc.files import still_there
    from display.log import plot_intervals

    if options["verify_screen"] and headless:
        raise ValueError("--verify-screen reads a monitor: use --verify with --headless")
    playing = {
        name: options[name]
        for name in ("fps", "every", "seconds", "loop", "hold", "on_bad_frame", "start_on")
        if name in options  # a test picture has no loop
    }
    with contextlib.ExitStack() as stack:
        stack.enter_context(ended_by_signal(even_under_nohup=True))
        screen = stack.enter_context(
            screen_on(
                {**options, "headless": headless},
                slm,
                f"chrmc: {name}",
                channel=options["channel"],
                trigger=trigger_of(options),
                on_flip=_marks(options["udp"], options["serial"], stack, _lasers(reel)),
                log=log,
                verify="screen" if options["verify_screen"] else "frames" * options["verify"],
            )
        )
        click.echo(f"{name} on {screen.name}" + ("" if headless else "; Esc ends"))
        flips = screen.play(
            reel,
            **playing,
            countdown=options["countdown"],
            paced=not headless or options["every"] is not None,
        )
        interrupted = False
        try:
            for _ in flips:
                pass
        except KeyboardInterrupt:
            interrupted = True
        summary = screen.summary()
    for line in summary.lines():
        click.echo(line)
    written = []
    if log is not None:
        still_there(log.parent)
        written = [f"flips in {log}", f"monitor and versions in {log.with_suffix('.json')}"]
        plot = plot or log.with_suffix(".png")
    if plot is not None:
        plot_intervals(summary, plot, f"{name} on {screen.name}")
        written.append(f"histogram in {plot}")
    if written:
        click.echo(", ".join(written))
    if interrupted:
        raise KeyboardInterrupt
    return 1 if summary.faults or summary.mismatches or summary.misplaced else 0


def _lasers(reel: Any) -> list[str]:
    """Names of the lasers that a reel shows one after the other."""
    return list(getattr(reel, "lasers", []))


def _marks(
    udp: str | None, serial: str | None, stack: contextlib.ExitStack, lasers: list[str]
) -> Any:
    """What every flip calls, or None; lasers in sequence are told apart by bytes 1, 2, 3."""
    from display.colours import laser_bytes
    from display.marks import SerialMark, UDPMark

    marks: list[Any] = []
    if udp is not None:
        marks.append(UDPMark(udp, laser_bytes(lasers) if lasers else None))
    if serial is not None:
        marks.append(SerialMark(serial, laser_bytes(lasers) if lasers else b"\x01"))
    for mark in marks:
        stack.callback(mark.close)

    def send(flip: Any) -> None:
        for mark in marks:
            mark(flip)

    return send if marks else None
