"""Image measures see what was done to a field: moved, defocused, made noisy."""

import numpy as np
import pytest

import chrmc
from chrmc.compensation.ch_rmc_paper.image_measures import BEST_PSNR, image_measures
from chrmc.optics.propagation import propagate
from chrmc.scene.scene import ObjectFrame, SceneFrame
from chrmc.slm import SLM, WAVELENGTH

PANEL = SLM("panel", 480, 480, 8.1e-6)
DEPTH = 0.06


def some_object(shift: float = 0.0) -> ObjectFrame:
    rng = np.random.default_rng(2)
    positions = rng.uniform(-1, 1, (25, 3)) * [3e-4, 3e-4, 0] + [shift, 0, DEPTH]
    return ObjectFrame("thing", chrmc.PointCloud(positions, np.ones(25), rng.uniform(0, 6, 25)))


def field_of(obj: ObjectFrame) -> np.ndarray:
    return chrmc.compute_field(obj.cloud, PANEL, WAVELENGTH, method="rt")


@pytest.fixture(scope="module")
def truth() -> np.ndarray:
    return field_of(some_object())


def measured(field: np.ndarray, truth: np.ndarray) -> dict[str, float]:
    frame = SceneFrame(1, (some_object(), ObjectFrame("dark", chrmc.PointCloud.empty())))
    found = image_measures(PANEL, WAVELENGTH)(field, truth, frame)
    assert set(found) == {"thing"}
    return found["thing"]


def test_equal_fields(truth: np.ndarray) -> None:
    same = measured(truth, truth)
    assert same["psnr"] == BEST_PSNR and same["ssim"] == pytest.approx(1)
    assert same["shift_x"] == same["shift_y"] == same["focus_shift"] == 0
    assert same["focus"] == pytest.approx(DEPTH, abs=1e-4)


def test_a_moved_object(truth: np.ndarray) -> None:
    moved = measured(field_of(some_object(3 * PANEL.pixel_pitch)), truth)
    assert moved["shift_x"] == pytest.approx(3 * PANEL.pixel_pitch, rel=0.1)
    assert abs(moved["shift_y"]) < 1e-6
    assert moved["psnr"] < 30


def test_a_defocused_object(truth: np.ndarray) -> None:
    # Light carried on by +d shows the object d farther away.
    far = measured(propagate(truth, PANEL.pixel_pitch, WAVELENGTH, 4e-4), truth)
    assert far["focus_shift"] == pytest.approx(4e-4, abs=6e-5)


def test_noise_lowers_psnr_as_it_must(truth: np.ndarray) -> None:
    rng = np.random.default_rng(0)
    noise = rng.normal(size=(2, *PANEL.shape)) * np.sqrt(np.mean(np.abs(truth) ** 2) / 2)
    values = [
        measured(truth + s * (noise[0] + 1j * noise[1]).astype(np.complex64), truth)["psnr"]
        for s in (0.1, 0.4)
    ]
    # Cross terms of light and noise grow with the amplitude: 12 dB for a factor of 4.
    assert values[0] - values[1] == pytest.approx(12, abs=3)


def place(x: float, y: float, seed: int = 2) -> ObjectFrame:
    rng = np.random.default_rng(seed)
    positions = rng.uniform(-1, 1, (25, 3)) * [2e-4, 1e-4, 0] + [x, y, DEPTH]
    return ObjectFrame("thing", chrmc.PointCloud(positions, np.ones(25), rng.uniform(0, 6, 25)))


@pytest.mark.parametrize("sides", [(0, 0), (1, 1), (-1, -1), (0, 1), (-1, 0)])
def test_an_object_at_the_panels_border_is_measured_like_one_in_its_middle(
    sides: tuple[int, int],
) -> None:
    """Its own light moved by whole pixels: the shift is told, rows and columns apart."""
    edge = PANEL.x()[-1]
    x, y = sides[0] * (edge - 3e-4), sides[1] * (edge - 2e-4)
    pitch = PANEL.pixel_pitch
    obj = place(x, y)
    truth = field_of(obj)
    moved = field_of(place(x - 4 * pitch, y + 2 * pitch if y <= 0 else y - 2 * pitch))
    frame = SceneFrame(1, (obj,))
    found = image_measures(PANEL, WAVELENGTH)(moved, truth, frame)["thing"]
    assert found["shift_x"] == pytest.approx(-4 * pitch, rel=0.12)
    assert found["shift_y"] == pytest.approx(2 * pitch * (1 if y <= 0 else -1), rel=0.2)
    same = image_measures(PANEL, WAVELENGTH)(truth, truth, frame)["thing"]
    assert same["focus"] == pytest.approx(DEPTH, abs=6e-5)


def test_only_the_objects_own_area_counts(truth: np.ndarray) -> None:
    """Light beside it by more than the margin is not its own; an object off the panel has none."""
    beside = field_of(place(1.2e-3, 1.2e-3, 5))
    clean, noisy = measured(truth, truth), measured(truth + beside, truth)
    assert noisy["psnr"] > 25
    assert abs(noisy["shift_x"]) < 4e-6 and abs(noisy["shift_y"]) < 4e-6
    assert noisy["focus"] == pytest.approx(clean["focus"], abs=4e-5)
    off = ObjectFrame("off", chrmc.PointCloud(np.array([[0.1, 0.0, DEPTH]]), [1.0], [0.0]))
    assert image_measures(PANEL, WAVELENGTH)(truth, truth, SceneFrame(1, (off,))) == {}


@pytest.mark.parametrize("by", [1.1e-4, -3.7e-4, 1.3e-3, -1.3e-3])
def test_best_focus_is_found_between_the_depths_that_are_tried(
    truth: np.ndarray, by: float
) -> None:
    far = measured(propagate(truth, PANEL.pixel_pitch, WAVELENGTH, by), truth)
    assert far["focus_shift"] == pytest.approx(by, abs=3e-5)
    assert far["focus"] == pytest.approx(DEPTH + by, abs=1e-4)


def test_pictures_are_compared_by_their_intensity(truth: np.ndarray) -> None:
    """Of a field c times as bright the intensity differs by c² − 1 everywhere."""
    one, other = (measured(np.complex64(c) * truth, truth)["psnr"] for c in (1.01, 1.1))
    assert one - other == pytest.approx(20 * np.log10(0.21 / 0.0201), abs=0.05)
