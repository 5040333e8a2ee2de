import json

import numpy as np
import pytest

from chrmc import SLM, PointCloud, compute_field
from chrmc.encoding import coding_for
from display import encode
from reconstruct import FourF, report
from reconstruct.verdict import FrameVerdict, Target, judge_frame

P, LAMBDA = 8.1e-6, 532e-9
SLM_ = SLM("small", 320, 288, P)
PITCH = 40e-6


def block(name, centre, seed, count=90):
    rng = np.random.default_rng(seed)
    places = rng.uniform(-1, 1, (count, 3)) * [0.3e-3, 0.2e-3, 0.3e-3] + centre
    cloud = PointCloud(places, rng.uniform(0.5, 1, count), rng.uniform(0, 6.3, count))
    return cloud, Target.of_cloud(name, cloud)


NEAR, NEAR_TARGET = block("near", (-0.5e-3, 0.3e-3, 0.060), 1)
FAR, FAR_TARGET = block("far", (0.5e-3, -0.3e-3, 0.070), 2)


def field_of(*clouds):
    band = coding_for("ssb", SLM_).passband
    return compute_field(PointCloud.concatenate(clouds), SLM_, LAMBDA, passband=band, method="rt")


BOTH = field_of(NEAR, FAR)
SYSTEM = FourF(SLM_, LAMBDA)


def moved(target, by):
    by = np.asarray(by)
    return Target(target.name, target.position + by, target.low + by, target.high + by)


def test_objects_where_the_scene_says_pass():
    verdict = judge_frame(encode(BOTH, SLM_), SYSTEM, [NEAR_TARGET, FAR_TARGET], PITCH, 5, BOTH)
    assert verdict.passed and verdict.number == 5
    for found in verdict.objects:
        assert abs(found.depth_error) < 2e-4
        assert found.contrast > 0.5 and found.psnr > 30 and found.ssim > 0.95
        assert found.focus.front < found.focus.depth < found.focus.rear


@pytest.mark.parametrize("by", [(0, 0, 1.2e-3), (0, 0, -1.2e-3), (0, 0, 0.01), (0.1e-3, 0, 0)])
def test_objects_elsewhere_fail(by):
    verdict = judge_frame(encode(BOTH, SLM_), SYSTEM, [moved(NEAR_TARGET, by)], PITCH)
    assert not verdict.passed


def test_a_missing_object_noise_and_darkness_fail():
    for frame in (
        encode(field_of(FAR), SLM_),
        np.random.default_rng(3).integers(0, 256, SLM_.shape, dtype=np.uint8),
        np.zeros(SLM_.shape, dtype=np.uint8),
        np.full(SLM_.shape, 255, dtype=np.uint8),
    ):
        verdict = judge_frame(frame, SYSTEM, [NEAR_TARGET], PITCH)
        assert not verdict.passed
        assert "FAILS" in "\n".join(report.table([verdict]))
        json.dumps(report.as_dict([verdict]), allow_nan=False)


def test_objects_of_little_light_cannot_be_judged():
    """Dim beside a bright one, and outshone by one in front of it; a missing one is no excuse."""
    behind, _ = block("behind", (-0.5e-3, 0.3e-3, 0.062), 3)

    def judged(*named):
        field = field_of(*(cloud for _, cloud in named))
        targets = [Target.of_cloud(name, cloud, SYSTEM) for name, cloud in named]
        return judge_frame(encode(field, SLM_), SYSTEM, targets, PITCH)

    dim = PointCloud(FAR.positions, 0.02 * FAR.amplitude, FAR.phase)
    found = judged(("near", NEAR), ("far", dim))
    assert found.passed and [o.judged for o in found.objects] == [True, False]
    lines = list(report.table([found]))
    assert "cannot be judged: it has 0.000" in lines[3]
    assert lines[-1].startswith("all 1 objects that can be judged, of 2, are in focus")
    assert [o["judged"] for o in report.as_dict([found])["frames"][0]["objects"]] == [True, False]
    faint = PointCloud(behind.positions, 0.3 * behind.amplitude, behind.phase)
    found = judged(("near", NEAR), ("behind", faint))
    assert [o.judged for o in found.objects] == [True, False]
    assert "others have" in list(report.table([found]))[3]
    targets = [Target.of_cloud(n, c, SYSTEM) for n, c in (("near", NEAR), ("far", FAR))]
    found = judge_frame(encode(field_of(NEAR), SLM_), SYSTEM, targets, PITCH)
    assert not found.passed and found.objects[1].judged
    # Light of which a video tells nothing is no reason.
    assert all(
        o.judged
        for o in judge_frame(encode(BOTH, SLM_), SYSTEM, [NEAR_TARGET, FAR_TARGET], PITCH).objects
    )


@pytest.mark.parametrize(
    ("encoding", "most", "least"),
    [
        ("ssb", 1.0, 4.0),
        ("real", 0.5, 4.0),
        ("bipolar", 0.5, 4.0),
        ("error-diffusion", 0.5, 6.0),
        ("double-phase", 1.0, 6.0),
    ],
)
def test_noise_of_more_light_than_the_objects_fails(encoding, most, least):
    """`most` times the field's power is less light than theirs; a sideband's filter halves it."""
    slm, system = SLM_, FourF(SLM_, LAMBDA, encoding)
    band = coding_for(encoding, slm).passband
    both = compute_field(
        PointCloud.concatenate([NEAR, FAR]), slm, LAMBDA, passband=band, method="rt"
    )
    targets = [Target.of_cloud(n, c, system) for n, c in (("near", NEAR), ("far", FAR))]
    noise = np.random.default_rng(4).standard_normal((2, *slm.shape))
    noise = (noise[0] + 1j * noise[1]) * np.sqrt(np.mean(np.abs(both) ** 2) / 2)
    for times, passes in ((most, True), (least, False)):
        frame = encode(both + np.sqrt(times) * noise, slm, encoding)
        found = judge_frame(frame, system, targets, PITCH)
        assert found.passed == passes, found.light
        assert ["noise" in fault for fault in found.faults] == [True] * (not passes)


def test_right_frames_of_encodings_that_bring_noise_pass():
    """A speck whose light is on a part of the panel: the rest of the frame is noise."""
    slm = SLM("half", 960, 600, P)
    rng = np.random.default_rng(3)
    places = rng.uniform(-1, 1, (30, 3)) * [0.19e-3, 0.12e-3, 0.5e-3] + [0, 0, 0.037]
    speck = PointCloud(places, np.ones(30), rng.uniform(0, 6.3, 30))
    for encoding in ("offaxis", "lee", "error-diffusion", "double-phase", "kinoform"):
        band, system = coding_for(encoding, slm).passband, FourF(slm, LAMBDA, encoding)
        field = compute_field(speck, slm, LAMBDA, passband=band, method="rt")
        target = Target.of_cloud("speck", speck, system)
        found = judge_frame(encode(field, slm, encoding), system, [target], PITCH)
        assert found.passed, (encoding, found.faults, found.objects[0].faults)


def test_mirrored_and_negative_holograms_fail():
    frame = encode(BOTH, SLM_)
    assert not judge_frame(frame[:, ::-1].copy(), SYSTEM, [NEAR_TARGET], PITCH).passed
    assert not judge_frame(frame[::-1].copy(), SYSTEM, [NEAR_TARGET], PITCH).passed
    # A negative is a hologram of the same wave, half a turn later.
    assert judge_frame(255 - frame, SYSTEM, [NEAR_TARGET], PITCH).passed


def test_published_metrics_on_request():
    frame = encode(BOTH, SLM_)
    found = judge_frame(frame, SYSTEM, [FAR_TARGET], PITCH, with_metrics=True)
    depths = found.objects[0].metric_depths
    assert set(depths) == {"variance", "peakedness", "tenengrad", "tamura"}
    for depth in depths.values():
        assert depth == pytest.approx(FAR_TARGET.position[2], abs=6e-4)
    assert len(list(report.metric_table([found]))) == 2
    assert not judge_frame(frame, SYSTEM, [FAR_TARGET], PITCH).objects[0].metric_depths


def test_an_empty_frame_passes():
    assert judge_frame(np.full(SLM_.shape, 128, dtype=np.uint8), SYSTEM, [], PITCH).passed
    assert "empty" in "\n".join(report.table([FrameVerdict(1)]))


def test_targets_from_a_manifest():
    assert Target.of_record({"name": "a", "position": None, "depth": None}) is None
    record = {"name": "a", "position": [0, 0, 0.1], "box": [[-1, -2, 0.05], [1, 2, 0.2]]}
    target = Target.of_record(record)
    assert target.low.tolist() == [-1, -2, 0.05] and target.high[2] == 0.2
    bare = Target.of_record({"name": "a", "position": [0, 0, 0.1]})
    assert bare.low[2] < 0.1 < bare.high[2]


def test_report_and_plot(tmp_path):
    frame = encode(BOTH, SLM_)
    good = judge_frame(frame, SYSTEM, [NEAR_TARGET, FAR_TARGET], PITCH)
    off = judge_frame(frame, SYSTEM, [moved(NEAR_TARGET, (0, 0, 0.9e-3))], PITCH, 2)
    lines = list(report.table([good, off]))
    assert lines[-1].startswith("1 of 3 objects")
    assert "mm off" in lines[-2]
    content = report.as_dict([good, off])
    assert not content["passed"] and content["frames"][0]["passed"]
    assert len(content["frames"][0]["objects"][0]["curve"]["depths"]) > 10
    report.plot_curves([good, off], tmp_path / "focus.png")
    assert (tmp_path / "focus.png").stat().st_size > 10_000
