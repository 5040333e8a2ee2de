"""What was opened lately: a short list in the user's own folder for such things."""

from pathlib import Path

from chrmc.files import read_json, write_json

LENGTH = 10


def recent_file() -> Path:
    """Where the list is kept."""
    from platformdirs import user_state_path

    return Path(user_state_path("chrmc", appauthor=False)) / "recent.json"


def read_recent(file: Path) -> list[Path]:
    """The paths that are still there, newest first; none when the list cannot be read."""
    try:
        held = read_json(file, "list")
        return [Path(p) for p in held if isinstance(p, str) and Path(p).exists()]
    except (OSError, ValueError, TypeError):
        return []


def note_recent(file: Path, opened: Path) -> None:
    """Put a path first. A list that cannot be written is done without."""
    whole = opened.resolve()
    others = [p for p in read_recent(file) if p != whole]
    try:
        write_json(file, [str(p) for p in [whole, *others][:LENGTH]])
    except OSError:
        return
