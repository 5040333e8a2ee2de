"""Standard errors of depths, and which depth counts by them."""

import runpy
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from reconstruct.focus import refine_peak
from reconstruct.jackknife import standard_error
from reconstruct.verdict import Target, judge_frame

TRIAL = Path(__file__).with_name("confusion.py")
confusion = SimpleNamespace(**runpy.run_path(str(TRIAL)))
PLACES = np.linspace(-1, 1, 81)


def peak(curve):
    return refine_peak(PLACES, curve)


def bells(centres):
    """(D, m, n) a bell per cell about each centre."""
    return np.exp(-((PLACES[:, None, None] - centres) ** 2) / 0.08)


def test_the_error_is_that_of_the_mean_of_blocks_that_differ():
    random, lit = np.random.default_rng(4), np.ones((16, 16), dtype=bool)
    of_blocks = random.normal(0, 0.05, (200, 4, 4))
    found = [bells(np.kron(c, np.ones((4, 4)))) for c in of_blocks]
    errors = [standard_error(f, lit, peak) for f in found]
    assert np.median(errors) == pytest.approx(0.05 / 4, rel=0.15)
    spread = np.std([peak(f.sum(axis=(1, 2))) for f in found])
    assert np.median(errors) == pytest.approx(spread, rel=0.2)


def test_two_peaks_of_one_height_are_unsure():
    halves = np.where(np.arange(16) < 8, -0.6, 0.6) * np.ones((16, 1))
    lit = np.ones((16, 16), dtype=bool)
    assert standard_error(bells(halves), lit, peak) > 1
    halves[:, 7:] = -0.6  # the same, of one
    assert standard_error(bells(halves), lit, peak) < 1e-9


def test_one_block_tells_no_error():
    lit = np.zeros((16, 16), dtype=bool)
    lit[:3, :3] = True
    assert standard_error(bells(np.zeros((16, 16))) * lit, lit, peak) == np.inf


def scene(seed, number, wanted):
    """A scene of the trial of random pictures."""
    random = np.random.default_rng([seed, number])
    for kind in confusion.GOOD:
        found = [confusion.cloud_of(p, same, random) for p, same in confusion.bodies(kind, random)]
        if kind == wanted:
            return found[0]
    raise AssertionError(wanted)


@pytest.mark.parametrize(
    ("seed", "number", "kind"),
    [
        (32, 1, "surface"),  # whose rim has five times the standard error
        (52, 3, "helix"),  # whose cells hold two turns, and have two peaks
    ],
)
def test_cells_that_are_surer_than_the_rim_count(seed, number, kind):
    cloud = scene(seed, number, kind)
    frame = confusion.frame_of([cloud])
    target = Target.of_cloud("body", cloud, confusion.SYSTEM)
    (found,) = judge_frame(frame, confusion.SYSTEM, [target], confusion.PITCH).objects
    assert not found.faults and found.focus.method == "cells"
    assert abs(found.depth_error) < found.depth_tolerance / 5
    up = np.array([0, 0, 2.5e-3])
    map_ = target.light
    near, far = map_.ends
    light = replace(map_, depth=map_.depth + up[2], ends=(near + up[2], far + up[2]))
    elsewhere = replace(
        target, position=target.position + up, low=target.low + up, high=target.high + up,
        light=light,
    )  # fmt: skip
    (found,) = judge_frame(frame, confusion.SYSTEM, [elsewhere], confusion.PITCH).objects
    assert found.depth_error == pytest.approx(-up[2], abs=found.depth_tolerance / 3)
    assert any("depth" in fault for fault in found.faults)
