"""chrmc: holograms of moving 3-D scenes for amplitude SLMs, as accurate as you ask for."""

from chrmc.cgh import compute_field
from chrmc.compensation import video
from chrmc.reference import reference_field
from chrmc.scene.load import load_scene
from chrmc.scene.points import PointCloud
from chrmc.slm import LC_R_1080, SLM, WAVELENGTH

__version__ = "0.1.0"

__all__ = [
    "LC_R_1080",
    "SLM",
    "WAVELENGTH",
    "PointCloud",
    "compute_field",
    "load_scene",
    "reference_field",
    "video",
]
