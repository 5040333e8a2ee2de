"""The verdict on videos of a built-in scene at full size, right ones and wrong ones."""

import json

import numpy as np
import pytest

import reconstruct
from chrmc import PointCloud, compute_field, generate, load_scene, open_video
from chrmc.encoding import coding_for
from chrmc.grey_levels import encode
from chrmc.pictures import write_grey


@pytest.fixture(scope="module")
def car_house(tmp_path_factory):
    return generate(
        load_scene("car-house"), tmp_path_factory.mktemp("v") / "video", frames=(21, 21)
    )


def test_the_map_is_in_the_manifest_and_the_verdict_uses_it(car_house):
    (verdict,) = reconstruct.check(car_house)
    assert verdict.passed and verdict.light > 0.8
    for found in verdict.objects:
        assert found.shape.told and found.shape.picture > 0.9
        assert abs(found.depth_error) < 5e-5 and np.hypot(*found.lateral_error) < 1e-5


def test_a_video_without_maps_is_judged_by_its_built_in_scene(car_house, tmp_path):
    manifest = json.loads((car_house.folder / "manifest.json").read_text())
    for obj in manifest["frames"][0]["objects"]:
        del obj["light"]
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    name = manifest["frames"][0]["file"]
    (tmp_path / name).write_bytes((car_house.folder / name).read_bytes())
    (verdict,) = reconstruct.check(tmp_path)
    assert verdict.passed and all(o.shape.told for o in verdict.objects)


def random_points(cloud, rng):
    low, high = cloud.positions.min(axis=0), cloud.positions.max(axis=0)
    places = rng.uniform(low, high, (100, 3))
    size = np.full(100, np.sqrt(cloud.intensity.sum() / 100))
    return PointCloud(
        places - places.mean(axis=0) + cloud.centroid, size, rng.uniform(0, 6.28, 100)
    )


def stretched(factors):
    def change(cloud, _):
        places = cloud.centroid + (cloud.positions - cloud.centroid) * factors
        return PointCloud(places, cloud.amplitude, cloud.phase)

    return change


@pytest.mark.parametrize(
    "change",
    [
        stretched([-1, 1, 1]),
        stretched([1, 1, 0]),
        stretched([1, 1, -1]),
        random_points,
    ],
    ids=["mirrored", "flat", "inverted", "random"],
)
def test_objects_of_a_wrong_shape_fail(car_house, tmp_path, change):
    rng = np.random.default_rng(1)
    clouds = [change(o.cloud, rng) for o in load_scene("car-house").frame(21).objects]
    slm, band = car_house.slm, coding_for("ssb", car_house.slm).passband
    field = compute_field(
        PointCloud.concatenate(clouds), slm, car_house.wavelength, "curved", passband=band
    )
    manifest = (car_house.folder / "manifest.json").read_text()
    (tmp_path / "manifest.json").write_text(manifest)
    frame = encode(field, slm, scale=car_house.scale)
    write_grey(tmp_path / json.loads(manifest)["frames"][0]["file"], frame)
    (verdict,) = reconstruct.check(open_video(tmp_path))
    assert not verdict.passed and any(o.shape.faults for o in verdict.objects)
