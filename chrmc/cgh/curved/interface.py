"""What `curved` offers to a method that keeps basebands from frame to frame.

Nothing else of the package is promised. In the order of the computation, see docs/curved.md:

plan      `plane_of` says what is planned for, `reference_at` takes the wave out,
          `cluster_axes` gives the nodes (`Axis`, in runs read by blocks), `part_of` some of them
sum       `sum_points` gives the baseband at nodes, for `cost_of_sums`, or from `MANY_POINTS` on
          by transforms (`transformed`) where these take less; `make_series`, `chebyshev`
          and `interpolation` are its parts, for sums at other places than a hologram's nodes
edges     `readings_of` says how nodes are read off a baseband without footprints, by filters
taps      `taps_for`: reading waves of limited frequency off an even grid
assemble  `Factor` is a baseband with its nodes; `field_of` and `signal_of` make pixels of some
waves     `axis_cycles`, `reference_cycles`, `phasor`, `phasors`: phases without cancellation
predict   `sample_points` stand for all, `budget_of` gives the `Budget` of a factor, powers of its
          error and its light; `promise_kept` whether that is good enough;
          `measured_error` looks at some pixels, up to `SURE` of the tolerance they may miss;
          `light_kept` says whether factors cancel
cost      `split` gives the clusters, `cost_of` counts a hologram beforehand, `pixels_from` its way
          from nodes to pixels, `waves_looked_at` the look
few       `SMALL` points times pixels are summed one by one
at once   `low_rank` does all of this for one cloud, or raises `Refusal`; `in_parallel` and
          `alone` divide the cores up
"""

from chrmc.cgh.curved import (
    check_tolerance,
    field_of,
    low_rank,
    plane_of,
    signal_of,
)
from chrmc.cgh.curved.assembly import Factor, reference_cycles
from chrmc.cgh.curved.axes import Axes, cluster_axes
from chrmc.cgh.curved.baseband import Summed, series_for, sum_points
from chrmc.cgh.curved.chebyshev import chebyshev, interpolation
from chrmc.cgh.curved.clusters import Plane, bounding_box, cost_of_sums, reference_at, split
from chrmc.cgh.curved.cost import cost_of, pixels_from, some_of
from chrmc.cgh.curved.direct import SMALL
from chrmc.cgh.curved.edge import Reading, readings_of
from chrmc.cgh.curved.nodes import Axis, Line, part_of
from chrmc.cgh.curved.nonuniform import MANY_POINTS, transformed
from chrmc.cgh.curved.predict import Budget, budget_of, promise_kept, sample_points
from chrmc.cgh.curved.refusal import Refusal
from chrmc.cgh.curved.series import Remainder, Series, make_series
from chrmc.cgh.curved.taps import Taps, taps_for
from chrmc.cgh.curved.verify import SURE, light_kept, measured_error, waves_looked_at
from chrmc.cgh.curved.wave import Kernel, Reference, Wave, axis_cycles, phasor, phasors
from chrmc.parallel import alone, in_parallel

__all__ = [
    "MANY_POINTS",
    "SMALL",
    "SURE",
    "Axes",
    "Axis",
    "Budget",
    "Factor",
    "Kernel",
    "Line",
    "Plane",
    "Reading",
    "Reference",
    "Refusal",
    "Remainder",
    "Series",
    "Summed",
    "Taps",
    "Wave",
    "alone",
    "axis_cycles",
    "bounding_box",
    "budget_of",
    "chebyshev",
    "check_tolerance",
    "cluster_axes",
    "cost_of",
    "cost_of_sums",
    "field_of",
    "in_parallel",
    "interpolation",
    "light_kept",
    "low_rank",
    "make_series",
    "measured_error",
    "part_of",
    "phasor",
    "phasors",
    "pixels_from",
    "plane_of",
    "promise_kept",
    "readings_of",
    "reference_at",
    "reference_cycles",
    "sample_points",
    "series_for",
    "signal_of",
    "some_of",
    "split",
    "sum_points",
    "taps_for",
    "transformed",
    "waves_looked_at",
]
