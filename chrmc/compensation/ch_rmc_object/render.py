"""Factors to fields and signals, with what rests kept from frame to frame."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from numpy.typing import NDArray

from chrmc.cgh.curved.interface import Factor, field_of, signal_of
from chrmc.encoding import Coding
from chrmc.record import FrameRecord
from chrmc.slm import SLM
from chrmc.window import Window

Shown = tuple[bool, Sequence[Factor]]
"""Whether an object rests, and its factors."""


class Renderer:
    """Makes pixels; what rested in the frame before is not made again."""

    def __init__(self, slm: SLM, wavelength: float, window: Window, coding: Coding) -> None:
        self._slm, self._wavelength, self._window, self._coding = slm, wavelength, window, coding
        self._kept: dict[str, tuple[dict[str, int], NDArray[Any]]] = {}

    def of(
        self, kind: str, objects: Sequence[Shown], still: Mapping[str, int], record: FrameRecord
    ) -> Callable[[], NDArray[Any]]:
        """What makes a frame's "field" or "signal".

        still : names of the objects that rest, and versions of their factors
        """

        def make() -> NDArray[Any]:
            with record.stage("HC"):
                base = None
                if still:
                    kept = self._kept.get(kind)
                    if kept is None or kept[0] != still:
                        resting = [f for rests, factors in objects if rests for f in factors]
                        kept = self._kept[kind] = dict(still), self._render(kind, resting, None)
                    base = kept[1]
                moving = [f for rests, factors in objects if not rests for f in factors]
                return self._render(kind, moving, base)

        return make

    def _render(self, kind: str, factors: list[Factor], base: NDArray[Any] | None) -> NDArray[Any]:
        if kind == "field":
            return field_of(factors, self._slm, self._wavelength, self._window, base)
        return signal_of(
            factors, self._slm, self._wavelength, self._window, self._coding.carrier, base
        )
