"""Points on a surface: as many as asked, even by area, and apart."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from chrmc.scene.models import house
from chrmc.scene.shapes import Part, Solid, box, plain
from chrmc.scene.surface.sampling import DISTANCE, sample
from chrmc.scene.surface.surface import from_solid

SPACING = 20e-6


def solid_box():
    return from_solid(Solid((Part(box((-4e-4, -2e-4, -1e-4), (4e-4, 2e-4, 1e-4)), plain(0.5)),)))


@pytest.mark.parametrize("surface", [solid_box(), from_solid(house())], ids=["box", "house"])
def test_one_point_per_spacing_squared(surface) -> None:
    face, _ = sample(surface, SPACING, 1)
    assert len(face) == pytest.approx(surface.areas.sum() / SPACING**2, rel=0.04)


def test_even_by_area_on_every_side() -> None:
    surface = solid_box()
    face, weights = sample(surface, SPACING, 1)
    normal = np.rint(surface.face_normals[face])
    place = surface.at(face, weights)
    for axis, area in ((0, 4e-4 * 2e-4), (1, 8e-4 * 2e-4), (2, 8e-4 * 4e-4)):
        for side in (-1, 1):
            mine = normal[:, axis] == side
            assert mine.sum() == pytest.approx(area / SPACING**2, rel=0.1)
            # The mean of even points is the middle of the side.
            assert place[mine].mean(axis=0) == pytest.approx(
                side * np.eye(3)[axis] * [4e-4, 2e-4, 1e-4][axis], abs=SPACING / 2
            )


def test_blue_noise_none_close_to_another_and_no_holes() -> None:
    surface = solid_box()
    face, weights = sample(surface, SPACING, 1)
    front = surface.face_normals[face][:, 2] < -0.5
    place = surface.at(face, weights)[front, :2]
    near, _ = cKDTree(place).query(place, k=2)
    assert near[:, 1].min() >= DISTANCE * SPACING
    middle = np.random.default_rng(0).uniform([-3.8e-4, -1.8e-4], [3.8e-4, 1.8e-4], (4000, 2))
    hole, _ = cKDTree(place).query(middle)
    assert hole.max() < 1.3 * SPACING


def test_both_sides_of_a_thin_sheet_are_covered() -> None:
    thin = from_solid(Solid((Part(box((-4e-4, -4e-4, 0), (4e-4, 4e-4, 1e-6)), plain(0.5)),)))
    face, _ = sample(thin, SPACING, 1)
    for side in (-1, 1):
        mine = np.rint(thin.face_normals[face][:, 2]) == side
        assert mine.sum() == pytest.approx((8e-4 / SPACING) ** 2, rel=0.08)


def test_the_same_for_the_same_seed_and_refused_beyond_reason() -> None:
    surface = solid_box()
    first, again, other = (sample(surface, SPACING, seed) for seed in (1, 1, 2))
    assert np.array_equal(first[1], again[1])
    assert not np.array_equal(first[1][:10], other[1][:10])
    with pytest.raises(ValueError, match="choose fewer --points"):
        sample(surface, 1e-8, 1)
