"""A stored video on a screen, in one call."""

from os import PathLike, fspath
from pathlib import Path
from typing import Any

from chrmc.store.colour import ColourVideo, open_video
from chrmc.store.video import Video
from display.screen import Screen
from display.timing import Summary


def play(
    video: Video | ColourVideo | str | PathLike[str],
    monitor: str | int | None = None,
    *,
    headless: bool = False,
    windowed: bool = False,
    fps: float | None = None,
    log: str | Path | None = None,
    verify: str = "",
    **playing: Any,
) -> Summary:
    """Play a stored video, or the folder of one, to its end, and say how it went.

    monitor, headless, windowed, log, verify : as `display.Screen`
    fps, playing : as `Screen.play`: loop, seconds, every, hold, start_on, …

    Without a screen frames follow each other as fast as they come, unless a rate is given.
    """
    stored = video if isinstance(video, Video | ColourVideo) else open_video(fspath(video))
    if headless and fps is None:
        playing.setdefault("paced", playing.get("every") is not None)
    with Screen(
        monitor, slm=stored.slm, headless=headless, windowed=windowed, log=log, verify=verify
    ) as screen:
        for _ in screen.play(stored, fps, **playing):
            pass
        return screen.summary()
