"""What keys and buttons do: a model, the tool in hand, marks, messages. No GUI."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from chrmc.store.colour import ColourVideo
from reconstruct.sequence import following
from reconstruct.viewer import saving
from reconstruct.viewer.compare import MODES as COMPARISONS
from reconstruct.viewer.keys import action_of
from reconstruct.viewer.lasers import Source, leading
from reconstruct.viewer.measure import Region, Statistics, statistics
from reconstruct.viewer.model import ViewerModel
from reconstruct.viewer.pipeline import Picture
from reconstruct.viewer.recent import note_recent, read_recent
from reconstruct.viewer.shade import COLOURS, MODES
from reconstruct.viewer.sources import open_source, title_of, titles_of
from reconstruct.viewer.view import View

TOOLS = ("focus", "line", "region")
SAVES = (
    ("picture (PNG)", ".png", "picture"),
    ("intensities (EXR)", ".exr", "picture"),
    ("figure (PDF)", ".pdf", "figure"),
    ("figure (SVG)", ".svg", "figure"),
    ("figure (PNG)", "_figure.png", "figure"),
    ("movie of all frames (GIF)", "_frames.gif", "frames"),
    ("movie through the depths (GIF)", "_depths.gif", "stack"),
    ("movie of all frames (MP4)", "_frames.mp4", "frames"),
    ("movie through the depths (MP4)", "_depths.mp4", "stack"),
)
"""What the list of files to save offers: words, end of the name, and what is made."""
FOURIER_SIDE = 1000
"""Units of the Fourier plane's picture along a side: it is square, as the plane is."""
STEP = 1e-4
"""Metres that the depth keys step by."""
READABLE = 6.0
"""Seconds that a message stays."""


class Session:
    """One viewer's state beyond the pictures.

    tool : what dragging on a reconstruction does, one of TOOLS
    help : whether the keys are shown
    asking : whether a path to open is asked for; leaving : whether the window is to be closed
    show_marks : the marks' figures are to come to the front, once
    views : zoom and pan of "hologram" and "fourier"
    path : what was typed there
    folder : where files are saved; recent_file : the list of what was opened, or None
    """

    def __init__(
        self,
        videos: Source | Sequence[Source],
        wake: Callable[[], None] = lambda: None,
        folder: Path | None = None,
        recent_file: Path | None = None,
    ) -> None:
        self._wake = wake
        self.folder = Path.cwd() if folder is None else folder
        self.recent_file = recent_file
        self.tool = TOOLS[0]
        self.help = self.asking = self.leaving = self.show_marks = False
        self.message = self.path = ""
        self._message_until = 0.0
        self._show(videos)

    def _show(self, videos: Source | Sequence[Source]) -> None:
        self.model = ViewerModel(videos, self._wake)
        self._statistics: tuple[Region, Picture, Statistics] | None = None
        slm = self.model.video.slm
        self.views = {
            "hologram": View(slm.width, slm.height),
            "fourier": View(FOURIER_SIDE, FOURIER_SIDE),
        }
        if self.recent_file is not None:
            for video in self.model.sources:
                single = (
                    not isinstance(video, ColourVideo)
                    and not video.methods
                    and title_of(video) == video.scene.get("name")
                )
                path = leading(video).path(video.numbers[0]) if single else video.folder
                note_recent(self.recent_file, path)

    @property
    def title(self) -> str:
        """Of the window."""
        return " and ".join(titles_of(self.model.sources)) + " - chrmc"

    def say(self, message: str) -> None:
        """Tell the user, for a few seconds."""
        self.message, self._message_until = message, time.monotonic() + READABLE

    @property
    def told(self) -> str:
        """The message that is shown now, or nothing."""
        return self.message if time.monotonic() < self._message_until else ""

    def update(self) -> bool:
        """What the model does for each picture of the window; whether anything new came."""
        fresh = self.model.update()
        for message in self.model.messages():
            self.say(message)
            fresh = True
        return fresh

    def press(self, name: str) -> bool:
        """Do what a key does, "Ctrl+Z" or "Space"; whether it does anything."""
        action = action_of(name)
        if action is None:
            return False
        getattr(self, action)()
        return True

    def statistics(self) -> Statistics | None:
        """Of the marked region of what is shown; kept until either changes."""
        region, picture = self.model.region, self.model.picture(self.model.front)
        if region is None or picture is None:
            return None
        if self._statistics is None or self._statistics[:2] != (region, picture):
            shape = picture.light.shape[0], picture.light.shape[1]
            part = region.scaled(self.model.video.slm.shape, shape)
            self._statistics = region, picture, statistics(picture.light, part)
        return self._statistics[2]

    # --- files ---

    def open(self, path: str | Path) -> bool:
        """Look at another video or picture; a fault is told, and all stays as it was."""
        try:
            video = open_source(Path(path).expanduser())
        except (OSError, ValueError) as error:
            self.say(" ".join(str(error).split()))
            return False
        self.model.close()
        self._show(video)
        self.say(f"opened {path}")
        return True

    def recent(self) -> list[Path]:
        """What was opened lately, newest first."""
        return [] if self.recent_file is None else read_recent(self.recent_file)

    def save(self, ending: str, kind: str) -> None:
        """Write a file into the folder, beside all else; what came of it is told."""
        model = self.model
        front = model.front
        decoded = model.decoded(front)
        if decoded is None or decoded.frame.number != model.number:
            self.say(model.fault(front) or "there is no picture yet")
            return
        path = self.folder / (model.suggested_name() + ending)
        video, request, look = model.sources[front], model.request, model.snapshot().look
        job: Any
        if kind == "picture" and model.comparing and model.mode == "difference":
            held = model.comparison
            if (
                held is None
                or held.coarse
                or held.ssim is None
                or held.request.subject != request.subject
            ):
                self.say("the difference is not sharp yet")
                return
            names = titles_of(model.sources)
            stem = f"{names[1]}_less_{names[0]}".replace("/", "_")
            path = path.with_name(f"{stem}_{path.name}")
            note = saving.settings_of(video, request, look) | {"sources": names}
            job = lambda: saving.save_difference(path, held, look, note)  # noqa: E731
        elif kind == "picture":
            job = lambda: saving.save_picture(path, video, decoded, request, look)  # noqa: E731
        elif kind == "figure":
            part = self.visible_part()
            job = lambda: saving.save_figure(path, video, decoded, request, look, part)  # noqa: E731
        elif kind == "frames":
            numbers = list(model.numbers)
            depths = [request.depth] * len(numbers)
            if model.follow is not None:
                depth_of = following(model.videos[front], model.follow)
                depths = [depth_of(n) for n in numbers]
            path = self.folder / f"{title_of(video)}{ending}"
            job = lambda: saving.save_frames(  # noqa: E731
                path, video, numbers, depths, request.filter, look, model.rate,
                saving.settings_of(video, request, look),
            )  # fmt: skip
        else:
            path = self.folder / f"{title_of(video)}_frame_{model.number:04d}{ending}"
            depths_ = model.depth_range
            note = saving.settings_of(video, request, look)
            job = lambda: saving.save_stack(path, decoded, depths_, look, model.rate, note)  # noqa: E731
        model.run_errand(job)
        self.say(f"saving {path}")

    def visible_part(self) -> tuple[slice, slice]:
        """Rows and columns of the panel that the reconstruction shows."""
        view = self.model.view
        left, top = view.to_picture(0, 0)
        right, bottom = view.to_picture(view.screen_width, view.screen_height)
        rows = slice(max(int(top), 0), max(min(int(np.ceil(bottom)), view.height), int(top) + 2))
        columns = slice(max(int(left), 0), max(min(int(np.ceil(right)), view.width), int(left) + 2))
        return rows, columns

    def save_picture(self) -> None:
        self.save(".png", "picture")

    def save_intensities(self) -> None:
        self.save(".exr", "picture")

    def save_figure(self) -> None:
        self.save(".pdf", "figure")

    def ask_to_open(self) -> None:
        self.asking = True

    # --- frames and depth ---

    def play(self) -> None:
        self.model.playing = not self.model.playing

    def frame_before(self) -> None:
        self.model.step(-1)

    def frame_after(self) -> None:
        self.model.step(1)

    def first_frame(self) -> None:
        self.model.index = 0

    def last_frame(self) -> None:
        self.model.index = len(self.model.numbers) - 1

    def go_deeper(self, metres: float) -> None:
        """Change the depth by hand: no object is followed any more."""
        self.model.follow = None
        self.model.depth += metres

    def deeper(self) -> None:
        self.go_deeper(STEP)

    def nearer(self) -> None:
        self.go_deeper(-STEP)

    def much_deeper(self) -> None:
        self.go_deeper(10 * STEP)

    def much_nearer(self) -> None:
        self.go_deeper(-10 * STEP)

    def next_object(self) -> None:
        depths = sorted(float(t.position[2]) for t in self.model.objects())
        if not depths:
            self.say("this frame tells of no objects")
            return
        self.model.follow = None
        behind = [d for d in depths if d > self.model.depth + 1e-6]
        self.model.depth = behind[0] if behind else depths[0]

    def find_curves(self) -> None:
        if not self.model.objects():
            self.say("this frame tells of no objects")
            return
        self.model.find_curves()

    # --- what is shown, and how ---

    def show_intensity(self) -> None:
        self.model.look.mode = MODES[0]

    def show_log(self) -> None:
        self.model.look.mode = MODES[1]

    def show_phase(self) -> None:
        self.model.look.mode = MODES[2]

    def next_colours(self) -> None:
        look = self.model.look
        look.colours = COLOURS[(COLOURS.index(look.colours) + 1) % len(COLOURS)]

    def fit(self) -> None:
        for view in (self.model.view, *self.views.values()):
            view.fit()

    def use_line(self) -> None:
        self.tool = TOOLS[0] if self.tool == "line" else "line"
        self.show_marks = self.tool == "line"

    def use_region(self) -> None:
        self.tool = TOOLS[0] if self.tool == "region" else "region"
        self.show_marks = self.tool == "region"

    def other_video(self) -> None:
        self.model.active = (self.model.active + 1) % len(self.model.videos)

    def next_mode(self) -> None:
        if self.model.comparing:
            at = COMPARISONS.index(self.model.mode)
            self.model.mode = COMPARISONS[(at + 1) % len(COMPARISONS)]

    def undo(self) -> None:
        if not self.model.undo():
            self.say("this is the first view")

    def redo(self) -> None:
        if not self.model.redo():
            self.say("this is the last view")

    def toggle_help(self) -> None:
        self.help = not self.help

    def escape(self) -> None:
        """Close what is open, else put the tool away, else drop marks, else stop long work."""
        model = self.model
        if self.asking or self.help:
            self.asking = self.help = False
        elif self.tool != TOOLS[0]:
            self.tool = TOOLS[0]
        elif any(mark is not None for mark in (model.line, model.region, model.found)):
            model.line = model.region = model.found = None
        else:
            model.stop()

    def leave(self) -> None:
        self.leaving = True
