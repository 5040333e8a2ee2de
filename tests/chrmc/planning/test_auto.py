"""`auto`: the plan's methods are taken, named in the manifest, and kept by whoever goes on."""

import json
from pathlib import Path

import numpy as np
import pytest

import chrmc
from chrmc.generation import auto
from chrmc.generation.checking import Check
from chrmc.generation.recipe import recipe_for
from chrmc.planning import choices
from chrmc.planning.rates import KINDS, Rates
from chrmc.scene.scene import ObjectFrame, SceneFrame

PANEL = chrmc.SLM("small", 240, 160, 32e-6)


def scene() -> chrmc.PointScene:
    random = np.random.default_rng(1)
    body = chrmc.PointCloud(random.normal(0, 2e-4, (60, 3)), np.ones(60), random.uniform(0, 6, 60))
    poses = [chrmc.Pose.from_rotvec([0, 0.01 * n, 0], [0, 0, 0.25]) for n in range(3)]
    return chrmc.PointScene("turning", {"body": body}, {"body": poses})


def machine(monkeypatch: pytest.MonkeyPatch, slow: str = "") -> None:
    """One whose cores are a million times slower at some kind of operation."""
    speeds = {kind: 1e3 if kind == slow else 1e9 for kind in KINDS}
    monkeypatch.setattr(choices, "machine_rates", lambda: Rates(speeds, speeds, 2))


def test_a_video_is_continued_with_the_methods_it_was_begun_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    options = {"slm": PANEL, "tolerance": 1e-3, "check_pixels": 8}
    machine(monkeypatch, "calls")
    begun = chrmc.generate(scene(), tmp_path / "a", frames=(1, 1), **options)  # type: ignore
    assert begun.methods["auto"]["why"].startswith(begun.methods["cgh"])
    machine(monkeypatch, "phasors")
    elsewhere = chrmc.plan(scene(), PANEL, tolerance=1e-3).taken
    assert elsewhere.cgh != begun.methods["cgh"]  # where it would have been another
    whole = chrmc.generate(scene(), tmp_path / "a", **options)  # type: ignore[arg-type]
    assert whole.numbers == [1, 2, 3] and whole.methods == begun.methods
    with pytest.raises(ValueError, match="another video"):
        chrmc.generate(scene(), tmp_path / "a", **options | {"tolerance": 1e-2})  # type: ignore


def test_the_manifest_names_what_was_taken(tmp_path: Path) -> None:
    chrmc.generate(scene(), tmp_path / "v", slm=PANEL, cgh="auto", compensation="auto")
    methods = json.loads((tmp_path / "v" / "manifest.json").read_text())["methods"]
    assert methods["cgh"] in chrmc.cgh.METHODS
    assert methods["auto"]["tolerance"] == 1e-3 and methods["auto"]["why"]


def test_auto_beside_a_named_method_is_the_default() -> None:
    assert not auto.is_auto("rt", "auto", None, {})
    assert not auto.is_auto("auto", "auto", None, {"reuse": "always"})
    (frame, *_) = chrmc.video(scene(), PANEL, cgh="rt", compensation="auto")
    assert frame.record.key


def test_video_keeps_the_tolerance() -> None:
    given = scene()
    for frame in chrmc.video(given, PANEL, cgh="auto", compensation="auto", tolerance=1e-4):
        truth = chrmc.reference_field(frame.cloud, PANEL, 532e-9)
        assert chrmc.relative_error(frame.field, truth) < 1e-4


def test_the_error_check_keeps_to_its_share(tmp_path: Path) -> None:
    many = chrmc.PointCloud(
        np.random.default_rng(2).normal(0, 3e-4, (30_000, 3)), np.ones(30_000), np.zeros(30_000)
    )
    poses = [chrmc.Pose(np.eye(3), [0, 0, 0.25])] * 20
    crowd = chrmc.PointScene("crowd", {"body": many}, {"body": poses})
    recipes = [
        recipe_for(crowd, PANEL, check_share=share, compensation="none")
        for share in (0.0, 0.001, 0.1, 1.0)
    ]
    none, little, usual, much = (Check(r.check_pixels, r.check_every) for r in recipes)
    assert none.pixels == 0 and not none.includes(1, 20, 96)
    assert little.every > usual.every or little.pixels < usual.pixels
    assert much.pixels >= usual.pixels and much.every <= usual.every
    assert little.includes(1, 20, 96) and little.includes(20, 20, 96)
    assert Check(16, 1000).includes(97, 200, 96) and not Check(16, 1000).includes(98, 200, 96)


def test_a_stored_check_is_kept_and_told(tmp_path: Path) -> None:
    video = chrmc.generate(scene(), tmp_path / "v", slm=PANEL)
    errors = [entry["error_reference"] for entry in video.frames]
    pixels = [entry["error_pixels"] for entry in video.frames]
    assert errors[0] is not None and errors[-1] is not None and pixels[0] >= 16
    again = chrmc.generate(scene(), tmp_path / "v", slm=PANEL, check_share=0.5)
    assert again.frames == video.frames  # as it was begun


class Mixed:
    """A still house, a spinning car of many points, and a cloth whose points are not known."""

    name, form, frame_count, object_names = "mixed", "points", 40, ("house", "car", "cloth")
    wavelength, pixel_pitch, planes = None, 40.5e-6, None

    def __init__(self) -> None:
        random = np.random.default_rng(3)
        self.bodies = {
            name: chrmc.PointCloud(
                random.uniform(-5e-4, 5e-4, (count, 3)), np.ones(count), random.uniform(0, 6, count)
            )
            for name, count in (("house", 50), ("car", 20_000), ("cloth", 60))
        }

    def pose(self, name: str, number: int) -> chrmc.Pose | None:
        if name == "cloth":
            return None
        turn, aside = (0.5, -1e-3) if name == "house" else (0.003 * number, 1e-3)
        return chrmc.Pose.from_rotvec([0, turn, 0], [aside, 0, 0.25])

    def frame(self, number: int) -> SceneFrame:
        things = []
        for name, body in self.bodies.items():
            pose = self.pose(name, number)
            if pose is None:
                bent = np.add(body.positions, [0.0, 1e-3, 0.25])
                bent[:, 2] += 1e-4 * np.sin(4e3 * bent[:, 0] + 0.3 * number)
                things.append(ObjectFrame(name, chrmc.PointCloud(bent, body.amplitude, body.phase)))
                continue
            cloud = chrmc.PointCloud(pose.apply(body.positions), body.amplitude, body.phase)
            things.append(ObjectFrame(name, cloud, body, np.arange(len(body)), pose))
        return SceneFrame(number, tuple(things))


def test_each_object_is_made_its_own_way() -> None:
    made = list(
        chrmc.video(Mixed(), PANEL, compensation="auto", tolerance=1e-2, frames=(1, 5))  # type: ignore
    )
    second = made[1].record
    assert set(second.reuse) == {"car", "cloth"}  # nothing is done for the house
    assert second.reuse["car"].startswith("from its sphere")
    assert second.reuse["cloth"].startswith("afresh")
    assert second.points_computed == 60
