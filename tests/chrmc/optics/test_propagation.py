import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import fresnel

from chrmc import SLM, PointCloud, reference_field
from chrmc.optics.passband import Passband
from chrmc.optics.propagation import (
    Patch,
    Propagator,
    cycles_to_phasor,
    padded_shape,
    propagate,
    spread,
    transfer_function,
)

P, LAMBDA = 8.1e-6, 532e-9


def relative(a, b):
    return np.linalg.norm(a - b) / np.linalg.norm(b)


def window(n, share=0.25):
    """Smooth from 0 to 1 over the outer share, so that no edge rings."""
    u = np.clip(np.minimum(np.arange(n) + 0.5, n - np.arange(n) - 0.5) / (share * n), 0, 1)
    return np.sin(np.pi / 2 * u) ** 2


def smooth_field(shape, seed=0, band=0.3):
    """Random, inside the window, with no frequency above `band` times Nyquist before windowing."""
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
    f = np.hypot(np.fft.fftfreq(shape[0])[:, None], np.fft.fftfreq(shape[1])[None, :])
    limited = np.fft.ifft2(np.fft.fft2(noise) * (f < band / 2))
    return limited * window(shape[0])[:, None] * window(shape[1])


def axes(shape, pitch=P):
    y, x = ((np.arange(n) - (n - 1) / 2) * pitch for n in shape)
    return y[:, None], x[None, :]


def test_phasor_keeps_phase_of_millions_of_turns():
    cycles = np.array([0.25, 4e5 + 0.25, -3e6 - 0.125, 7e6])
    want = np.array([1j, 1j, np.exp(-0.25j * np.pi), 1])
    assert np.abs(cycles_to_phasor(cycles) - want).max() < 1e-6


@pytest.mark.parametrize("shape", [(12, 15), (13, 16), (1, 8), (2, 3)])
@pytest.mark.parametrize("shift", [(0.0, 0.0), (3e-5, -8e-5)])
@pytest.mark.parametrize("distance", [-0.02, 0.001, 0.0])
def test_transfer_function_is_the_formula_where_it_passes(shape, shift, distance):
    h = transfer_function(shape, P, LAMBDA, distance, shift)
    fy, fx = (np.fft.fftfreq(n, P) for n in shape)
    fy, fx = fy[:, None], fx[None, :]
    kz = np.sqrt(1 / LAMBDA**2 - fy**2 - fx**2)
    want = np.exp(2j * np.pi * ((distance * kz) % 1 + fy * shift[0] + fx * shift[1]))
    walk_y, walk_x = shift[0] - distance * fy / kz, shift[1] - distance * fx / kz
    margin_y, margin_x = (0.5 * n * P for n in shape)
    passes = (np.abs(walk_y) <= margin_y) & (np.abs(walk_x) <= margin_x)
    assert np.abs(h - want * passes).max() < 1e-4


def test_evanescent_waves_do_not_pass():
    fine = 0.2 * LAMBDA
    h = transfer_function((64, 64), fine, LAMBDA, 1e-6)
    f = np.hypot(*np.meshgrid(np.fft.fftfreq(64, fine), np.fft.fftfreq(64, fine)))
    assert not h[f > 1 / LAMBDA].any() and h[f == 0] != 0


def test_plane_wave_gains_its_own_phase():
    """A plane wave comes back as itself times exp(2πi·d·cos θ/λ)."""
    shape, distance = (64, 64), 1e-3
    f = np.array([5, -9]) / (64 * P)
    y, x = axes(shape)
    wave = np.exp(2j * np.pi * (f[0] * y + f[1] * x))
    h = transfer_function(shape, P, LAMBDA, distance)
    moved = propagate(wave, P, LAMBDA, distance, transfer=h)
    turn = distance * np.sqrt(1 / LAMBDA**2 - f @ f)
    assert relative(moved, wave * np.exp(2j * np.pi * (turn % 1))) < 1e-5


def test_agrees_with_a_direct_rayleigh_sommerfeld_sum():
    """U(q) = Σ U₀·p²·d/(2πr²)·(1/r − ik)·exp(ikr), the first Rayleigh–Sommerfeld integral."""
    shape, distance, k = (40, 48), 12e-3, 2 * np.pi / LAMBDA
    field = smooth_field(shape, 3)
    y, x = axes(shape)
    want = np.zeros(shape, dtype=complex)
    for row in range(shape[0]):
        dy = y[row] - y  # (H, 1)
        dx = x.T[:, :, None] - x[None]  # (W, 1, W)
        r = np.sqrt(dy[None] ** 2 + dx**2 + distance**2)
        kernel = distance / (2 * np.pi * r**2) * (1 / r - 1j * k) * np.exp(1j * k * r)
        want[row] = np.sum(field[None] * kernel, axis=(1, 2)) * P**2
    assert relative(propagate(field, P, LAMBDA, distance), want) < 2e-3


def test_points_shine_from_where_they_stand():
    """Going on by d, a spherical wave from z is the one from z + d; the sign of everything."""
    slm = SLM("small", 192, 160, P)
    here = PointCloud([[60e-6, -40e-6, 0.02]], [1.0], [0.3])
    there = PointCloud([[60e-6, -40e-6, 0.021]], [1.0], [0.3])
    soft = window(160)[:, None] * window(192)
    field = reference_field(here, slm, LAMBDA, footprint=None) * soft
    moved = propagate(field, P, LAMBDA, 0.001)[40:-40, 48:-48]
    want = reference_field(there, slm, LAMBDA, footprint=None)[40:-40, 48:-48]
    assert abs(np.vdot(want, moved)) / np.vdot(want, want).real == pytest.approx(1, abs=0.02)
    assert abs(np.angle(np.vdot(want, moved))) < 0.02


@pytest.mark.parametrize("place", [(60e-6, -40e-6), (-70e-6, 30e-6)])
def test_back_propagation_focuses_points_where_they_are(place):
    slm = SLM("small", 128, 96, P)
    cloud = PointCloud([[*place, 0.015]], [1.0], [0.0])
    image = np.abs(propagate(reference_field(cloud, slm, LAMBDA), P, LAMBDA, -0.015))
    row, column = np.unravel_index(image.argmax(), image.shape)
    assert abs(slm.x(column) - place[0]) <= P / 2 + 1e-12
    assert abs(slm.y(row) - place[1]) <= P / 2 + 1e-12


def test_there_and_back_is_the_field():
    field = smooth_field((96, 128))
    back = propagate(propagate(field, P, LAMBDA, 2e-4), P, LAMBDA, -2e-4)
    assert relative(back, field) < 1e-4


@pytest.mark.parametrize("share", [0.2, 0.45, 0.6])
def test_there_and_back_on_samples_finer_than_half_a_wavelength(share):
    """Where the finest samples hold no travelling wave, of whose slope there is none."""
    line = np.exp(-((np.arange(96) - 47.5) ** 2) / 200)
    field = line[:, None] * line
    away = propagate(field, share * LAMBDA, LAMBDA, 2e-6)
    assert relative(propagate(away, share * LAMBDA, LAMBDA, -2e-6), field) < 1e-4
    assert relative(away, field) > 0.1


def test_light_walks_sideways_by_the_tangent_of_its_angle():
    for sine in (0.03, 0.6, 0.8):
        walk = 2e-3 * sine / np.cos(np.arcsin(sine))
        assert spread(LAMBDA, sine / LAMBDA, 2e-3) == pytest.approx(walk)
        assert spread(LAMBDA, sine / LAMBDA, -2e-3) == pytest.approx(walk)
    assert 2e-3 < spread(LAMBDA, 1.5 / LAMBDA, 2e-3) < 1  # no wave goes there


def test_energy_is_kept():
    """Parseval: a field that stays in the window keeps Σ|U|²."""
    field = smooth_field((128, 128), 1)
    moved = propagate(field, P, LAMBDA, -2e-4)
    assert np.sum(np.abs(moved) ** 2) == pytest.approx(np.sum(np.abs(field) ** 2), rel=1e-4)


def test_gaussian_beam_spreads_as_it_should():
    """w(z) = w₀·√(1 + (λz/πw₀²)²)."""
    w0, z, shape = 60e-6, 0.02, (256, 256)
    y, x = axes(shape)
    beam = np.exp(-(x**2 + y**2) / w0**2)
    image = np.abs(propagate(beam, P, LAMBDA, z)) ** 2
    variance = np.sum(image * x**2) / image.sum()
    assert 2 * np.sqrt(variance) == pytest.approx(
        w0 * np.hypot(1, LAMBDA * z / (np.pi * w0**2)), rel=1e-3
    )


def test_lens_makes_a_focus():
    """A converging wave from a square pupil of side A focuses to sinc²; first zero at λf/A."""
    n, focal = 192, 0.04
    y, x = axes((n, n))
    pupil = np.exp(-1j * np.pi / LAMBDA / focal * (x**2 + y**2))
    side = n * P
    fine = Patch((0.0, 0.0), (1, 401), LAMBDA * focal / side / 100)
    line = np.abs(Propagator((n, n), P, LAMBDA, focal, fine)(pupil, focal)[0])
    u = np.arange(-200, 201) / 100
    assert relative(line / line.max(), np.abs(np.sinc(u))) < 0.02


def test_knife_edge_is_a_fresnel_integral():
    """Intensity behind a straight edge: ½[(C + ½)² + (S + ½)²], a quarter at the shadow's edge."""
    n, z = 1024, 0.02
    x = (np.arange(n) - (n - 1) / 2) * P
    # Both ends of the half plane fade slowly; only the edge in the middle is sharp.
    screen = (x > 0) * np.clip((x.max() - x) / (0.4 * x.max()), 0, 1) ** 2
    rows = 8
    field = np.tile(screen, (rows, 1)).astype(complex)
    h = transfer_function((rows, 2 * n), P, LAMBDA, z)
    image = np.abs(propagate(field, P, LAMBDA, z, transfer=h)[0]) ** 2
    s, c = fresnel(x * np.sqrt(2 / (LAMBDA * z)))
    want = 0.5 * ((c + 0.5) ** 2 + (s + 0.5) ** 2)
    near = np.abs(x) < 0.1e-3
    # The far, faded end still sends a little light.
    assert (
        np.abs(image / np.clip((x.max() - x) / (0.4 * x.max()), 0, 1).max() - want)[near].max()
        < 0.08
    )


@settings(max_examples=20, deadline=None)
@given(
    row=st.integers(0, 60),
    column=st.integers(0, 80),
    rows=st.integers(1, 36),
    columns=st.integers(1, 48),
    distance=st.floats(-6e-3, 6e-3),
)
def test_a_patch_is_a_part_of_the_plane(row, column, rows, columns, distance):
    shape = (96, 128)
    field = smooth_field(shape, 5)
    big = np.zeros((4 * 96, 4 * 128), dtype=complex)
    big[:96, :128] = field
    h = transfer_function(big.shape, P, LAMBDA, distance)
    whole = np.fft.ifft2(np.fft.fft2(big) * h)[:96, :128]
    centre = ((row + (rows - 1) / 2 - 47.5) * P, (column + (columns - 1) / 2 - 63.5) * P)
    part = Propagator(shape, P, LAMBDA, distance, Patch(centre, (rows, columns), P))(
        field, distance
    )
    scale = np.sqrt(np.mean(np.abs(field) ** 2))
    want = whole[row : row + rows, column : column + columns]
    assert np.abs(part - want).max() < 3e-3 * scale


@pytest.mark.parametrize("ratio", [0.5, 0.37, 2.0, 3.3])
def test_other_pitches_sample_the_same_field(ratio):
    """Finer or coarser samples, taken where two grids meet, against the band-limited sum."""
    shape, distance = (64, 72), -2e-3
    field = smooth_field(shape, 6)
    patch = Patch((5e-5, -3e-5), (9, 11), ratio * P)
    got = Propagator(shape, P, LAMBDA, distance, patch)(field, distance)
    plane = propagate(field, P, LAMBDA, distance).astype(complex)
    y, x = patch.coordinates()
    rows = np.sinc(y[:, None] / P - (np.arange(64) - 31.5))
    columns = np.sinc(x[:, None] / P - (np.arange(72) - 35.5))
    assert relative(got, rows @ plane @ columns.T) < 5e-3


def test_a_small_patch_runs_on_a_small_grid():
    small = Propagator((1200, 1920), P, LAMBDA, 1e-3, Patch((0, 0), (50, 60), P))
    far = Propagator((1200, 1920), P, LAMBDA, 0.25, Patch((0, 0), (50, 60), P))
    assert max(small.grid) < 250
    assert far.grid[0] * far.grid[1] < 0.5 * np.prod(padded_shape((1200, 1920), P, LAMBDA, 0.25))


def test_kernels_are_kept_per_distance():
    made = Propagator((64, 64), P, LAMBDA, 5e-3, keep=2)
    first = made.transfer(-4e-3)
    assert made.transfer(-4e-3) is first
    made.transfer(-3e-3)
    made.transfer(-2e-3)
    assert made.transfer(-4e-3) is not first
    assert np.array_equal(made.transfer(-4e-3), first)


def test_band_limits_what_passes():
    f = 0.4 / P
    h = transfer_function((64, 64), P, LAMBDA, 1e-3, band=Passband(fx_max=f, fy_max=0.2 / P))
    fy = np.abs(np.fft.fftfreq(64, P))
    assert not h[fy > 0.2 / P].any() and not h[:, fy > f].any()
    assert h[np.ix_(fy <= 0.2 / P, fy <= f)].all()


def test_too_long_a_distance_is_refused():
    made = Propagator((32, 32), P, LAMBDA, 1e-3)
    with pytest.raises(ValueError, match="beyond"):
        made(np.ones((32, 32), dtype=complex), 2e-3)
    with pytest.raises(ValueError, match="made for"):
        made(np.ones((32, 33), dtype=complex), 1e-3)
    with pytest.raises(ValueError, match="pitch"):
        Patch((0, 0), (3, 3), 0.0)


def test_a_narrower_band_runs_on_a_smaller_grid_along_its_own_axis():
    shape, nyquist = (400, 400), 0.5 / P
    whole = Propagator(shape, P, LAMBDA, 0.05).grid
    half = Propagator(shape, P, LAMBDA, 0.05, band=Passband(nyquist, nyquist / 2)).grid
    assert half[0] < whole[0] and half[1] == whole[1]
    half = Propagator(shape, P, LAMBDA, 0.05, band=Passband(nyquist / 2, nyquist)).grid
    assert half[0] == whole[0] and half[1] < whole[1]
    # What lies beyond Nyquist is not in the samples.
    assert Propagator(shape, P, LAMBDA, 0.05, band=Passband(9 * nyquist, 9 * nyquist)).grid == whole


@pytest.mark.parametrize("at", [0, -1500, 1500])
def test_what_is_left_out_of_the_input_is_cut_softly(at):
    """A long bright line, of which a patch needs a part: no edge of the cut shows in it."""
    shape, distance = (3, 4096), 4e-3
    wave = np.exp(2j * np.pi * 0.1 * np.arange(4096)) * window(4096, 0.05)
    field = np.tile(wave, (3, 1))
    small = Propagator(shape, P, LAMBDA, distance, Patch((0.0, at * P), (3, 64), P))
    assert small.grid[1] < 1000
    want = Propagator(shape, P, LAMBDA, distance)(field, distance)
    assert relative(small(field, distance), want[:, 2016 + at : 2080 + at]) < 1e-3


def test_grids_that_memory_cannot_hold_are_refused_by_their_area():
    with pytest.raises(ValueError, match="too many for memory"):
        Propagator((9000, 9000), P, LAMBDA, 5.0)
    assert max(Propagator((40_000, 4), P, LAMBDA, 0.1).grid) > 40_000
