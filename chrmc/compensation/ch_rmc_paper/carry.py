"""Carry one object's field over a motion, and say on which window it serves."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from chrmc.compensation.ch_rmc_paper import cylinder as cylinders
from chrmc.compensation.ch_rmc_paper.blank import reusable
from chrmc.compensation.ch_rmc_paper.conversion import to_curved, to_planar
from chrmc.compensation.ch_rmc_paper.cylinder import Cylinder, cylinder_at, turned
from chrmc.optics.footprint import reach
from chrmc.optics.passband import Passband
from chrmc.optics.propagation import cycles_to_phasor, padded_shape, transfer_function
from chrmc.record import FrameRecord
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM
from chrmc.threads import workers
from chrmc.window import Window


@dataclass(frozen=True)
class Rotation:
    """By `angle` radians about the vertical axis through `centre` (x, z), right-handed about +y."""

    centre: tuple[float, float]
    angle: float


@dataclass(frozen=True)
class Translation:
    """By (x, y, z) metres."""

    by: tuple[float, float, float]


Motion = Rotation | Translation | None
"""What an object does between two frames; None for no motion."""


def moved(cloud: PointCloud, motion: Motion) -> PointCloud:
    """The cloud after the motion, phases and amplitudes kept."""
    if motion is None:
        return cloud
    if isinstance(motion, Rotation):
        positions = turned(cloud.positions, motion.centre, motion.angle)
    else:
        positions = cloud.positions + np.array(motion.by)
    return PointCloud(positions, cloud.amplitude, cloud.phase)


def carried_window(
    before: PointCloud,
    after: PointCloud,
    motion: Motion,
    slm: SLM,
    wavelength: float,
    passband: Passband,
) -> Window:
    """Where the carried field stands for the whole object."""
    if motion is None:
        return Window.full(slm)
    if isinstance(motion, Rotation):
        # The object's light sweeps the panel as the arc's centre sees it, whatever its own depth.
        shift = (0.0, -motion.centre[1] * np.tan(motion.angle))
        return reusable(before, after, slm, wavelength, passband, shift, soft_axes=(0,))
    x, y, z = motion.by
    # Footprints move along; they widen or narrow with depth, which may pass a pixel.
    grown = [abs(z) * reach(wavelength, f) for f in (passband.fx_max, passband.fy_max)]
    soft = [axis for axis, change in enumerate(grown) if change > slm.pixel_pitch]
    margin = abs(z) * reach(wavelength, slm.nyquist) + 2 * np.sqrt(wavelength * abs(z))
    return reusable(before, after, slm, wavelength, passband, (y, x), soft, margin)


def carry(
    field: NDArray[np.complex64],
    middle: NDArray[np.float64],
    motion: Rotation | Translation,
    slm: SLM,
    wavelength: float,
    radius: float,
    record: FrameRecord,
    cylinder: Cylinder | None = None,
) -> tuple[NDArray[np.complex64], Cylinder | None]:
    """The field after the motion, (H, W), and the cylinder it went by, to be handed in next time.

    middle : (3,) the object's centre before the motion, metres
    radius : of the curved hologram, metres
    record : books the stages PA, CON and RMC
    """
    if isinstance(motion, Translation):
        with record.stage("RMC"):
            return translate(field, motion, slm, wavelength), cylinder
    with record.stage("PA"):
        if cylinder is None or cylinder.centre != motion.centre or cylinder.radius != radius:
            cylinder = cylinder_at(slm, wavelength, motion.centre, radius)
        local: NDArray[Any] = cylinders.to_local(field, cylinder, motion.angle)
    with record.stage("CON"):
        local = to_curved(local, cylinder.table)
    with record.stage("RMC"):
        bearing = float(middle[0]) - motion.centre[0]
        local = cylinders.rotate(local, cylinder, motion.angle, bearing)
    with record.stage("CON"):
        local = to_planar(local, cylinder.table)
    with record.stage("PA"):
        axial = float(turned(middle, motion.centre, motion.angle)[2] - middle[2])
        out = cylinders.to_original(local, cylinder, axial)
        out *= np.complex64(cylinders.piston(cylinder, middle, motion.angle))
    return out, cylinder


def translate(
    field: NDArray[np.complex64], motion: Translation, slm: SLM, wavelength: float
) -> NDArray[np.complex64]:
    """The field of an object that moved without turning: exact but for what was off the panel."""
    x, y, z = motion.by
    grid = padded_shape(field.shape, slm.pixel_pitch, wavelength, z)
    # Room for what the shift carries off the panel, so that it doesn't come back opposite.
    away = [int(np.ceil(abs(v) / slm.pixel_pitch)) for v in (y, x)]
    rows, columns = (
        scipy.fft.next_fast_len(max(g, n + min(a, n)))
        for g, n, a in zip(grid, field.shape, away, strict=True)
    )
    spectrum = scipy.fft.fft2(field, s=(rows, columns), workers=workers())
    if z:
        spectrum *= transfer_function((rows, columns), slm.pixel_pitch, wavelength, z)
    spectrum *= cycles_to_phasor(-scipy.fft.fftfreq(rows, slm.pixel_pitch) * y)[:, None]
    spectrum *= cycles_to_phasor(-scipy.fft.fftfreq(columns, slm.pixel_pitch) * x)
    out = scipy.fft.ifft2(spectrum, workers=workers(), overwrite_x=True)
    return np.ascontiguousarray(out[: field.shape[0], : field.shape[1]])
