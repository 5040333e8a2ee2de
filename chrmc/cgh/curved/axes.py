"""The nodes of one cluster along x and y."""

from chrmc.cgh.curved import clusters
from chrmc.cgh.curved.bandwidth import Needs
from chrmc.cgh.curved.clusters import Plane
from chrmc.cgh.curved.nodes import Axis, axis_behind, make_axis
from chrmc.cgh.curved.wave import Reference
from chrmc.scene.points import PointCloud

BLOCK_X, BLOCK_Y = 20.0, 15.0
"""Spacings of nodes in a block: few make the second product small, many the baseband."""
_BEHIND = 60.0  # in blocks whose targets are nodes
NODE_SHARE = 0.45
"""Of the tolerance, for interpolation."""

Axes = tuple[Axis, Axis]


def _needs(
    cloud: PointCloud,
    reference: Reference,
    plane: Plane,
    tolerance: float,
    blocks: tuple[float, float],
) -> tuple[Needs, Needs]:
    box = clusters.bounding_box(cloud.positions)
    extents = clusters.extents(box, reference, plane)
    lit = clusters.lit(box, plane)
    first, second = (
        Needs(
            extents[axis],
            plane.wavelength,
            plane.reach[axis],
            tolerance,
            lit[axis],
            blocks[axis],
        )
        for axis in range(2)
    )
    return first, second


def cluster_axes(
    cloud: PointCloud,
    reference: Reference,
    plane: Plane,
    tolerance: float,
) -> Axes:
    """Nodes and blocks along x and y for one cluster's pixels."""
    x, y, z = cloud.positions.T
    along_x, along_y = _needs(cloud, reference, plane, tolerance * NODE_SHARE, (BLOCK_X, BLOCK_Y))
    return make_axis(plane.x, x, z, along_x), make_axis(plane.y, y, z, along_y)


def axes_behind(
    axes: Axes,
    cloud: PointCloud,
    reference: Reference,
    plane: Plane,
    tolerance: float,
) -> Axes:
    """Nodes from which the values at other nodes are read."""
    x, y, z = cloud.positions.T
    along_x, along_y = _needs(cloud, reference, plane, tolerance, (_BEHIND, _BEHIND))
    return axis_behind(axes[0], x, z, along_x), axis_behind(axes[1], y, z, along_y)
