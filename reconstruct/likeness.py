"""Does a focal stack show an object of the right shape? Its light per cell, and its relief.

The scene's map of light says how much light each cell holds and at what depth. Each cell of the
picture is looked at where the scene has it: then the light per cell must be in proportion to the
scene's (correlation), and every cell must be sharpest there. Moved in depth as a whole, cells get
blurred together: where they are sharpest is the object's depth error, however deep it is. Stretched
in depth by a factor about the mean, they are sharpest at factor 1; at 0 the object is flat, at −1
its relief is inverted.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.light_map import LightMap
from reconstruct.depth_profile import profile_likeness
from reconstruct.focus import Cells, refine_peak
from reconstruct.jackknife import standard_error
from reconstruct.relief import gain_of_wrong, stretch_of

ALIKE = 0.8
"""Least correlation of the light per cell: right pictures have more, mirrored ones less."""
RELIEF = 0.4, 2.2
"""Least and largest factor of the relief: right ones of a body whose relief is half the depth of
focus had 0.5 to 1.7, flat ones −0.3 to 0.2. And four standard errors off 1."""
RELIEF_ERROR = 0.3
"""Standard error of the relief's factor up to which it counts: with more, the object is too shallow
for its depth of focus, or too dense to be sharp anywhere."""
GAIN = 2.0
"""Standard errors by which cells must tell more at a wrong stretch than at 1: right helices came to
1.8, flat and inverted ones to 2.3 and more where they could be told from right ones."""
SHALLOW = 0.1
"""Least relief, as a standard deviation over the larger depth of focus, of which a factor can be
told: that of a car of 0.14 mm at 250 mm is 0.2."""
CLEAR = 0.2
"""Least share of the light in cells of one depth, for the cells to tell depths."""
SHARP = 5.0
"""Height of the focus curve of all cells, in standard errors, that counts as a focus: noise reaches
3."""


@dataclass(frozen=True, eq=False)
class Likeness:
    """How a picture compares with the scene's map of light.

    told : there are cells enough to judge a shape by
    picture : correlation of the light per cell, 1 for the scene's own
    lateral_error : (x, y) metres by which that is largest elsewhere
    slices : (depth in metres, correlation) of the light that is sharp there, nearest first
    depth_error : metres by which the cells together are sharpest elsewhere; NaN for no peak
    depth_scatter : its standard error, metres; infinite where the cells tell no depth
    sharpness : height of that peak over the curve's median, in standard errors
    relief : stretch in depth at which the cells are sharpest; NaN where nothing can be told
    relief_error : its standard error
    relief_gain : standard errors by which the cells tell more at a wrong stretch than at 1
    deep : the scene's relief is enough of the depth of focus to be asked for
    """

    told: bool
    picture: float
    lateral_error: tuple[float, float]
    slices: tuple[tuple[float, float], ...]
    depth_error: float
    depth_scatter: float
    sharpness: float
    relief: float
    relief_error: float
    relief_gain: float = float("inf")
    deep: bool = True

    @property
    def relief_known(self) -> bool:
        """Whether it can be told from a flat one; where it is off, from the right one."""
        return self.relief_error < RELIEF_ERROR and (
            not self._relief_off or self.relief_gain > GAIN
        )

    @property
    def _relief_off(self) -> bool:
        far = abs(self.relief - 1) > 4 * self.relief_error
        return far and not RELIEF[0] <= self.relief <= RELIEF[1]

    @property
    def faults(self) -> list[str]:
        """What is wrong with the shape, each in a few words."""
        found = []
        if self.told and self.picture < ALIKE:
            found.append(f"the picture is not the scene's (correlation {self.picture:.2f})")
        if self.relief_known and self._relief_off:
            kind = "inverted" if self.relief < -0.5 else "flat" if self.relief < 0.5 else "wrong"
            found.append(f"its relief is {kind} ({self.relief:.1f} of the scene's)")
        return found

    @property
    def doubt(self) -> str:
        """What cannot be judged though the scene has it, in words; "" for nothing."""
        if self.relief_known or not self.deep:
            return ""
        off = self.relief_error < RELIEF_ERROR and self._relief_off
        why = f"as like at {self.relief:.1f} as at 1" if off else "too shallow, or speckle"
        return f"its relief cannot be judged ({why})"

    def as_dict(self) -> dict[str, Any]:
        """Plain figures."""
        return {
            "told": self.told,
            "picture": self.picture,
            "slices": [list(pair) for pair in self.slices],
            "depth_error": self.depth_error,
            "depth_scatter": self.depth_scatter,
            "sharpness": self.sharpness,
            "relief": self.relief,
            "relief_error": self.relief_error,
            "relief_gain": self.relief_gain,
            "doubt": self.doubt,
        }


def compare(
    cells: Cells, expected: LightMap, depth_of_focus: float, finer: float | None = None
) -> Likeness:
    """Compare a stack's cells (on the map's own grid) with the map.

    depth_of_focus : metres, of the coarser axis; slices are no thinner
    finer : metres, of the finer axis; default the same
    """
    light = expected.light
    finer = finer or depth_of_focus
    middle = float((light * expected.depth).sum())
    relief = expected.depth - middle
    told = expected.shaped
    offsets = cells.depths - cells.depths[len(cells.depths) // 2]
    if expected.layers is None:
        # A cell with light at several depths is sharp at any of them; the relief is told by cells
        # within a depth of focus.
        one, two = (light / (1 + (expected.spread / f) ** 2) for f in (depth_of_focus, finer / 2))
        clear = told and float(one.sum()) > CLEAR
        size = sqrt(float((light * relief**2).sum()))
        where, how_deep = (_sharpness(cells, middle, relief, weight) for weight in (one, two))
    else:
        # Cells that hold two turns of a helix tell by the whole course of their sharpness.
        one, clear = light, told
        size = sqrt(float((light * (relief**2 + expected.spread**2)).sum()))
        where = how_deep = profile_likeness(cells, expected, (finer, depth_of_focus))
    # A relief of another size peaks elsewhere: the offset is that of the best of four sizes.
    tries = [_peak(partial(where, stretch), one, offsets) for stretch in (1.0, 0.0, -1.0, 2.0)]
    best = max(tries[: 4 if clear and size > 0 else 1], key=lambda t: t.value)
    error, height = best.offset, best.height
    shift = error if clear and np.isfinite(error) and height >= SHARP else 0.0
    found = at_depths(cells.light, cells.depths, expected.depth + shift)
    factor, scatter, gain = float("nan"), float("inf"), 0.0
    deep = told and size > SHALLOW * depth_of_focus
    # Cells that hardly tell the depth (see `spill`) do not tell the relief.
    if clear and deep and height >= 2 * SHARP:
        factor, scatter = stretch_of(partial(how_deep, offset=shift), light)
        # What overlaps may look alike at two stretches.
        mixed = expected.layers is not None
        gain = gain_of_wrong(partial(how_deep, offset=shift), light) if mixed else float("inf")
    return Likeness(
        told,
        correlation(found, light),
        lateral_shift(found, light, expected.cell),
        _slices(cells, expected, depth_of_focus),
        error,
        best.scatter if clear else float("inf"),
        height if clear else 0.0,
        factor,
        scatter,
        gain,
        deep,
    )


def correlation(found: NDArray[np.float64], expected: NDArray[np.float64]) -> float:
    """Pearson's, 0 where either is even."""
    a, b = found - found.mean(), expected - expected.mean()
    size = sqrt(float((a * a).sum()) * float((b * b).sum()))
    return float((a * b).sum()) / size if size > 0 else 0.0


def dimmed(light: LightMap, brightness: NDArray[np.floating]) -> LightMap:
    """The map as a panel shows it that does not get all the light of every point.

    brightness : (h, w) over the map's grid, whole samples to a cell
    """
    rows, columns = light.light.shape
    blocks = brightness.reshape(rows, brightness.shape[0] // rows, columns, -1)
    shown = light.light * blocks.mean(axis=(1, 3))
    return replace(light, light=shown / shown.sum())


def light_of(cells: Cells, expected: LightMap, depth_error: float) -> float:
    """Light in the cells that the scene lights, each at its depth, less what the dark ones hold."""
    found = at_depths(cells.light, cells.depths, expected.depth + depth_error)
    lit = expected.light > 0
    dark = float(np.median(found[~lit])) if not lit.all() else 0.0
    return max(float((found[lit] - dark).sum()), 0.0)


def lateral_shift(
    found: NDArray[np.float64], expected: NDArray[np.float64], cell: float
) -> tuple[float, float]:
    """(x, y) metres by which the correlation is largest elsewhere, up to two cells to each side.

    The expected light is moved by parts of a cell, its cells mixed with their neighbours as light
    spread evenly in them would be.
    """
    from scipy.ndimage import shift

    tried = np.linspace(-2, 2, 161)
    moved = [0.0, 0.0]
    for axis in (0, 1, 0, 1):
        there = []
        for way in tried:
            moved[axis] = way
            there.append(correlation(found, shift(expected, moved, order=1)))
        best = float(tried[int(np.argmax(there))])
        # The curve has corners where cells meet cells: a parabola is right between them.
        near = np.abs(tried - best) <= 0.4
        bend, slope, _ = np.polyfit(tried[near] - best, np.array(there)[near], 2)
        moved[axis] = best + float(np.clip(-slope / (2 * bend), -0.4, 0.4)) if bend < 0 else best
    return moved[1] * cell, moved[0] * cell


def at_depths(
    values: NDArray[np.float64], depths: NDArray[np.float64], wanted: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(m, n) values of a (D, m, n) stack, each cell at its own depth, interpolated."""
    place = np.clip((wanted - depths[0]) / (depths[1] - depths[0]), 0, len(depths) - 1)
    low = np.minimum(place.astype(np.intp), len(depths) - 2)
    way = place - low
    rows, columns = np.indices(wanted.shape)
    below, above = values[low, rows, columns], values[low + 1, rows, columns]
    mixed: NDArray[np.float64] = below * (1 - way) + above * way
    return mixed


def _mean(values: NDArray[np.float64], weight: NDArray[np.float64]) -> float:
    return float((values * weight).sum() / weight.sum())


@dataclass(frozen=True, eq=False)
class _Peak:
    """Of the cells' mean sharpness against an offset in depth: its place (NaN for none), its
    standard error, height over the median in standard errors, and value."""

    offset: float
    scatter: float
    height: float
    value: float


def _sharpness(
    cells: Cells,
    middle: float,
    relief: NDArray[np.float64],
    weight: NDArray[np.float64],
) -> Callable[..., NDArray[np.float64]]:
    """A function of the relief's stretch and an offset in depth: (m, n) each cell's weight times
    its sharpness there over its median."""
    sharp = cells.sharpness / np.maximum(np.median(cells.sharpness, axis=0), 1e-300)
    return lambda stretch, offset: (
        weight * at_depths(sharp, cells.depths, middle + offset + stretch * relief)
    )


def _peak(
    at: Callable[[float], NDArray[np.float64]],
    weight: NDArray[np.float64],
    offsets: NDArray[np.float64],
) -> _Peak:
    """Of what the cells tell at each offset, weighted; no peak at the range's ends."""
    share = weight / weight.sum()
    per_cell = np.array([at(o) for o in offsets]) / weight.sum()
    curve = per_cell.sum(axis=(1, 2))
    top = int(curve.argmax())
    offset = refine_peak(offsets, curve)
    if not np.isfinite(offset):
        return _Peak(offset, float("inf"), 0.0, 0.0)
    value = float(curve[top])
    error = sqrt(float(((per_cell[top] - share * value) ** 2).sum()))
    height = (value - float(np.median(curve))) / error if error > 0 else 0.0
    scatter = standard_error(per_cell, weight > 0, lambda c: refine_peak(offsets, c))
    return _Peak(offset, scatter, float(height), value)


def _slices(
    cells: Cells, expected: LightMap, depth_of_focus: float
) -> tuple[tuple[float, float], ...]:
    """Correlation of the light per cell in slices of depth, as thick as the depth of focus or more.

    Light belongs to the slices beside its cell's depth, in proportion.
    """
    lit = expected.light > 0
    near, far = float(expected.depth[lit].min()), float(expected.depth[lit].max())
    count = int(np.clip((far - near) / (2 * depth_of_focus), 0, 5)) + 1
    if count == 1:
        return ()
    centres = np.linspace(near, far, count)
    seen = np.isfinite(cells.depth)
    found_at = np.where(seen, cells.depth, far + 10 * (far - near))
    light = np.where(seen, cells.focused_light, 0.0)
    width = centres[1] - centres[0]
    out = []
    for centre in centres:
        want = expected.light * np.clip(1 - np.abs(expected.depth - centre) / width, 0, 1)
        got = light * np.clip(1 - np.abs(found_at - centre) / width, 0, 1)
        if want.any():
            out.append((float(centre), correlation(got, want)))
    return tuple(out)
