"""Tracked poses from a CSV: what a motion-capture system or a SLAM program writes."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from chrmc.scene.scene import Pose
from chrmc.scene.sources.cloud import find_column, read_table
from chrmc.scene.sources.model import MOST_FRAMES
from chrmc.scene.sources.world import LARGEST

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

TIME_NAMES = ("time", "t", "timestamp", "seconds")
PLACES = (("x", "tx", "px"), ("y", "ty", "py"), ("z", "tz", "pz"))
QUATERNION = ("qx", "qy", "qz", "qw")
VECTOR = ("rx", "ry", "rz")
LONGEST_GAP = 1.0
"""Seconds without a pose over which none is made up."""


def poses_from_csv(path: str | Path, fps: float = 60.0, unit: float = 1.0) -> list[Pose]:
    """One pose per frame of a track, evenly `fps` a second.

    path : columns time (seconds) or frame, x, y, z, and qx qy qz qw (a quaternion, the real part
        last) or rx ry rz (a rotation vector, radians), found by their names in any order; eight
        columns without a header are time x y z qx qy qz qw, as the TUM data sets have it
    unit : metres of one unit of x, y and z

    Rows are put in order of time; those with a number missing are left out; times between rows
    are interpolated, over up to one second. Quaternions are normalised. Raises ValueError, in one
    line, for anything else.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"{path} is missing")
    if not (np.isfinite(fps) and 0 < fps <= 1e6):
        raise ValueError(f"fps must be a number of frames a second, not {fps}")
    names, table = read_table(path)
    column = _columns(path, names, table)
    turning = [column[c] for c in (QUATERNION if "qw" in column else VECTOR) if c in column]
    used = [column["time"], *(column[a] for a in "xyz"), *turning]
    table = table[np.isfinite(table[:, used]).all(axis=1)]
    if not len(table):
        raise ValueError(f"{path} holds no row with all its numbers")
    if np.abs(table[:, used]).max() > LARGEST:
        raise ValueError(f"{path} holds {np.abs(table[:, used]).max():g}: at most {LARGEST:g}")
    time = table[:, column["time"]] / (fps if column["frames"] else 1.0)
    _, order = np.unique(time, return_index=True)
    table, time = table[order], time[order]
    place = unit * table[:, [column[a] for a in "xyz"]]
    rotation = _rotations(path, table[:, turning])
    if len(time) == 1:
        return [Pose(rotation.as_matrix()[0], place[0])]
    gap = np.diff(time)
    if gap.max() > LONGEST_GAP:
        k = int(gap.argmax())
        raise ValueError(
            f"{path} has no pose from {time[k]:.6g} s to {time[k + 1]:.6g} s: nobody knows where "
            f"the object was for {gap[k]:.3g} s; cut the track there, or fill the gap"
        )
    from scipy.spatial.transform import Slerp

    count = int(np.floor((time[-1] - time[0]) * fps + 1e-6)) + 1
    if count > MOST_FRAMES:
        raise ValueError(
            f"{path} makes {count} frames at {fps:g} a second, more than {MOST_FRAMES}: take fewer "
            "a second, or cut the track"
        )
    at = time[0] + np.arange(count) / fps
    at = np.minimum(at, time[-1])
    where = np.stack([np.interp(at, time, place[:, k]) for k in range(3)], axis=1)
    turns = Slerp(time, rotation)(at).as_matrix()
    return [Pose(turn, spot) for turn, spot in zip(turns, where, strict=True)]


def _columns(path: Path, names: list[str], table: NDArray[np.float64]) -> dict[str, Any]:
    if not names:
        if table.shape[1] != 8:
            raise ValueError(
                f"{path} has {table.shape[1]} columns and no header: name them time,x,y,z and "
                "qx,qy,qz,qw or rx,ry,rz"
            )
        return {c: k for k, c in enumerate(("time", *"xyz", *QUATERNION))} | {"frames": False}
    column: dict[str, Any] = {"frames": False}
    for name in TIME_NAMES:
        if name in names:
            column["time"] = names.index(name)
    if "time" not in column and "frame" in names:
        column |= {"time": names.index("frame"), "frames": True}
    for axis, called in zip("xyz", PLACES, strict=True):
        find_column(column, names, axis, called)
    for sets in (QUATERNION, VECTOR):
        if all(c in names for c in sets):
            column.update({c: names.index(c) for c in sets})
    missing = [c for c in ("time", *"xyz") if c not in column]
    half = [c for c in (*QUATERNION, *VECTOR) if c in names and c not in column]
    if missing or half:
        raise ValueError(
            f"{path} has columns {', '.join(names)}; needed are time or frame, x, y, z, and "
            "qx, qy, qz, qw or rx, ry, rz or neither"
        )
    return column


def _rotations(path: Path, values: NDArray[np.float64]) -> "Rotation":
    from scipy.spatial.transform import Rotation

    if values.shape[1] == 4:
        length = np.linalg.norm(values, axis=1)
        if (length < 1e-3).any():
            raise ValueError(
                f"{path}: {(length < 1e-3).sum()} quaternions are zero, which is no rotation"
            )
        return Rotation.from_quat(values / length[:, None])
    if values.shape[1] == 3:
        return Rotation.from_rotvec(values)
    return Rotation.from_quat(np.tile([0.0, 0, 0, 1], (len(values), 1)))
