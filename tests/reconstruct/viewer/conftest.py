"""What the viewer draws into, without a window."""

import sys

import moderngl
import pytest


@pytest.fixture(scope="module")
def context():
    """Off the screen; nothing that is drawn may leave an error."""
    backend = {"backend": "egl"} if sys.platform.startswith("linux") else {}
    made = moderngl.create_context(standalone=True, **backend)
    yield made
    assert made.error == "GL_NO_ERROR"
    made.release()
