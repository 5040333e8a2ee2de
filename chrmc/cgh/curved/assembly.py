"""From basebands at nodes to pixels: A_y·M·A_x, in real matrix products.

A_x and A_y hold the interpolation from the nodes and the phase of the reference wave; A_y also
holds the carrier, so that Re(field·carrier) comes out as float32 without a complex field.
"""

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.nodes import Axis, Panel
from chrmc.cgh.curved.parallel import spread
from chrmc.cgh.curved.wave import Reference

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
_MINUS = np.float32(-1)  # np.negative skips rows of strided outputs in NumPy 2.4


@dataclass(frozen=True, eq=False)
class Factor:
    """A cluster's hologram in low-rank form.

    axis_x, axis_y : nodes and panels; targets count from the window's first column and row
    reference : the wave that was taken out
    real, imag : (n_y, n_x) baseband at the nodes
    """

    axis_x: Axis
    axis_y: Axis
    reference: Reference
    real: Singles
    imag: Singles


def reference_cycles(t: Floats, centre: float, z: float, wavelength: float) -> Floats:
    """(r − z)/λ of the reference along one axis, without cancellation."""
    d2 = (t - centre) ** 2
    return d2 / ((np.sqrt(d2 + z * z) + z) * wavelength)


def phasor(cycles: Floats) -> tuple[Floats, Floats]:
    """cos and sin of 2π·cycles in float64."""
    turn = 2 * pi * (cycles - np.rint(cycles))
    return np.cos(turn), np.sin(turn)


def expand_columns(factor: Factor, x: tuple[Floats, Floats]) -> Singles:
    """M·A_x as (2·n_y, columns of axis_x.targets): each node's real, then its imaginary row.

    x : cos and sin of the phase put on along x, over all targets
    """
    ny, nx = factor.real.shape
    # (M_re, −M_im) meet the cosine and the sine for the real part, (M_im, M_re) for the other.
    left = np.empty((ny, 2, nx, 2), dtype=np.float32)
    left[:, 0, :, 0] = left[:, 1, :, 1] = factor.real
    np.multiply(factor.imag, _MINUS, out=left[:, 0, :, 1])
    left[:, 1, :, 0] = factor.imag
    flat = left.reshape(2 * ny, 2 * nx)
    panels = factor.axis_x.panels
    covered = factor.axis_x.targets
    width = covered.stop - covered.start
    whole = sum(panel.target_count for panel in panels) == width
    out = (np.empty if whole else np.zeros)((2 * ny, width), dtype=np.float32)

    def expand(panel: Panel) -> None:
        place = slice(panel.targets.start - covered.start, panel.targets.stop - covered.start)
        cos, sin = x[0][panel.targets], x[1][panel.targets]
        part = flat[:, 2 * panel.nodes.start : 2 * panel.nodes.stop]
        if panel.matrix is None:
            out[:, place] = part[:, 0::2] * cos.astype(np.float32)
            out[:, place] += part[:, 1::2] * sin.astype(np.float32)
            return
        right = np.empty((panel.node_count, 2, panel.target_count), dtype=np.float32)
        np.multiply(panel.matrix.T, cos, out=right[:, 0], casting="same_kind")
        np.multiply(panel.matrix.T, sin, out=right[:, 1], casting="same_kind")
        np.matmul(part, right.reshape(-1, panel.target_count), out=out[:, place])

    spread(expand, panels)
    return out


def add_signal(
    out: Singles, factor: Factor, x: tuple[Floats, Floats], y: tuple[Floats, Floats], add: bool
) -> None:
    """Put (or add) Re(A_y·M·A_x) on the targets of `out`."""
    wide = expand_columns(factor, x)
    columns = factor.axis_x.targets

    def put(panel: Panel) -> None:
        rows = wide[2 * panel.nodes.start : 2 * panel.nodes.stop]
        cos, sin = y[0][panel.targets, None], y[1][panel.targets, None]
        place = out[panel.targets, columns]
        if panel.matrix is None:
            block = rows[0::2] * cos.astype(np.float32)
            block -= rows[1::2] * sin.astype(np.float32)
        else:
            left = np.empty((panel.target_count, panel.node_count, 2), dtype=np.float32)
            np.multiply(panel.matrix, cos, out=left[:, :, 0], casting="same_kind")
            np.multiply(panel.matrix, -sin, out=left[:, :, 1], casting="same_kind")
            flat = left.reshape(panel.target_count, -1)
            if not add:
                np.matmul(flat, rows, out=place)
                return
            block = flat @ rows
        if add:
            place += block
        else:
            place[:] = block

    spread(put, factor.axis_y.panels)


def add_field(
    out: NDArray[np.complex64],
    factor: Factor,
    x: tuple[Floats, Floats],
    y: tuple[Floats, Floats],
    add: bool,
) -> None:
    """Put (or add) A_y·M·A_x on the targets of `out`."""
    wide = expand_columns(factor, x)
    columns = factor.axis_x.targets

    def put(panel: Panel) -> None:
        n = panel.node_count
        rows = np.empty((n, 2, wide.shape[1]), dtype=np.complex64)
        part = wide[2 * panel.nodes.start : 2 * panel.nodes.stop].reshape(n, 2, -1)
        rows[:, 0].real, rows[:, 0].imag = part[:, 0], part[:, 1]
        np.multiply(part[:, 1], _MINUS, out=rows[:, 1].real)
        rows[:, 1].imag = part[:, 0]
        cos, sin = y[0][panel.targets, None], y[1][panel.targets, None]
        place = out[panel.targets, columns]
        if panel.matrix is None:
            block = rows[:, 0] * cos.astype(np.float32) + rows[:, 1] * sin.astype(np.float32)
        else:
            left = np.empty((panel.target_count, n, 2), dtype=np.float32)
            np.multiply(panel.matrix, cos, out=left[:, :, 0], casting="same_kind")
            np.multiply(panel.matrix, sin, out=left[:, :, 1], casting="same_kind")
            # The interleaved real and imaginary columns are plain columns to sgemm.
            block = (
                left.reshape(panel.target_count, -1) @ rows.reshape(2 * n, -1).view(np.float32)
            ).view(np.complex64)
        if add:
            place += block
        else:
            place[:] = block

    spread(put, factor.axis_y.panels)
