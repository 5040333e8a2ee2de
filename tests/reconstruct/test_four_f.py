import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chrmc import SLM, PointCloud, reference_field
from chrmc.encoding import CODINGS, coding_for
from chrmc.response import GreyResponse
from display import encode
from reconstruct import Bench, Filter, FourF, Illumination, decode_field, four_f, four_f_field
from reconstruct.four_f_system import power

P, LAMBDA, Z = 8.1e-6, 532e-9, 0.03
SLM_ = SLM("small", 192, 160, P)


def field_of(positions, amplitude=None, phase=None, encoding="ssb", slm=SLM_):
    positions = np.atleast_2d(positions)
    n = len(positions)
    cloud = PointCloud(
        positions,
        np.ones(n) if amplitude is None else amplitude,
        np.zeros(n) if phase is None else phase,
    )
    band = coding_for(encoding, slm).passband
    return reference_field(cloud, slm, LAMBDA, passband=band)


def peak(image, slm=SLM_):
    row, column = np.unravel_index(np.argmax(image), image.shape)
    return slm.x(column), slm.y(row)


@pytest.mark.parametrize("encoding", ["ssb", "real"])
@pytest.mark.parametrize(
    "place", [(0.3e-3, 0.2e-3), (-0.3e-3, 0.2e-3), (0.3e-3, -0.2e-3), (-0.25e-3, -0.15e-3)]
)
def test_a_point_appears_upright_where_it_is(place, encoding):
    frame = encode(field_of([*place, Z], encoding=encoding), SLM_, encoding)
    image = four_f(frame, SLM_, LAMBDA, Z, encoding)
    assert image.dtype == np.float32 and image.shape == SLM_.shape
    x, y = peak(image)
    assert abs(x - place[0]) <= 0.51 * P and abs(y - place[1]) <= 0.51 * P


def test_the_other_half_plane_shows_it_on_the_other_side():
    """Passing f_y < 0 instead gives the conjugate wave: nothing at +z, the image at −z."""
    frame = encode(field_of([0.1e-3, 0.1e-3, Z]), SLM_)
    image = four_f(frame, SLM_, LAMBDA, Z)
    flip = np.ones((2, 1))
    flip[1] = 0  # f_y < 0 only
    lower = Bench(filter=Filter(half_plane=False, dc_block=10e-6, image=flip))
    system = FourF(SLM_, LAMBDA, bench=lower)
    # The carrier is on the other side, so it is put back twice before propagating.
    turned = np.conj(system.field(frame) * np.exp(4j * np.pi * SLM_.y()[:, None] / (4 * P)))
    assert np.abs(system.at(turned, Z)).max() == pytest.approx(np.sqrt(image.max()), rel=0.02)
    wrong = system.at(np.conj(turned).astype(np.complex64), Z)
    assert np.abs(wrong).max() < 0.1 * np.sqrt(image.max())


def test_a_dark_field_and_constant_frames_show_nothing():
    for grey in (0, 127, 255):
        frame = np.full(SLM_.shape, grey, dtype=np.uint8)
        for encoding in ("ssb", "real"):
            assert four_f(frame, SLM_, LAMBDA, Z, encoding).max() < 1e-9


@pytest.mark.parametrize("share", [0.2, 0.9])
def test_scale_gives_back_the_field(share):
    rng = np.random.default_rng(4)
    points = rng.uniform(-1, 1, (30, 3)) * [0.5e-3, 0.4e-3, 1e-3] + [0, 0, Z]
    field = field_of(points, rng.uniform(0.5, 1, 30), rng.uniform(0, 6, 30))
    scale = np.abs(field).max() / share
    frame = encode(field, SLM_, scale=scale)
    got = decode_field(frame, SLM_, scale=scale)
    band = np.abs(np.fft.fftfreq(160, P)) < 0.97 * SLM_.nyquist / 2
    want = np.fft.ifft(np.fft.fft(field, axis=0) * band[:, None], axis=0)
    mine = np.fft.ifft(np.fft.fft(got, axis=0) * band[:, None], axis=0)
    error = np.linalg.norm(mine - want) / np.linalg.norm(want)
    # Clipped where |U| > scale; else rounding to 255 levels and the wrap of a small panel's edge.
    assert error < (0.02 if share == 0.9 else 0.06)


def test_real_encoding_gives_field_and_twin():
    field = field_of([0, 0, Z], encoding="real")
    scale = np.abs(field).max()
    got = decode_field(encode(field, SLM_, "real", scale=scale), SLM_, "real", scale)
    assert np.abs(got.imag).max() < 1e-3 * scale
    signal = 2 * field.real
    assert np.linalg.norm(got.real - (signal - signal.mean())) < 0.02 * np.linalg.norm(signal)


def test_two_points_at_the_resolution_limit():
    """The x aperture is A = the panel's width: λz/A apart they part, at half of it they do not."""
    slm = SLM("wide", 240, 32, P)
    limit = LAMBDA * Z / (slm.width * P)
    for factor, parted in ((1.5, True), (0.5, False)):
        gap = factor * limit
        pair = [[-gap / 2, 0, Z], [gap / 2, 0, Z]]
        frame = encode(field_of(pair, phase=[0, np.pi / 2], slm=slm), slm)
        system = FourF(slm, LAMBDA)
        field = system.field(frame)
        from chrmc.optics.propagation import Patch
        from reconstruct.stack import focal_stack

        fine = Patch((0.0, 0.0), (1, 81), limit / 20)
        line = focal_stack(field, slm, LAMBDA, [Z], fine).intensity[0, 0]
        middle = line[40]
        assert (line.max() > 1.2 * middle) == parted


def test_a_grating_has_its_orders_where_and_as_bright_as_it_should():
    """Amplitude ½ + ½cos(2πx/Λ): orders 0, ±1 at 0, ±λf/Λ, energies ¼, 1/16, 1/16 per pixel."""
    period = 8
    column = 0.5 + 0.5 * np.cos(2 * np.pi * np.arange(192) / period)
    frame = np.tile(np.rint(255 * column).astype(np.uint8), (160, 1))
    system = FourF(SLM_, LAMBDA, "real", Bench(focal1=0.2))
    light = np.abs(system.fourier_plane(frame)) ** 2 / frame.size
    _, x = system.fourier_coordinates()
    assert light[0, 0] == pytest.approx(0.25, rel=0.02)
    at = LAMBDA * 0.2 / (period * P)
    for sign in (1, -1):
        order = np.argmin(np.abs(x - sign * at))
        assert x[order] == pytest.approx(sign * at)
        assert light[0, order] == pytest.approx(1 / 16, rel=0.02)
    light[0, [0, np.argmin(np.abs(x - at)), np.argmin(np.abs(x + at))]] = 0
    assert light.sum() < 1e-4


@pytest.mark.parametrize("fill", [0.25, 0.81])
def test_the_fill_factor_dims_orders_as_a_square_of_its_root_does(fill):
    """Order ±1 of period Λ passes fill·sinc(p·√fill/Λ) of the amplitude, order 0 fill."""
    period = 4
    column = np.where(np.arange(192) % period < 2, 255, 0).astype(np.uint8)
    frame = np.tile(column, (160, 1))
    plain, dim = (
        np.abs(FourF(SLM_, LAMBDA, "real", Bench(fill_factor=f)).fourier_plane(frame))
        for f in (None, fill)
    )
    assert dim[0, 0] / plain[0, 0] == pytest.approx(fill, rel=1e-4)
    order = 192 // period
    assert dim[0, order] / plain[0, order] == pytest.approx(
        fill * np.sinc(np.sqrt(fill) / period), rel=1e-4
    )


@pytest.mark.parametrize("magnification", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("tilt", [0.0, 0.02, -0.02])
def test_the_second_lens_casts_its_shadow_along_the_light(magnification, tilt):
    """Lens 2 stands focal2 before the image, where light of angle θ/M comes from θ·focal2/M
    aside; in the scene's scale the lit disc is centred θ·focal2/M² off the axis and 1/M as wide."""
    focal2 = magnification * 0.01
    bench = Bench(
        focal1=0.01, focal2=focal2, lens2=magnification * 0.5e-3, filter=Filter(dc_block=None),
        illumination=Illumination(tilt=(0.0, np.arcsin(tilt))),
    )  # fmt: skip
    frame = np.full(SLM_.shape, 128, dtype=np.uint8)
    light = np.abs(FourF(SLM_, LAMBDA, "real", bench).field(frame)) ** 2
    y, x = SLM_.y()[:, None], SLM_.x()[None, :] - tilt * focal2 / magnification**2
    inside, outside = (y**2 + x**2 < 0.2e-3**2), (y**2 + x**2 > 0.32e-3**2)
    assert light[inside].mean() > 20 * light[outside].mean()


@settings(max_examples=10, deadline=None)
@given(
    seed=st.integers(0, 1000),
    edges=st.booleans(),
    fill=st.sampled_from([None, 0.7]),
    waist=st.sampled_from([None, 0.5e-3]),
    aperture=st.sampled_from([None, 2e-3, (1e-3, 3e-3)]),
)
def test_energy_is_accounted_for(seed, edges, fill, waist, aperture):
    slm = SLM("tiny", 48, 40, P)
    frame = np.random.default_rng(seed).integers(0, 256, slm.shape, dtype=np.uint8)
    light = None if waist is None else Illumination(waist=waist, tilt=(0.01, -0.02))
    bench = Bench(
        edges=edges, fill_factor=fill, illumination=light, filter=Filter(aperture=aperture)
    )
    account = FourF(slm, LAMBDA, bench=bench).energy(frame)
    parts = account.absorbed + account.blocked_filter + account.blocked_lenses + account.image
    assert account.incident == pytest.approx(parts, rel=1e-5)
    assert min(account.absorbed, account.blocked_filter, account.image) >= 0
    assert abs(account.blocked_lenses) < 1e-4 * account.incident
    if fill is None and waist is None and not edges:
        lit = np.sum((frame / 255) ** 2)
        assert account.incident == frame.size
        assert account.absorbed == pytest.approx(frame.size - lit, rel=1e-4)


def test_image_energy_is_parsevals():
    frame = encode(field_of([0.1e-3, 0, Z]), SLM_)
    system = FourF(SLM_, LAMBDA)
    assert power(system.field(frame)) / 16 == pytest.approx(system.energy(frame).image, rel=1e-4)


def test_apertures_keep_what_lies_inside():
    frame = np.random.default_rng(0).integers(0, 256, SLM_.shape, dtype=np.uint8)
    for aperture, inside in (
        (3e-3, lambda y, x: y**2 + x**2 <= 1.5e-3**2),
        ((2e-3, 4e-3), lambda y, x: (abs(y) <= 1e-3) & (abs(x) <= 2e-3)),
    ):
        chosen = Filter(half_plane=False, dc_block=None, aperture=aperture)
        system = FourF(SLM_, LAMBDA, "real", Bench(filter=chosen))
        y, x = system.fourier_coordinates()
        want = inside(y[:, None], x[None, :])
        assert np.array_equal(system.transmission() > 0, want)
        assert np.array_equal(np.abs(np.fft.fft2(system.field(frame))) > 1e-2, want)


def test_an_opening_stands_where_the_light_is_unless_told():
    """On the carrier of a single sideband, λ·focal1/4p off the axis: nothing of the top is lost."""
    frame = encode(field_of([[0, 0.4e-3, Z], [0, -0.4e-3, Z]]), SLM_)
    open_, narrow = (
        four_f(frame, SLM_, LAMBDA, Z, bench=Bench(filter=Filter(aperture=size)))
        for size in (None, 4e-3)
    )
    top, bottom = (narrow[part].sum() / open_[part].sum() for part in (slice(80), slice(80, None)))
    assert top == pytest.approx(bottom, rel=0.02) and top > 0.3
    carrier = LAMBDA * 0.15 / (4 * P)
    for centre, want in ((None, carrier), ((0.0, 0.0), 0.0), ((1e-3, 0.0), 1e-3)):
        bench = Bench(filter=Filter(half_plane=True, dc_block=None, aperture=1e-3, centre=centre))
        y = FourF(SLM_, LAMBDA, bench=bench)
        lit = y.fourier_coordinates()[0][y.transmission().max(axis=1) > 0]
        assert lit.max() == pytest.approx(want + 0.5e-3, abs=6e-5)
    real = FourF(SLM_, LAMBDA, "real", Bench(filter=Filter(aperture=1e-3)))
    assert np.abs(real.fourier_coordinates()[0][real.transmission().max(axis=1) > 0]).max() < 5e-4


def test_a_users_filter_image_is_upright_in_frequency():
    """A quarter-plane picture passes f_y > 0, f_x > 0."""
    picture = np.zeros((2, 2))
    picture[1, 1] = 1
    bench = Bench(filter=Filter(half_plane=False, dc_block=None, image=picture))
    system = FourF(SLM_, LAMBDA, "real", bench)
    y, x = system.fourier_coordinates()
    assert np.array_equal(system.transmission() > 0, (y[:, None] >= 0) & (x[None, :] >= 0))


def test_a_narrow_aperture_blurs_across_only():
    frame = encode(field_of([0, 0, Z]), SLM_)
    sharp = four_f(frame, SLM_, LAMBDA, Z)
    slit = Bench(filter=Filter(aperture=(9e-3, 2e-3)))
    blurred = four_f(frame, SLM_, LAMBDA, Z, bench=slit)

    def width(image, axis):
        line = image.max(axis=axis)
        return np.count_nonzero(line > line.max() / 2)

    assert width(blurred, 0) > 1.8 * width(sharp, 0)
    assert abs(width(blurred, 1) - width(sharp, 1)) <= 1


def test_a_tilted_beam_moves_the_spectrum():
    """By f = sin(θ)/λ, which is focal1·sin θ in the Fourier plane."""
    theta = 6 * LAMBDA / (192 * P)
    frame = np.full(SLM_.shape, 255, dtype=np.uint8)
    beam = Illumination(tilt=(0.0, np.arcsin(theta)))
    system = FourF(SLM_, LAMBDA, "real", Bench(illumination=beam))
    light = np.abs(system.fourier_plane(frame)) ** 2
    row, column = np.unravel_index(light.argmax(), light.shape)
    assert (row, column) == (0, 6)
    assert system.fourier_coordinates()[1][6] == pytest.approx(0.15 * theta)


def test_a_curved_panel_moves_the_focus():
    """A quadratic phase error is a thin lens: 1/z' = 1/z + 1/f."""
    focal = 0.6
    y, x = SLM_.y()[:, None], SLM_.x()[None, :]
    # The error's own wave, as diverging from z = focal, adds to the points' divergence.
    error = np.pi / (LAMBDA * focal) * (x**2 + y**2)
    frame = encode(field_of([0, 0, Z]), SLM_)
    system = FourF(SLM_, LAMBDA, bench=Bench(aberration=error, filter=Filter(dc_block=None)))
    field = system.field(frame)
    depths = np.linspace(0.026, 0.032, 121)
    # On the axis through the point only: what the error does to bias and twin stays away.
    curve = [np.abs(system.at(field, d)[70:90, 86:106]).max() for d in depths]
    assert depths[np.argmax(curve)] == pytest.approx(1 / (1 / Z + 1 / focal), abs=2e-4)


def test_lens_apertures_vignette():
    frame = encode(field_of([[0.4e-3, 0.3e-3, Z], [-0.4e-3, -0.3e-3, Z]]), SLM_)
    wide = FourF(SLM_, LAMBDA, bench=Bench(focal1=0.02, focal2=0.02, lens1=0.1, lens2=0.1))
    plain = FourF(SLM_, LAMBDA, bench=Bench(focal1=0.02, focal2=0.02))
    narrow = FourF(SLM_, LAMBDA, bench=Bench(focal1=0.02, focal2=0.02, lens1=0.6e-3))
    late = FourF(SLM_, LAMBDA, bench=Bench(focal1=0.02, focal2=0.02, lens2=0.6e-3))
    everything = plain.energy(frame).image
    assert wide.energy(frame).image == pytest.approx(everything, rel=0.01)
    image, want = (np.abs(s.at(s.field(frame), Z)) ** 2 for s in (wide, plain))
    assert np.abs(image - want).max() < 0.03 * want.max()
    # Nearly collimated light: what passes is the pupil's share of the panel.
    account = narrow.energy(frame)
    share = np.pi * 0.3e-3**2 / (192 * 160 * P**2)
    lit = account.incident - account.absorbed
    assert account.blocked_lenses == pytest.approx((1 - share) * lit, rel=0.05)
    account = late.energy(frame)
    assert account.blocked_lenses > 0.1 * everything
    assert account.image < everything


def test_edges_light_up_the_panels_border():
    """With darkness around, the bias is cut off sharply, and its border shows."""
    frame = np.full(SLM_.shape, 128, dtype=np.uint8)
    system = FourF(SLM_, LAMBDA, bench=Bench(edges=True))
    assert system.fourier_plane(frame).shape == (320, 384)
    image = np.abs(system.field(frame)) ** 2
    assert image[:6].mean() > 5 * image[70:90].mean() > 0


def test_grey_response_is_undone():
    response = GreyResponse.from_gamma(1.4)
    frame = encode(field_of([0.1e-3, 0.1e-3, Z]), SLM_, response=response)
    plain = encode(field_of([0.1e-3, 0.1e-3, Z]), SLM_)
    want = four_f(plain, SLM_, LAMBDA, Z)
    got = four_f(frame, SLM_, LAMBDA, Z, response=response)
    assert np.abs(got - want).max() < 0.02 * want.max()


def test_field_then_depths_is_four_f():
    frame = encode(field_of([0.1e-3, 0.1e-3, Z]), SLM_)
    system = FourF(SLM_, LAMBDA)
    field = system.field(frame)
    assert np.array_equal(field, four_f_field(frame, SLM_, LAMBDA))
    for depth in (Z, 0.02, Z):
        want = four_f(frame, SLM_, LAMBDA, depth)
        assert np.allclose(np.abs(system.at(field, depth)) ** 2, want, atol=1e-4 * want.max())


def test_bad_input_is_told():
    frame = np.zeros(SLM_.shape, dtype=np.uint8)
    for distance in (0, -0.1, np.nan, np.inf):
        with pytest.raises(ValueError, match="distance"):
            four_f(frame, SLM_, LAMBDA, distance)
    with pytest.raises(ValueError, match="rows, columns"):
        four_f(frame[:-1], SLM_, LAMBDA, Z)
    with pytest.raises(ValueError, match="8-bit"):
        four_f(frame.astype(float), SLM_, LAMBDA, Z)
    with pytest.raises(ValueError, match="encoding"):
        four_f(frame, SLM_, LAMBDA, Z, "dsb")
    with pytest.raises(ValueError, match="wavelength"):
        four_f(frame, SLM_, -1.0, Z)
    with pytest.raises(ValueError, match="aberration"):
        four_f(frame, SLM_, LAMBDA, Z, bench=Bench(aberration=np.zeros((3, 3))))
    with pytest.raises(ValueError, match="focal1"):
        Bench(focal1=0)
    with pytest.raises(ValueError, match="aperture"):
        Filter(aperture=-1.0)
    with pytest.raises(ValueError, match="dc_block"):
        Filter(dc_block=-1.0)
    with pytest.raises(ValueError, match="waist"):
        Illumination(waist=0.0)


@pytest.mark.parametrize("encoding", [n for n in CODINGS if coding_for(n, SLM_).aperture])
def test_an_encodings_aperture_ends_both_ways(encoding):
    """What the encoding occupies passes, and nothing beyond it, across and down."""
    system = FourF(SLM_, LAMBDA, encoding)
    y, x = system.fourier_coordinates()
    passed = system.transmission()
    unit, edge = LAMBDA * system.bench.focal1, system.coding.aperture
    across, down = np.abs(x) < unit * edge.fx_max, np.abs(y) < unit * edge.fy_max
    assert not passed[:, ~across].any() and not passed[~down].any()
    assert passed[np.ix_(down, across)].mean() > 0.4


def test_a_mirrored_frame_gives_the_mirrored_wave_through_small_lenses():
    """Light that leaves the panel to the left meets the same pupil as light to the right."""
    slm = SLM("tiny", 64, 48, P)
    frame = np.random.default_rng(2).integers(0, 256, slm.shape, dtype=np.uint8)
    bench = Bench(
        focal1=0.01, focal2=0.01, lens1=0.9e-3, lens2=0.8e-3, filter=Filter(dc_block=None)
    )
    system = FourF(slm, LAMBDA, "real", bench)
    wave = np.abs(system.field(frame))
    for flip in (np.s_[:, ::-1], np.s_[::-1]):
        mirrored = np.abs(system.field(np.ascontiguousarray(frame[flip])))
        assert np.linalg.norm(mirrored[flip] - wave) < 1e-4 * np.linalg.norm(wave)


def test_a_scale_must_be_positive_and_an_account_is_a_share():
    for scale in (0.0, -1.0):
        with pytest.raises(ValueError, match="scale"):
            FourF(SLM_, LAMBDA, scale=scale)
    frame = np.random.default_rng(0).integers(0, 256, SLM_.shape, dtype=np.uint8)
    account = FourF(SLM_, LAMBDA).energy(frame)
    assert account.efficiency == pytest.approx(account.image / account.incident)
    assert 0 < account.efficiency < 1


def test_a_panel_knows_its_fill_factor_and_a_bench_may_say_another():
    frame = np.random.default_rng(1).integers(0, 256, SLM_.shape, dtype=np.uint8)
    sparse = SLM("sparse", 192, 160, P, fill_factor=0.64)

    def wave(slm, fill):
        return FourF(slm, LAMBDA, bench=Bench(fill_factor=fill)).fourier_plane(frame)

    whole, dim = wave(SLM_, None), wave(SLM_, 0.64)
    assert dim[0, 0] == pytest.approx(0.64 * whole[0, 0], rel=1e-5)
    assert np.array_equal(wave(sparse, None), dim)
    assert np.array_equal(wave(sparse, 0.25), wave(SLM_, 0.25))
    full = SLM("full", 192, 160, P, fill_factor=1.0)
    assert np.array_equal(wave(full, None), whole)


def test_what_a_decoded_field_occupies():
    nyquist = SLM_.nyquist
    open_ = Bench(filter=Filter(aperture=3e-3))
    either = Bench(filter=Filter(half_plane=False))
    for encoding, bench, want in (
        ("ssb", None, (nyquist, nyquist / 2)),
        ("ssb", either, (nyquist, nyquist)),
        ("real", None, (nyquist, nyquist)),
        ("real", Bench(filter=Filter(half_plane=True)), (nyquist, nyquist)),
        ("double-phase", None, (nyquist / 2, nyquist / 2)),
        ("double-phase", open_, (nyquist, nyquist)),
    ):
        band = FourF(SLM_, LAMBDA, encoding, bench).band
        assert (band.fx_max, band.fy_max) == want, (encoding, bench)
