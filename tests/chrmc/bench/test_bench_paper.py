"""The paper's numbers: what is known to agree agrees, what is known to contradict is named."""

import pytest
from click.testing import CliRunner

from chrmc.bench.paper import claims
from chrmc.cli.bench_paper import command


def by_text(start: str) -> list[bool]:
    found = [claim.consistent for claim in claims() if claim.text.startswith(start)]
    assert found, start
    return found


@pytest.mark.parametrize(
    "text",
    ["z at which W(z) = p", "z0 (Eq. 9)", "R·θ at 0.3°", "R·θ in pixels", "overlap of 1827",
     "RT: stages add up", "WRP: stages add up", "NLUT: stages add up", "WRP: points per frame",
     "NLUT: time per frame", "C1: from the printed centre", "C1: l = x_O"],
)  # fmt: skip
def test_agrees(text: str) -> None:
    assert all(by_text(text))


@pytest.mark.parametrize(
    "text",
    ["C1: radius", "C2: radius", "C3: radius", "C2: from the printed", "C3: from the printed",
     "T_conv", "WRP: time per frame", "PFP", "direction of the car", "lateral position",
     "width of the blank"],
)  # fmt: skip
def test_contradicts(text: str) -> None:
    assert not any(by_text(text))


def test_one_line_each() -> None:
    result = CliRunner().invoke(command, [])
    assert result.exit_code == 0
    lines = result.output.splitlines()
    assert len(lines) == len(claims()) + 1
    assert all(line.startswith(("consistent", "NOT consistent")) for line in lines[:-1])
    assert "0.385 cm" in result.output and "1.02 cm" in result.output
    assert "2.82 cm" in result.output
