"""The paper's tables made again: what they count, how they name, what they refuse."""

import csv
import io
from pathlib import Path

import numpy as np
import pytest

import chrmc
from chrmc.bench import tables
from chrmc.bench.kept_scene import kept_scene
from chrmc.bench.systems import Measured, System, count_points, measure, still_objects
from chrmc.cgh import METHODS, compute_field
from chrmc.cli.bench_tables import chosen, image_psnr
from chrmc.compensation import COMPENSATIONS
from chrmc.encoding import coding_for
from chrmc.scene.load import load_scene
from chrmc.slm import SLM

SMALL = SLM("small", 64, 40, 8.1e-6)
REAL = coding_for("real", SMALL)
NONE, TR = System("fresnel", "fresnel"), System("tr", "fresnel", "tr-nlut")
MPEG = System("mpeg", "fresnel", "mpeg-nlut")


def measured_on(form: str, systems: list[System], last: int, **options: object) -> list[Measured]:
    scene = load_scene("car-house", form=form)
    return measure(systems, scene, SMALL, chrmc.WAVELENGTH, REAL, frames=(1, last), **options)  # type: ignore[arg-type]


def test_every_registered_method_is_in_the_tables() -> None:
    pairs = tables.table1_pairs()
    assert {p.original.cgh for p in pairs} == set(METHODS)
    surfaces = {p.original.cgh: p.compensated.compensation for p in pairs}
    assert surfaces.pop("curved") == "ch-rmc-object" and set(surfaces.values()) == {"ch-rmc-paper"}
    assert {p.paper for p in pairs} - {None} == {"RT", "WRP", "NLUT"}
    others = {p.compensated.compensation for p in tables.table2_pairs("nlut")}
    assert others == set(COMPENSATIONS) - {"none", "ch-rmc-object"}


def test_countings_agree_with_the_scene_by_hand() -> None:
    scene = load_scene("car-house", form="rgbd")
    plain, tr, mpeg = measured_on("rgbd", [NONE, TR, MPEG], 5)
    sizes = [[len(o.cloud) for o in scene.frame(n).objects] for n in range(1, 6)]
    assert plain.mean("points_computed") == pytest.approx(np.sum(sizes) / 5)
    assert plain.mean("points_moving") == pytest.approx(np.mean([car for car, _ in sizes]))
    assert tr.points_moving[0] == sizes[0][0]
    # Same pixel, plane and intensity to 2/255: counted here without the package's matching.
    for n in (2, 3):
        before, after = (
            {
                (round(x / 40.5e-6 - 0.5), round(y / 40.5e-6 - 0.5), round(z * 1e4)): i
                for (x, y, z), i in zip(c.positions, c.intensity, strict=True)
            }
            for c in (scene.frame(n - 1).cloud, scene.frame(n).cloud)
        )
        kept = [k for k in before.keys() & after if abs(before[k] - after[k]) <= 2 / 255 + 1e-9]
        assert tr.records[n - 1].points_removed == len(before) - len(kept)
        assert tr.records[n - 1].points_added == len(after) - len(kept)
    assert [r.key for r in mpeg.records] == [True, False, False, False, True]
    assert mpeg.points_moving[4] == sizes[4][0]
    assert mpeg.corrections == np.mean([r.points_computed for r in mpeg.records[1:4]])


def test_counting_without_computing_gives_the_same_ledgers() -> None:
    scene = load_scene("car-house", form="rgbd")
    counted = count_points(TR, scene, SMALL, chrmc.WAVELENGTH, range(1, 4), REAL)
    (tr,) = measured_on("rgbd", [TR], 3)
    assert [r.points_computed for r in counted] == [r.points_computed for r in tr.records]


def test_the_house_stands_still_and_frames_are_made_once() -> None:
    kept = kept_scene(load_scene("car-house"))
    assert still_objects(kept, range(1, 4)) == {"house"}
    assert kept.frame(2) is kept.frame(2) and kept.frame_count == 80


def test_accuracy_stands_beside_every_row() -> None:
    rt = System("rt", "rt")
    plain, exact = measured_on("points", [NONE, rt], 2, pixels=64)
    assert 1e-4 < plain.rms("error_shown") < 0.3 and plain.rms("error_scene") < 0.3
    assert exact.rms("error_shown") < 1e-5
    assert np.isinf(exact.worst("snr_images")) and np.isnan(exact.worst("psnr_scene"))
    (mc,) = measured_on("rgbd", [System("mc", "rt", "mc-nlut")], 3, pixels=64)
    # Compensated points keep their phases, so the field is another than the scene's.
    assert mc.rms("error_shown") < 1e-5 < 0.1 < mc.rms("error_scene")


def test_a_method_that_refuses_says_so_in_its_row() -> None:
    wrong = System("wrong", "nlut", "none", (("subpixel", "never"),))
    plain, refused = measured_on("points", [NONE, wrong], 1)
    pairs = [tables.Pair(NONE, wrong)]
    table = tables.rows("points", pairs, [plain, refused], {})
    assert "subpixel" in table[1]["refused"] and "subpixel" in tables.to_text(table)
    assert len(plain.records) == 1


def test_text_csv_and_plot(tmp_path: Path) -> None:
    nlut, mc = System("nlut", "nlut"), System("mc-nlut", "nlut", "mc-nlut")
    pairs = [tables.Pair(nlut, mc, "MC-NLUT")]
    measured = measured_on("rgbd", [nlut, mc], 3)
    table = tables.rows("rgbd", pairs, measured, {mc: 123.0})
    back = list(csv.DictReader(io.StringIO(tables.to_csv(table))))
    assert [row["system"] for row in back] == ["nlut", "mc-nlut"]
    assert float(back[0]["paper_points"]) == 1208 and float(back[0]["paper_seconds"]) == 26.61
    assert float(back[1]["paper_points"]) == pytest.approx(1208 * 1.2765)
    assert float(back[1]["points_change_%"]) == pytest.approx(
        100 * (float(back[1]["points"]) / float(back[0]["points"]) - 1)
    )
    text = tables.to_text(table)
    assert "PFPs" in text and "MiB of at most 512 MiB" in text
    assert "mc-nlut" in text and "123" in text and "1542" in text
    assert "+27.6" in tables.claims_text(table) or "+27.7" in tables.claims_text(table)
    for ending, start in ((".png", b"\x89PNG"), (".pdf", b"%PDF"), (".svg", b"<?xml")):
        tables.plot({"rgbd": table}, tmp_path / f"t{ending}", "test")
        assert (tmp_path / f"t{ending}").read_bytes().startswith(start)


def test_image_psnr_sees_a_wrong_field_and_not_a_right_one() -> None:
    slm = SLM("middle", 400, 300, 8.1e-6)
    scene_frame = load_scene("car-house").frame(40)
    band = coding_for("real", slm).passband
    field = compute_field(scene_frame.cloud, slm, chrmc.WAVELENGTH, "fresnel", passband=band)
    compare = image_psnr(slm, chrmc.WAVELENGTH)
    same = compare(field, field, scene_frame)
    assert set(same) == {"car", "house"} and min(same.values()) == np.inf
    rng = np.random.default_rng(0)
    noise = 0.1 * np.abs(field).mean() * rng.standard_normal(field.shape)
    near = compare((field + noise).astype(np.complex64), field, scene_frame)
    far = compare(np.roll(field, 3, axis=1), field, scene_frame)
    assert 25 < near["house"] < 70 and far["house"] < near["house"] - 10


def test_only_known_systems_can_be_chosen() -> None:
    pairs = tables.table2_pairs()
    assert [p.compensated.label for p in chosen(pairs, "mc-nlut")] == ["mc-nlut"]
    with pytest.raises(ValueError, match="3dmc-nlut"):
        chosen(pairs, "mc")


def test_planes_as_far_apart_as_asked() -> None:
    from chrmc.scene.car_house import car_house_rgbd

    usual, wide = (car_house_rgbd("car-house", spacing) for spacing in (None, 1e-3))
    assert (usual.planes.step, wide.planes.step) == (0.1e-3, 1e-3)
    assert 0 <= wide.planes.last - usual.planes.last < 1e-3
    places = wide.frame(1).cloud.positions[:, 2] - wide.planes.first
    np.testing.assert_allclose(places / 1e-3, np.rint(places / 1e-3), atol=1e-6)
