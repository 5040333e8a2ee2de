"""What is handed over was looked at: coherence, grazing edges, cancelling waves, odd numbers."""

import threading
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from threadpoolctl import threadpool_info

from chrmc import LC_R_1080, SLM, WAVELENGTH, PointCloud, compute_field, parallel
from chrmc.cgh import curved, field_and_error, rt
from chrmc.cgh.counts import STATED
from chrmc.cgh.curved import predict, verify
from chrmc.cgh.curved.along import waves_along
from chrmc.cgh.curved.axes import cluster_axes
from chrmc.cgh.curved.clusters import bounding_box, reference_of
from chrmc.cgh.curved.exact import rounding_of
from chrmc.cgh.curved.tables import exact_baseband, phasor_table
from chrmc.cgh.curved.wave import Wave
from chrmc.encoding import coding_for
from chrmc.optics.footprint import coverage, expected_power, reach
from chrmc.optics.passband import UNLIMITED, full_band
from chrmc.reference import reference_field, reference_samples, relative_error
from chrmc.window import Window

PANEL = SLM("panel", 320, 200, 16e-6)


def cloud_of(count: int, size: tuple[float, ...], place: tuple[float, ...]) -> PointCloud:
    random = np.random.default_rng(count)
    return PointCloud(
        (random.random((count, 3)) - 0.5) * size + place,
        random.uniform(0.2, 1, count),
        random.uniform(0, 6.3, count),
    )


def check(
    cloud: PointCloud,
    slm: SLM,
    *tolerances: float,
    encoding: str = "real",
    wavelength: float = WAVELENGTH,
) -> None:
    """Within tolerance on the whole panel's light, and expected within a factor of three."""
    band = coding_for(encoding, slm).passband
    truth = reference_field(cloud, slm, wavelength, passband=band)
    for tolerance in tolerances:
        made, expected = field_and_error(
            cloud, slm, wavelength, "curved", passband=band, tolerance=tolerance
        )
        error = relative_error(made, truth)
        assert error <= tolerance, tolerance
        assert expected is None or error < 3 * expected or error < 1e-6, tolerance


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4])
def test_points_that_only_graze_the_panel(tolerance: float) -> None:
    band = full_band(PANEL)
    x = PANEL.x()[-1] + 0.94 * 0.2 * reach(WAVELENGTH, band.fx_max)
    check(cloud_of(60, (3e-5, 1e-4, 1e-4), (x, 0, 0.2)), PANEL, tolerance)


def test_coherent_lattices() -> None:
    side = np.linspace(-4e-4, 4e-4, 18)
    positions = np.stack([*np.meshgrid(side, side), np.full((18, 18), 0.05)], -1).reshape(-1, 3)
    check(PointCloud(positions, np.ones(324), np.zeros(324)), PANEL, 1e-3, 1e-5)


def test_waves_that_all_but_cancel_are_exact_or_refused() -> None:
    one = cloud_of(40, (3e-4,) * 3, (0, 0, 0.1))
    both = PointCloud.concatenate(
        [one, PointCloud(one.positions, one.amplitude, one.phase + np.pi * (1 + 1e-7))]
    )
    check(both, PANEL, 1e-3)
    # By rays too: what is left is summed in double precision.
    truth = reference_field(both, PANEL, WAVELENGTH)
    assert relative_error(compute_field(both, PANEL, WAVELENGTH, "rt"), truth) < 1e-5
    with pytest.raises(ValueError, match="all but cancel"):
        curved.low_rank(both, PANEL, WAVELENGTH, Window.full(PANEL), full_band(PANEL))


def test_what_double_precision_leaves_of_opposite_waves_is_kept_or_refused() -> None:
    small, wavelength = SLM("s", 40, 30, 1e-3), 2e-6  # paths of thousands of wavelengths
    one = cloud_of(40, (3e-4,) * 3, (0, 0, 0.03))

    def made(turned: float) -> tuple[PointCloud, NDArray[np.complex64]]:
        against = PointCloud(one.positions, one.amplitude, one.phase + np.pi * (1 + turned))
        both = PointCloud.concatenate([one, against])
        given = both, small, wavelength, "curved"
        return both, compute_field(*given, footprint=None, tolerance=2e-6)

    both, field = made(3e-9)
    truth = reference_field(both, small, wavelength, footprint=None)
    assert relative_error(field, truth) < 1e-6
    with pytest.raises(ValueError, match=r"holds what is left to .*leave out points"):
        made(1e-12)
    # Where no footprint reaches there is nothing to keep.
    aside = PointCloud(one.positions + np.array([0.1, 0, 0]), one.amplitude, one.phase)
    dark = rounding_of(np.zeros((1, 2), complex), aside, np.zeros(2), np.zeros(1), 2e-6, (0.1, 0.1))
    assert dark == 0


def test_tables_in_single_precision_have_no_bias() -> None:
    cycles = np.random.default_rng(0).uniform(-9, 9, (200, 1000))
    cos, sin, _ = phasor_table(lambda some: cycles[some].copy(), cycles.shape, np.float32)
    assert abs(np.mean(cos - np.cos(2 * np.pi * cycles))) < 5e-9
    assert abs(np.mean(sin - np.sin(2 * np.pi * cycles))) < 5e-9


def test_a_wrong_factor_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    cloud = cloud_of(80, (5e-4,) * 3, (0, 0, 0.15))
    window, band = Window.full(PANEL), full_band(PANEL)
    made = curved.low_rank(cloud, PANEL, WAVELENGTH, window, band)
    plane = curved.plane_of(PANEL, WAVELENGTH, window, band)

    def seen() -> float:
        return verify.measured_error(made.factors, cloud, plane, 1e-3, 1e-3)

    assert seen() < 1e-3
    made.factors[0].real[:] *= np.float32(1.05)
    made.factors[0].imag[:] *= np.float32(1.05)
    assert seen() == pytest.approx(0.05, rel=0.15)


@cache
def cluster() -> tuple[PointCloud, NDArray[np.complex128]]:
    """Points and their true field."""
    cloud = cloud_of(300, (9e-4, 7e-4, 5e-4), (3e-4, 2e-4, 0.12))
    return cloud, reference_field(cloud, PANEL, WAVELENGTH)


@pytest.mark.parametrize("wrong", ["x", "y", "rounding", "dropped"])
def test_each_source_of_error_is_expected_where_it_dominates(wrong: str) -> None:
    """One axis planned for 3e-2, the other for 1e-6; then terms left out on purpose."""
    cloud, truth = cluster()
    window, band = Window.full(PANEL), full_band(PANEL)
    plane = curved.plane_of(PANEL, WAVELENGTH, window, band)
    reference = reference_of(bounding_box(cloud.positions), plane)
    fine = cluster_axes(cloud, reference, plane, 1e-6)
    coarse = cluster_axes(cloud, reference, plane, 3e-2)
    axes = {"x": (coarse[0], fine[1]), "y": (fine[0], coarse[1])}.get(wrong, fine)
    wave = Wave(reference, WAVELENGTH, plane.reach)
    real, imag = exact_baseband(cloud, *axes, wave)
    missed = predict.Remainder(None, 2e-3 if wrong == "dropped" else 0.0)
    if wrong == "dropped":
        noise = np.random.default_rng(0).normal(size=(2, *real.shape)).astype(np.float32)
        scale = 2e-3 * np.sqrt(np.mean(real**2 + imag**2) / 2)
        real, imag = real + scale * noise[0], imag + scale * noise[1]
    factor = curved.Factor(*axes, reference, real, imag)
    places = plane.x.places, plane.y.places
    budget = predict.budget_of(factor, cloud, places, wave, missed)
    field = curved.field_of([factor], PANEL, WAVELENGTH, window)
    error = relative_error(field, truth)
    if wrong == "rounding":
        assert error < budget.relative < 2e-6
    else:
        assert error / 2.5 < budget.relative < 2.5 * error
        assert error > 1e-3


@pytest.mark.parametrize("depth", [0.1, 0.2, 2.0])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-5, 1e-6])
def test_what_is_missed_at_the_end_of_the_light_is_expected(depth: float, tolerance: float) -> None:
    """A few columns there hold most of the error of points whose light ends on the panel."""
    slm = SLM("wide", 1400, 300, 4e-6)
    plane = curved.plane_of(slm, WAVELENGTH, Window.full(slm), full_band(slm))
    at = plane.x.first - depth * plane.reach[0] + 150 * slm.pixel_pitch
    cloud = cloud_of(30, (5e-6 * depth,) * 3, (at, 0.0, depth))
    reference = reference_of(bounding_box(cloud.positions), plane)
    axis = cluster_axes(cloud, reference, plane, tolerance)[0]
    along = waves_along(Wave(reference, WAVELENGTH, plane.reach), 0, cloud.positions.T)
    _, missed = predict.axis_powers(axis, plane.x.places, along)
    every = 0.0
    read = [(run, block) for run in axis.runs for block in axis.blocks_of(run)]
    for run, block in read:
        nodes, targets = axis.nodes[block.nodes], plane.x.places[block.targets]
        told, truth = along.waves(nodes), along.waves(targets)
        if run.tapered:
            told, truth = told * along.weights(nodes), truth * along.weights(targets)
        told = told if block.matrix is None else told @ block.matrix.T
        every += float(np.sum(np.abs(told - truth) ** 2))
    assert missed.sum() == pytest.approx(every, rel=0.8)


def test_points_that_shine_brighter_together_err_as_each_does() -> None:
    """A lattice of one phase is a hundred times brighter than one of any phases."""
    band = full_band(PANEL)
    plane = curved.plane_of(PANEL, WAVELENGTH, Window.full(PANEL), band)
    side = np.arange(40) * 1e-6
    places = np.stack([*np.meshgrid(side, side), np.full((40, 40), 0.02)], -1).reshape(-1, 3)
    phases = np.random.default_rng(0).uniform(0, 2 * np.pi, len(places))
    one, any_ = (
        curved.make_factor(PointCloud(places, np.ones(1600), phase), plane, 1e-2)[1]
        for phase in (np.zeros(1600), phases)
    )
    assert 0.5 < one.relative / any_.relative < 2


def test_the_exact_signal_is_the_fields_real_part_on_its_carrier() -> None:
    """Few points: the exact sum, whose carrier turns as `exp(+2πi·carrier·y)`."""
    cloud = cloud_of(3, (3e-4,) * 3, (2e-4, 3e-4, 0.15))
    slm, coding = SLM("s", 60, 50, 16e-6), coding_for("ssb", SLM("s", 60, 50, 16e-6))
    made = curved.signal(cloud, slm, WAVELENGTH, Window.full(slm), coding)
    truth = reference_field(cloud, slm, WAVELENGTH, passband=coding.passband)
    wanted = (truth * np.exp(2j * np.pi * coding.carrier * slm.y())[:, None]).real
    assert np.linalg.norm(made - wanted) < 1e-6 * np.linalg.norm(wanted)


@pytest.mark.parametrize("method", ["curved", "rt", "wrp", "nlut", "fresnel"])
def test_phases_of_any_size_and_amplitudes_in_range(method: str) -> None:
    cloud = cloud_of(5, (2e-4, 2e-4, 1e-4), (0, 0, 0.2))
    slm = SLM("s", 64, 48, 16e-6)
    plain = compute_field(cloud, slm, WAVELENGTH, method)
    turns = np.array([1e15, -3e16, 7e18, 1e22, 12.0])
    turned = np.arctan2(np.sin(turns), np.cos(turns))
    far = PointCloud(cloud.positions, cloud.amplitude, turns)
    near = PointCloud(cloud.positions, cloud.amplitude, turned)
    same = [compute_field(c, slm, WAVELENGTH, method) for c in (far, near)]
    assert relative_error(same[0], same[1]) < 1e-6
    for scale in (1e-12, 1e12):
        scaled = PointCloud(cloud.positions, cloud.amplitude * scale, cloud.phase)
        made = compute_field(scaled, slm, WAVELENGTH, method).astype(np.complex128) / scale
        assert relative_error(made, plain.astype(np.complex128)) < 1e-6
    for scale in (1e-45, 1e38, 1e200):
        with pytest.raises(ValueError, match=r"single precision holds .* scale the amplitudes"):
            beyond = PointCloud(cloud.positions, cloud.amplitude * scale, cloud.phase)
            compute_field(beyond, slm, WAVELENGTH, method)


def test_expected_power_is_the_mean_of_the_squared_weight() -> None:
    cloud = PointCloud(np.array([[1e-3, -4e-4, 0.06]]), np.array([2.0]), np.zeros(1))
    band = coding_for("ssb", PANEL).passband
    field = reference_field(cloud, PANEL, WAVELENGTH, passband=band)
    (power,) = expected_power(cloud, PANEL, WAVELENGTH, band)
    assert power == pytest.approx(np.mean(np.abs(field) ** 2), rel=0.03)


def test_coverage_counts_whole_pixels_to_the_edge() -> None:
    """The panel ends half a pixel past its outermost centres."""
    slm = SLM("s", 10, 8, 20e-6)
    z, far = 0.01, 0.01 * reach(WAVELENGTH, slm.nyquist)
    x = 5 * slm.pixel_pitch + far - 1.5 * slm.pixel_pitch  # 1.5 of 10 columns
    cloud = PointCloud(np.array([[x, 0, z]]), np.ones(1), np.zeros(1))
    assert 2 * far > 8 * slm.pixel_pitch  # all rows
    assert coverage(cloud, slm, WAVELENGTH, full_band(slm)) == pytest.approx([0.15])


def blas_threads() -> list[int]:
    return [pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"]


def test_blas_has_its_threads_again_whatever_is_raised() -> None:
    before = blas_threads()

    def fails(number: int) -> int:
        if number == 5:
            raise KeyError(number)
        return parallel.in_parallel(lambda n: n * n, range(number))[-1] if number else 0

    with pytest.raises(KeyError):
        parallel.in_parallel(fails, range(40))
    assert blas_threads() == before

    def below(n: int) -> int:
        return sum(parallel.in_parallel(lambda m: m, range(n)))

    assert parallel.in_parallel(below, range(5)) == [0, 0, 1, 3, 6]
    assert blas_threads() == before


def test_several_threads_at_once_get_what_one_gets() -> None:
    clouds = [cloud_of(60 + k, (4e-4,) * 3, (0, 0, 0.12 + 0.01 * k)) for k in range(4)]
    alone = [compute_field(c, PANEL, WAVELENGTH, "curved") for c in clouds]
    before, found = blas_threads(), [np.zeros(0)] * 4

    def work(k: int) -> None:
        for _ in range(2):
            found[k] = compute_field(clouds[k], PANEL, WAVELENGTH, "curved")

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for one, other in zip(alone, found, strict=True):
        assert np.array_equal(one, other)
    assert blas_threads() == before


def test_a_look_costs_little_of_a_frame() -> None:
    """Waves of the float64 truth against the points times pixels of the frame."""
    cloud = cloud_of(1200, (1.6e-3, 6e-4, 7e-4), (0, 0, 0.25))
    waves: list[int] = []
    exact = verify.field_at

    def counted(points: PointCloud, x: np.ndarray, *rest: object) -> np.ndarray:
        waves.append(len(points) * len(x))
        return exact(points, x, *rest)  # type: ignore[arg-type]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(verify, "field_at", counted)
        compute_field(cloud, LC_R_1080, WAVELENGTH, "curved", tolerance=1e-3)
    assert sum(waves) <= 2.5e5
    rows, columns = np.array([10, 600]), np.array([20, 900])
    x, y = LC_R_1080.x(columns), LC_R_1080.y(rows)
    band = full_band(LC_R_1080)
    limits = reach(WAVELENGTH, band.fx_max), reach(WAVELENGTH, band.fy_max)
    truth = reference_samples(cloud, LC_R_1080, WAVELENGTH, rows, columns)
    assert relative_error(exact(cloud, x, y, WAVELENGTH, limits), truth) < 1e-8


def test_clusters_that_overlap_are_looked_at_in_all_rows() -> None:
    """Eight clusters over the same rows share them once, not an eighth each."""
    cloud = cloud_of(60, (4e-4,) * 3, (0, 0, 0.12))
    plane = curved.plane_of(PANEL, WAVELENGTH, Window.full(PANEL), full_band(PANEL))
    factor, _ = curved.make_factor(cloud, plane, 1e-3)
    alone, many = (verify._picked([factor.axis_y] * n, np.random.default_rng(0)) for n in (1, 8))
    assert len(many[0]) == len(alone[0]) >= 20
    assert many[1].sum() == pytest.approx(alone[1].sum())


def test_clusters_that_cancel_each_other_round_as_what_they_are() -> None:
    cloud = cloud_of(80, (5e-4,) * 3, (0, 0, 0.15))
    window, band = Window.full(PANEL), full_band(PANEL)
    factors = curved.low_rank(cloud, PANEL, WAVELENGTH, window, band).factors
    less = [replace(f, real=-0.99 * f.real, imag=-0.99 * f.imag) for f in factors]
    plane = curved.plane_of(PANEL, WAVELENGTH, window, band)
    given = cloud, plane, 1e-3, 1e-3
    assert verify.look(factors, *given)[1] == pytest.approx(predict.ROUNDING)
    assert verify.look(factors + less, *given)[1] == pytest.approx(
        predict.ROUNDING * np.hypot(1, 0.99) / 0.01, rel=1e-3
    )


@pytest.mark.parametrize(
    ("slm", "wavelength", "depth", "tolerance"),
    [
        (SLM("column", 49, 180, 4.24e-6), 7.48e-7, 79.7, 4.6e-6),
        (SLM("thin", 33, 200, 1.28e-6), 5.1e-6, 12.2, 6e-4),
    ],
)
def test_deep_scenes_on_small_panels_are_not_cut_into_hundreds(
    slm: SLM, wavelength: float, depth: float, tolerance: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No short series fits them; wave by wave at the nodes is a fraction of a second."""
    random = np.random.default_rng(0)
    band = coding_for("real", slm).passband
    near = 0.2 * depth
    room = np.array([near * min(reach(wavelength, f), 0.5) for f in (band.fx_max, band.fy_max)])
    positions = np.column_stack(
        [random.uniform(-0.9, 0.9, (800, 2)) * room, random.uniform(near, 3 * depth, 800)]
    )
    positions[:, 2] = np.minimum(positions[:, 2], 190)
    monkeypatch.setattr(curved.baseband, "_MOST_LEAVES", 0)
    check(
        PointCloud(positions, np.ones(800), random.random(800)),
        slm,
        tolerance,
        wavelength=wavelength,
    )


def test_rays_in_single_precision_know_where_they_will_not_do() -> None:
    one = cloud_of(40, (3e-4,) * 3, (0, 0, 0.1))
    both = PointCloud.concatenate(
        [one, PointCloud(one.positions, one.amplitude, one.phase + np.pi * (1 + 1e-5))]
    )
    full, band = Window.full(PANEL), full_band(PANEL)
    made = rt.quick_field(one, PANEL, WAVELENGTH, full, band)
    assert made is not None
    assert relative_error(made, reference_field(one, PANEL, WAVELENGTH)) < 1e-5
    assert rt.quick_field(both, PANEL, WAVELENGTH, full, band) is None
    steep = PointCloud(one.positions * (1, 1, 0.01), one.amplitude, one.phase)
    assert rt.quick_field(steep, PANEL, WAVELENGTH, full, UNLIMITED) is None


def near_lattice(side: tuple[int, int], size: float, z: float) -> PointCloud:
    x, y = (np.linspace(-size / 2, size / 2, n) for n in side)
    places = np.stack([*np.meshgrid(x, y), np.full(side[::-1], z)], -1).reshape(-1, 3)
    return PointCloud(places, np.ones(len(places)), np.zeros(len(places)))


def test_points_of_small_footprints_are_summed_by_rays(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whose nodes would be as many as the pixels; at 1e-6 the rounding of rays dominates."""
    slm = SLM("panel", 200, 120, 16e-6)
    cloud = near_lattice((12, 8), 2e-3, 0.008)
    with monkeypatch.context() as patch:
        patch.setattr(curved, "low_rank", None)
        check(cloud, slm, 1e-6, 1e-3)
    # Waves that cancel are too few for single precision, and get the exact sum.
    against = PointCloud(cloud.positions, cloud.amplitude, cloud.phase + np.pi - 1e-6)
    check(PointCloud.concatenate([cloud, against]), slm, 1e-6, 1e-3)


def test_a_near_lattice_takes_seconds_at_the_tightest_tolerance() -> None:
    slm = SLM("panel", 1920, 1080, 8.1e-6)
    cloud = near_lattice((56, 46), 5e-3, 0.034)
    band = coding_for("ssb", slm).passband
    counts = curved.cost(cloud, slm, WAVELENGTH, Window.full(slm), band, tolerance=1e-6)
    assert STATED.seconds(counts) < 3
