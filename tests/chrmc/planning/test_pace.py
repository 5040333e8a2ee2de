"""A rate is kept within bounds, and the tolerance comes back when there is time."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import chrmc
import chrmc.cgh
from chrmc.generation.paced import pace_for, paced
from chrmc.generation.recipe import recipe_for
from chrmc.planning.pace import Pace, first_tolerance

EXACT = chrmc.cgh.DEFAULT_METHOD
PANEL = chrmc.SLM("small", 240, 160, 32e-6)


def test_slow_frames_loosen_and_quick_ones_tighten_again() -> None:
    pace = Pace(0.1, 1e-4, 1e-2, 1e-3)
    assert pace.took(1, 0.15) and pace.tolerance == 2e-3
    assert pace.took(2, 0.5) and pace.tolerance == 8e-3
    assert pace.took(3, 0.5) and pace.tolerance == 1e-2  # its bound
    assert not pace.took(4, 0.5)
    for number in range(5, 200):
        pace.took(number, 0.01)
    assert pace.tolerance == 1e-4
    assert "over it" in pace.summary()


@given(st.lists(st.floats(1e-4, 1), max_size=60), st.floats(1e-4, 1e-2))
def test_it_stays_within_its_bounds(seconds: list[float], start: float) -> None:
    pace = Pace(0.03, 1e-4, 1e-2, start)
    for number, spent in enumerate(seconds):
        pace.took(number, spent)
        assert 1e-4 <= pace.tolerance <= 1e-2


def test_the_first_is_the_tightest_that_is_expected_to_do() -> None:
    seconds = {1e-4: 0.3, 1e-3: 0.1, 1e-2: 0.05}
    assert first_tolerance(seconds, 0.1, 1e-4, 1e-1) == 1e-3
    assert first_tolerance(seconds, 0.01, 1e-4, 2e-2) == 2e-2


def test_a_video_goes_on_through_changes_of_tolerance() -> None:
    random = np.random.default_rng(1)
    body = chrmc.PointCloud(random.normal(0, 2e-4, (40, 3)), np.ones(40), random.uniform(0, 6, 40))
    poses = [chrmc.Pose.from_rotvec([0, 0.01 * n, 0], [0, 0, 0.25]) for n in range(4)]
    scene = chrmc.PointScene("turning", {"body": body}, {"body": poses})
    recipe = recipe_for(scene, PANEL, cgh=EXACT, tolerance=1e-4, check_pixels=0)
    pace = pace_for(recipe, 1e-5, 1e-2)
    pace.tolerance = 1e-4  # so that it has to change
    made = [frame for frame in paced(recipe, range(1, 5), pace) if frame.field is not None]
    assert [frame.number for frame in made] == [1, 2, 3, 4]
    had = [tolerance for _, tolerance, _ in pace.frames]
    assert had[0] == 1e-4 and had[-1] > 3e-4
    for frame, tolerance in zip(made, had, strict=True):
        truth = chrmc.reference_field(frame.cloud, PANEL, 532e-9, passband=recipe.coding.passband)
        assert chrmc.relative_error(frame.field, truth) < tolerance
    with pytest.raises(ValueError, match="loosest"):
        pace_for(recipe, 0.01, 1e-5)
