"""What a CGH method is: one file, one line, and every part of the house knows it."""

from pathlib import Path

import numpy as np
import pytest

import chrmc
from chrmc import SLM, WAVELENGTH, PointCloud, compute_field
from chrmc.bench import tradeoff
from chrmc.cgh import METHODS, method_named
from chrmc.compensation import chosen
from chrmc.encoding import coding_for
from chrmc.generation.group import grey_levels
from chrmc.generation.recipe import Recipe
from chrmc.scene.load import load_scene

PANEL = SLM("small", 320, 200, 40e-6)

FILE = '''
"""A quick method: half the light, which it knows."""
import numpy as np
from chrmc.cgh.method import CGHMethod
from chrmc.cgh.rt import field as exact

def field(cloud, slm, wavelength, window, passband, *, share=0.5, cache=None):
    if cache is not None:
        cache.append(len(cloud))
    return share * exact(cloud, slm, wavelength, window, passband)

def field_and_error(cloud, slm, wavelength, window, passband, *, share=0.5, cache=None):
    return field(cloud, slm, wavelength, window, passband, share=share, cache=cache), 1 - share

def signal(cloud, slm, wavelength, window, coding, *, share=0.5, cache=None):
    turn = np.exp(2j * np.pi * coding.carrier * slm.y(window.rows))[:, None]
    made = field(cloud, slm, wavelength, window, coding.passband, share=share, cache=cache)
    return (made * turn).real.astype(np.float32)

def signal_and_error(cloud, slm, wavelength, window, coding, **options):
    return signal(cloud, slm, wavelength, window, coding, **options), 1 - options.get("share", 0.5)

METHOD = CGHMethod(
    field, signal, field_and_error, signal_and_error, new_cache=list,
    settings=({"share": 0.5}, {"share": 0.9}),
)
'''


@pytest.fixture
def half(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "half_the_light.py").write_text(FILE)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setitem(METHODS, "half", "half_the_light")
    return "half"


def test_a_new_method_is_one_file_and_one_line(half: str) -> None:
    scene = load_scene("car-house")
    exact = compute_field(scene.frame(1).cloud, PANEL, WAVELENGTH, "rt")
    np.testing.assert_allclose(
        compute_field(scene.frame(1).cloud, PANEL, WAVELENGTH, half), exact / 2, rtol=1e-6
    )
    cache: list[int] = []
    frames = list(
        chrmc.video(
            scene,
            PANEL,
            cgh=half,
            coding="ssb",
            frames=(1, 2),
            share=0.9,
            cache=cache,
            compensation="none",
        )
    )
    assert [len(frame.cloud) for frame in frames] == [len(scene.frame(n).cloud) for n in (1, 2)]
    for frame in frames:
        assert frame.signal is not None and "field" not in vars(frame)
        assert frame.record.error_predicted == pytest.approx(0.1)
        wanted = frame.field * np.exp(2j * np.pi * PANEL.nyquist / 2 * PANEL.y())[:, None]
        np.testing.assert_allclose(frame.signal, wanted.real, atol=1e-5 * np.abs(wanted).max())
    assert len(cache) == 4  # the same one for the whole video


def test_a_new_method_reaches_the_stored_record_and_the_bench(half: str) -> None:
    scene = load_scene("car-house")
    recipe = Recipe(scene, PANEL, cgh=half, check_pixels=0)
    for frame in recipe.video(1, 1):
        grey_levels(frame, recipe, 1.0)
        assert frame.record.error_predicted == 0.5
    optics = tradeoff.Optics(PANEL, WAVELENGTH, coding_for("real", PANEL))
    entries = tradeoff.cgh_entries("ten", tradeoff.synthetic(10, PANEL, 1), optics)
    own = [e for e in entries if e.method == half]
    assert [e.label for e in own] == ["half share 0.5", "half share 0.9"]
    assert [e.predicted for e in own] == pytest.approx([0.5, 0.1])
    assert [e.error for e in own] == pytest.approx([0.5, 0.1], rel=1e-3)


def test_a_plain_function_is_a_method_and_has_no_more_than_its_field() -> None:
    def dark(cloud, slm, wavelength, window, passband, *, level=0.0):  # type: ignore[no-untyped-def]
        return np.full(window.shape, level, dtype=np.complex64)

    cloud = PointCloud(np.array([[0, 0, 0.2]]), np.ones(1), np.zeros(1))
    assert compute_field(cloud, PANEL, WAVELENGTH, dark, level=2.0)[3, 4] == 2.0
    (frame,) = chrmc.video(
        load_scene("car-house"), PANEL, cgh=dark, coding="ssb", frames=(1, 1), compensation="none"
    )
    assert frame.signal is None and not frame.field.any()
    assert frame.record.error_predicted is None
    with pytest.raises(ValueError, match="CGH method dark has no option 'tolerance'"):
        compute_field(cloud, PANEL, WAVELENGTH, dark, tolerance=1e-3)


@pytest.mark.parametrize(
    ("method", "option", "words"),
    [
        (
            "rt",
            "tolerance",
            "rt has no option .tolerance.; it takes none; curved has it",
        ),
        ("curved", "cache", "it takes tolerance; wrp, nlut, nlut-1d have it"),
        ("wrp", "sharpness", "it takes planes, guard, cache$"),
    ],
)
def test_an_option_that_others_have_is_answered_with_their_names(
    method: str, option: str, words: str
) -> None:
    cloud = PointCloud(np.array([[0, 0, 0.2]]), np.ones(1), np.zeros(1))
    with pytest.raises(ValueError, match=words):
        compute_field(cloud, PANEL, WAVELENGTH, method, **{option: 1})


def test_video_methods_answer_likewise() -> None:
    scene = load_scene("car-house")
    said = "'rekey_every'; it takes tolerance, reuse; ch-rmc-paper has it"
    with pytest.raises(ValueError, match=said):
        chrmc.video(scene, PANEL, cgh="curved", compensation="ch-rmc-object", rekey_every=3)
    said = "none with rt has no option 'tolerance'; .*; ch-rmc-object, cgh curved have it"
    with pytest.raises(ValueError, match=said):
        chosen("rt", "none", options={"tolerance": 1e-3})


def test_every_registered_method_says_what_it_is() -> None:
    for name in METHODS:
        method = method_named(name)
        assert method.name == name
        assert all(method.takes(option) for setting in method.settings for option in setting)
        assert (method.new_cache is not None) == method.takes("cache")


def test_both_surfaces_are_names_and_ch_rmc_stays_for_either() -> None:
    scene = load_scene("car-house")

    def first(compensation: str, **options: object) -> np.ndarray:
        frame = next(chrmc.video(scene, PANEL, cgh="curved", compensation=compensation, **options))
        return np.asarray(frame.field)

    exact = first("ch-rmc-object")
    assert np.array_equal(first("ch-rmc"), exact)
    assert np.array_equal(first("ch-rmc", surface="object"), exact)
    paper = first("ch-rmc-paper")
    assert np.array_equal(first("ch-rmc", surface="paper"), paper)
    with pytest.raises(ValueError, match="unknown surface 'flat': choose one of object, paper"):
        first("ch-rmc", surface="flat")


def test_an_option_of_neither_method_is_answered_with_those_of_both() -> None:
    with pytest.raises(ValueError, match=r"radus.*mean radius.*radius.*planes, guard"):
        chosen("wrp", "ch-rmc-paper", options={"radus": 0.1})
    assert chosen("wrp", "ch-rmc-paper", options={"planes": 2})[2] == {"planes": 2}
