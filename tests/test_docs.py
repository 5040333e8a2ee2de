"""The documents run: their Python as it stands, their commands by name."""

import re
from pathlib import Path

import pytest

from chrmc.cli.bench import SUBCOMMANDS
from chrmc.cli.main import COMMANDS, main

ROOT = Path(__file__).parents[1]
DOCUMENTS = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks(path: Path, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", path.read_text("utf-8"), flags=re.DOTALL)


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda p: p.name)
def test_python_in_documents_runs(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    if path.stem == "slmsuite":
        pytest.importorskip("slmsuite")
    if '"video"' in path.read_text("utf-8"):
        with pytest.raises(SystemExit) as ended:
            main(
                [
                    "generate",
                    "car-house",
                    "--out",
                    "video",
                    "--frames",
                    "1:2",
                    "--compensation",
                    "none",
                ]
            )
        assert ended.value.code == 0
    names: dict[str, object] = {}
    for code in blocks(path, "python"):
        exec(compile(code, str(path), "exec"), names if path.stem == "recipes" else {})


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda p: p.name)
def test_commands_in_documents_exist(path: Path) -> None:
    inline = "\n".join(re.findall(r"`chrmc [^`]*", path.read_text("utf-8")))
    text = "\n".join(blocks(path, "sh")) + "\n" + inline
    for name in re.findall(r"(?:^|`)chrmc ([a-z][a-z0-9-]*)", text, flags=re.MULTILINE):
        assert name in COMMANDS, f"{path.name} names `chrmc {name}`"
    for name in re.findall(r"chrmc bench ([a-z][a-z0-9-]*)", text):
        assert name in SUBCOMMANDS, f"{path.name} names `chrmc bench {name}`"


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda p: p.name)
def test_links_lead_somewhere(path: Path) -> None:
    for target in re.findall(r"\]\(([^)#:]+)\)", path.read_text("utf-8")):
        assert (path.parent / target).exists(), f"{path.name} links to {target}"
