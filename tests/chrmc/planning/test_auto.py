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
        for share in (0.0, 0.001, 0.05, 1.0)
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
