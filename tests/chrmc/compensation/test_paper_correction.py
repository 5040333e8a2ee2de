"""Eq. 14 and the matching rules, against images put together by hand."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import chrmc
from chrmc.compensation.ch_rmc_paper.error_correction import RULES, match, rule_named, snr

PITCH, PLANE = 40e-6, 1e-4


def image_cloud(pixels: dict[tuple[int, int], tuple[int, float]]) -> chrmc.PointCloud:
    """Points of an image: (column, row) to (plane, intensity)."""
    positions = [
        ((c + 0.5) * PITCH, (r + 0.5) * PITCH, 0.244 + k * PLANE)
        for (c, r), (k, _) in pixels.items()
    ]
    intensity = np.array([v for _, v in pixels.values()])
    return chrmc.PointCloud(np.array(positions), np.sqrt(intensity), np.zeros(len(pixels)))


def by_hand(
    compensated: dict[tuple[int, int], tuple[int, float]],
    actual: dict[tuple[int, int], tuple[int, float]],
    rule: str,
) -> tuple[set[tuple[int, int]], set[tuple[int, int]], float]:
    """Wrong pixels, missing pixels, and Eq. 14 summed pixel by pixel."""
    planes, share = {"strict": (0, 2 / 255), "tolerant": (1, 0.05)}[rule]
    full = max(v for image in (compensated, actual) for _, v in image.values())
    wrong, missing, signal, noise = set(), set(), 0.0, 0.0
    for at in set(compensated) | set(actual):
        n, m = compensated.get(at), actual.get(at)
        together = n is not None and m is not None and abs(n[0] - m[0]) <= planes
        signal += n[1] ** 2 if n else 0
        if together:
            noise += (n[1] - m[1]) ** 2
        else:
            noise += (n[1] ** 2 if n else 0) + (m[1] ** 2 if m else 0)
        if not (together and abs(n[1] - m[1]) <= share * full + 1e-12):
            wrong |= {at} if n else set()
            missing |= {at} if m else set()
    return wrong, missing, 10 * np.log10(signal / noise) if noise else np.inf


images = st.dictionaries(
    st.tuples(st.integers(0, 5), st.integers(0, 5)),
    st.tuples(st.integers(0, 3), st.integers(1, 255).map(lambda v: v / 255)),
    min_size=1,
)


@given(images, images, st.sampled_from(sorted(RULES)))
@settings(max_examples=150, deadline=None)
def test_images_against_a_sum_over_pixels(compensated: dict, actual: dict, rule: str) -> None:
    n, m = image_cloud(compensated), image_cloud(actual)
    found = match(n, m, rule_named(rule), PITCH, PLANE)
    wrong, missing, ratio = by_hand(compensated, actual, rule)
    assert {at for at, bad in zip(compensated, found.wrong, strict=True) if bad} == wrong
    assert {at for at, bad in zip(actual, found.missing, strict=True) if bad} == missing
    assert snr(n, m, found) == pytest.approx(ratio, rel=1e-6, abs=1e-6)


@given(st.floats(-0.49, 0.49), st.floats(-0.49, 0.49), st.integers(0, 1000))
def test_rotated_points_fall_into_the_pixel_they_are_in(x: float, z: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    spots = {(int(c), int(r)): (3, 0.5) for c, r in rng.integers(0, 9, (10, 2))}
    actual = image_cloud(spots)
    shifted = chrmc.PointCloud(
        actual.positions + np.array([x * PITCH, 0, z * PLANE]), actual.amplitude, actual.phase
    )
    found = match(shifted, actual, rule_named("strict"), PITCH, PLANE)
    assert not found.wrong.any() and not found.missing.any()
    far = chrmc.PointCloud(
        actual.positions + np.array([0, 0, (z + np.copysign(1.0, z)) * PLANE]),
        actual.amplitude,
        actual.phase,
    )
    assert match(far, actual, rule_named("strict"), PITCH, PLANE).wrong.all()
    assert not match(far, actual, rule_named("tolerant"), PITCH, PLANE).wrong.any()


def test_two_points_in_one_pixel_find_one_partner() -> None:
    actual = image_cloud({(0, 0): (0, 0.5)})
    both = chrmc.PointCloud(
        np.repeat(actual.positions, 2, axis=0), np.sqrt([0.4, 0.5]), np.zeros(2)
    )
    found = match(both, actual, rule_named("strict"), PITCH, PLANE)
    assert found.wrong.tolist() == [True, False]
    assert found.missing.tolist() == [False]


def test_known_identities_are_compared_with_themselves() -> None:
    rng = np.random.default_rng(1)
    cloud = chrmc.PointCloud(
        rng.uniform(0, 1e-3, (6, 3)) + np.array([0, 0, 0.25]), np.ones(6), np.zeros(6)
    )
    before, after = np.array([0, 1, 2, 3, 4]), np.array([1, 2, 3, 4, 5])
    n, m = cloud.select(before), cloud.select(after)
    found = match(n, m, rule_named("strict"), PITCH, PLANE, (before, after))
    assert found.wrong.tolist() == [True, False, False, False, False]
    assert found.missing.tolist() == [False, False, False, False, True]
    assert snr(n, m, found) == pytest.approx(10 * np.log10(5 / 2))
    away = chrmc.PointCloud(m.positions + np.array([0.6 * PITCH, 0, 0]), m.amplitude, m.phase)
    assert match(n, away, rule_named("tolerant"), PITCH, PLANE, (before, after)).wrong.all()


def test_nothing_to_compare() -> None:
    none, one = chrmc.PointCloud.empty(), image_cloud({(1, 1): (0, 1.0)})
    rule = rule_named("strict")
    found = match(none, one, rule, PITCH, PLANE)
    assert found.missing.all() and snr(none, one, found) == -np.inf
    found = match(one, none, rule, PITCH, PLANE)
    assert found.wrong.all() and snr(one, none, found) == pytest.approx(0)
    assert snr(none, none, match(none, none, rule, PITCH, PLANE)) == np.inf
    with pytest.raises(ValueError, match="unknown matching rule 'loose'"):
        rule_named("loose")


@pytest.mark.parametrize(("grey", "same"), [(1, True), (2, True), (3, False)])
def test_the_strict_rule_ends_at_two_grey_levels(grey: int, same: bool) -> None:
    before = image_cloud({(0, 0): (1, 1.0), (3, 2): (1, 100 / 255)})
    after = image_cloud({(0, 0): (1, 1.0), (3, 2): (1, (100 + grey) / 255)})
    found = match(before, after, rule_named("strict"), PITCH, PLANE)
    assert found.wrong.tolist() == found.missing.tolist() == [False, not same]


@pytest.mark.parametrize(("share", "same"), [(0.048, True), (0.052, False)])
def test_the_tolerant_rule_ends_at_a_twentieth(share: float, same: bool) -> None:
    before = image_cloud({(0, 0): (1, 1.0), (3, 2): (1, 0.5)})
    after = image_cloud({(0, 0): (1, 1.0), (3, 2): (1, 0.5 + share)})
    found = match(before, after, rule_named("tolerant"), PITCH, PLANE)
    assert found.wrong.tolist() == found.missing.tolist() == [False, not same]


@pytest.mark.parametrize(("rule", "planes"), [("strict", 0.5), ("tolerant", 1.5)])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_known_point_may_be_half_a_pixel_and_a_plane_away(
    rule: str, planes: float, axis: int
) -> None:
    ids = np.arange(1), np.arange(1)
    here = image_cloud({(1, 2): (3, 0.5)})
    limit = planes * PLANE if axis == 2 else PITCH / 2
    for share, same in ((0.98, True), (1.02, False), (-0.98, True), (-1.02, False)):
        by = np.zeros(3)
        by[axis] = share * limit
        there = chrmc.PointCloud(here.positions + by, here.amplitude, here.phase)
        assert match(here, there, rule_named(rule), PITCH, PLANE, ids).wrong[0] == (not same)
