"""A panel's window, opened, polled and closed in the one thread that may."""

from collections.abc import Callable
from typing import Any

from chrmc.slm import LC_R_1080, SLM


def open_window(
    monitor: str | None, slm: SLM | None, windowed: bool, title: str
) -> tuple[SLM, Any, Callable[[], None], Callable[[], None]]:
    """The panel, its window, and how to close and to poll it; all of it done at home."""
    from display.home import home
    from display.monitors import choose, list_monitors
    from display.window import Window

    place = home()

    def open_it() -> tuple[SLM, Window]:
        panel = slm
        if panel is None:
            panel = LC_R_1080
            if monitor is not None and not windowed:
                found = choose(list_monitors(), monitor, panel, any_size=True)
                if not found.fits(panel):
                    panel = SLM(found.title, found.width, found.height, panel.pixel_pitch)
        window = Window(panel, monitor, windowed, title=title)
        window.unbind()
        return panel, window

    panel, window = place.call(open_it)
    place.watch(window.poll)

    def close_it() -> None:
        def end() -> None:
            place.forget(window.poll)
            window.close()

        place.call(end)

    return panel, window, close_it, place.poll
