"""On how many pixels of which frames the stored error is measured, within a share of the time.

Counted, not timed: the same recipe is checked on the same pixels on every machine.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil
from typing import Any

from chrmc.cgh import OperationCounts, method_named
from chrmc.cgh.counts import STATED
from chrmc.options import option_names
from chrmc.planning.choices import GROUP, first_lit
from chrmc.ranges import Range
from chrmc.scene.scene import Scene
from chrmc.slm import SLM
from chrmc.window import Window

SHARE = 0.05
"""Of the time that frames take, which their check may take, where nothing else is asked for."""
SHARES = Range("check_share", 0.0, 1.0, unit="")
MOST, LEAST = 256, 16
"""Pixels of a frame that is checked."""
_WAVE = 20.0  # of the truth, in phasors
_REUSED = 0.4  # of what a frame afresh takes, where frames are made of others


@dataclass(frozen=True)
class Check:
    """Pixels of a checked frame; every so manieth frame is, beside the first and the last of the
    scene and the first of each group."""

    pixels: int
    every: int = 1

    def includes(self, number: int, last: int, group: int) -> bool:
        """Whether a frame is checked. last : of the scene; group : frames of one."""
        if self.pixels < 1:
            return False
        begins = group > 1 and (number - 1) % group == 0
        return number == last or begins or (number - 1) % self.every == 0


def check_within(
    share: float,
    scene: Scene,
    slm: SLM,
    wavelength: float,
    passband: Any,
    cgh: Any,
    compensation: Any,
    options: dict[str, Any],
) -> Check:
    """As many pixels, then as many frames, as a share of the counted time allows."""
    if share <= 0:
        return Check(0)
    cloud = first_lit(scene, range(1, scene.frame_count + 1)).cloud
    method = method_named(cgh)
    if method.cost is None or not len(cloud):
        return Check(MOST)
    known, _ = option_names(method.cost)
    own = {name: value for name, value in options.items() if name in known}
    try:
        method.check(own)
        counts: OperationCounts = method.cost(
            cloud, slm, wavelength, Window.full(slm), passband, **own
        )
    except ValueError:  # which the method says better once it is asked
        return Check(MOST)
    seconds = STATED.seconds(counts, method.shares_cores)
    if compensation != "none":
        seconds *= _REUSED
    pixel = STATED.seconds(OperationCounts(phasors=_WAVE * len(cloud)), False)
    pixels = int(share * seconds / pixel)
    if pixels >= LEAST:
        return Check(min(pixels, MOST))
    # The frames that are checked always are part of it.
    frames = scene.frame_count
    others = share * seconds * frames / (LEAST * pixel) - 2 - frames / GROUP
    return Check(LEAST, ceil(frames / others) if others >= 1 else frames)


def stored_check(manifest: Mapping[str, Any]) -> Check | None:
    """How the video of a manifest is checked; None where that does not say."""
    try:
        found = manifest["error_check"]
        check = Check(int(found["pixels"]), int(found.get("every", 1)))
    except (ValueError, KeyError, TypeError, AttributeError):
        return None
    return check if 0 <= check.pixels <= MOST and check.every >= 1 else None
