"""Blue-noise points on a surface: random, of even density by area, none close to another."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from chrmc.scene.surface.surface import Surface

CANDIDATES = 4
"""Random places tried per point kept."""
DISTANCE = 0.68
"""Least distance of points in units of their spacing, √(area per point): with this one, as many
of the candidates are kept as are asked for."""
APART = 0.55
"""Of the least distance, added to it per unit between the normals of two places: opposite sides of
a thin sheet (2 units) do not keep each other's points away, neighbours on a curve do."""
MOST = 20_000_000
"""Points of one body beyond which a request is taken for a mistake."""


def sample(
    surface: Surface,
    spacing: float,
    seed: int,
    wanted: NDArray[np.bool_] | None = None,
) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Places on a surface, one per spacing² of its area.

    spacing : metres; seed : the same places for the same seed; wanted : (F,) faces to sample
    Returns (N,) faces and (N, 3) barycentric weights.

    Of random candidates one stays when none of a higher rank within the least distance does
    (dart throwing, all darts at once). Faces that look apart keep each other's points less
    away, so that both sides of a thin sheet are covered.
    """
    area = surface.areas if wanted is None else np.where(wanted, surface.areas, 0.0)
    total = float(area.sum())
    count = total / spacing**2
    if count > MOST:
        raise ValueError(
            f"{count:.3g} points of one body are more than {MOST:.0e}: choose fewer --points, or "
            "more --density cells per point"
        )
    if total == 0:
        return np.zeros(0, dtype=np.intp), np.zeros((0, 3))
    rng = np.random.default_rng(seed)
    tries = max(int(np.ceil(CANDIDATES * count)), CANDIDATES)
    # Stratified over the faces, then ranked at random.
    along = (np.arange(tries) + rng.uniform(size=tries)) / tries
    face = np.searchsorted(np.cumsum(area), along * total, side="right")
    face = np.minimum(face, np.flatnonzero(area)[-1])
    rng.shuffle(face)
    u, v = np.sqrt(rng.uniform(size=tries)), rng.uniform(size=tries)
    weights = np.stack([1 - u, u * (1 - v), u * v], axis=1)
    least = DISTANCE * spacing
    place = np.hstack([surface.at(face, weights), APART * least * surface.face_normals[face]])
    kept = np.flatnonzero(_apart(place, least))
    return face[kept], weights[kept]


def _apart(place: NDArray[np.float64], least: float) -> NDArray[np.bool_]:
    """(N,) which places stay: no two within `least`, the first of the list preferred."""
    tree = cKDTree(place, balanced_tree=False, compact_nodes=False)
    pairs = tree.query_pairs(least, output_type="ndarray")
    first, second = pairs.min(axis=1), pairs.max(axis=1)
    undecided = np.ones(len(place), dtype=bool)
    kept = np.zeros(len(place), dtype=bool)
    while len(first):
        best = undecided.copy()
        best[second] = False
        kept |= best
        undecided &= ~best
        undecided[second[best[first]]] = False
        both = undecided[first] & undecided[second]
        first, second = first[both], second[both]
    return kept | undecided
