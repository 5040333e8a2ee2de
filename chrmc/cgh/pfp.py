"""Principal fringe patterns: what the look-up-table methods look up, and where they keep it.

The principal fringe pattern (PFP) of a depth plane is the field of a point of unit amplitude on
the axis, at a pixel centre of the plane. Every other point's fringe is a shifted copy. A PFP is
even in x and y, so one quadrant is kept. The constant exp(ikz) is left to the point, in float64.

A point between pixels or planes needs more than a shift. Per axis, with s(d, z) the excess path,

    exp(2πi/λ·[s(d, z) − s(m·p, z0)]),   s = √(d² + z²) − z  or  d²/2z (Fresnel),

turns the PFP of plane z0, m pixels off its centre, into the fringe of a point at depth z and
distance d: the thin-lens property PFP(z) = PFP(z0)·exp[(ik/2)(x² + y²)(1/z − 1/z0)] of the
look-up-table literature, with a tilt for the sub-pixel shift, and not only paraxially.
"""

from collections.abc import Callable, Hashable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chrmc.kept import Kept
from chrmc.optics.footprint import reach, taper
from chrmc.optics.passband import Passband
from chrmc.optics.propagation import cycles_to_phasor
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM

DEPTH_STEP = 1e-4
DEPTH_SETTINGS = tuple({"depth_step": step} for step in (1e-3, 1e-4, None))
"""Default distance between depth planes, metres: that of the paper's 256-plane images."""
SUBPIXEL = ("exact", "round")
FORMS = ("spherical", "fresnel")
_ON_GRID = 1e-5  # pixels; 3e-5 rad at Nyquist
_ON_PLANE = 1e-9  # metres; 1e-5 rad at 2 degrees
_MOST_LINES = 2e8  # samples along the axes of all planes' patterns: half a minute
_ROUND_UP = 64  # samples; so that a slowly moving scene does not rebuild its PFPs


class PFPTable(Kept):
    """PFPs built on demand; one larger than the limit in bytes is refused with ValueError.

    Hold one for a whole video and give it to every call (`cache=`): planes seen before cost
    nothing. A PFP is built anew when a point needs a larger part of it than there is.
    """

    def __init__(self, limit: int = 1 << 29) -> None:
        super().__init__(limit)
        self.built = 0
        self.reused = 0

    def __str__(self) -> str:
        return f"{super().__str__()}; {self.built} built, {self.reused} reused".replace(
            "arrays", "PFPs"
        )

    def at_least(
        self,
        key: Hashable,
        extent: tuple[int, ...],
        build: Callable[[tuple[int, ...]], NDArray[np.complex64]],
    ) -> NDArray[np.complex64]:
        """The pattern of `key`, at least `extent` large, built by build(extent) when needed."""
        if key in self:
            found = self.get(key, lambda: np.zeros(0))
            if all(n >= need for n, need in zip(found.shape, extent, strict=True)):
                self.reused += 1
                return found
            extent = tuple(np.maximum(found.shape, extent))
        size = int(np.prod(extent)) * 8
        if size > self.limit:
            raise ValueError(
                f"one principal fringe pattern of {' × '.join(map(str, extent))} samples takes "
                f"{size / 2**20:.4g} MiB, but the table may hold {self.limit / 2**20:.4g} MiB: "
                "raise its limit, or use nlut-1d"
            )
        self.built += 1
        return self.put(key, build(extent))


def excess(
    d: NDArray[np.floating], z: NDArray[np.floating] | float, form: str
) -> NDArray[np.float64]:
    """Path from a point at depth z to a pixel a distance d off its axis, less z, metres."""
    reach2: NDArray[np.float64] = np.square(d, dtype=np.float64)
    return reach2 / (2 * z if form == "fresnel" else np.sqrt(reach2 + z**2) + z)


def quadrant(
    table: PFPTable,
    slm: SLM,
    wavelength: float,
    z: float,
    passband: Passband,
    extent: tuple[int, int],
    form: str,
    tapered: bool,
) -> NDArray[np.complex64]:
    """A quadrant of the PFP of plane z, from its centre outwards, at least `extent` large.

    form : "spherical" w/r·exp(ik(r − z)), or "fresnel" w/z·exp(ikρ²/2z)
    tapered : with the soft footprint w in it, or without
    """
    p = slm.pixel_pitch

    def build(shape: tuple[int, ...]) -> NDArray[np.complex64]:
        y, x = np.arange(shape[0]) * p, np.arange(shape[1]) * p
        if form == "fresnel":
            out = np.outer(
                cycles_to_phasor(excess(y, z, form) / wavelength) / np.float32(z),
                cycles_to_phasor(excess(x, z, form) / wavelength),
            )
        else:
            out = np.empty(shape, dtype=np.complex64)
            for i in range(0, shape[0], _ROUND_UP):
                rho2 = y[i : i + _ROUND_UP, None] ** 2 + x**2
                r = np.sqrt(rho2 + z**2)
                out[i : i + _ROUND_UP] = cycles_to_phasor(rho2 / (r + z) / wavelength)
                out[i : i + _ROUND_UP] /= r.astype(np.float32)
        if tapered:
            half = z * np.array([reach(wavelength, f) for f in (passband.fy_max, passband.fx_max)])
            out *= taper(y, half[0]).astype(np.float32)[:, None]
            out *= taper(x, half[1]).astype(np.float32)
        return out

    key = (p, wavelength, z, form, passband if tapered else None)
    return table.at_least(key, extent, build)


def quarter_axis(
    table: PFPTable, slm: SLM, wavelength: float, z: float, f_max: float, extent: int, tapered: bool
) -> NDArray[np.complex64]:
    """One axis of the Fresnel PFP of plane z, from its centre outwards: exp(ikd²/2z), tapered."""

    def build(shape: tuple[int, ...]) -> NDArray[np.complex64]:
        d = np.arange(shape[0])[None] * slm.pixel_pitch
        return axis_lines(d, np.array([z]), np.array([tapered]), wavelength, f_max)[0]

    key = (slm.pixel_pitch, wavelength, z, "axis", f_max if tapered else None)
    return table.at_least(key, (extent,), build)


def axis_lines(
    d: NDArray[np.floating],
    z: NDArray[np.float64],
    tapered: NDArray[np.bool_],
    wavelength: float,
    f_max: float,
) -> NDArray[np.complex64]:
    """(N, samples) the same at distances d (N, samples) off the axis, each of a plane z (N,)."""
    out = cycles_to_phasor(excess(d, z[:, None], "fresnel") / wavelength)
    half = z[tapered, None] * reach(wavelength, f_max)
    out[tapered] *= taper(d[tapered], half).astype(np.float32)
    return out


@dataclass(frozen=True, eq=False)
class Placed:
    """Points sorted onto pixels and depth planes.

    index : (N, 2) row and column of the nearest pixel, perhaps beyond the panel
    plane : (N,) depth of the nearest plane, metres
    offset : (N, 2) metres from pixel centre to point; nought when rounded
    z : (N,) depth used for the wavefront, metres
    factor : (N,) complex64 amplitude·plane/z·exp(i(kz + φ)), z the point's true depth
    shift_only : (N,) the shifted PFP needs no correction
    """

    index: NDArray[np.intp]
    plane: NDArray[np.float64]
    offset: NDArray[np.float64]
    z: NDArray[np.float64]
    factor: NDArray[np.complex64]
    shift_only: NDArray[np.bool_]

    @classmethod
    def of(
        cls,
        cloud: PointCloud,
        slm: SLM,
        wavelength: float,
        depth_step: float | None,
        subpixel: str,
    ) -> "Placed":
        """Place a cloud; arguments as for `chrmc.cgh.nlut.field`."""
        if subpixel not in SUBPIXEL:
            raise ValueError(f"subpixel must be one of {', '.join(SUBPIXEL)}, not {subpixel!r}")
        if depth_step is not None and not (np.isfinite(depth_step) and depth_step > 0):
            raise ValueError(f"depth_step must be a positive length, not {depth_step} m")
        x, y, z = cloud.positions.T
        p = slm.pixel_pitch
        index = np.stack(
            [np.rint(y / p + (slm.height - 1) / 2), np.rint(x / p + (slm.width - 1) / 2)], axis=1
        ).astype(np.intp)
        plane = z if depth_step is None else np.maximum(np.rint(z / depth_step), 1) * depth_step
        offset = np.stack([y - slm.y(index[:, 0]), x - slm.x(index[:, 1])], axis=1)
        near = (np.abs(offset) < _ON_GRID * p).all(axis=1) & (np.abs(z - plane) < _ON_PLANE)
        phasor = cycles_to_phasor(z / wavelength + cloud.phase / (2 * np.pi))
        # The table's 1/r is that of the plane.
        factor = phasor * (cloud.amplitude * plane / z).astype(np.float32)
        if subpixel == "round":
            near = np.ones(len(cloud), dtype=bool)
        offset = np.where(near[:, None], 0.0, offset)
        return cls(index, plane, offset, np.where(near, plane, z), factor, near)

    def extent(self, slm: SLM, wavelength: float, passband: Passband) -> tuple[int, int]:
        """(rows, columns) of a quadrant that serves all these points on the whole panel."""
        out = []
        limits = (passband.fy_max, passband.fx_max)
        for axis, (count, f_max) in enumerate(zip(slm.shape, limits, strict=True)):
            i = self.index[:, axis]
            need = int(np.maximum(np.abs(i), np.abs(count - 1 - i)).max()) + 1
            need = -(-need // _ROUND_UP) * _ROUND_UP
            half = float(self.z.max()) * reach(wavelength, f_max) / slm.pixel_pitch
            out.append(int(min(need, np.ceil(half) + 2)))
        lines = len(np.unique(self.plane)) * float(sum(out))
        if lines > _MOST_LINES:
            raise ValueError(
                f"look-up tables of {len(np.unique(self.plane))} depth planes would take "
                f"{lines:.2g} samples along each axis: use a larger depth_step, rt or curved"
            )
        return out[0], out[1]

    def select(self, index: NDArray[np.intp] | NDArray[np.bool_] | slice) -> "Placed":
        """The points that an index array or slice picks."""
        return Placed(
            self.index[index],
            self.plane[index],
            self.offset[index],
            self.z[index],
            self.factor[index],
            self.shift_only[index],
        )

    def __len__(self) -> int:
        return len(self.index)

    def span(
        self, j: int, axis: int, pixels: NDArray[np.intp], slope: float, slm: SLM
    ) -> tuple[int, int]:
        """First and past-the-last of the pixels (ascending) in point j's footprint.

        slope : half-width of a footprint per unit of depth
        """
        first, last = int(pixels[0]), int(pixels[-1])
        if not np.isfinite(slope):
            return first, last + 1
        centre = self.index[j, axis] + self.offset[j, axis] / slm.pixel_pitch
        half = self.z[j] * slope / slm.pixel_pitch
        low = max(int(np.ceil(centre - half)), first)
        return low, max(low, min(int(np.floor(centre + half)), last) + 1)


def axis_factors(
    placed: Placed,
    axis: int,
    pixels: NDArray[np.intp],
    slm: SLM,
    wavelength: float,
    f_max: float,
    form: str,
) -> NDArray[np.complex64]:
    """(N, pixels) what turns the untapered PFP of a point's plane and pixel into its fringe.

    Thin lens, tilt and the point's own taper along one axis (0 for y, 1 for x).
    """
    steps = pixels - placed.index[:, axis, None]
    on_plane = steps * slm.pixel_pitch
    d = on_plane - placed.offset[:, axis, None]
    z = placed.z[:, None]
    path = excess(d, z, form) - excess(on_plane, placed.plane[:, None], form)
    out = cycles_to_phasor(path / wavelength)
    out *= taper(d, z * reach(wavelength, f_max)).astype(np.float32)
    return out


def placed_waves(
    placed: Placed,
    slm: SLM,
    wavelength: float,
    rows: NDArray[np.intp],
    columns: NDArray[np.intp],
    passband: Passband,
    form: str,
) -> NDArray[np.complex128]:
    """(N, K) each point's shifted and corrected PFP at pixels of its own."""
    plane, z, shifted = placed.plane[:, None], placed.z[:, None], placed.shift_only[:, None]
    path = np.zeros(rows.shape)
    weight = np.ones(rows.shape)
    square = np.zeros(rows.shape)
    bands = passband.fy_max, passband.fx_max
    for axis, (pixels, f_max) in enumerate(zip((rows, columns), bands, strict=True)):
        on_plane = (pixels - placed.index[:, axis, None]) * slm.pixel_pitch
        d = on_plane - placed.offset[:, axis, None]
        own = excess(d, z, form) - excess(on_plane, plane, form)
        path += np.where(shifted, 0.0, own)
        weight *= taper(d, z * reach(wavelength, f_max))
        square += on_plane**2
    path += excess(np.sqrt(square), plane, form)
    modulus = 1 / (plane if form == "fresnel" else np.sqrt(square + plane**2))
    cycles = path / wavelength
    waves: NDArray[np.complex128] = (
        placed.factor[:, None] * weight * modulus * np.exp(2j * np.pi * (cycles - np.rint(cycles)))
    )
    return waves
