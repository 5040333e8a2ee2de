"""Real models: those of Debian's package assimp-testmodels."""

from pathlib import Path

import pytest

pytest.importorskip("trimesh")
MODELS = Path("/usr/share/assimp/models")


@pytest.fixture(scope="session")
def models() -> Path:
    if not MODELS.is_dir():
        pytest.skip("needs the Debian package assimp-testmodels")
    return MODELS
