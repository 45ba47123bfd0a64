"""Messages quote at most 200 characters of what they were given, whoever writes them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import kinolab
from kinolab.cli.front import execute
from kinolab.errors import InputError, KinolabError, Mistake, UnknownNameError

LONG = 5000


def longest_run(text: str) -> int:
    """Return how often one character comes in a row at most."""
    return max(len(found[0]) for found in re.finditer(r"(.)\1*", text))


@pytest.mark.parametrize(
    "error",
    [
        UnknownNameError("planner", "s" * LONG, known=["sst"], where="a.toml"),
        InputError([Mistake("w" * LONG, "no.", "Give one.")]),
        InputError([Mistake("a", f"it is no file ({'e ' * LONG}).", f"Not {'r' * LONG}.")]),
        InputError([Mistake("a", f"{'it ' * LONG!r} is no name.")]),
        KinolabError(f"there is no '{'q' * LONG}'."),
    ],
)
def test_a_message_quotes_at_most_200_characters(error: KinolabError) -> None:
    assert longest_run(str(error)) <= 200
    assert len(str(error)) <= 3 * 200
    assert "…" in str(error)


def test_what_kinolab_says_itself_is_not_cut() -> None:
    told = "It says so at length, the machine's own law. " * 40
    known = ", ".join(f"name_{k}" for k in range(300))
    assert str(Mistake("a (b)", f"(short) {told}", f"Known: {known}.")).endswith("name_299.")


@pytest.mark.parametrize("text", ["m" * LONG, f"{'m' * LONG}.toml", f"--{'m' * LONG}"])
def test_what_is_typed_is_not_repeated(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert execute([text]) != 0
    assert longest_run(capsys.readouterr().err) <= 200


def test_a_long_name_in_a_scenario_is_not_repeated(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_text(f'schema = 1\ntitle = "t"\n[system]\nname = "{"n" * LONG}"\n{"k" * LONG} = 1\n')
    with pytest.raises(InputError) as caught:
        kinolab.load(path)
    assert longest_run(str(caught.value)) <= 200
