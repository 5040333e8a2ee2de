import numpy as np
import pytest
from PIL import Image

from chrmc.store.video import open_video
from reconstruct import four_f
from reconstruct.animation import movies_there, write_animation
from reconstruct.sequence import (
    at_depth,
    common_scale,
    composite,
    following,
    panorama,
    reconstruct_all,
    region_of,
    shrink,
    spread_frames,
    system_of,
    targets_of,
)


@pytest.fixture
def stored(video):
    return open_video(video)


def test_every_frame_is_four_f_at_its_depth(stored):
    shown = list(reconstruct_all(stored, at_depth(0.06)))
    assert [s.number for s in shown] == [1, 2, 3]
    want = four_f(stored.read(2), stored.slm, stored.wavelength, 0.06, scale=stored.scale)
    assert np.allclose(shown[1].image, want, atol=1e-4 * want.max())


def test_following_an_object(stored):
    depth_of = following(stored, "cluster")
    for number in (1, 2):
        assert depth_of(number) == targets_of(stored, number)[0].position[2]
    assert depth_of(3) == depth_of(2)  # out of sight: where it was last
    with pytest.raises(ValueError, match="cluster"):
        following(stored, "boat")
    with pytest.raises(ValueError, match="distance"):
        at_depth(-1)


def test_a_composite_has_its_objects_in_focus_and_nothing_else(stored):
    system = system_of(stored)
    shown = composite(stored, 1, system)
    target = targets_of(stored, 1)[0]
    plane = system.image(stored.read(1), float(target.position[2]))
    lit = shown.image > 0
    assert 0 < lit.mean() < 0.5
    difference = np.linalg.norm((shown.image - plane)[lit])
    assert difference < 0.02 * np.linalg.norm(plane)
    assert not composite(stored, 3, system).image.any()


def test_panorama_shows_all_moments(stored):
    system = system_of(stored)
    both = panorama(stored, [1, 2]).image
    for number in (1, 2):
        assert (both >= composite(stored, number, system).image).all()
    # The object moves by a quarter of itself: one moment does not overlap itself.
    assert spread_frames(stored) == [1]


def test_the_region_holds_every_object(stored):
    rows, columns = region_of(stored)
    for number in (1, 2):
        target = targets_of(stored, number)[0]
        assert columns.start <= target.low[0] / 8.1e-6 + 127.5
        assert columns.stop >= target.high[0] / 8.1e-6 + 127.5
        assert rows.start <= target.low[1] / 8.1e-6 + 127.5


def test_shrinking_keeps_the_mean():
    image = np.random.default_rng(0).random((60, 90)).astype(np.float32)
    small = shrink(image, 30)
    assert small.shape == (20, 30)
    assert small.mean() == pytest.approx(image.mean(), rel=1e-5)
    assert shrink(image, 100) is image or np.array_equal(shrink(image, 100), image)


def test_common_scale_leaves_dark_frames_out():
    bright = np.ones((4, 4))
    assert common_scale([bright, 0 * bright, 3 * bright]) == 2.0
    assert common_scale([0 * bright]) == 0.0


@pytest.mark.parametrize("suffix", [".gif", ".png"])
def test_animations_hold_their_frames(tmp_path, suffix):
    frames = [np.full((8, 10), 60 * i, dtype=np.uint8) for i in range(4)]
    path = tmp_path / f"a{suffix}"
    write_animation(path, frames, 10)
    with Image.open(path) as picture:
        assert picture.n_frames == 4 and picture.size == (10, 8)
        picture.seek(2)
        assert np.abs(np.asarray(picture.convert("L")).astype(int) - 120).max() <= 1
        assert picture.info["duration"] == 100


def test_animations_that_cannot_be(tmp_path):
    frames = [np.zeros((8, 10), dtype=np.uint8)]
    with pytest.raises(ValueError, match="gif"):
        write_animation(tmp_path / "a.bmp", frames, 10)
    with pytest.raises(ValueError, match="no frames"):
        write_animation(tmp_path / "a.gif", [], 10)
    with pytest.raises(ValueError, match="rate"):
        write_animation(tmp_path / "a.gif", frames, 0)
    if not movies_there():
        with pytest.raises(OSError, match="movie"):
            write_animation(tmp_path / "a.mp4", frames, 10)


@pytest.mark.parametrize("suffix", [".gif", ".png"])
def test_animations_keep_their_comment(tmp_path, suffix):
    frames = [np.full((8, 10), 60 * i, dtype=np.uint8) for i in range(4)]
    write_animation(tmp_path / f"a{suffix}", frames, 10, '{"depth": 0.25}')
    with Image.open(tmp_path / f"a{suffix}") as picture:
        kept = picture.info.get("comment", b"") or picture.text["Comment"].encode()
    assert kept == b'{"depth": 0.25}'


@pytest.mark.skipif(not movies_there(), reason="chrmc[movie] is optional")
def test_movies_are_written(tmp_path):
    frames = [np.full((64, 64), 20 * i, dtype=np.uint8) for i in range(8)]
    write_animation(tmp_path / "a.mp4", frames, 10, '{"depth": 0.25}')
    assert (tmp_path / "a.mp4").stat().st_size > 500
    assert b'{"depth": 0.25}' in (tmp_path / "a.mp4").read_bytes()
