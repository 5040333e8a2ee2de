"""Every monitor shows its own number, so that one sees which is which."""

import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from chrmc.slm import SLM
from display.monitors import Monitor


def show_numbers(monitors: Sequence[Monitor], seconds: float = 10.0) -> None:
    """Show each monitor its index, label, output and mode until a key is pressed or time is up."""
    from display.gl import Painter
    from display.window import Window

    if not seconds > 0:
        raise ValueError(f"--seconds must be positive, not {seconds:g}")
    windows = []
    try:
        for monitor in monitors:
            slm = SLM(monitor.title, monitor.width, monitor.height, 1e-5)
            window = Window(slm, str(monitor.index), title=f"monitor {monitor.index}")
            windows.append(window)
            painter = Painter(window.context, slm.shape)
            painter.upload(number_picture(monitor))
            # Twice, so that both of the window's buffers hold it.
            for _ in range(2):
                painter.draw(window.size)
                window.flip()
            window.unbind()
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            for window in windows:
                window.poll()
                if window.closed or window.pressed():
                    return
            time.sleep(0.02)
    finally:
        for window in windows:
            window.close()


def number_picture(monitor: Monitor) -> NDArray[np.uint8]:
    """(height, width) grey levels: the number, large, and below it what else is known."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    width, height = monitor.width, monitor.height
    figure = Figure(figsize=(width / 100, height / 100), dpi=100, facecolor="black")
    canvas = FigureCanvasAgg(figure)
    lines = [monitor.label, monitor.name, f"{width} × {height} at ({monitor.x}, {monitor.y})"]
    size = min(height, 0.7 * width)
    points = 0.72 * size
    figure.text(
        0.5, 0.6, str(monitor.index), color="white", size=0.5 * points, ha="center", va="center"
    )
    figure.text(
        0.5,
        0.2,
        "\n".join(filter(None, lines)),
        color="white",
        size=0.05 * points,
        ha="center",
        va="center",
    )
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:height, :width, 0].copy()
