"""chrmc: holograms of moving 3-D scenes for amplitude SLMs, as accurate as you ask for.

Importing this loads nothing large; each name is loaded when it is first asked for.
"""

from typing import TYPE_CHECKING

from chrmc.lazy import lazily

if TYPE_CHECKING:
    from chrmc.cgh import compute_field
    from chrmc.compensation.frame import VideoFrame
    from chrmc.encoding import coding_for
    from chrmc.generation.auto import video
    from chrmc.generation.generate import generate
    from chrmc.optics.passband import Passband
    from chrmc.planning.choices import Plan, plan
    from chrmc.record import FrameRecord
    from chrmc.reference import reference_field, relative_error
    from chrmc.response import GreyResponse
    from chrmc.scene.light import scenes_in_light
    from chrmc.scene.load import load_scene
    from chrmc.scene.point_scene import PointScene
    from chrmc.scene.points import PointCloud
    from chrmc.scene.scene import ObjectFrame, Pose, Scene, SceneFrame
    from chrmc.scene.sources.poses import poses_from_csv
    from chrmc.slm import LC_R_1080, SLM, WAVELENGTH
    from chrmc.store.colour import ColourVideo, open_video
    from chrmc.store.export import export_field
    from chrmc.store.notebook import show_field
    from chrmc.store.video import Video
    from chrmc.window import Window

__version__ = "0.1.0"

_LAZY = {
    "LC_R_1080": "chrmc.slm",
    "SLM": "chrmc.slm",
    "WAVELENGTH": "chrmc.slm",
    "ColourVideo": "chrmc.store.colour",
    "FrameRecord": "chrmc.record",
    "GreyResponse": "chrmc.response",
    "ObjectFrame": "chrmc.scene.scene",
    "Passband": "chrmc.optics.passband",
    "Plan": "chrmc.planning.choices",
    "PointCloud": "chrmc.scene.points",
    "PointScene": "chrmc.scene.point_scene",
    "Pose": "chrmc.scene.scene",
    "Scene": "chrmc.scene.scene",
    "SceneFrame": "chrmc.scene.scene",
    "Video": "chrmc.store.video",
    "VideoFrame": "chrmc.compensation.frame",
    "Window": "chrmc.window",
    "coding_for": "chrmc.encoding",
    "compute_field": "chrmc.cgh",
    "export_field": "chrmc.store.export",
    "generate": "chrmc.generation.generate",
    "load_scene": "chrmc.scene.load",
    "open_video": "chrmc.store.colour",
    "plan": "chrmc.planning.choices",
    "poses_from_csv": "chrmc.scene.sources.poses",
    "reference_field": "chrmc.reference",
    "relative_error": "chrmc.reference",
    "scenes_in_light": "chrmc.scene.light",
    "show_field": "chrmc.store.notebook",
    "video": "chrmc.generation.auto",
}

__all__ = [
    "LC_R_1080",
    "SLM",
    "WAVELENGTH",
    "ColourVideo",
    "FrameRecord",
    "GreyResponse",
    "ObjectFrame",
    "Passband",
    "Plan",
    "PointCloud",
    "PointScene",
    "Pose",
    "Scene",
    "SceneFrame",
    "Video",
    "VideoFrame",
    "Window",
    "coding_for",
    "compute_field",
    "export_field",
    "generate",
    "load_scene",
    "open_video",
    "plan",
    "poses_from_csv",
    "reference_field",
    "relative_error",
    "scenes_in_light",
    "show_field",
    "video",
]

__getattr__ = lazily(__name__, _LAZY)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
