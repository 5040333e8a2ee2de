"""An object's light on a grid of directions, summed where it is first looked at.

The light of an object is exp(ikr)/r·m, r the distance from its centre. A rotation of the object
only turns directions; m changes slowly with range, like k·Δ²/(2r) for a point Δ from the centre, so
a few layers, polynomials of 1/r, hold it at all ranges.

The grid is cut into tiles. A tile knows which points it holds; when a frame looks at it, what has
appeared or vanished since is added once, and a tile that was never looked at is summed then.
"""

from dataclasses import dataclass, field
from itertools import pairwise
from math import factorial, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.interface import Series, alone, in_parallel
from chrmc.compensation.ch_rmc_object.chart import Place, path
from chrmc.compensation.ch_rmc_object.grid import SHARE, Grid
from chrmc.compensation.ch_rmc_object.layers import layer_series, middle_range, polynomials
from chrmc.compensation.ch_rmc_object.sums import (
    chunks_of,
    cycles_of,
    phase_table,
    product_of,
    weighed,
)
from chrmc.compensation.ch_rmc_object.transforms import TRANSFORMED, transformed_tile
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Tables = tuple[NDArray[np.floating], NDArray[np.floating]]
"""cos and sin of points' phases along α, (2, N, n_α), and along β, (2, N, n_β)."""

_EXACT = 1e-8  # of a step, to which places along a column are found
_ROUNDING = 5e-7  # of sums in single precision
_SINGLE = 5e-6  # smallest tolerance that single precision serves


class NotCovered(Exception):
    """A frame needs directions or ranges beyond the chart."""


@dataclass(eq=False)
class _Tile:
    """Places of the grid that are summed together.

    alpha, beta : which
    held : (N,) points that its values hold
    rests : per layer, the series of what tables leave, and its terms at the places
    """

    alpha: slice
    beta: slice
    held: Mask | None = None
    rests: list[tuple[Series, NDArray[np.complexfloating]]] = field(default_factory=list)


class Sphere:
    """m on a grid.

    points : (N,) all points of the body from its centre, in the chart's axes
    half : (3,) how far they lie from there
    """

    def __init__(
        self,
        points: PointCloud,
        half: Floats,
        grid: Grid,
        wavelength: float,
        tolerance: float,
    ) -> None:
        self.grid = grid
        self._points, self._half = points, half
        self._wavelength, self._tolerance = wavelength, tolerance
        self._real: type[np.floating] = np.float32 if tolerance >= _SINGLE else np.float64
        self._complex = np.result_type(self._real, np.complex64)
        # The layers of a place side by side: they are read together.
        shape = (grid.count[1], grid.count[0], len(grid.layers))
        self._values = np.zeros(shape, dtype=self._complex)
        self._tiles: dict[tuple[int, int], _Tile] = {}
        self._power = points.amplitude**2
        self._weighed_errors = self._power * self._expected_errors()
        self.dropped = 0.0
        self._taken = 0

    def taken(self) -> int:
        """Points summed onto tiles that were new, since it was asked last."""
        taken, self._taken = self._taken, 0
        return taken

    @property
    def size(self) -> int:
        """Complex numbers it may hold."""
        return int(self._values.size)

    @alone
    def look_up(
        self, turn: Floats, centre: Floats, x: Floats, y: Floats, visible: Mask
    ) -> NDArray[np.complexfloating]:
        """(len(x), len(y)) m at places (x, y, 0) of the hologram.

        turn : (3, 3) world axes to the chart's
        centre : (3,) the object's centre in the world
        visible : (N,) the points that are seen

        Two passes, as images are turned: along α for every β of the grid and column of the
        hologram, then along β. Raises NotCovered.
        """
        grid, taps = self.grid, self.grid.taps
        along = turn[:, 1]
        # (3, n_x): from the centre to y = 0.
        q = turn @ np.stack(
            [x - centre[0], np.full(len(x), -centre[1]), np.full(len(x), -centre[2])]
        )
        dot, square = np.einsum("i,ix->x", along, q), np.einsum("ix,ix->x", q, q)
        r = np.sqrt(square[..., None] + y * (2 * dot[..., None] + y))
        beta = (q[1][..., None] + y * along[1]) / r
        place = (beta - grid.first[1]) / grid.step[1]
        first = int(np.floor(place.min())) - (taps.count // 2 - 1)
        rows = int(np.floor(place.max())) - first + taps.count // 2 + 1
        at = first + np.arange(rows, dtype=np.intp)
        if first < 0 or first + rows > grid.count[1]:
            raise NotCovered
        wanted: Floats = grid.first[1] + at * np.float64(grid.step[1])
        y_at = self._columns(q, dot, square, along, wanted)
        r_at = np.sqrt(square[..., None] + y_at * (2 * dot[..., None] + y_at))
        alpha = (q[0][..., None] + y_at * along[0]) / r_at
        place_a = (alpha - grid.first[0]) / grid.step[0]
        start, weight = taps.weights(place_a)
        low, high = int(start.min()), int(start.max()) + taps.count
        slack = 1e-6 * grid.span[1]
        inside = grid.span[0] - slack <= 1 / r.max() and 1 / r.min() <= grid.span[1] + slack
        if low < 0 or high > grid.count[0] or not inside:
            raise NotCovered
        self._ensure(slice(low, high), slice(first, first + rows), visible)
        by_layer = polynomials(grid.layers, grid.span, 1 / r_at)
        out = np.empty(place.shape, dtype=self._complex)
        flat = self._values.reshape(-1, len(by_layer))

        def some(columns: slice) -> None:
            both = weighed(flat, at * grid.count[0] + start[columns], weight[columns])
            lines = both[..., 0]
            for layer in range(1, len(by_layer)):
                lines = lines + both[..., layer] * by_layer[layer][columns].astype(self._real)
            own, by = taps.weights(place[columns])
            line = np.arange(len(lines))[:, None]
            out[columns] = weighed(lines.reshape(-1, 1), line * rows + own - first, by)[..., 0]

        cuts = np.linspace(0, len(x), min(len(x), 4) + 1).astype(int)
        in_parallel(some, [slice(a, b) for a, b in pairwise(cuts)])
        return out

    def _columns(
        self, q: Floats, dot: Floats, square: Floats, along: Floats, beta: Floats
    ) -> Floats:
        """(n_x, rows) y at which the hologram's columns pass the grid's β, by Newton's steps."""
        y = (beta * np.sqrt(square)[..., None] - q[1][..., None]) / along[1]
        for _ in range(20):
            r = np.sqrt(square[..., None] + y * (2 * dot[..., None] + y))
            miss = q[1][..., None] + y * along[1] - beta * r
            step = miss / (along[1] - beta * (dot[..., None] + y) / r)
            y = y - step
            if np.max(np.abs(step)) <= _EXACT * self.grid.step[1] * np.max(r):
                break
        return np.asarray(y)

    def _ensure(self, alpha: slice, beta: slice, visible: Mask) -> None:
        """Bring the tiles of some places up to what is visible."""
        (wide, high), (across, down) = self.grid.tile, self.grid.count
        for i in range(alpha.start // wide, (alpha.stop - 1) // wide + 1):
            for j in range(beta.start // high, (beta.stop - 1) // high + 1):
                tile = self._tiles.get((i, j))
                if tile is None:
                    tile = self._tiles[i, j] = _Tile(
                        slice(i * wide, min((i + 1) * wide, across)),
                        slice(j * high, min((j + 1) * high, down)),
                    )
                self._update(tile, visible)

    def _update(self, tile: _Tile, visible: Mask) -> None:
        if tile.held is not None:
            change = np.flatnonzero(tile.held != visible)
            if 2 * len(change) <= np.count_nonzero(visible):
                if len(change):
                    self._add(tile, change, np.where(visible[change], 1.0, -1.0))
                    tile.held = visible.copy()
                return
        self._values[tile.beta, tile.alpha] = 0
        every = np.flatnonzero(visible)
        if not self._transform(tile, every):
            self._add(tile, every, np.ones(len(every)))
        self._taken += len(every)
        tile.held = visible.copy()

    def _transform(self, tile: _Tile, index: NDArray[np.intp]) -> bool:
        """Sum many points on an empty tile; False where that is not the way."""
        if len(index) < TRANSFORMED:
            return False
        points = self._points.select(index)
        alpha, beta, _, _ = self._middle(tile)
        aim = SHARE * self._tolerance
        summed = transformed_tile(points, (alpha, beta), self.grid.layers, self._wavelength, aim)
        if summed is None:
            return False
        for layer, values in enumerate(summed[0]):
            self._values[tile.beta, tile.alpha, layer] = values
        self.dropped = max(self.dropped, summed[1])
        return True

    def _add(self, tile: _Tile, index: NDArray[np.intp], sign: Floats) -> None:
        """Add the waves of some points to a tile."""
        if not len(index):
            return
        if not tile.rests:
            tile.rests = self._rests(tile)

        def some(part: slice) -> list[NDArray[np.complexfloating]]:
            return self._sum(tile, index[part], sign[part])

        for sums in in_parallel(some, chunks_of(len(index))):
            for layer, one in enumerate(sums):
                self._values[tile.beta, tile.alpha, layer] += one

    def _sum(
        self, tile: _Tile, index: NDArray[np.intp], sign: Floats
    ) -> list[NDArray[np.complexfloating]]:
        """Of each layer (n_β, n_α) waves of points on a tile."""
        local = self._points.positions[index]
        strength = sign * self._points.amplitude[index]
        across, down = self._tables(tile, local, self._points.phase[index] / (2 * pi))
        return [
            product_of(across, down, (series.at_points(local) * strength).astype(self._real), terms)
            for series, terms in tile.rests
        ]

    def _middle(self, tile: _Tile) -> tuple[Floats, Floats, Floats, Floats]:
        """α and β of a tile's places and of its middle."""
        grid = self.grid
        alpha = grid.first[0] + grid.step[0] * np.arange(tile.alpha.start, tile.alpha.stop)
        beta = grid.first[1] + grid.step[1] * np.arange(tile.beta.start, tile.beta.stop)
        return alpha, beta, np.asarray(alpha.mean()), np.asarray(beta.mean())

    def _rests(self, tile: _Tile) -> list[tuple[Series, NDArray[np.complexfloating]]]:
        """What the tables leave, layer by layer: its series, and the terms at the tile's places."""
        alpha, beta, at_a, at_b = self._middle(tile)
        r = middle_range(self.grid.layers)

        def rest(a: Floats, b: Floats, place: Place) -> Floats:
            crossed = path(a, at_b, place, r) + path(at_a, b, place, r)
            return path(a, b, place, r) + path(at_a, at_b, place, r) - crossed

        box = np.stack([-self._half, self._half], axis=1)
        ends = (float(alpha[0]), float(alpha[-1])), (float(beta[0]), float(beta[-1]))
        aim = SHARE * self._tolerance
        expanded = layer_series(ends, box, self.grid.layers, rest, self._wavelength, aim)
        if expanded is None:
            raise NotCovered
        self.dropped = max(self.dropped, expanded[1])
        out = []
        for series in expanded[0]:
            on_nodes = series.on_nodes(alpha, beta, self._real)
            terms = [on_nodes.of(term) for term in range(series.terms)]
            values = np.stack([real + 1j * imag for real, imag in terms]).astype(self._complex)
            out.append((series, values))
        return out

    def _tables(self, tile: _Tile, local: Floats, turns: Floats) -> Tables:
        alpha, beta, at_a, at_b = self._middle(tile)
        r = middle_range(self.grid.layers)
        x, y, z = (column[:, None] for column in local.T)
        corner = path(at_a, at_b, (x, y, z), r) / self._wavelength
        across = cycles_of(lambda a: path(a, at_b, (x, y, z), r), alpha, at_b, self._wavelength)
        down = cycles_of(lambda b: path(at_a, b, (x, y, z), r), beta, at_a, self._wavelength)
        down += turns[:, None] - corner
        return phase_table(across, self._real), phase_table(down, self._real)

    def expected_error(self, visible: Mask) -> float:
        """Relative rms error of a look-up, averaged over the power of the points seen."""
        total = float(self._power @ visible)
        mean = float(self._weighed_errors @ visible) / total if total > 0 else 0.0
        return sqrt(mean + self.dropped**2 + 2 * _ROUNDING**2)

    def _expected_errors(self) -> Floats:
        """(N,) mean square error of reading each point's wave off the grid."""
        grid = self.grid
        x, y, z = self._points.positions.T
        ends = [
            max(abs(first), abs(first + step * count))
            for first, step, count in zip(grid.first, grid.step, grid.count, strict=True)
        ]
        f_a = (np.abs(x) + np.abs(z) * ends[0]) / self._wavelength
        f_b = (np.abs(y) + np.abs(z) * ends[1]) / self._wavelength + grid.tilt * f_a
        error = grid.taps.rms_error(f_a, grid.bandwidth[0]) ** 2
        error += grid.taps.rms_error(f_b, grid.bandwidth[1]) ** 2
        half = (grid.span[1] - grid.span[0]) / 2
        count = len(grid.layers)
        swing = pi * (x * x + y * y) / self._wavelength * half
        return np.asarray(error + 2 * ((swing / 2) ** count / factorial(count)) ** 2)
