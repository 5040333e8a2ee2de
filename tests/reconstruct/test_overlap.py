"""Objects that overlap in depth, and lines whose points interfere, are judged by their picture."""

import json

import numpy as np
import pytest

from chrmc import SLM, PointCloud, compute_field
from chrmc.encoding import coding_for
from chrmc.interference import alike
from chrmc.light_map import MOST_LAYERS, LightMap
from chrmc.optics.resolution import resolution
from display import encode
from reconstruct import FourF
from reconstruct.focus import cells_of
from reconstruct.likeness import Likeness, at_depths, correlation
from reconstruct.region import target_stack
from reconstruct.verdict import Target, judge_frame

LAMBDA = 532e-9
PANEL = SLM("small", 480, 400, 8.1e-6)
BAND = coding_for("ssb", PANEL).passband
SYSTEM = FourF(PANEL, LAMBDA)


def helix(turns, count, z=0.07, depth=1.1e-3, phase=None):
    t = np.linspace(0, 2 * np.pi * turns, count)
    places = np.column_stack(
        [0.6e-3 * np.cos(t), 0.45e-3 * np.sin(t), z + np.linspace(-depth, depth, count)]
    )
    return PointCloud(places, np.ones(count), np.zeros(count) if phase is None else phase)


def shown(cloud):
    return encode(compute_field(cloud, PANEL, LAMBDA, "curved", passband=BAND), PANEL)


TWO_TURNS = helix(2, 150)
TARGET = Target.of_cloud("helix", TWO_TURNS, SYSTEM)


@pytest.mark.parametrize(
    ("stretch", "says"), [(1, ""), (0, "relief is flat"), (-1, "relief is inverted")]
)
@pytest.mark.parametrize("random", [False, True])
def test_turns_that_overlap_tell_their_depths(stretch, says, random):
    middle = np.array([0, 0, 0.07])
    phase = np.random.default_rng(2).uniform(0, 6.28, 150) if random else np.zeros(150)
    made = PointCloud(
        middle + (TWO_TURNS.positions - middle) * (1, 1, stretch), np.ones(150), phase
    )
    found = judge_frame(shown(made), SYSTEM, [TARGET], 40e-6).objects[0]
    assert TARGET.light.layers is not None
    assert found.passed == (not says) and says in "; ".join(found.faults)
    # Other phases interfere otherwise than the scene's.
    assert found.shape.relief == pytest.approx(stretch, abs=0.3 if random else 0.2)
    assert abs(found.depth_error) < 0.1e-3


@pytest.mark.parametrize("way", [0.0, 0.5, 0.75])
def test_turns_that_stand_one_behind_the_other_interfere_between_their_depths(way):
    """Points of both turns lie on one line of sight: the picture is bright or dark between them."""
    both = helix(2, 101, depth=1.1e-3 + way * LAMBDA)
    target = Target.of_cloud("helix", both, SYSTEM)
    for stretch, says in ((1, ""), (0, "relief is flat")):
        middle = np.array([0, 0, 0.07])
        made = PointCloud(
            middle + (both.positions - middle) * (1, 1, stretch), both.amplitude, both.phase
        )
        found = judge_frame(shown(made), SYSTEM, [target], 40e-6).objects[0]
        assert says in "; ".join(found.faults) and found.passed == (not says)
        assert found.shape.relief == pytest.approx(stretch, abs=0.15)
        assert abs(found.depth_error) < 0.05e-3


@pytest.mark.parametrize(
    ("relief", "gain", "fails", "doubted"),
    [(0.0, 4.0, True, False), (0.0, 1.0, False, True), (1.2, 0.0, False, False)],
)
def test_a_relief_that_looks_wrong_by_chance_is_doubted(relief, gain, fails, doubted):
    found = Likeness(True, 0.95, (0.0, 0.0), (), 0.0, 1e-5, 30.0, relief, 0.05, gain)
    assert bool(found.faults) == fails and bool(found.doubt) == doubted
    assert found.relief_known == (not doubted)


def test_layers_survive_the_record():
    light = TARGET.light
    record = json.loads(json.dumps(light.as_record()))
    again = LightMap.from_record(record)
    assert len(json.dumps(record)) < 6000
    assert np.abs(again.layers - light.layers).max() < 0.01
    assert again.layer_depths == pytest.approx(light.layer_depths)
    random = helix(2, 150, phase=np.random.default_rng(1).uniform(0, 6.28, 150))
    light = LightMap.of_cloud(random, PANEL, LAMBDA, BAND)
    shares = (light.layers * light.light).sum(axis=(1, 2))
    assert shares @ light.layer_depths == pytest.approx(0.07, abs=2e-5)
    for layers in ({"ends": [1, 0]}, {"data": "AAAA"}, {"ends": [0.1, 1e300]}, {"ends": [1]}):
        with pytest.raises(ValueError, match="map of light"):
            LightMap.from_record(record | {"layers": record["layers"] | layers})
    assert len(LightMap.of_cloud(helix(3, 90, 0.2, 0.1), PANEL, LAMBDA, BAND).layers) == MOST_LAYERS
    assert LightMap.of_cloud(helix(1, 90, depth=1e-6), PANEL, LAMBDA, BAND).layers is None


def test_neighbours_of_one_phase_leave_the_light_that_the_picture_shows():
    """A ring of points 0.6 resolutions apart: random phases would show all of it alike."""
    fine = np.mean(resolution(PANEL, LAMBDA, 0.07, BAND))
    ring = helix(1, round(1.7 * 2 * np.pi * 0.53e-3 / fine), depth=0.2e-3)
    light = LightMap.of_cloud(ring, PANEL, LAMBDA, BAND)
    field = compute_field(ring, PANEL, LAMBDA, "curved", passband=BAND)
    target = Target.of_cloud("ring", ring, SYSTEM)
    stack, _, parts = target_stack(field, SYSTEM, target, 40e-6)
    cells = cells_of(stack, parts)
    seen = at_depths(cells.light, cells.depths, light.depth)
    phase = np.random.default_rng(1).uniform(0, 6.28, len(ring))
    plain = PointCloud(ring.positions, ring.amplitude, phase)
    assert alike(ring) and not alike(plain)
    alone = LightMap.of_cloud(plain, PANEL, LAMBDA, BAND).light
    assert correlation(seen, light.light) > 0.95
    assert correlation(seen, alone) < 0.85
