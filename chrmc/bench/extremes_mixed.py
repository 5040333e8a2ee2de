"""Points whose places, amplitudes and phases are patterns drawn apart from each other: what no list
of adversaries foresaw."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Numbers = NDArray[np.floating]
Random = np.random.Generator


def _grid(axes: int) -> Callable[[Random, int], Floats]:
    def places(random: Random, n: int) -> Floats:
        side = max(1, round(n ** (1 / axes)))
        steps = [np.arange(n) // side**k % side for k in range(axes)]
        return np.stack([*(s / side - 0.5 for s in steps), *[np.zeros(n)] * (3 - axes)], axis=1)

    return places


def _line(random: Random, n: int) -> Floats:
    out = np.zeros((n, 3))
    out[:, random.integers(3)] = np.linspace(-0.5, 0.5, n) if random.random() < 0.5 else (
        random.random(n) - 0.5
    )  # fmt: skip
    return out


def _circle(turns: float, rise: float) -> Callable[[Random, int], Floats]:
    def places(random: Random, n: int) -> Floats:
        t = np.arange(n) / n
        angle = 2 * np.pi * turns * t
        return np.stack([np.cos(angle), np.sin(angle), rise * (2 * t - 1)], axis=1) / 2

    return places


def _shell(random: Random, n: int) -> Floats:
    out = random.normal(size=(n, 3))
    return out / (2 * np.linalg.norm(out, axis=1)[:, None])


def _clusters(random: Random, n: int) -> Floats:
    middles = random.random((random.integers(2, 12), 3)) - 0.5
    own = (random.random((n, 3)) - 0.5) * 10 ** random.uniform(-3, -1)
    return middles[random.integers(len(middles), size=n)] + own


def _fractal(random: Random, n: int) -> Floats:
    return (random.random((n, 3)) - 0.5) * 10 ** (-4 * random.random((n, 1)))


def _outlier(random: Random, n: int) -> Floats:
    out = 1e-3 * (random.random((n, 3)) - 0.5)
    out[0] = 0.5
    return out


def _tilted(random: Random, n: int) -> Floats:
    out = random.random((n, 3)) - 0.5
    out[:, 2] = out[:, 0] + 0.5 * out[:, 1]
    return out


def _cross(random: Random, n: int) -> Floats:
    out = random.random((n, 3)) - 0.5
    out[::2, 0] = 0
    out[1::2, 1] = 0
    return out


def _pairs(random: Random, n: int) -> Floats:
    out = random.random((n, 3)) - 0.5
    out[1::2] = out[: n // 2 * 2 : 2] * (1 + 1e-6)
    return out


PLACES: tuple[Callable[[Random, int], Floats], ...] = (
    lambda random, n: random.random((n, 3)) - 0.5,
    lambda random, n: 0.2 * random.normal(size=(n, 3)),
    lambda random, n: (random.random((n, 3)) - 0.5) * (1, 1e-3, 1),
    lambda random, n: np.zeros((n, 3)),
    _line, _grid(1), _grid(2), _grid(3), _circle(1, 0), _circle(6, 1), _shell, _clusters, _fractal,
    _outlier, _tilted, _cross, _pairs,
)  # fmt: skip
"""Places in a box of side 1 about the origin, (N, 3)."""


def _ratio(random: Random, distance: Floats) -> Floats:
    return 10 ** random.uniform(-12, 12, len(distance))


def _one_bright(random: Random, distance: Floats) -> Floats:
    out = random.uniform(0.2, 1, len(distance))
    out[random.integers(len(out))] *= 10 ** random.uniform(1, 4)
    return out


AMPLITUDES: tuple[Callable[[Random, Floats], Floats], ...] = (
    lambda random, distance: np.ones(len(distance)),
    lambda random, distance: random.uniform(0.2, 1, len(distance)),
    lambda random, distance: np.exp(2 * random.normal(size=len(distance))),
    lambda random, distance: distance / distance.mean(),
    lambda random, distance: random.uniform(0.2, 1, len(distance))
    * (random.random(len(distance)) < 0.5),
    _ratio, _one_bright,
)  # fmt: skip
"""Of points at distances (N,) along the axis."""


def _gradient(random: Random, places: Floats, k: float, sine: Floats) -> Numbers:
    return k * (places[:, :2] @ (random.uniform(-1, 1, 2) * sine))


def _focus(random: Random, places: Floats, k: float, sine: Floats) -> Numbers:
    """All waves in step at one place in the hologram plane."""
    spot = np.append(places[:, :2].mean(axis=0) + random.uniform(-1, 1, 2) * 1e-2 * sine, 0.0)
    distance: Floats = np.linalg.norm(places - spot, axis=1)
    return -k * distance


def _lens(random: Random, places: Floats, k: float, sine: Floats) -> Numbers:
    return random.uniform(-1, 1) * k * np.sum(places[:, :2] ** 2, axis=1) / places[:, 2].mean()


def _vortex(random: Random, places: Floats, k: float, sine: Floats) -> Numbers:
    about = places[:, :2] - places[:, :2].mean(axis=0)
    return np.arctan2(about[:, 1], about[:, 0]) * random.integers(1, 50)


PHASES: tuple[Callable[[Random, Floats, float, Floats], Numbers], ...] = (
    lambda random, places, k, sine: random.uniform(0, 2 * np.pi, len(places)),
    lambda random, places, k, sine: np.zeros(len(places)),
    lambda random, places, k, sine: np.pi * (np.arange(len(places)) % 2),
    lambda random, places, k, sine: np.pi * random.integers(0, 2, len(places)),
    _gradient, _focus, _lens, _vortex,
)  # fmt: skip
"""Of points at places (N, 3), with light of wave number k, that leaves the panel's middle at sines
of up to (2,) along x and y."""


def mixed(
    random: Random,
    count: int,
    size: Floats,
    middle: Floats,
    pitch: float,
    wavelength: float,
    sine: Floats,
) -> tuple[Floats, Floats, Floats]:
    """Positions (N, 3), amplitudes and phases (N,) of points about a middle (3,).

    size : (3,) of the box about it, metres; pitch : of the panel, whose pixels some lie on
    sine : (2,) of the steepest light
    """
    places = PLACES[random.integers(len(PLACES))](random, count) * size + middle
    if random.random() < 0.1:
        places[:, :2] = np.rint(places[:, :2] / pitch) * pitch
    places[:, 2] = np.maximum(places[:, 2], 0.05 * middle[2])
    amplitude = AMPLITUDES[random.integers(len(AMPLITUDES))](random, places[:, 2])
    k = 2 * np.pi / wavelength
    phase = PHASES[random.integers(len(PHASES))](random, places, k, sine)
    return places, amplitude, np.mod(phase, 2 * np.pi)
