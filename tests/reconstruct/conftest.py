"""A small stored video that several tests look at."""

from dataclasses import asdict

import numpy as np
import pytest

from chrmc import SLM, PointCloud, compute_field
from chrmc.encoding import coding_for
from chrmc.grey_levels import encode
from chrmc.record import FrameRecord
from chrmc.store.group import GroupWriter
from chrmc.store.manifest import FORMAT
from chrmc.store.writer import VideoWriter

P, LAMBDA = 8.1e-6, 532e-9
SLM_ = SLM("small", 256, 256, P)
SCALE = 60.0


def cloud_of(number):
    rng = np.random.default_rng(8)
    places = rng.uniform(-1, 1, (60, 3)) * [0.2e-3, 0.2e-3, 0.2e-3]
    places += [0.1e-3 * number, -0.2e-3, 0.06]
    return PointCloud(places, np.ones(60), rng.uniform(0, 6.3, 60))


@pytest.fixture(scope="module")
def video(tmp_path_factory):
    """Three frames: an object that moves to the right, and none in the last."""
    folder = tmp_path_factory.mktemp("video")
    description = {
        "format": FORMAT,
        "slm": asdict(SLM_),
        "wavelength": LAMBDA,
        "scene": {"name": "cluster", "form": "points", "pixel_pitch": 40e-6},
        "methods": {},
        "encoding": "ssb",
        "scale": SCALE,
    }
    writer, group = VideoWriter(folder, description), GroupWriter(folder, 1)
    band = coding_for("ssb", SLM_).passband
    for number in (1, 2, 3):
        cloud = cloud_of(number) if number < 3 else PointCloud.empty()
        record = FrameRecord(number)
        obj = {"name": "cluster", "position": None, "depth": None}
        if len(cloud):
            p = cloud.positions
            obj["position"], obj["depth"] = cloud.centroid.tolist(), cloud.centroid[2]
            obj["box"] = [p.min(axis=0).tolist(), p.max(axis=0).tolist()]
        record.objects = [obj]
        field = compute_field(cloud, SLM_, LAMBDA, passband=band, method="rt")
        group.add(record, encode(field, SLM_, scale=SCALE))
    group.save()
    writer.collect()
    return folder
