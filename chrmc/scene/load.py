"""Scenes by name, by folder, or from a Python file."""

from collections.abc import Sequence
from inspect import isclass, isroutine
from pathlib import Path

from chrmc.options import meant
from chrmc.python_file import from_python_file, is_python_name, one_line
from chrmc.scene.car_house import HEADINGS, car_house, car_house_rgbd
from chrmc.scene.scene import Scene, as_scene
from chrmc.slm import LC_R_1080, SLM

DENSE = "car-house-dense"
BUILT_IN = (*HEADINGS, DENSE)
"""Names of the scenes that come with the package."""
HAS_ITS_POINTS = (
    "--density, --points and --fit belong to meshes, pictures, text and cameras' recordings; "
    "{} has its points and places"
)
SIZED = {"density": None, "points": None, "fit": False}
"""Options of `load_scene` that say how many points files become and where, with their defaults."""


def load_scene(
    name_or_folder: str | Path | Sequence[str],
    form: str = "points",
    *,
    slm: SLM = LC_R_1080,
    wavelength: float | None = None,
    density: float | None = None,
    points: int | None = None,
    fit: bool = False,
) -> Scene:
    """A built-in scene, a folder of RGB-D frames, or what other programs write.

    name_or_folder : `car-house`, `car-house-deep`, `car-house-dense`, a folder with a scene.json
        and OpenEXR frames of any tool (see `chrmc.scene.scene_json`), or FILE.py:NAME, a scene in
        a Python file or a function without arguments that returns one. Or files: meshes, point
        clouds, pictures (each `FILE@DEPTH` in metres if not 0.25), text as `text:WORDS`, a
        scene.toml, a folder of a depth camera's pictures; several as a sequence
    form : "points" (body-fixed, exact) or "rgbd" (320 × 240 images, depth in planes) of a built-in
        scene or of surfaces; a folder is points where its ids and poses tell which point is which
        (see `tracked`), else rgbd
    slm, wavelength : what files are sized and sampled for
    density : of surfaces and recordings, resolution cells of the SLM per point; points : on all
        of them, instead
    fit : scale and shift files' content so that no frame leaves what the SLM shows

    Raises ValueError or OSError, in one line, for a scene that is not there or makes no sense.
    """
    if form not in ("points", "rgbd"):
        raise ValueError(f"unknown form {form!r} of a scene: choose points or rgbd")
    words = [str(name_or_folder)]
    if not isinstance(name_or_folder, str | Path):
        words = [str(word) for word in name_or_folder]
    name = words[0] if words else ""
    if (density, points, fit) != (None, None, False) and (name in BUILT_IN or is_python_name(name)):
        raise ValueError(HAS_ITS_POINTS.format(name))
    if name == DENSE:
        from chrmc.scene.dense import car_house_dense, car_house_dense_rgbd

        return car_house_dense() if form == "points" else car_house_dense_rgbd()
    if name in BUILT_IN:
        return car_house(name) if form == "points" else car_house_rgbd(name)
    if is_python_name(name):
        return python_scene(name)
    from chrmc.scene.sources.files import is_source, load_sources

    if len(words) > 1 or is_source(name):
        return load_sources(
            words, form, slm=slm, wavelength=wavelength, density=density, points=points, fit=fit
        )
    folder = Path(name)
    if folder.is_dir():
        if (density, points, fit) != (None, None, False):
            raise ValueError(HAS_ITS_POINTS.format(name))
        from chrmc.scene.read_folder import read_scene
        from chrmc.scene.tracked import tracked

        scene = read_scene(folder)
        return (tracked(scene) if form == "points" else None) or scene
    if folder.exists():
        from chrmc.scene.sources import READERS

        raise ValueError(
            f"{folder} is a file that is no scene; known endings are {', '.join(READERS)}, .toml"
        )
    raise ValueError(
        f"there is no scene {name!r}{meant(name, BUILT_IN)}: name a built-in one "
        f"({', '.join(BUILT_IN)}), a folder of RGB-D frames, a mesh, cloud or picture, or one of "
        "your own as FILE.py:NAME"
    )


def python_scene(text: str) -> Scene:
    """The scene that FILE.py:NAME names, or that the function of that name returns."""
    found = from_python_file(text)
    with one_line(text):
        return as_scene(found() if isroutine(found) or isclass(found) else found)
