"""The command `chrmc`: finds commands by name, and turns every error into one line."""

import importlib.util
import os
import sys
from pathlib import Path
from typing import Any

import click

from chrmc.cli.lazy import LazyGroup
from chrmc.cli.signals import ended_by_signal, interrupted

# name: (module, one line for --help). Modules load when their command is called.
COMMANDS = {
    "demo": ("chrmc.cli.demo", "Everything at once: 80 holograms, reconstructions, a verdict."),
    "scene": ("chrmc.cli.scene", "Write a scene as OpenEXR frames, or as a scene.toml."),
    "inspect": ("chrmc.cli.inspect", "What will the SLM show of a scene? Sizes, points, cost."),
    "plan": ("chrmc.cli.plan", "Which method to take for a scene: time, error, memory."),
    "calibrate": ("chrmc.cli.calibrate", "Measure this machine's rates, for plans."),
    "generate": ("chrmc.cli.generate", "Make a hologram video from a scene."),
    "sweep": ("chrmc.cli.sweep", "One table of many settings: times, errors, focus, PSNR."),
    "play": ("chrmc.cli.play", "Show a video or picture on an SLM, full screen, and log it."),
    "reconstruct": ("chrmc.cli.reconstruct", "Reconstruct one frame at a depth."),
    "check": ("chrmc.cli.check", "Is every object in focus where the scene says?"),
    "montage": ("chrmc.cli.montage", "Holograms, and what they show at each object's depth."),
    "panorama": ("chrmc.cli.panorama", "The whole video in one picture (Fig. 14)."),
    "view": ("chrmc.cli.view", "Look around in a video: frames, depths, filters."),
    "bench": ("chrmc.cli.bench", "Measure speed, error and the paper's numbers."),
    "monitors": ("chrmc.cli.monitors", "List the monitors."),
    "panels": ("chrmc.cli.panels", "List the panels that --slm takes by name."),
    "serve": ("chrmc.cli.serve", "Show what another program or machine sends."),
    "live": ("chrmc.cli.live", "Generate and play at once, without files."),
    "calibrate-response": (
        "chrmc.cli.calibrate_response",
        "Measure what a panel's grey levels do to light.",
    ),
    "pattern": ("chrmc.cli.pattern", "Test pictures for setting up a bench."),
    "bench-sheet": ("chrmc.cli.bench_sheet", "What to build: orders, masks, camera distances."),
}


@click.group(
    cls=LazyGroup,
    table=COMMANDS,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 96},
)
@click.version_option(package_name="chrmc")
def group() -> None:
    """Holographic video for amplitude SLMs, from a moving 3-D scene to a checked focus.

    Start with:  chrmc demo

    Lengths are written with their unit (252mm, 8um, 532nm); bare numbers are metres. Completion in
    bash:  eval "$(_CHRMC_COMPLETE=bash_source chrmc)"  (zsh_source and fish_source likewise).
    """


def main(arguments: list[str] | None = None) -> None:
    """Run a command line. Exit status 2 and one line on stderr for whatever the user can mend."""
    if sys.stderr is None:  # closed by the caller: progress bars and warnings write there
        sys.stderr = Path(os.devnull).open("w")  # noqa: SIM115 - until the end
    hidden = hidden_package()
    if hidden is not None:
        fail(hidden)
    # Left only after the exceptions are gone: what their frames hold of C++ libraries would be
    # reported as leaked.
    status: Any = None
    why = ""
    try:
        with ended_by_signal():
            status = group.main(args=arguments, prog_name="chrmc", standalone_mode=False)
    except (click.exceptions.Abort, KeyboardInterrupt):
        status = interrupted()
    except click.ClickException as error:
        why = error.format_message()
    except MemoryError as error:
        less = str(error) or "a smaller panel, fewer points or fewer --workers take less"
        why = f"there is not enough memory: {less}"
    except OSError as error:
        why = in_words(error)
    except ValueError as error:
        why = str(error) or "ValueError"
    if why:
        fail(why)
    sys.exit(status if isinstance(status, int) else 0)


def hidden_package() -> str | None:
    """What hides one of this program's packages, in words: a file of that name in the folder that
    `python -m chrmc` was called in, say."""
    home = Path(__file__).parents[2].resolve()
    for name in ("chrmc", "display", "reconstruct"):
        spec = importlib.util.find_spec(name)
        found = None if spec is None or spec.origin is None else Path(spec.origin).resolve()
        if found != home / name / "__init__.py":
            where = found or "a folder without __init__.py"
            return f"{where} hides the package {name} of chrmc: rename it, or work elsewhere"
    return None


def in_words(error: OSError) -> str:
    """What the system refused, without its number; other messages as they are."""
    if error.strerror is None:
        return str(error) or f"{type(error).__name__} without a word of its own"
    if error.filename is None:
        return error.strerror
    if isinstance(error, FileExistsError):
        return f"{error.filename} is in the way: it is no folder"
    return f"{error.filename}: {error.strerror}"


def fail(message: str) -> None:
    """Print `message` as one line on stderr and exit with 2."""
    print("chrmc: " + " ".join(message.split()), file=sys.stderr)
    sys.exit(2)
