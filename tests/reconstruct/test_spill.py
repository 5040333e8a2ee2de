"""The rim tells the depth of what is dense and speckle everywhere."""

from dataclasses import replace
from pathlib import Path

import pytest

import chrmc
import reconstruct
from chrmc.response import GreyResponse
from reconstruct.checking import _targets
from reconstruct.four_f_system import FourF
from reconstruct.region import target_stack
from reconstruct.spill import spill_error

BISON = Path("/usr/share/assimp/models/PLY/Wuson.ply")


@pytest.mark.skipif(not BISON.is_file(), reason="needs the Debian package assimp-testmodels")
def test_a_real_animal_seen_from_the_side(tmp_path: Path) -> None:
    # 2 mm long and 1.3 mm deep: as a whole it is sharpest 0.9 mm behind its mean depth.
    toml = tmp_path / "bison.toml"
    toml.write_text(f'[[object]]\nname = "bison"\nfile = "{BISON}"\nturn = [0, 60, 0]\n')
    video = chrmc.generate(toml, tmp_path / "video", compensation="none", check_pixels=0)
    (verdict,) = reconstruct.check(video, [1])
    (found,) = verdict.objects
    assert verdict.passed, found.faults
    assert found.focus.method == "rim" and abs(found.depth_error) < 0.25e-3
    response = GreyResponse.from_dict(video.response)
    system = FourF(
        video.slm, video.wavelength, video.encoding, response=response, scale=video.scale
    )
    (target,) = _targets(video, 1, system, None)
    stack, _, _ = target_stack(system.field(video.read(1)), system, target, video.pixel_pitch)
    assert target.light is not None
    for off in (-1.2e-3, 0.8e-3):  # of what the scene is said to be
        wrong = replace(target.light, depth=target.light.depth + off)
        assert spill_error(stack, wrong, system)[0] == pytest.approx(-off, abs=0.25e-3)
