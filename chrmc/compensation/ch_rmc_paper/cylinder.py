"""Carry a hologram from one frame to the next on the paper's cylinder (sections 2.2.3 to 2.2.6).

OPH → LPH by propagation over (d, l), LPH → curved hologram, rotation as a shift by R·θ along the
cylinder, and the same way back. Angles are right-handed about +y (down): a positive one moves
what stands in front of the centre towards −x.

The rows play no part between the two propagations, so the local holograms are kept as (f_y, x):
Fourier transformed along y only.

What the published method leaves open is settled so: the shift is sub-pixel; light that the
rotation would carry past Nyquist is taken out first, with the soft edge of a footprint; the
object's axial step (`recede`) and the constant phase that a chain of thin conversions gets wrong
(`piston`) are put right for the object's centre. The aberrations stay, they are the method's own:
k·θ·x·(α² + x²/R²)/2 at x from the axis, for light at angle α.
"""

from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from chrmc.compensation.ch_rmc_paper.conversion import conversion_table, gap, sagitta
from chrmc.optics.footprint import taper
from chrmc.optics.propagation import cycles_to_phasor, transfer_function
from chrmc.slm import SLM
from chrmc.threads import workers

_ROOM = 256  # columns into which a rotation may carry light before it comes back on the other side


@dataclass(frozen=True, eq=False)
class Cylinder:
    """Where the local holograms of one arc lie, with what the conversions need.

    slm, wavelength : as everywhere
    centre : (x_O, z_O) of the arc, metres
    radius : of the curved hologram, metres
    z0 : its sagitta over the SLM's width, metres
    out, back : transfer functions OPH → LPH and LPH → OPH on the padded grid
    table : T on the padded grid's columns
    """

    slm: SLM
    wavelength: float
    centre: tuple[float, float]
    radius: float
    z0: float
    out: NDArray[np.complex64]
    back: NDArray[np.complex64]
    table: NDArray[np.complex64]

    @property
    def distance(self) -> float:
        """d of the paper: depth of the LPH, z_O − R + z0, metres."""
        return self.centre[1] - self.radius + self.z0

    @property
    def offset(self) -> float:
        """l of the paper: x of the LPH's centre, metres."""
        return self.centre[0]

    @property
    def fx(self) -> NDArray[np.float64]:
        """(columns,) frequencies of the padded grid, cycles per metre."""
        return scipy.fft.fftfreq(self.table.shape[0], self.slm.pixel_pitch)

    @property
    def fy(self) -> NDArray[np.float64]:
        """(rows,) frequencies of the padded grid, cycles per metre."""
        return scipy.fft.fftfreq(self.out.shape[0], self.slm.pixel_pitch)


def _side(count: int, spread: int) -> int:
    """Pixels of a padded axis: room for light of the whole band, within reason."""
    return min(max(count + spread, 2 * spread), max(3 * count, 4096))


def grid_for(slm: SLM, wavelength: float, distance: float) -> tuple[int, int]:
    """Rows and columns of the padded grid for propagation over a distance, metres."""
    spread = int(np.ceil(abs(distance) * wavelength / (2 * slm.pixel_pitch**2)))
    rows, columns = _side(slm.height, spread), _side(slm.width, spread) + _ROOM
    return scipy.fft.next_fast_len(rows), scipy.fft.next_fast_len(columns)


def cylinder_at(
    slm: SLM, wavelength: float, centre: tuple[float, float], radius: float
) -> Cylinder:
    """The cylinder around the centre (x_O, z_O) of an arc, metres."""
    z0 = sagitta(radius, slm.width * slm.pixel_pitch)
    distance = centre[1] - radius + z0
    grid = grid_for(slm, wavelength, distance)
    # The grid is periodic: it is read from where the panel's light arrives, seen from the axis.
    middle = (slm.width - 1) / 2 - centre[0] / slm.pixel_pitch
    index = np.arange(grid[1])
    index = index + grid[1] * np.rint((middle - index) / grid[1])
    x = np.clip((index - (slm.width - 1) / 2) * slm.pixel_pitch, -radius, radius)
    aside = cycles_to_phasor(scipy.fft.fftfreq(grid[1], slm.pixel_pitch) * centre[0])
    return Cylinder(
        slm,
        wavelength,
        centre,
        radius,
        z0,
        transfer_function(grid, slm.pixel_pitch, wavelength, -distance) * aside,
        transfer_function(grid, slm.pixel_pitch, wavelength, distance) * aside.conj(),
        conversion_table(x, radius, z0, wavelength),
    )


def to_local(
    field: NDArray[np.complex64], cylinder: Cylinder, angle: float = 0.0
) -> NDArray[np.complex64]:
    """OPH → LPH. (H, W) on the panel → (f_y, x) on the padded grid.

    angle : of the coming rotation, which adds the frequency −sin(angle)/λ. What it would carry
    past Nyquist is taken out now; it would come back aliased, as light from a wrong direction.
    """
    local = scipy.fft.fft2(field, s=cylinder.out.shape, workers=workers())
    local *= cylinder.out
    if angle:
        then = cylinder.fx - np.sin(angle) / cylinder.wavelength
        local *= taper(then, np.array(cylinder.slm.nyquist)).astype(np.float32)
    return scipy.fft.ifft(local, axis=1, workers=workers(), overwrite_x=True)


def to_original(
    local: NDArray[np.complex64], cylinder: Cylinder, recede: float = 0.0
) -> NDArray[np.complex64]:
    """LPH → OPH. (f_y, x) on the padded grid → (H, W) on the panel.

    recede : metres by which the object moves away from the hologram. A shift and a tilt leave an
    object at its depth, a rotation about a distant axis does not; its constant phase they have.
    The defocus exp(−iπλ·recede·f²) is paraxial, ample for the micrometres of one step.
    """
    spectrum = scipy.fft.fft(local, axis=1, workers=workers())
    spectrum *= cylinder.back
    if recede:
        scale = -0.5 * cylinder.wavelength * recede
        spectrum *= cycles_to_phasor(scale * cylinder.fx**2)
        spectrum *= cycles_to_phasor(scale * cylinder.fy**2)[:, None]
    field = scipy.fft.ifft2(spectrum, workers=workers(), overwrite_x=True)
    return np.ascontiguousarray(field[: cylinder.slm.height, : cylinder.slm.width])


def rotate(
    curved: NDArray[np.complex64], cylinder: Cylinder, angle: float, bearing: float = 0.0
) -> NDArray[np.complex64]:
    """The curved hologram turned by `angle`: shifted by −R·angle along its columns, sub-pixel.

    bearing : x of the object from the axis, metres. Seen from the cylinder the object's light is
    tilted by bearing/R, which can exceed what the pixels resolve; the sub-pixel shift then has to
    know which of the frequencies 1/pitch apart is meant.
    """
    centre = -bearing / (cylinder.radius * cylinder.wavelength)
    pitch = cylinder.slm.pixel_pitch
    fx = cylinder.fx + np.rint((centre - cylinder.fx) * pitch) / pitch
    spectrum = scipy.fft.fft(curved, axis=1, workers=workers())
    spectrum *= cycles_to_phasor(fx * (cylinder.radius * angle))
    return scipy.fft.ifft(spectrum, axis=1, workers=workers(), overwrite_x=True)


def turned(
    point: NDArray[np.float64], centre: tuple[float, float], angle: float
) -> NDArray[np.float64]:
    """(…, 3) positions rotated by `angle` about the vertical axis through `centre` (x, z)."""
    c, s = np.cos(angle), np.sin(angle)
    x, z = point[..., 0] - centre[0], point[..., 2] - centre[1]
    return np.stack([centre[0] + c * x + s * z, point[..., 1], centre[1] - s * x + c * z], axis=-1)


def piston(cylinder: Cylinder, point: NDArray[np.float64], angle: float) -> complex:
    """The unit phasor that brings the chain's phase for a point at `point` (3,) to the true one.

    Followed along the ray that meets the LPH at a right angle after the rotation: the true path
    there is the new depth; the chain gives the old path, one shift aside, and the difference of
    two z(x).
    """
    after = turned(point, cylinder.centre, angle)
    x = after[0] - cylinder.offset
    before = x + cylinder.radius * angle
    depth = point[2] - cylinder.distance
    aside = before + cylinder.offset - point[0]
    z = gap(np.array([before, x]), cylinder.radius, cylinder.z0)
    chain = np.copysign(np.hypot(depth, aside), depth) + z[0] - z[1]
    cycles = (after[2] - cylinder.distance - chain) / cylinder.wavelength
    return complex(np.exp(2j * np.pi * (cycles - np.rint(cycles))))
