"""A small stored video that the command line's tests share."""

from pathlib import Path

import pytest

from chrmc.cli.main import group


@pytest.fixture(scope="session")
def stored_video(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two frames of car-house on a coarse panel; not to be changed."""
    folder = tmp_path_factory.mktemp("stored") / "video"
    small = ["--slm", "192x120:81um", "--cgh", "fresnel", "--compensation", "none"]
    arguments = ["generate", "car-house", "--out", str(folder), *small, "--frames", "1:2"]
    group.main(arguments, standalone_mode=False)
    return folder
