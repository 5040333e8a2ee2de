"""An encoding: everything that belongs to one way of putting a complex field onto a panel.

One entry says what the field may occupy, how it becomes grey levels, and how the 4-f system reads
them again. To add one, write a function `SLM → Coding` and give it a line in CODINGS.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from chrmc.optics.passband import Passband
from chrmc.slm import SLM

SIGMAS = 3.0
"""Signal clipped at this many standard deviations: 0.3 % of pixels, 59 dB in the reconstruction."""


class Levels(Protocol):
    """Grey levels, uint8 (H, W), of a field and its signal Re(field·carrier), which may be used
    up; `scale` is the signal at which the grey range ends, `response` what grey levels do."""

    def __call__(
        self,
        field: NDArray[np.complexfloating],
        signal: NDArray[np.float32],
        scale: float,
        slm: SLM,
        response: Any = None,
    ) -> NDArray[np.uint8]: ...


@dataclass(frozen=True)
class Coding:
    """An encoding on one SLM.

    name : one of CODINGS
    passband : what the complex field may occupy before the carrier is put on
    carrier : frequency of exp(+2πi·carrier·y), cycles per metre; 0 for none
    needs_field : the grey levels follow from the complex field, not from Re(field·carrier) alone
    limits : a field that exceeds the passband is cut down to it
    levels : how grey levels are made; None is 0.5 + 0.5·clip(signal/scale, −1, 1) as amplitude
    sigmas : a video's scale in standard deviations of its brightest frame's signal
    own_scale : scale of a single field, from it and its signal; None is sigmas of that signal
    gain : the light that passes the filter is field·carrier/(gain·scale)
    half_plane : the filter passes f_y > 0 only
    aperture : the filter passes nothing beyond it; None passes all
    zero_order : the picture's light surrounds the zero order, which then is not blocked
    wave : complex light of grey levels, for panels that shift the phase; None is the response's
    bits : grey-level depth that the encoding itself uses; None is the panel's
    """

    name: str
    passband: Passband
    carrier: float
    needs_field: bool = False
    limits: bool = False
    levels: Levels | None = None
    sigmas: float = SIGMAS
    own_scale: Callable[[NDArray[np.complexfloating], NDArray[np.float32]], float] | None = None
    gain: float = 4.0
    half_plane: bool = False
    aperture: Passband | None = None
    zero_order: bool = False
    wave: Callable[[NDArray[np.uint8]], NDArray[np.complex64]] | None = None
    bits: int | None = None


CODINGS: dict[str, str | Callable[[SLM], Coding]] = {
    "ssb": "chrmc.encodings.amplitude:ssb",
    "real": "chrmc.encodings.amplitude:real",
    "bipolar": "chrmc.encodings.amplitude:bipolar",
    "burch": "chrmc.encodings.amplitude:burch",
    "offaxis": "chrmc.encodings.amplitude:offaxis",
    "error-diffusion": "chrmc.encodings.binary:error_diffusion",
    "lee": "chrmc.encodings.binary:lee",
    "double-phase": "chrmc.encodings.phase:double_phase",
    "kinoform": "chrmc.encodings.phase:kinoform",
}
"""name: "module:function" or the function itself, SLM → Coding."""


def coding_for(name: str, slm: SLM) -> Coding:
    """The coding called `name` on `slm`; ValueError for an unknown name."""
    if name not in CODINGS:
        raise ValueError(f"unknown encoding {name!r}: choose one of {', '.join(CODINGS)}")
    entry = CODINGS[name]
    if isinstance(entry, str):
        module, _, function = entry.partition(":")
        entry = getattr(import_module(module), function)
    coding: Coding = entry(slm)
    return coding
