"""Numeric reconstruction through the 4-f system: the SLM's grey levels to the image at a depth.

The frame itself is the input. Its grey levels become amplitude; lens 1 (focal1 behind the panel)
makes the spectrum in the Fourier plane, where the filter passes the half plane f_y > 0 and blocks
the zero order; lens 2 makes the image. Demodulated by the carrier exp(+2πi·y/4p), the image-plane
field is the coded field U again, and going back along the light by `distance` shows depth
z = distance.

Orientation: two Fourier transforms in a row turn the image upside down and left to right, and
enlarge it by focal2/focal1. Here the image is always shown as a camera turned by 180° and divided
by the magnification would: on the SLM's own pixels, a point at (x, y, z) at pixel (x, y).

Units: amplitude = 0.5 + 0.5·Re(U·carrier)/scale is what the encoder wrote, so one sideband holds
U/(4·scale); other encodings have gains of their own. The field here is multiplied by gain·scale:
it reproduces U where `scale` is the video's, and U/scale where it is left at 1. The plain real
part without a sideband gives U + U*, the twin image included.
"""

from dataclasses import dataclass, replace
from math import ceil
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from chrmc.encoding import Coding, coding_for
from chrmc.optics.passband import Passband
from chrmc.optics.propagation import (
    Propagator,
    cycles_to_phasor,
    soft_edge,
    spread,
    transfer_function,
)
from chrmc.panels import encoding_for
from chrmc.ranges import DISTANCE_RANGE, WAVELENGTH_RANGE, real
from chrmc.response import GreyResponse
from chrmc.slm import SLM, WAVELENGTH
from chrmc.threads import workers
from reconstruct.bench import Bench, Filter


@dataclass(frozen=True)
class Energy:
    """Where the light went, sums of |amplitude|² over pixels, with the illumination on axis as 1.

    incident = absorbed (by dark grey levels and between pixels) + blocked_filter + blocked_lenses
    + image.
    """

    incident: float
    absorbed: float
    blocked_filter: float
    blocked_lenses: float
    image: float

    @property
    def efficiency(self) -> float:
        """Share of the incident light that reaches the image."""
        return self.image / self.incident


def check_frame(frame: Any, slm: SLM) -> NDArray[np.uint8]:
    """The frame as a (H, W) uint8 array, or ValueError."""
    frame = np.asarray(frame)
    if frame.shape != slm.shape:
        raise ValueError(f"frame is {frame.shape} but {slm.name} has (rows, columns) = {slm.shape}")
    if frame.dtype != np.uint8:
        raise ValueError(f"a frame holds 8-bit grey levels; this one is {frame.dtype}: encode it")
    return frame


def check_distance(distance: float) -> float:
    """The distance, or ValueError unless it is a plausible one in metres."""
    return DISTANCE_RANGE.of(distance)


class FourF:
    """The 4-f system for one SLM, encoding and bench; filter and kernels are kept between frames.

    slm, wavelength, encoding : as the frames were made; default the usual one of the panel's kind
    bench : default the paper's, two 15 cm lenses
    response : amplitude of each grey level, default grey/255
    scale : the video's, see the module's text on units
    """

    def __init__(
        self,
        slm: SLM,
        wavelength: float,
        encoding: str | None = None,
        bench: Bench | None = None,
        response: GreyResponse | None = None,
        scale: float = 1.0,
    ) -> None:
        scale = real("scale", scale)
        if not scale > 0:
            raise ValueError(f"scale must be positive, not {scale}")
        self.slm = slm
        self.wavelength = WAVELENGTH_RANGE.of(wavelength)
        self.coding: Coding = coding_for(encoding or encoding_for(slm), slm)
        self.bench = Bench() if bench is None else bench
        self.response = GreyResponse.linear() if response is None else response
        self.scale = scale
        aberration = self.bench.aberration
        if aberration is not None and np.shape(aberration) != slm.shape:
            raise ValueError(
                f"aberration is {np.shape(aberration)}, but the SLM is {slm.shape} pixels"
            )
        half_plane = self.bench.filter.half_plane
        self._half_plane = self.coding.half_plane if half_plane is None else half_plane
        self._transmission: NDArray[np.float32] | None = None
        self._plane: Propagator | None = None

    def amplitude(self, frame: NDArray[np.uint8]) -> NDArray[np.float32] | NDArray[np.complex64]:
        """(H, W) wave that leaves the panel; complex where illumination or panel shift phase."""
        frame = check_frame(frame, self.slm)
        wave = (self.coding.wave or self.response.amplitude)(frame)
        if self.bench.illumination is not None:
            wave = wave * self.bench.illumination.wave(self.slm, self.wavelength)
        if self.bench.aberration is not None:
            wave = wave * np.exp(1j * np.asarray(self.bench.aberration)).astype(np.complex64)
        return wave

    @property
    def _grid(self) -> tuple[int, int]:
        """Samples of the Fourier plane."""
        if not self.bench.edges:
            return self.slm.shape
        rows, columns = (scipy.fft.next_fast_len(2 * n, real=False) for n in self.slm.shape)
        return rows, columns

    def fourier_coordinates(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Heights and widths (metres) at which the samples of `fourier_plane` lie, FFT order."""
        fy, fx = (scipy.fft.fftfreq(n, self.slm.pixel_pitch) for n in self._grid)
        unit = self.wavelength * self.bench.focal1
        return fy * unit, fx * unit

    def transmission(self) -> NDArray[np.float32]:
        """Amplitude transmission of the filter on the samples of `fourier_plane`, FFT order."""
        if self._transmission is None:
            self._transmission = self._make_transmission()
        return self._transmission

    def _make_transmission(self) -> NDArray[np.float32]:
        y, x = self.fourier_coordinates()
        unit = self.wavelength * self.bench.focal1
        light = (unit * self.coding.carrier if self._half_plane else 0.0, 0.0)
        chosen, aperture = self.bench.filter, self.coding.aperture
        if self.coding.zero_order:
            chosen = replace(chosen, dc_block=None)
        passed = chosen.transmission(y, x, unit * self.slm.nyquist, light)
        if self._half_plane:
            passed[y <= 0] = 0
        if aperture is not None and chosen.aperture is None:
            passed[np.abs(y) >= unit * aperture.fy_max] = 0
            passed[:, np.abs(x) >= unit * aperture.fx_max] = 0
        return passed

    def fourier_plane(self, frame: NDArray[np.uint8]) -> NDArray[np.complex64]:
        """Complex amplitude before the filter, FFT order, scaled so that Σ|·|² is the energy."""
        wave = self.amplitude(frame)
        if self.bench.lens1 is not None:
            wave = self._through_lens(wave, self.bench.focal1, self.bench.lens1)
        spectrum = scipy.fft.fft2(wave, s=self._grid, norm="ortho", workers=workers())
        fill = self.bench.fill_factor
        if fill is None and self.slm.fill_factor < 1:
            fill = self.slm.fill_factor
        if fill is not None:
            # Square active areas of side p·√fill: an envelope over the orders.
            side = self.slm.pixel_pitch * np.sqrt(fill)
            fy, fx = (scipy.fft.fftfreq(n, self.slm.pixel_pitch) for n in self._grid)
            rows, columns = np.sinc(fy * side), np.sinc(fx * side)
            envelope = fill * rows[:, None] * columns[None, :]
            spectrum = spectrum * envelope.astype(np.float32)
        return np.asarray(spectrum, dtype=np.complex64)

    def _through_lens(
        self, wave: NDArray[Any], distance: float, diameter: float
    ) -> NDArray[np.complex64]:
        """The wave as a round pupil leaves it that stands `distance` behind (or, if negative,
        before) this plane; the thin lens in the pupil changes phases only, its focusing is the
        Fourier transform itself."""
        p, shape = self.slm.pixel_pitch, self.slm.shape
        walk = ceil(spread(self.wavelength, self.slm.nyquist, distance) / p)
        edge = soft_edge(self.wavelength, distance, p)
        rows, columns = (scipy.fft.next_fast_len(n + 2 * walk + edge, real=False) for n in shape)
        grid = (rows, columns)
        there = transfer_function(grid, p, self.wavelength, distance)
        spectrum = scipy.fft.fft2(wave, s=grid, workers=workers()) * there
        in_pupil = scipy.fft.ifft2(spectrum, workers=workers(), overwrite_x=True)
        # Samples past the middle of the padding stand before the first one.
        y, x = (
            (np.where(np.arange(g) < (n + g) // 2, 0, -g) + np.arange(g) - (n - 1) / 2) * p
            for g, n in zip(grid, shape, strict=True)
        )
        in_pupil *= y[:, None] ** 2 + x[None, :] ** 2 <= (diameter / 2) ** 2
        spectrum = scipy.fft.fft2(in_pupil, workers=workers(), overwrite_x=True)
        spectrum *= np.conj(there)
        back = scipy.fft.ifft2(spectrum, workers=workers(), overwrite_x=True)
        return np.asarray(back[: shape[0], : shape[1]], dtype=np.complex64)

    def _image_wave(self, spectrum: NDArray[np.complex64]) -> NDArray[np.complex64]:
        """Filtered wave in the image plane, carrier still on it, panel's energy units."""
        rows, columns = self.slm.shape
        wave = scipy.fft.ifft2(
            spectrum * self.transmission(), norm="ortho", workers=workers(), overwrite_x=True
        )[:rows, :columns]
        if self.bench.lens2 is not None:
            # In the SLM's own scale, lens 2 stands focal2/M² before the image, 1/M as wide.
            m = self.bench.magnification
            wave = self._through_lens(wave, -self.bench.focal2 / m**2, self.bench.lens2 / m)
        return np.asarray(wave, dtype=np.complex64)

    def field(self, frame: NDArray[np.uint8]) -> NDArray[np.complex64]:
        """(H, W) complex field in the image plane (depth 0), demodulated: an estimate of U."""
        return self.decode(self.fourier_plane(frame))

    def decode(self, plane: NDArray[np.complex64]) -> NDArray[np.complex64]:
        """(H, W) complex field in the image plane, from `fourier_plane`."""
        wave = self._image_wave(plane)
        wave *= np.float32(self.coding.gain * self.scale)
        if self.coding.carrier:
            wave *= cycles_to_phasor(-self.coding.carrier * self.slm.y())[:, None]
        return wave

    def at(self, field: NDArray[np.complex64], distance: float) -> NDArray[np.complex64]:
        """(H, W) complex field at depth `distance` > 0, from `field`; kernels are kept."""
        distance = check_distance(distance)
        if self._plane is None or self._plane.longest != distance:
            self._plane = Propagator(
                self.slm.shape, self.slm.pixel_pitch, self.wavelength, distance, band=self.band
            )
        return self._plane(field, -distance)

    @property
    def band(self) -> Passband:
        """What a decoded field occupies."""
        nyquist = self.slm.nyquist
        if self.coding.aperture is not None and self.bench.filter.aperture is None:
            return self.coding.aperture
        one_sided = self._half_plane and self.coding.carrier
        return Passband(nyquist, nyquist / 2 if one_sided else nyquist)

    def image(self, frame: NDArray[np.uint8], distance: float) -> NDArray[np.float32]:
        """(H, W) intensity at depth `distance` > 0."""
        return intensity(self.at(self.field(frame), distance))

    def energy(self, frame: NDArray[np.uint8]) -> Energy:
        """The light's account for one frame, up to the image plane."""
        bench = self.bench
        light = bench.illumination
        lit: NDArray[Any] = np.ones(self.slm.shape, dtype=np.float32)
        if light is not None:
            lit = light.wave(self.slm, self.wavelength)
        without = FourF(
            self.slm,
            self.wavelength,
            self.coding.name,
            replace(bench, lens1=None, lens2=None),
            self.response,
        )
        incident, panel = power(lit), power(without.fourier_plane(frame))
        spectrum = self.fourier_plane(frame)
        before = power(spectrum)
        after = power(spectrum * self.transmission())
        image = power(self._image_wave(spectrum)) if bench.lens2 is not None else after
        return Energy(
            incident=incident,
            absorbed=incident - panel,
            blocked_filter=before - after,
            blocked_lenses=(panel - before) + (after - image),
            image=image,
        )


def intensity(field: NDArray[np.complexfloating]) -> NDArray[np.float32]:
    """|field|² as float32."""
    return np.asarray(field.real**2 + field.imag**2, dtype=np.float32)


def power(field: NDArray[Any]) -> float:
    """Σ|field|² in float64."""
    return float(np.sum(np.abs(field) ** 2, dtype=np.float64))


def four_f_field(
    frame: NDArray[np.uint8],
    slm: SLM,
    wavelength: float,
    encoding: str | None = None,
    *,
    bench: Bench | None = None,
    response: GreyResponse | None = None,
    scale: float = 1.0,
) -> NDArray[np.complex64]:
    """Complex field in the image plane of the 4-f system: (H, W), an estimate of the coded U.

    Propagate it by −d (`chrmc.optics.propagation.propagate`) to see depth d: one filter pass for
    many depths.
    Arguments as `FourF`.
    """
    return FourF(slm, wavelength, encoding, bench, response, scale).field(frame)


def four_f(
    frame: NDArray[np.uint8],
    slm: SLM,
    wavelength: float,
    distance: float,
    encoding: str | None = None,
    *,
    bench: Bench | None = None,
    response: GreyResponse | None = None,
    scale: float = 1.0,
) -> NDArray[np.float32]:
    """Intensity that the 4-f system shows at a depth.

    frame : (H, W) uint8 grey levels, as the SLM gets them
    wavelength : metres
    distance : scene depth in metres, > 0
    encoding : as the frame was made, such as "ssb" (half plane f_y > 0 and zero order blocked)
    bench : lenses, filter, imperfections; default the paper's two 15 cm lenses
    response : grey to amplitude, default grey/255
    scale : the video's scale gives the scene's own units, |Σ a/r·exp(ikr)|²

    Returns float32 (H, W) on the SLM's pixels and orientation: a point at (x, y, distance) appears
    at pixel (x, y), upright. Raises ValueError for a frame of another shape or type, or a
    distance that is not positive.
    """
    check_distance(distance)
    return FourF(slm, wavelength, encoding, bench, response, scale).image(frame, distance)


def decode_field(
    frame: NDArray[np.uint8],
    slm: SLM,
    encoding: str | None = None,
    scale: float = 1.0,
    response: GreyResponse | None = None,
) -> NDArray[np.complex64]:
    """What a frame says of the coded field, by an ideal filter: no bench and no wavelength.

    The inverse of encoding: (H, W) complex64, U within its passband up to rounding and clipping.
    """
    # An ideal filter knows no lengths: any wavelength gives the same field.
    ideal = Bench(filter=Filter(dc_block=0.0))
    return FourF(slm, WAVELENGTH, encoding, ideal, response, scale).field(frame)
