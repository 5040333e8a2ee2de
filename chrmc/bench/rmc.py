"""How the published CH-RMC fares along a scene: field error and images, with and without re-keying.

The fields are judged, not grey levels: error of the whole frame and of the worst object alone
against recomputation by the same CGH method, PSNR of the worst object's image at its depth.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from chrmc.cgh import DEFAULT_METHOD
from chrmc.compensation import video
from chrmc.record import FrameRecord
from chrmc.scene.scene import Scene
from chrmc.slm import SLM, WAVELENGTH

REKEY_ERROR = 0.1
"""Field-error limit of the run that re-keys, unless the user names one."""


@dataclass(frozen=True)
class Run:
    """One pass over a scene. label : with or without re-keying; records : one per frame"""

    scene: str
    label: str
    records: tuple[FrameRecord, ...]

    @property
    def numbers(self) -> list[int]:
        """Frame numbers."""
        return [r.number for r in self.records]

    @property
    def keys(self) -> list[int]:
        """Numbers of the key frames."""
        return [r.number for r in self.records if r.key]

    @property
    def errors(self) -> list[float]:
        """Relative field error of every frame."""
        return [r.error_reuse or 0.0 for r in self.records]

    @property
    def own_errors(self) -> list[float]:
        """Relative field error of the worst object alone, of every frame."""
        return [
            max((o.get("error_reuse", 0.0) for o in r.objects), default=0.0) for r in self.records
        ]

    def measure(self, name: str) -> list[float]:
        """The worst object's "psnr", "ssim" or largest |"shift_x"| … of every frame."""
        values = [[entry[name] for entry in r.image.values()] for r in self.records]
        if name in ("psnr", "ssim"):
            return [min(v, default=np.nan) for v in values]
        return [max((abs(x) for x in v), default=np.nan) for v in values]

    def summary(self) -> dict[str, float]:
        """Figures of the frames that were carried; of all where every frame is a key."""
        carried = [k for k, r in enumerate(self.records) if not r.key] or range(len(self.records))
        at = np.array(carried)
        errors, psnr = np.array(self.errors)[at], np.array(self.measure("psnr"))[at]
        seconds = [sum(r.stage_seconds.values()) for r in self.records]
        return {
            "keys": len(self.keys),
            "error_median": float(np.median(errors)),
            "error_worst": float(errors.max()),
            "own_median": float(np.median(np.array(self.own_errors)[at])),
            "own_worst": float(np.array(self.own_errors)[at].max()),
            "psnr_median": float(np.median(psnr)),
            "psnr_worst": float(psnr.min()),
            "ssim_worst": float(np.array(self.measure("ssim"))[at].min()),
            "shift_worst": float(np.array(self.measure("shift_x"))[at].max()),
            "points": float(np.mean([r.points_computed for r in self.records])),
            "point_pixels": float(np.mean([r.point_pixels for r in self.records])),
            "blank": float(np.mean([self.records[k].blank_share for k in carried])),
            "seconds": float(np.mean(seconds)),
        }


def runs(
    scenes: list[Scene],
    slm: SLM,
    wavelength: float = WAVELENGTH,
    *,
    cgh: str = DEFAULT_METHOD,
    encoding: str = "ssb",
    frames: tuple[int, int] | None = None,
    rekey: dict[str, Any] | None = None,
    watch: Callable[[Iterator[Any], str], Iterator[Any]] | None = None,
    **options: Any,
) -> Iterator[Run]:
    """Each scene without and with re-keying.

    rekey : the options of the run that re-keys, default rekey_error = REKEY_ERROR
    watch : wraps the frames of a run, called with a label, for a progress bar
    options : of the video method and the CGH method, in both runs
    """
    again = {"rekey_error": REKEY_ERROR} if rekey is None else rekey
    for scene in scenes:
        for label, extra in (("no re-keying", {}), (_label(again), again)):
            sequence = video(
                scene,
                slm,
                wavelength,
                cgh=cgh,
                compensation="ch-rmc-paper",
                frames=frames,
                coding=encoding,
                measure=True,
                **{**options, **extra},
            )
            watched = sequence if watch is None else watch(sequence, f"{scene.name}, {label}")
            yield Run(scene.name, label, tuple(frame.record for frame in watched))


def _label(rekey: dict[str, Any]) -> str:
    words = {
        "rekey_error": "key past {:.0%} error",
        "rekey_image": "key below {:g} dB",
        "rekey_every": "key every {:d} frames",
    }
    return ", ".join(words[name].format(value) for name, value in rekey.items())
