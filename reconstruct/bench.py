"""The optical bench that reads a hologram: illumination, panel, Fourier filter, lenses.

Plain descriptions in frozen dataclasses. Every part has a default that means "not modelled", and
what is not modelled costs nothing.
"""

from dataclasses import dataclass, field
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from chrmc.slm import SLM


@dataclass(frozen=True)
class Illumination:
    """The laser beam at the panel, of amplitude 1 on its axis.

    tilt : (y, x) radians; the beam's direction against the axis
    waist : 1/e² intensity radius of a Gaussian beam, metres; None for a plane wave
    centre : (y, x) metres, where the beam's axis meets the panel
    """

    tilt: tuple[float, float] = (0.0, 0.0)
    waist: float | None = None
    centre: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        if self.waist is not None and not (isfinite(self.waist) and self.waist > 0):
            raise ValueError(f"the beam's waist must be a positive length, not {self.waist} m")
        if max(abs(t) for t in self.tilt) >= np.pi / 2:
            raise ValueError(f"a beam tilted by {self.tilt} rad does not meet the panel")

    def wave(self, slm: SLM, wavelength: float) -> NDArray[np.complex64] | NDArray[np.float32]:
        """(H, W) amplitude over the panel; float32 unless tilted."""
        y, x = slm.y()[:, None] - self.centre[0], slm.x()[None, :] - self.centre[1]
        profile = np.ones(slm.shape, dtype=np.float32)
        if self.waist is not None:
            rows, columns = np.exp(-((y / self.waist) ** 2)), np.exp(-((x / self.waist) ** 2))
            profile = (rows * columns).astype(np.float32)
            if not profile.any():
                raise ValueError(
                    f"a beam with a waist of {self.waist * 1e6:.3g} µm lights no pixel of "
                    f"{slm.pixel_pitch * 1e6:.3g} µm: take a wider one"
                )
        if not any(self.tilt):
            return profile
        cycles = (np.sin(self.tilt[0]) * y + np.sin(self.tilt[1]) * x) / wavelength
        turn = (2 * np.pi * (cycles - np.rint(cycles))).astype(np.float32)
        return (profile * np.exp(1j * turn)).astype(np.complex64)


@dataclass(frozen=True, eq=False)
class Filter:
    """What stands in the Fourier plane of the first lens.

    half_plane : pass f_y > 0 only; None means: when the encoding is single sideband
    dc_block : radius of the opaque dot on the axis, metres; 0 blocks the one sample at zero
        frequency, None blocks nothing
    aperture : opening, metres: a diameter, or (height, width) of a rectangle; None is unlimited
    centre : (y, x) of the opening, metres; None is where the light is: on the carrier of a single
        sideband, else on the axis
    image : (rows, columns) amplitude transmission of a user's own filter, spread over the
        Nyquist square with f_y, f_x rising from −1/2p to 1/2p; multiplied with the rest

    A frequency f crosses the plane at wavelength·focal1·f.
    """

    half_plane: bool | None = None
    dc_block: float | None = 10e-6
    aperture: float | tuple[float, float] | None = None
    centre: tuple[float, float] | None = None
    image: NDArray[np.floating] | None = None

    def __post_init__(self) -> None:
        if self.dc_block is not None and not (isfinite(self.dc_block) and self.dc_block >= 0):
            raise ValueError(f"dc_block must be a radius of 0 or more, not {self.dc_block} m")
        if self.aperture is not None:
            sides = np.atleast_1d(np.asarray(self.aperture, dtype=np.float64))
            if sides.size > 2 or not (np.isfinite(sides).all() and (sides > 0).all()):
                raise ValueError(
                    f"aperture must be a diameter or (height, width) in metres, not {self.aperture}"
                )
        if self.image is not None:
            image = np.asarray(self.image, dtype=np.float32)
            if image.ndim != 2 or image.size == 0 or not np.isfinite(image).all():
                raise ValueError("a filter image must be a (rows, columns) array of finite values")
            object.__setattr__(self, "image", image)

    def transmission(
        self,
        y: NDArray[np.float64],
        x: NDArray[np.float64],
        edge: float,
        light: tuple[float, float] = (0.0, 0.0),
    ) -> NDArray[np.float32]:
        """Amplitude transmission at heights y and widths x (metres), all but the half plane.

        edge : metres from the axis to the Nyquist frequency, where `image` ends
        light : (y, x) metres, the opening's centre where the filter gives none
        """
        passed = np.ones((len(y), len(x)), dtype=np.float32)
        if self.image is not None:
            rows, columns = self.image.shape
            row = np.clip(((y / edge + 1) / 2 * rows).astype(np.intp), 0, rows - 1)
            column = np.clip(((x / edge + 1) / 2 * columns).astype(np.intp), 0, columns - 1)
            passed *= self.image[row[:, None], column[None, :]]
        if self.aperture is not None:
            centre = light if self.centre is None else self.centre
            dy, dx = y[:, None] - centre[0], x[None, :] - centre[1]
            if np.ndim(self.aperture) == 0:
                inside = dy**2 + dx**2 <= (float(np.asarray(self.aperture)) / 2) ** 2
            else:
                height, width = np.asarray(self.aperture, dtype=np.float64)
                inside = (np.abs(dy) <= height / 2) & (np.abs(dx) <= width / 2)
            passed *= inside
        if self.dc_block is not None:
            rows_near, columns_near = (np.abs(v) <= self.dc_block for v in (y, x))
            near = np.ix_(rows_near, columns_near)
            dot = y[rows_near, None] ** 2 + x[None, columns_near] ** 2 <= self.dc_block**2
            passed[near] *= ~dot
        return passed


@dataclass(frozen=True, eq=False)
class Bench:
    """The paper's 4-f system, and whatever of the real bench is to be modelled.

    focal1, focal2 : of the two lenses, metres; the image is focal2/focal1 times as large
    filter : in the Fourier plane
    lens1, lens2 : clear diameters of the lenses, metres; None is unlimited
    illumination : of the panel, None is a plane wave on the axis
    aberration : (H, W) radians, phase error of panel and illumination together
    fill_factor : active share of a pixel's area (`slm.fill_factor` is the panel's own), which
        dims the orders by an envelope; None is not modelled
    edges : True models the light that the lit panel's own border diffracts, by padding it with
        darkness; False takes the panel as periodic, so that its bias is exactly the zero order
    """

    focal1: float = 0.15
    focal2: float = 0.15
    filter: Filter = field(default_factory=Filter)
    lens1: float | None = None
    lens2: float | None = None
    illumination: Illumination | None = None
    aberration: NDArray[np.floating] | None = None
    fill_factor: float | None = None
    edges: bool = False

    def __post_init__(self) -> None:
        for name in ("focal1", "focal2", "lens1", "lens2"):
            value = getattr(self, name)
            if value is not None and not (isfinite(value) and value > 0):
                raise ValueError(f"{name} must be a positive length, not {value} m")
        if self.fill_factor is not None and not 0 < self.fill_factor <= 1:
            raise ValueError(f"fill_factor must lie in (0, 1], not {self.fill_factor}")

    @property
    def magnification(self) -> float:
        """Image size over hologram size, focal2/focal1; the image is upside down besides."""
        return self.focal2 / self.focal1
