"""A Screen as an SLM of the package slmsuite, for its feedback loops, calibrations and cameras.

    from display.slmsuite_slm import ScreenSLM

Importing this needs `pip install 'chrmc[slmsuite]'`.
"""

from typing import Any

import numpy as np

from chrmc.encoding import coding_for
from chrmc.grey_levels import encode
from chrmc.panels import encoding_for
from chrmc.slm import WAVELENGTH
from display.log import Flip
from display.screen import Screen

try:
    from slmsuite.hardware.slms.slm import SLM as SlmsuiteSLM
except ImportError:
    raise ImportError("this needs slmsuite: pip install 'chrmc[slmsuite]'") from None


class ScreenSLM(SlmsuiteSLM):
    """slmsuite's SLM, shown on a Screen pixel for pixel; `set_phase` returns when it is on.

    screen : an open `display.Screen`, which its owner closes
    wavelength : metres
    encoding : None on a phase panel, or one of unknown kind: grey levels are phases as slmsuite
        writes them. On an amplitude or binary panel one of `chrmc.encoding.CODINGS`, default its
        usual one: the field exp(iφ) of the phases is encoded, within the band that is kept
    options : of slmsuite's own SLM, such as settle_time_s

    `flip` is that of the last frame shown.
    """

    def __init__(
        self,
        screen: Screen,
        wavelength: float = WAVELENGTH,
        encoding: str | None = None,
        **options: Any,
    ) -> None:
        if encoding is not None or screen.slm.kind in ("amplitude", "binary"):
            encoding = encoding_for(screen.slm, encoding)
            coding_for(encoding, screen.slm)
        self.screen, self.encoding = screen, encoding
        self.flip: Flip | None = None
        panel = screen.slm
        micrometres = 1e6 * panel.pixel_pitch
        super().__init__(
            (panel.width, panel.height),
            bitdepth=8,
            name=options.pop("name", screen.name),
            wav_um=1e6 * wavelength,
            pitch_um=(micrometres, micrometres),
            **options,
        )
        self.set_phase(None)

    def _set_phase_hw(self, display: Any) -> None:
        """Show integers 0 … 255, which stand for phases."""
        levels = np.asarray(display.get() if hasattr(display, "get") else display)
        if self.encoding is not None:
            phase = self._gray2phase(levels)
            field = np.exp(1j * np.asarray(phase)).astype(np.complex64)
            # One scale for all: amplitude 1 everywhere fills the range.
            scale = 1.0 if coding_for(self.encoding, self.screen.slm).carrier else None
            levels = encode(field, self.screen.slm, self.encoding, scale)
        self.flip = self.screen.show(levels.astype(np.uint8), "slmsuite")

    def close(self) -> None:
        """The screen's owner closes it."""
