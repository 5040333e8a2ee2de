"""Bodies and panels on which the object surface once broke its promise, divided by zero or hung."""

import numpy as np
import pytest

from chrmc.bench.extremes import case_of, run


@pytest.mark.parametrize(
    "seed",
    [
        15,  # one pixel
        3010,  # one column, a long wavelength, near
        3025,  # one row
        1031,  # two points: their error stands in one corner
        6001,  # three points 17 m away: a strip of thousands of places
    ],
)
def test_the_promise_is_kept_or_refused(seed: int) -> None:
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        out = run(case_of(seed))
    assert not out.fault, out.fault
    assert out.seconds < 60
