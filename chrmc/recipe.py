"""From a command line's words to a `Recipe`: defaults, and refusals before any work."""

from pathlib import Path
from typing import Any

from chrmc.cgh import DEFAULT_METHOD, method_named
from chrmc.compensation import ch_rmc_for, compensation_named, unaliased
from chrmc.encoding import coding_for
from chrmc.generation import Recipe, scene_wavelength
from chrmc.options import option_names
from chrmc.response import GreyResponse
from chrmc.scene.scene import Scene
from chrmc.slm import SLM

DEFAULT_TOLERANCE = 1e-3


def recipe_for(
    scene: Scene,
    slm: SLM,
    wavelength: float | None = None,
    *,
    cgh: str | None = None,
    compensation: str | None = None,
    surface: str | None = None,
    tolerance: float | None = None,
    encoding: str = "ssb",
    gamma: float | None = None,
    response: Path | None = None,
    settings: tuple[tuple[str, Any], ...] = (),
    check_pixels: int = 256,
) -> Recipe:
    """The recipe that these choices mean; ValueError where they do not fit together."""
    if cgh is None:
        cgh = DEFAULT_METHOD
    takes_tolerance = method_named(cgh).takes("tolerance")
    if compensation is None:
        exact = ch_rmc_for(cgh) == "ch-rmc-object"
        compensation = "ch-rmc" if exact or surface is not None else "none"
    options = dict(settings)
    if compensation == "ch-rmc":
        compensation = ch_rmc_for(cgh)
        if surface is not None:
            compensation = str(unaliased("ch-rmc", {"surface": surface})[0])
    elif surface is not None:
        raise ValueError(f"--surface belongs to --compensation ch-rmc, not {compensation}")
    if tolerance is not None and not 0 < tolerance < 1:
        raise ValueError(f"--tolerance must lie between 0 and 1, not {tolerance:g}")
    promises = (
        compensation == "none" or "tolerance" in option_names(compensation_named(compensation))[0]
    )
    coding_for(encoding, slm)
    if tolerance is not None and not promises:
        raise ValueError(
            f"--compensation {compensation} cannot promise --tolerance {tolerance:g}: use "
            "--surface object, --compensation none, or --set rekey_error=… on the paper's surface"
        )
    if takes_tolerance:
        options.setdefault("tolerance", tolerance or DEFAULT_TOLERANCE)
    elif tolerance is not None:
        raise ValueError(
            f"--cgh {cgh} has no tolerance to set; leave --tolerance out, or use --cgh curved"
        )
    if gamma is not None and response is not None:
        raise ValueError("--gamma and --response both give the grey response; use one")
    grey = None
    if gamma is not None:
        grey = GreyResponse.from_gamma(gamma)
    elif response is not None:
        grey = GreyResponse.from_csv(response)
    return Recipe(
        scene,
        slm,
        scene_wavelength(scene, wavelength),
        cgh,
        compensation,
        options,
        encoding,
        check_pixels,
        grey,
    )
