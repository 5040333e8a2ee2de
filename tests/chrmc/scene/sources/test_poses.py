"""Tracks of poses: gaps, order, quaternions of any length."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import chrmc


def write(path: Path, rows: np.ndarray, header: str) -> Path:
    np.savetxt(path, rows, delimiter=",", header=header, comments="")
    return path


def track(count: int = 31, rate: float = 30.0) -> np.ndarray:
    time = np.arange(count) / rate
    turn = Rotation.from_rotvec(np.outer(time, [0, 2.0, 0]))
    place = np.stack([0.1 * time, np.sin(time), 0.5 + 0 * time], axis=1)
    return np.column_stack([time, place, turn.as_quat()])


def test_a_track_at_twice_its_rate(tmp_path: Path) -> None:
    path = write(tmp_path / "t.csv", track(), "time,x,y,z,qx,qy,qz,qw")
    poses = chrmc.poses_from_csv(path, fps=60)
    assert len(poses) == 61
    time = 37 / 60
    assert poses[37].rotation == pytest.approx(
        Rotation.from_rotvec([0, 2.0 * time, 0]).as_matrix(), abs=1e-9
    )
    assert poses[37].translation == pytest.approx([0.1 * time, np.sin(time), 0.5], abs=2e-4)


def test_order_missing_numbers_and_lengths_of_quaternions_do_not_matter(tmp_path: Path) -> None:
    plain = chrmc.poses_from_csv(write(tmp_path / "a.csv", track(), "time,x,y,z,qx,qy,qz,qw"), 30)
    rows = track()
    rows[:, 4:] *= np.linspace(0.3, 4, len(rows))[:, None]
    rows = rows[np.random.default_rng(1).permutation(len(rows))]
    rows[3] = np.nan
    other = chrmc.poses_from_csv(write(tmp_path / "b.csv", rows, "time,x,y,z,qx,qy,qz,qw"), 30)
    assert len(other) == len(plain)
    for a, b in zip(plain, other, strict=True):
        assert a.rotation == pytest.approx(b.rotation, abs=1e-9)
        assert a.translation == pytest.approx(b.translation, abs=2e-4)


def test_rotation_vectors_frames_and_millimetres(tmp_path: Path) -> None:
    rows = np.array([[0, 1000, 0, 0, 0, 0.1, 0], [1, 2000, 0, 0, 0, 0.2, 0]])
    path = write(tmp_path / "v.csv", rows, "frame,x,y,z,rx,ry,rz")
    first, second = chrmc.poses_from_csv(path, fps=25, unit=1e-3)
    assert first.translation == pytest.approx([1, 0, 0])
    assert second.rotation == pytest.approx(Rotation.from_rotvec([0, 0.2, 0]).as_matrix())


def test_eight_columns_as_the_tum_sets_have_them(tmp_path: Path) -> None:
    path = tmp_path / "groundtruth.txt"
    lines = ["# timestamp tx ty tz qx qy qz qw"]
    lines += [" ".join(f"{v:.6f}" for v in row) for row in track()]
    path.write_text("\n".join(lines))
    assert len(chrmc.poses_from_csv(path, 30)) == 31


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda rows: np.delete(rows, slice(3, 40), axis=0), "nobody knows where"),
        (lambda rows: rows * [1, 1, 1, 1, 0, 0, 0, 0], "is no rotation"),
        (lambda rows: rows * np.nan, "no row with all its numbers"),
    ],
)
def test_what_cannot_be_mended_is_refused(tmp_path: Path, change, words: str) -> None:
    path = write(tmp_path / "t.csv", change(track(60)), "time,x,y,z,qx,qy,qz,qw")
    with pytest.raises(ValueError, match=words):
        chrmc.poses_from_csv(path)


def test_columns_that_are_missing_are_named(tmp_path: Path) -> None:
    path = write(tmp_path / "t.csv", track(), "time,x,y,z,qx,qy,qz,other")
    with pytest.raises(ValueError, match="qw"):
        chrmc.poses_from_csv(path)
    with pytest.raises(OSError, match="missing"):
        chrmc.poses_from_csv(tmp_path / "no.csv")
    with pytest.raises(ValueError, match="fps"):
        chrmc.poses_from_csv(path, fps=0)
