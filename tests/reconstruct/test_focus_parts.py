"""The search for a focus on stacks whose answer is known."""

import numpy as np
import pytest
import scipy.ndimage

from chrmc.optics.propagation import Patch
from reconstruct.focus import (
    DARK,
    brightness_at,
    cells_of,
    centroid,
    find_focus,
    peak_middle,
    refine_peak,
    smoothed_curve,
    tiled_centroid,
    weighted_mean,
    weighted_quantiles,
)
from reconstruct.focus_metrics import METRICS, gradient
from reconstruct.stack import FocalStack

P, SIDE = 8e-6, 9
DEPTHS = np.linspace(0.050, 0.060, 41)
MIDDLE = 0.055


def spots(places, light=None, ground=0.0, depths=DEPTHS):
    """A stack of tiles, each with a spot whose width grows on either side of the tile's depth.

    places : (m, n) metres; light : (m, n) of each spot; ground : even light beside it
    """
    places = np.atleast_2d(places)
    light = np.ones(places.shape) if light is None else np.atleast_2d(light)
    at = np.arange(SIDE) - SIDE // 2
    planes = []
    for depth in depths:
        width = np.sqrt(0.5 + ((depth - places) / 4e-4) ** 2)[..., None, None]
        spot = np.exp(-(at**2 + at[:, None] ** 2) / (2 * width**2))
        spot *= light[..., None, None] / spot.sum(axis=(2, 3), keepdims=True)
        planes.append(np.block([[tile for tile in row] for row in spot]) + ground / SIDE**2)
    patch = Patch((1e-3, -5e-4), planes[0].shape, P)
    return FocalStack(depths, np.array(planes, dtype=np.float32), patch)


def test_the_depth_is_the_mean_of_the_tiles_weighted_by_their_light():
    places = MIDDLE + 1e-3 * np.array([[-1.0, 0.2, 0.5], [0.9, 0.0, -0.4]])
    light = np.array([[1.0, 2.0, 0.5], [3.0, 1.0, 1.5]])
    focus = find_focus(spots(places, light), SIDE)
    assert focus.focused and focus.method == "tiles"
    mean = np.average(places, weights=light)
    assert focus.depth == pytest.approx(mean, abs=2e-5)
    spread = np.sqrt(np.average((places - mean) ** 2, weights=light))
    assert focus.scatter == pytest.approx(spread, rel=0.05)
    np.testing.assert_allclose(focus.tile_depth, places, atol=3e-5)
    np.testing.assert_allclose(focus.tile_light, light, rtol=1e-3)
    assert focus.front < focus.depth < focus.rear
    # The centroid of the spots, each where it is sharp.
    y, x = np.indices(places.shape) * SIDE * P
    x, y = x - x.mean() - 5e-4, y - y.mean() + 1e-3
    assert focus.position[0] == pytest.approx(np.average(x, weights=light), abs=1e-7)
    assert focus.position[1] == pytest.approx(np.average(y, weights=light), abs=1e-7)


def test_a_tile_far_from_the_others_does_not_count():
    places = np.full((4, 4), MIDDLE)
    places[1, 2] = MIDDLE + 3.5e-3
    focus = find_focus(spots(places), SIDE)
    assert focus.depth == pytest.approx(MIDDLE, abs=1e-5)
    # Within two and a half times the scatter it does.
    places[1, 2], places[2, 1] = MIDDLE + 3.5e-3, MIDDLE + 3.5e-3
    focus = find_focus(spots(places), SIDE)
    assert focus.depth == pytest.approx(MIDDLE + 3.5e-3 / 8, abs=3e-5) or focus.scatter < 1.4e-3


@pytest.mark.parametrize(("share", "counts"), [(0.8 * DARK, False), (1.2 * DARK, True)])
def test_dark_tiles_do_not_count(share, counts):
    # 100 dim tiles in front together outweigh nothing, or pull the mean.
    places, light = np.full((6, 6), MIDDLE - 2e-3), np.full((6, 6), share)
    places[0, 0], light[0, 0] = MIDDLE, 1.0
    focus = find_focus(spots(places, light), SIDE)
    pulled = MIDDLE - 2e-3 * 35 * share / (1 + 35 * share)
    assert focus.depth == pytest.approx(pulled if counts else MIDDLE, abs=3e-5)


def test_tiles_at_all_depths_are_a_focus_only_where_they_are_sharp():
    places = np.linspace(DEPTHS[4], DEPTHS[-5], 30).reshape(5, 6)
    sharp = find_focus(spots(places), SIDE)
    assert sharp.focused and sharp.scatter > 0.7 * np.ptp(DEPTHS) / np.sqrt(12)
    blurred = spots(places, ground=8.0)
    assert not find_focus(blurred, SIDE).focused
    # Together they are one, however faint each is.
    together = find_focus(spots(np.full((5, 6), MIDDLE), ground=8.0), SIDE)
    assert together.focused and together.method == "tiles"


def test_brightness_is_taken_out_of_light_and_sharpness():
    stack = spots(MIDDLE + 1e-3 * np.array([[-0.5, 0.3], [0.6, 0.1]]))
    near, far = (
        np.kron(v, np.ones((SIDE, SIDE)))
        for v in (np.array([[1.0, 0.5], [0.8, 0.3]]), np.array([[0.4, 0.9], [0.2, 0.7]]))
    )
    both = np.stack([near, far])
    seen = stack.intensity * (near + np.linspace(0, 1, 41)[:, None, None] * (far - near))
    dimmed = FocalStack(DEPTHS, seen.astype(np.float32), stack.patch)
    want, got = cells_of(stack, SIDE), cells_of(dimmed, SIDE, both)
    np.testing.assert_allclose(got.light, want.light, rtol=1e-5)
    np.testing.assert_allclose(got.square, want.square, rtol=1e-5)
    even, found = find_focus(stack, SIDE), find_focus(dimmed, SIDE, both)
    assert found.depth == pytest.approx(even.depth, abs=1e-9)
    assert found.position == pytest.approx(even.position, abs=1e-9)
    assert brightness_at(dimmed, both, 10)[0, 0] == pytest.approx(1 - 0.25 * 0.6)
    assert brightness_at(dimmed, None, 10) == 1


def test_tiles_that_do_not_fit_are_dropped():
    stack = spots(np.full((3, 4), MIDDLE))
    assert cells_of(stack, 10).light.shape == (41, 2, 3)
    assert cells_of(stack, 100).light.shape == (41, 1, 1)
    assert cells_of(stack, 0).light.shape == (41, 27, 36)


def test_a_tile_that_is_sharpest_at_an_end_has_no_depth():
    focus = find_focus(spots([[DEPTHS[0], MIDDLE, DEPTHS[-1]]]), SIDE)
    assert np.isnan(focus.tile_depth).tolist() == [[True, False, True]]
    assert focus.depth == pytest.approx(MIDDLE, abs=1e-5)
    nothing = find_focus(spots([[DEPTHS[0], DEPTHS[-1]]]), SIDE)
    assert not nothing.focused and np.isnan(nothing.depth)


def test_a_flat_top_is_where_it_begins():
    assert refine_peak(np.arange(5.0), np.array([0.0, 2.0, 2.0, 2.0, 0.0])) == pytest.approx(1.5)
    assert refine_peak(np.arange(3.0), np.array([2.0, 2.0, 2.0])) != 1  # an end, not a peak
    assert refine_peak(np.arange(4.0), np.array([0.0, 1.0, 0.5, 0.0])) == pytest.approx(7 / 6)


def test_the_peaks_middle_weighs_what_is_above_half_its_height():
    z = np.arange(9.0)
    curve = np.array([0, 0, 0, 6.0, 10.0, 8.0, 0, 0, 9.0])
    curve[8] = 0
    # Median 0, half 5: heights 1, 5, 3 above it at 3, 4, 5.
    assert peak_middle(z, curve) == pytest.approx((3 * 1 + 4 * 5 + 5 * 3) / 9)
    curve[1] = 7  # another peak beyond the dip does not count
    assert peak_middle(z, curve) == pytest.approx((3 * 1 + 4 * 5 + 5 * 3) / 9)


def test_a_tile_shows_its_own_depth_and_none_of_its_neighbours():
    patch = Patch((0.0, 0.0), (4, 6), P)
    random = np.random.default_rng(5)
    stack = FocalStack(DEPTHS[:5], random.random((5, 4, 6)).astype(np.float32), patch)
    plane, best, seen = random.random((4, 6)), np.array([[3, 1, 4], [0, 2, 2]]), np.zeros((2, 3))
    seen[0, 0] = seen[1, 1] = 1
    picture = plane.copy()
    picture[:2, :2], picture[2:, 2:4] = stack.intensity[3, :2, :2], stack.intensity[2, 2:, 2:4]
    want = centroid(picture, patch)
    assert tiled_centroid(stack, plane, best, seen > 0, None) == pytest.approx(want, abs=1e-12)


@pytest.mark.parametrize("brightness", [1e-6, 1.0, 1e6])
def test_a_centroid_does_not_depend_on_how_bright_the_picture_is(brightness):
    image = np.zeros((5, 7))
    image[3, 1], image[3, 5] = 0.03 * brightness, 0.01 * brightness
    x, y = centroid(image, Patch((1e-3, -5e-4), (5, 7), P))
    assert (x, y) == pytest.approx((-5e-4 - P, 1e-3 + P))


def test_means_and_quantiles_of_weights():
    values, weights = np.array([3.0, 1.0, 2.0]), np.array([1.0, 2.0, 1.0])
    mean, deviation = weighted_mean(values, weights)
    assert mean == pytest.approx(1.75) and deviation == pytest.approx(np.sqrt(0.6875))
    # Each value stands at the middle of its weight: 1 at 0.25, 2 at 0.625, 3 at 0.875.
    low, high = weighted_quantiles(values, weights, (0.4375, 0.75))
    assert low == pytest.approx(1.5) and high == pytest.approx(2.5)


def test_the_gradient_is_sobels():
    image = np.random.default_rng(0).random((11, 14))
    across, down = (scipy.ndimage.sobel(image, axis)[1:-1, 1:-1] for axis in (1, 0))
    np.testing.assert_allclose(gradient(image), np.hypot(across, down))


def test_what_the_metrics_measure():
    one = np.zeros((6, 5))
    one[2, 2] = 4
    assert METRICS["variance"](one) == pytest.approx(29)  # (N − 1) for one pixel in N
    assert METRICS["peakedness"](one) == pytest.approx(30)
    ramp = np.tile(np.arange(9.0), (7, 1))  # mean 4, gradient 8 everywhere
    assert METRICS["tenengrad"](ramp) == pytest.approx(4)
    assert METRICS["tamura"](ramp) == 0
    corner = np.zeros((3, 4))
    corner[:, 3] = 1  # gradient 0 and 4
    assert METRICS["tamura"](corner) == pytest.approx(1)
    assert METRICS["tenengrad"](np.ones((2, 9))) == 0 == METRICS["tamura"](np.ones((9, 2)))


def test_the_smoothed_curve_does_not_see_grain():
    random = np.random.default_rng(1)
    plane = np.zeros((60, 60))
    plane[20:40, 20:40] = 1
    grains = random.exponential(size=(9, 60, 60))
    depths = np.linspace(0.05, 0.06, 9)
    sharp = np.stack([scipy.ndimage.gaussian_filter(plane, 1 + abs(i - 4)) for i in range(9)])
    stack = FocalStack(depths, (sharp * grains).astype(np.float32), Patch((0, 0), (60, 60), P))
    assert np.argmax(smoothed_curve(stack, 3.0)) == 4
    even = FocalStack(depths, np.ones((9, 60, 60), np.float32), stack.patch)
    np.testing.assert_allclose(smoothed_curve(even, 3.0), 0, atol=1e-12)


@pytest.mark.parametrize(("contrast", "found"), [(1.0, True), (0.02, False)])
def test_a_region_of_speckle_is_where_its_outline_is_sharp(contrast, found):
    """New speckle in every plane, so that tiles find nothing; the outline walks sideways."""
    random = np.random.default_rng(3)
    columns = np.arange(90.0)
    planes = []
    for number in range(41):
        along = np.zeros((81, 90))
        along[24:54] = 1
        middle = 40.0 + 0.8 * (number - 14)
        edge = 1 / (1 + np.exp((np.abs(columns - middle) - 15) * 2))
        soft = scipy.ndimage.gaussian_filter(along * edge, 1 + 0.7 * abs(number - 14))
        planes.append((contrast * soft + 1 - contrast) * random.exponential(size=soft.shape))
    patch = Patch((2e-4, 3e-4), (81, 90), P)
    focus = find_focus(FocalStack(DEPTHS, np.array(planes, np.float32), patch), SIDE)
    assert focus.focused == found
    if found:
        assert focus.method == "region" and np.isnan([focus.front, focus.scatter]).all()
        assert focus.depth == pytest.approx(DEPTHS[14], abs=2.5e-4)
        assert focus.position[0] == pytest.approx(3e-4 + (40.0 - 44.5) * P, abs=1.5 * P)
        assert focus.position[1] == pytest.approx(2e-4 + (38.5 - 40.0) * P, abs=1.5 * P)
        # Seen through a shade that falls off to one side, and is known, it stands where it did.
        shade = np.tile(np.linspace(1, 0.7, 90), (2, 81, 1))
        dim = FocalStack(DEPTHS, (np.array(planes) * shade[0]).astype(np.float32), patch)
        again = find_focus(dim, SIDE, shade)
        assert again.method == "region"
        assert again.position == pytest.approx(focus.position, abs=0.01 * P)
