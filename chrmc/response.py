"""What a panel's grey levels do to light: the one place where grey and amplitude meet.

A response is the complex amplitude that a pixel of each grey level leaves on the wave, relative to
the brightest one. `reconstruct` reads it forwards (grey → amplitude), `display` backwards (wanted
amplitude → nearest grey).

Amplitude-mode panels commonly shift the phase a little with the grey level, so the levels lie on a
curve in the complex plane. What counts backwards is the level's component along the chord from
the darkest to the brightest end: it is what a wanted real amplitude can be matched with, and what
must rise (or fall) steadily. For a purely real response it is the amplitude itself.
"""

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from chrmc.response_map import STEPS, tile_levels, tile_tables, tiles
from chrmc.response_table import read_table, read_tilt, read_wavelength, to_both_ends

LEVELS = 256
FAR = 0.05
"""Share that a laser's wavelength may differ by from that of a response."""
_STEPS = 1 << 16  # of the backward table: finer than a grey step by 256, so nearest to 0.2 %


@dataclass(frozen=True, eq=False)
class GreyResponse:
    """Amplitude of every grey level.

    levels : (256,) complex, amplitude of grey 0 … 255; scaled here so that the largest modulus is 1
    name : what manifests and messages call it
    tilt : (256, 2 or 5) how the intensity varies over the panel, see `chrmc.response_map`, in units
        of the square of `levels`; None where it is the same everywhere
    wavelength : metres, of the laser it was measured with; None where that is not known

    Raises ValueError when the levels are not 256 finite numbers, all alike, or not monotone.
    """

    levels: NDArray[np.complex128] = field(repr=False)
    name: str = "linear"
    tilt: NDArray[np.float64] | None = field(default=None, repr=False)
    wavelength: float | None = None

    def __post_init__(self) -> None:
        levels = np.array(self.levels, dtype=np.complex128)
        if levels.shape != (LEVELS,):
            raise ValueError(f"a response needs {LEVELS} levels, not an array of {levels.shape}")
        if not np.isfinite(levels).all():
            raise ValueError(f"response {self.name}: NaN or infinite levels")
        peak = np.abs(levels).max()
        if not peak > 0:
            raise ValueError(f"response {self.name}: every level is dark; check the table")
        if self.tilt is not None:
            tilt = np.array(self.tilt, dtype=np.float64) / peak**2
            if tilt.ndim != 2 or tilt.shape[0] != LEVELS or tilt.shape[1] not in (2, 5):
                raise ValueError(f"a response's map needs {LEVELS} rows of 2 or 5 terms")
            if not np.isfinite(tilt).all():
                raise ValueError(f"response {self.name}: NaN or infinite terms of the map")
            tilt.setflags(write=False)
            object.__setattr__(self, "tilt", tilt)
        levels /= peak
        levels.setflags(write=False)
        object.__setattr__(self, "levels", levels)
        if abs(levels[-1] - levels[0]) < 1e-6:
            raise ValueError(
                f"response {self.name}: grey 0 and 255 give the same amplitude, nothing to modulate"
            )
        steps = np.diff(self._along_chord)
        if levels[-1].real ** 2 + levels[-1].imag ** 2 < abs(levels[0]) ** 2:
            steps = -steps
        if (steps < -1e-9).any():
            grey = int(np.argmin(steps))
            raise ValueError(
                f"response {self.name} is not monotone: it turns back by {-steps.min():.3g} of the "
                f"full amplitude from grey {grey} to {grey + 1}; smooth the table or drop that row"
            )

    @classmethod
    def linear(cls) -> "GreyResponse":
        """Amplitude = grey/255, the default."""
        return cls((np.arange(LEVELS) / (LEVELS - 1)).astype(np.complex128))

    @classmethod
    def from_gamma(cls, gamma: float) -> "GreyResponse":
        """Intensity = (grey/255)^gamma as displays count it, so amplitude is its square root.

        gamma = 2 is the linear response.
        """
        if not (np.isfinite(gamma) and gamma > 0):
            raise ValueError(f"gamma must be a positive number, not {gamma}")
        grey = np.arange(LEVELS) / (LEVELS - 1)
        return cls((grey ** (gamma / 2)).astype(np.complex128), f"gamma:{gamma:g}")

    @classmethod
    def from_table(
        cls, grey: ArrayLike, amplitude: ArrayLike, name: str = "table"
    ) -> "GreyResponse":
        """From measured levels: grey (n,) rising from 0 to 255, amplitude (n,) real or complex.

        Levels between the rows are interpolated monotonically (PCHIP, modulus and unwrapped phase).
        """
        from scipy.interpolate import PchipInterpolator

        try:
            at = np.asarray(grey, dtype=np.float64)
            values = np.asarray(amplitude, dtype=np.complex128)
        except TypeError:
            raise ValueError(f"response {name}: grey and amplitude must be numbers") from None
        if at.ndim != 1 or at.shape != values.shape or len(at) < 2:
            raise ValueError(f"response {name}: needs two rows or more, grey beside amplitude")
        if not (np.isfinite(at).all() and np.isfinite(values).all()):
            raise ValueError(f"response {name}: NaN or infinite entries")
        if (np.diff(at) <= 0).any() or at[0] != 0 or at[-1] != LEVELS - 1:
            raise ValueError(
                f"response {name}: grey must rise from 0 to {LEVELS - 1}, "
                f"not run from {at[0]:g} to {at[-1]:g}"
                + (" with repeats or backwards" if (np.diff(at) <= 0).any() else "")
            )
        every = np.arange(LEVELS)
        if np.abs(values).max() > 1e30:
            raise ValueError(f"response {name}: amplitudes of {np.abs(values).max():g} are none")
        modulus = PchipInterpolator(at, np.abs(values))(every)
        # Dark levels have no phase of their own: take it from the nearest lit one.
        lit = np.abs(values) > 1e-6 * np.abs(values).max()
        phase = np.unwrap(np.angle(values[lit])) if lit.any() else np.zeros(0)
        turn = np.interp(every, at[lit], phase) if lit.any() else np.zeros(LEVELS)
        return cls(np.asarray(modulus * np.exp(1j * turn), dtype=np.complex128), name)

    @classmethod
    def from_csv(cls, path: str | Path) -> "GreyResponse":
        """A measured table: grey beside intensity (any unit; square-rooted to amplitude), or beside
        amplitude with or without phase; `chrmc.response_table` says what forms are read.

        Noise that makes a table turn back is smoothed away up to 3 % of its range, and the name
        says by how much. Raises OSError for no file, ValueError for a bad one.
        """
        grey, values, moved = read_table(path)
        grey, values = to_both_ends(grey, values, LEVELS - 1)
        name = Path(path).name
        found = cls.from_table(grey, values, f"{name}, smoothed by {moved:.1%}" if moved else name)
        map_, tilt = read_tilt(path), None
        if map_ is not None:
            every, peak = np.arange(LEVELS), float(np.abs(values).max())
            tilt = np.stack([np.interp(every, map_[0], term) for term in map_[1].T], axis=1)
            tilt /= peak**2
        return cls(found.levels, found.name, tilt, read_wavelength(path))

    @classmethod
    def parse(cls, text: str | None) -> "GreyResponse":
        """From a command line: "linear", "gamma:G", or the path of a CSV table."""
        if text is None or text == "linear":
            return cls.linear()
        if text.startswith("gamma:"):
            try:
                gamma = float(text[6:])
            except ValueError:
                raise ValueError(f"{text!r}: write gamma:2.2, a number after the colon") from None
            return cls.from_gamma(gamma)
        return cls.from_csv(text)

    def as_dict(self) -> dict[str, Any]:
        """For a manifest: the name, and the levels as [real, imaginary] unless linear."""
        if self.is_linear:
            return {"name": "linear"}
        told: dict[str, Any] = {
            "name": self.name,
            "levels": [[v.real, v.imag] for v in self.levels.tolist()],
        }
        if self.tilt is not None:
            told["tilt"] = self.tilt.tolist()
        return told if self.wavelength is None else told | {"wavelength": self.wavelength}

    @classmethod
    def from_dict(cls, values: dict[str, Any] | None) -> "GreyResponse":
        """What `as_dict` wrote; None is linear."""
        if not values or "levels" not in values:
            return cls.linear()
        levels = np.array(values["levels"], dtype=np.float64)
        tilt, wavelength = values.get("tilt"), values.get("wavelength")
        return cls(
            levels[:, 0] + 1j * levels[:, 1],
            str(values.get("name", "table")),
            None if tilt is None else np.array(tilt, dtype=np.float64),
            None if wavelength is None else float(wavelength),
        )

    def check_wavelength(self, wavelength: float) -> None:
        """ValueError for a laser (metres) far from the one that the response was measured with."""
        if self.wavelength is None or abs(wavelength / self.wavelength - 1) <= FAR:
            return
        raise ValueError(
            f"response {self.name} was measured at {self.wavelength * 1e9:.4g} nm, not at "
            f"{wavelength * 1e9:.4g} nm: measure it there (chrmc calibrate-response --wavelength), "
            "or give one for each laser, in the order of the wavelengths"
        )

    @property
    def swing(self) -> float:
        """Distance of the darkest level's amplitude from the brightest's; 1 for one that is quite
        dark."""
        return float(abs(self.levels[-1] - self.levels[0]))

    @cached_property
    def is_linear(self) -> bool:
        """Whether amplitude is grey/255 exactly."""
        straight = np.arange(LEVELS) / (LEVELS - 1)
        return self.tilt is None and bool(np.array_equal(self.levels, straight))

    @cached_property
    def is_real(self) -> bool:
        """Whether no level shifts the phase."""
        return not self.levels.imag.any()

    @cached_property
    def _along_chord(self) -> NDArray[np.float64]:
        """(256,) place of each level on the chord, 0 at the darker end, 1 at the brighter one."""
        dark, bright = sorted((self.levels[0], self.levels[-1]), key=abs)
        chord = bright - dark
        place: NDArray[np.float64] = np.real((self.levels - dark) * np.conj(chord))
        return place / abs(chord) ** 2

    def amplitude(self, frame: NDArray[np.uint8]) -> NDArray[np.float32] | NDArray[np.complex64]:
        """Amplitude behind every pixel: float32, or complex64 where the panel shifts phase."""
        if frame.dtype != np.uint8:
            raise ValueError(f"grey levels must be uint8, not {frame.dtype}")
        if self.tilt is not None:
            found = np.empty(frame.shape, dtype=np.complex64)
            for i, j, part in tiles((frame.shape[0], frame.shape[1])):
                found[part] = self._tiles[i, j].astype(np.complex64)[frame[part]]
            return found.real if self.is_real else found
        if self.is_real:
            return self.levels.real.astype(np.float32)[frame]
        return self.levels.astype(np.complex64)[frame]

    @cached_property
    def _tiles(self) -> NDArray[np.complex128]:
        assert self.tilt is not None
        return tile_levels(self.levels, self.tilt)

    @cached_property
    def _tile_tables(self) -> NDArray[np.uint8]:
        return tile_tables(self._tiles)

    @cached_property
    def table(self) -> NDArray[np.uint8]:
        """(65537,) nearest grey for wanted amplitudes 0 … 1 in steps of 1/65536.

        0 means the darkest level and 1 the brightest, so a panel of poor contrast is driven over
        its whole range without clipping.
        """
        place = self._along_chord
        order = np.argsort(place, kind="stable")
        middles = (place[order][1:] + place[order][:-1]) / 2
        wanted = np.arange(_STEPS + 1) / _STEPS
        nearest = order[np.searchsorted(middles, wanted, side="right")].astype(np.uint8)
        nearest.setflags(write=False)
        return nearest

    def grey(self, wanted: NDArray[np.floating]) -> NDArray[np.uint8]:
        """Nearest grey level for wanted amplitudes, clipped to 0 (darkest) … 1 (brightest)."""
        steps = _STEPS if self.tilt is None else STEPS
        index = np.rint(np.clip(wanted, 0, 1) * np.float32(steps)).astype(np.int32)
        if self.tilt is None:
            return self.table[index]
        found = np.empty(index.shape, dtype=np.uint8)
        for i, j, part in tiles((index.shape[0], index.shape[1])):
            found[part] = self._tile_tables[i, j][index[part]]
        return found
