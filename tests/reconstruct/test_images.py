import numpy as np
import pytest

from reconstruct.images import read_image, to_grey, write_colour, write_image

IMAGE = np.random.default_rng(0).random((37, 53)).astype(np.float32) ** 3 * 7


def test_exr_keeps_every_bit_and_the_metadata(tmp_path):
    path = tmp_path / "a.exr"
    write_image(path, IMAGE, {"depth": 0.25, "frame": 3})
    values, note = read_image(path)
    assert np.array_equal(values, IMAGE)
    assert note == {"depth": 0.25, "frame": 3}
    assert [p.name for p in tmp_path.iterdir()] == ["a.exr"]


@pytest.mark.parametrize("gamma", [1.0, 2.2])
def test_png_levels_turn_back_into_intensities(tmp_path, gamma):
    path = tmp_path / "deep" / "a.png"
    write_image(path, IMAGE, {"depth": 0.25}, full_scale=5.0, gamma=gamma)
    levels, note = read_image(path)
    assert note["full_scale"] == 5.0 and note["gamma"] == gamma and note["depth"] == 0.25
    back = (levels / 255) ** gamma * 5.0
    slope = gamma * np.maximum(levels / 255, 1 / 255) ** (gamma - 1) * 5.0 / 255
    assert (np.abs(back - np.minimum(IMAGE, 5)) <= slope + 1e-3).all()


def test_grey_levels_of_known_intensities():
    assert to_grey(np.array([[0.0, 0.5, 1.0, 2.0]]), 1.0, 1.0).tolist() == [[0, 128, 255, 255]]
    assert not to_grey(np.zeros((3, 3))).any()
    with pytest.raises(ValueError, match="gamma"):
        to_grey(IMAGE, gamma=0)
    with pytest.raises(ValueError, match="full_scale"):
        to_grey(IMAGE, full_scale=np.nan)


def test_automatic_exposure_does_not_move_with_the_units():
    assert np.array_equal(to_grey(IMAGE), to_grey(1024 * IMAGE))


def test_colour_pictures(tmp_path):
    write_colour(tmp_path / "c.png", np.zeros((4, 5, 3), dtype=np.uint8))
    assert (tmp_path / "c.png").stat().st_size > 0
    with pytest.raises(ValueError, match="png"):
        write_colour(tmp_path / "c.exr", np.zeros((4, 5, 3), dtype=np.uint8))


def test_bad_files_are_told(tmp_path):
    with pytest.raises(ValueError, match=r"\.png or \.exr"):
        write_image(tmp_path / "a.jpg", IMAGE)
    with pytest.raises(ValueError, match="empty"):
        write_image(tmp_path / "a.png", np.zeros((0, 3)))
    with pytest.raises(FileNotFoundError, match="missing"):
        read_image(tmp_path / "none.png")
    (tmp_path / "bad.png").write_bytes(b"no picture")
    with pytest.raises(OSError, match="bad"):
        read_image(tmp_path / "bad.png")
