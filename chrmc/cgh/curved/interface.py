"""What `curved` offers to a method that keeps basebands from frame to frame.

Nothing else of the package is promised. In the order of the computation, see docs/curved.md:

plan      `plane_of` and `lines_of` say what is planned for, `reference_at` takes the wave out,
          `cluster_axes` gives the nodes (`Axis`, in runs read by blocks), `part_of` some of them
sum       `sum_points` gives the baseband at nodes; `make_series`, `node_count`, `chebyshev`,
          `interpolation`, `phasor_table` and `weighted_products` are its parts, for a baseband
          at other places than a hologram's nodes
assemble  `Factor` is a baseband with its nodes; `field_of` and `signal_of` make pixels of some
predict   `budget_of` gives the `Budget` of a factor, powers of its error and its light;
          `promise_kept` whether that is good enough
at once   `low_rank` does all of this for one cloud; `run_all` and `alone` share the cores
"""

from chrmc.cgh.curved import (
    check_tolerance,
    field_of,
    lines_of,
    low_rank,
    plane_of,
    signal_of,
)
from chrmc.cgh.curved.assembly import Factor
from chrmc.cgh.curved.baseband import Axes, Summed, cluster_axes, series_for, sum_points
from chrmc.cgh.curved.chebyshev import chebyshev, interpolation, node_count
from chrmc.cgh.curved.clusters import Plane, bounding_box, reference_at
from chrmc.cgh.curved.nodes import Axis, Line, part_of
from chrmc.cgh.curved.parallel import alone, run_all
from chrmc.cgh.curved.predict import Budget, budget_of, promise_kept
from chrmc.cgh.curved.series import Remainder, Series, make_series
from chrmc.cgh.curved.tables import phasor_table, weighted_products
from chrmc.cgh.curved.wave import Kernel, Reference, Wave

__all__ = [
    "Axes",
    "Axis",
    "Budget",
    "Factor",
    "Kernel",
    "Line",
    "Plane",
    "Reference",
    "Remainder",
    "Series",
    "Summed",
    "Wave",
    "alone",
    "bounding_box",
    "budget_of",
    "chebyshev",
    "check_tolerance",
    "cluster_axes",
    "field_of",
    "interpolation",
    "lines_of",
    "low_rank",
    "make_series",
    "node_count",
    "part_of",
    "phasor_table",
    "plane_of",
    "promise_kept",
    "reference_at",
    "run_all",
    "series_for",
    "signal_of",
    "sum_points",
    "weighted_products",
]
