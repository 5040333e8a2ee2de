"""What to build: the numbers of the 4-f bench that shows single-sideband holograms.

The panel stands in the front focal plane of lens 1, the filter in the common focal plane, the
panel's image in the back focal plane of lens 2. A frequency f of the panel crosses the filter
plane at λ·focal1·f.

Sides: rows of the panel run down (+y). A wave exp(+i(kr − ωt)) whose phase grows with +y travels
towards +y, so f_y > 0, the sideband that carries U itself, crosses the filter plane below the
axis. Passing it gives the objects upright in depth, as virtual images behind the panel. Passing
the other half instead gives the conjugate: real images in front of the panel, near and far
exchanged, that a bare sensor can catch.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import asin, degrees, sqrt, tan

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
    x, y : on the sensor; the image is upside down and left to right
    resolution : (x, y) in object space, λz over the panel's width and height
    focus : (x, y) depth of focus in object space, about 2λ(z/width)²
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
    """A bench for one panel, wavelength and pair of lenses; lengths in metres."""

    slm: SLM
    wavelength: float
    focal1: float = 0.15
    focal2: float = 0.15

    def __post_init__(self) -> None:
        for name in ("wavelength", "focal1", "focal2"):
            value = getattr(self, name)
            if not 0 < value < float("inf"):
                raise ValueError(f"{name} must be a positive length in metres, not {value:g}")
        if self.wavelength >= 2 * self.slm.pixel_pitch:
            raise ValueError(
                f"pixels of {self.slm.pixel_pitch:g} m diffract {self.wavelength:g} m past 90°"
            )

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
        """Of the sideband's centre from the axis, in y: λ·focal1/4p."""
        return self.order_spacing / 4

    @property
    def opening(self) -> tuple[float, float]:
        """Width and height of the mask's opening: all of f_x, half of f_y."""
        return self.order_spacing, self.order_spacing / 2

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
        x = self.order_spacing / 2 + width * m / 2
        y = self.order_spacing / 2 + height * m / 2
        return 2 * sqrt(x**2 + y**2)

    def place(self, target: Target) -> Place:
        """Where an object's image stands; ValueError for one at or behind the panel."""
        z = target.depth
        if not z > 0:
            raise ValueError(f"{target.name} is at depth {z:g} m; objects stand at z > 0")
        reach_x = z * tan(self.half_angle)
        reach_y = z * tan(asin(self.wavelength * self.slm.nyquist / 2))
        width, height = self.size
        m = self.magnification
        return Place(
            target,
            self.focal2 - m**2 * z,
            self.focal2 + m**2 * z,
            -m * target.x,
            -m * target.y,
            (self.wavelength * z / width, self.wavelength * z / height),
            (2 * self.wavelength * (z / width) ** 2, 2 * self.wavelength * (z / height) ** 2),
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
            f"  orders         every {mm(self.order_spacing)} in x and y",
            f"  carrier        {mm(self.carrier)} below the axis (its twin as far above)",
            f"  pass           the half below the axis: x within ±{mm(self.opening[0] / 2)}, "
            f"y from just below 0 to {mm(self.opening[1])}",
            f"  block          the half above the axis, and what lies outside the opening of "
            f"{mm(self.opening[0])} × {mm(self.opening[1])}",
            f"  zero order     on the axis, {um(self.zero_order[0])} × {um(self.zero_order[1])}; "
            "the edge of the mask, or a dot of some 0.1 mm, blocks it",
            "  conjugate      pass the half above instead: real images, near and far exchanged",
        ]
        if targets:
            text += [
                "",
                "Objects (camera: plane to focus on, behind lens 2, negative is before it; sensor: "
                "bare, conjugate passed):",
                f"  {'':<10}{'depth':>10}{'camera':>11}{'sensor':>11}{'resolution x, y':>19}"
                f"{'depth of focus':>18}{'field ±x, ±y':>19}{'by all pixels':>19}",
            ]
        for place in map(self.place, targets):
            text.append(
                f"  {place.target.name:<10}{mm(place.target.depth):>10}{mm(place.camera):>11}"
                f"{mm(place.sensor):>11}"
                f"{um(place.resolution[0]) + ', ' + um(place.resolution[1]):>19}"
                f"{mm(place.focus[0]) + ', ' + mm(place.focus[1]):>18}"
                f"{mm(place.field_any[0]) + ', ' + mm(place.field_any[1]):>19}"
                f"{mm(place.field_all[0]) + ', ' + mm(place.field_all[1]):>19}"
            )
        return text


def mm(metres: float) -> str:
    """Metres as millimetres."""
    value = 1e3 * metres
    return f"{value:.2f} mm" if abs(value) < 100 else f"{value:.1f} mm"


def um(metres: float) -> str:
    """Metres as micrometres."""
    return f"{1e6 * metres:.1f} µm"
