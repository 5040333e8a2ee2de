"""A scene in the volume that an SLM shows: front view and top view."""

from pathlib import Path
from typing import Any

import numpy as np

from chrmc.encoding import coding_for
from chrmc.figures import check_figure, new_figure, save
from chrmc.inspection.report import MM, Optics, occupied
from chrmc.scene.scene import Scene
from chrmc.slm import SLM

PATHS = 200
"""Frames at most whose places are drawn as a path."""
DOTS = 20_000
"""Points at most drawn of each object."""


def write_inspection(scene: Scene, slm: SLM, wavelength: float, path: Path) -> None:
    """Front view (x–y, y down) above the top view (x–z) of frame 1, with paths of the objects."""
    check_figure(path)
    frame = scene.frame(1)
    clouds = [o.cloud for o in frame.objects]
    if not len(frame.cloud):
        raise ValueError(f"{scene.name}: nothing is visible in frame 1")
    low, high = occupied(clouds) * MM
    optics = Optics.at(
        float(frame.cloud.centroid[2]), slm, wavelength, coding_for("ssb", slm).passband
    )
    figure, (front, top) = new_figure((9, 9), 2, 1)
    for obj in frame.objects:
        some = slice(None, None, max(1, len(obj.cloud) // DOTS))
        x, y, z = obj.cloud.positions[some].T * MM
        light = obj.cloud.amplitude[some] / max(obj.cloud.amplitude.max(initial=0), 1e-300)
        colour = dict(c=light, cmap="gray", vmin=0, vmax=1, s=1.5, linewidths=0)
        front.scatter(x, y, **colour)
        drawn = top.scatter(x, z, label=obj.name, s=1.5, linewidths=0)
        path_x, path_y, path_z = _path(scene, obj.name)
        if len(path_x) > 1:
            shade: Any = drawn.get_facecolor()[0]
            front.plot(path_x, path_y, "-", lw=0.8, color=shade)
            top.plot(path_x, path_z, "-", lw=0.8, color=shade)
    panel = (slm.width * slm.pixel_pitch / 2, slm.height * slm.pixel_pitch / 2)
    shown = [
        1.1 * max(p, float(np.abs([a, b]).max()))
        for p, a, b in zip(np.array(panel) * MM, low, high, strict=False)
    ]  # the field of view itself may be far beyond
    wide, tall = (h * MM for h in optics.half_view)
    beyond = ", beyond the picture" if wide > shown[0] and tall > shown[1] else ""
    _frame(front, optics.half_view, f"field of view ±{wide:.3g} × ±{tall:.3g} mm{beyond}")
    _frame(front, panel, slm.name, "--")
    front.set_facecolor("black")
    front.set(xlabel="x / mm", ylabel="y / mm (down)", aspect="equal")
    front.set_title(f"{scene.name}, frame 1, from the SLM", fontsize=10)
    front.set(xlim=(-shown[0], shown[0]), ylim=(shown[1], -shown[1]))
    front.legend(fontsize=7, loc="upper right")
    focus = optics.focus[0] * MM
    for k, obj in enumerate(o for o in frame.objects if len(o.cloud)):
        near, far = (obj.depth * MM + side * focus / 2 for side in (-1, 1))
        label = "depth of focus" if k == 0 else None
        top.axhspan(near, far, color="0.85", zorder=0, label=label)
    margin = max(0.1 * (high[2] - low[2]), 2 * focus)
    top.set(xlabel="x / mm", ylabel="z / mm", ylim=(low[2] - margin, high[2] + margin))
    top.set_title("from above", fontsize=10)
    top.legend(fontsize=7, loc="upper right", markerscale=4)
    save(figure, path, dpi=110)


def _path(scene: Scene, name: str) -> Any:
    """(3, F) millimetres of a body's origin over the frames; empty where nobody knows."""
    numbers = np.unique(np.linspace(1, scene.frame_count, min(PATHS, scene.frame_count)))
    poses = [scene.pose(name, int(n)) for n in numbers]
    if any(p is None for p in poses):
        return np.zeros((3, 0))
    return np.array([p.translation for p in poses if p is not None]).T * MM


def _frame(axes: Any, half: tuple[float, float], label: str, style: str = "-") -> None:
    x, y = (h * MM for h in half)
    axes.plot([-x, x, x, -x, -x], [-y, -y, y, y, -y], style, lw=1, label=label)
