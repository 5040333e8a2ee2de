"""What to build: the numbers of the 4-f bench that shows a panel's holograms.

The panel stands in the front focal plane of lens 1, the filter in the common focal plane, the
panel's image in the back focal plane of lens 2. A frequency f of the panel crosses the filter
plane at λ·focal1·f.

Single sideband, on amplitude and binary panels; the filter passes half of the plane.
Sides: rows of the panel run down (+y). A wave exp(+i(kr − ωt)) whose phase grows with +y travels
towards +y, so f_y > 0, the sideband that carries U itself, crosses the filter plane below the
axis. Passing it gives the objects upright in depth, as virtual images behind the panel. Passing
the other half instead gives the conjugate: real images in front of the panel, near and far
exchanged, that a bare sensor can catch.

Other encodings have no carrier: the picture's light lies around the axis. On a phase panel the zero
order is part of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import asin, degrees, sqrt, tan

from chrmc.encoding import Coding, coding_for
from chrmc.optics.resolution import depth_of_focus, resolution
from chrmc.panels import encoding_for
from chrmc.slm import SLM


@dataclass(frozen=True)
class Target:
    """An object to be photographed: its name, depth z and lateral position, metres."""

    name: str
    depth: float
    x: float = 0.0
    y: float = 0.0


@dataclass(frozen=True)
class Place:
    """Where an object's image stands, metres.

    camera : from lens 2, what to focus on when U passes (negative: before lens 2, seen through it)
    sensor : from lens 2, of the bare sensor when the conjugate passes
    x, y : image centre; the image is upside down and left to right
    resolution : (x, y) in object space, λz over what of the panel's sides a point is shown on
    focus : (x, y) depth of focus in object space, about 2λ(z/side)²
    field_any, field_all : (x, y) half-widths that some pixel, or every pixel, can serve
    """

    target: Target
    camera: float
    sensor: float
    x: float
    y: float
    resolution: tuple[float, float]
    focus: tuple[float, float]
    field_any: tuple[float, float]
    field_all: tuple[float, float]


@dataclass(frozen=True)
class Sheet:
    """A bench for one panel, wavelength, pair of lenses and encoding (default the usual one of the
    panel's kind); lengths in metres."""

    slm: SLM
    wavelength: float
    focal1: float = 0.15
    focal2: float = 0.15
    encoding: str | None = None

    def __post_init__(self) -> None:
        encoding_for(self.slm, self.encoding)
        for name in ("wavelength", "focal1", "focal2"):
            value = getattr(self, name)
            if not 0 < value < float("inf"):
                raise ValueError(f"{name} must be a positive length in metres, not {value:g}")
        if self.wavelength >= 2 * self.slm.pixel_pitch:
            raise ValueError(
                f"pixels of {self.slm.pixel_pitch:g} m diffract {self.wavelength:g} m past 90°"
            )

    @cached_property
    def coding(self) -> Coding:
        """The encoding on this panel."""
        return coding_for(encoding_for(self.slm, self.encoding), self.slm)

    @property
    def size(self) -> tuple[float, float]:
        """Panel width and height."""
        return self.slm.width * self.slm.pixel_pitch, self.slm.height * self.slm.pixel_pitch

    @property
    def half_angle(self) -> float:
        """Largest diffraction angle, radians: asin(λ/2p)."""
        return asin(self.wavelength * self.slm.nyquist)

    @property
    def order_spacing(self) -> float:
        """Between the panel's diffraction orders in the filter plane: λ·focal1/p."""
        return self.wavelength * self.focal1 / self.slm.pixel_pitch

    @property
    def carrier(self) -> float:
        """Of the passed light's centre from the axis, in y: λ·focal1/4p with one sideband, or 0."""
        return self.order_spacing / 4 if self.coding.half_plane else 0.0

    @property
    def opening(self) -> tuple[float, float]:
        """Width and height of the mask's opening about the carrier: all of f_x and half of f_y
        with one sideband; else the encoding's aperture, or all."""
        if self.coding.half_plane:
            return self.order_spacing, self.order_spacing / 2
        if self.coding.aperture is None:
            return self.order_spacing, self.order_spacing
        unit = 2 * self.wavelength * self.focal1
        return unit * self.coding.aperture.fx_max, unit * self.coding.aperture.fy_max

    @property
    def zero_order(self) -> tuple[float, float]:
        """Width and height of the zero order's main lobe: 2λ·focal1/size."""
        width, height = self.size
        return (
            2 * self.wavelength * self.focal1 / width,
            2 * self.wavelength * self.focal1 / height,
        )

    @property
    def magnification(self) -> float:
        """Image over panel, focal2/focal1; upside down besides."""
        return self.focal2 / self.focal1

    @property
    def lens1(self) -> float:
        """Clear diameter of lens 1 that cuts nothing off: the panel's diagonal and its spread."""
        spread = self.focal1 * tan(self.half_angle)
        width, height = self.size
        return sqrt((width + 2 * spread) ** 2 + (height + 2 * spread) ** 2)

    @property
    def lens2(self) -> float:
        """Clear diameter of lens 2: the opening's far corner and the image's spread."""
        width, height = self.size
        m = self.magnification
        x = self.opening[0] / 2 + width * m / 2
        y = self.carrier + self.opening[1] / 2 + height * m / 2
        return 2 * sqrt(x**2 + y**2)

    def place(self, target: Target) -> Place:
        """Where an object's image stands; ValueError for one at or behind the panel."""
        z = target.depth
        if not z > 0:
            raise ValueError(f"{target.name} is at depth {z:g} m; objects stand at z > 0")
        band = self.coding.passband
        reach_x, reach_y = (z * tan(asin(self.wavelength * f)) for f in (band.fx_max, band.fy_max))
        width, height = self.size
        m = self.magnification
        return Place(
            target,
            self.focal2 - m**2 * z,
            self.focal2 + m**2 * z,
            -m * target.x,
            -m * target.y,
            resolution(self.slm, self.wavelength, z, band)[::-1],
            depth_of_focus(self.slm, self.wavelength, z, band)[::-1],
            (reach_x + width / 2, reach_y + height / 2),
            (max(0.0, reach_x - width / 2), max(0.0, reach_y - height / 2)),
        )

    def lines(self, targets: Sequence[Target]) -> list[str]:
        """The sheet in words."""
        width, height = self.size
        text = [
            f"Panel        {self.slm.name}: {self.slm.width} × {self.slm.height} pixels of "
            f"{1e6 * self.slm.pixel_pitch:.4g} µm, {mm(width)} × {mm(height)}",
            f"Light        {1e9 * self.wavelength:.5g} nm, collimated; leaves the panel within "
            f"±{degrees(self.half_angle):.3f}°",
            f"Lenses       f1 {mm(self.focal1)}, clear {mm(self.lens1)} or more; "
            f"f2 {mm(self.focal2)}, clear {mm(self.lens2)} or more; magnification "
            f"{self.magnification:.4g}, upside down",
            f"Distances    panel – {mm(self.focal1)} – lens 1 – {mm(self.focal1)} – filter – "
            f"{mm(self.focal2)} – lens 2 – {mm(self.focal2)} – image of the panel",
            "",
            "Filter plane, seen along the light, panel upright (row 0 on top), y down:",
            f"  encoding       {self.coding.name}",
            f"  orders         every {mm(self.order_spacing)} in x and y",
            *self._mask(),
        ]
        if targets:
            text += [
                "",
                "Objects (camera: plane to focus on, behind lens 2, negative is before it"
                + ("; sensor: bare, conjugate passed):" if self.coding.half_plane else "):"),
                f"  {'':<10}{'depth':>10}{'camera':>11}{self._sensor('sensor')}"
                f"{'resolution x, y':>19}"
                f"{'depth of focus':>18}{'field ±x, ±y':>19}{'by all pixels':>19}",
            ]
        for place in map(self.place, targets):
            text.append(
                f"  {place.target.name:<10}{mm(place.target.depth):>10}{mm(place.camera):>11}"
                f"{self._sensor(mm(place.sensor))}"
                f"{um(place.resolution[0]) + ', ' + um(place.resolution[1]):>19}"
                f"{mm(place.focus[0]) + ', ' + mm(place.focus[1]):>18}"
                f"{mm(place.field_any[0]) + ', ' + mm(place.field_any[1]):>19}"
                f"{mm(place.field_all[0]) + ', ' + mm(place.field_all[1]):>19}"
            )
        return text

    def _sensor(self, text: str) -> str:
        """A cell of the column that only one sideband has."""
        return f"{text:>11}" if self.coding.half_plane else ""

    def _mask(self) -> list[str]:
        """What the filter passes and blocks."""
        width, height = self.opening
        spot = f"on the axis, {um(self.zero_order[0])} × {um(self.zero_order[1])}"
        if self.coding.half_plane:
            return [
                f"  carrier        {mm(self.carrier)} below the axis (its twin as far above)",
                f"  pass           the half below the axis: x within ±{mm(width / 2)}, "
                f"y from just below 0 to {mm(height)}",
                "  block          the half above the axis, and what lies outside the opening of "
                f"{mm(width)} × {mm(height)}",
                f"  zero order     {spot}; the edge of the mask, or a dot of some 0.1 mm, "
                "blocks it",
                "  conjugate      pass the half above instead: real images, near and far exchanged",
            ]
        zero = "part of the picture: leave it" if self.coding.zero_order else "block it by a dot"
        return [
            f"  pass           about the axis: x within ±{mm(width / 2)}, y within "
            f"±{mm(height / 2)}",
            "  block          what lies outside",
            f"  zero order     {spot}; {zero}",
        ]


def mm(metres: float) -> str:
    """Metres as millimetres."""
    value = 1e3 * metres
    return f"{value:.2f} mm" if abs(value) < 100 else f"{value:.1f} mm"


def um(metres: float) -> str:
    """Metres as micrometres."""
    return f"{1e6 * metres:.1f} µm"
