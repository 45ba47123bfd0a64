"""What optimisation is tuned by is printed as it is set, and does not change by the way."""

from __future__ import annotations

import json
from dataclasses import FrozenInstanceError, asdict, fields

import pytest

from kinolab import cli
from kinolab.trajopt.nlp.options import OPTIONS

Capture = pytest.CaptureFixture[str]


def listed(capsys: Capture, *arguments: str) -> str:
    assert cli.run(["list", "options", *arguments]) == 0
    return capsys.readouterr().out


def test_every_option_is_listed_with_its_value_and_its_meaning(capsys: Capture) -> None:
    entries = {entry["name"]: entry for entry in json.loads(listed(capsys, "--json"))["options"]}
    assert list(entries) == list(OPTIONS)
    for name, options in OPTIONS.items():
        told = entries[name]["settings"]
        values = {item["name"]: item["default"] for item in told}
        assert values == json.loads(json.dumps(asdict(options)))
        assert all(item["meaning"].endswith(".") for item in told)
        assert entries[name]["summary"].endswith(".")


def test_a_group_is_listed_as_text_with_a_line_for_each_option(capsys: Capture) -> None:
    lines = listed(capsys, "sqp").splitlines()
    assert lines[0].startswith("sqp: ")
    assert [line.split()[0] for line in lines[2:]] == [f.name for f in fields(OPTIONS["sqp"])]
    assert next(line for line in lines if "accept_ratio" in line).split()[1] == "0.1"


def test_a_group_that_does_not_exist_is_told_with_the_known_ones(capsys: Capture) -> None:
    assert cli.run(["list", "options", "sqpp"]) == 2
    told = capsys.readouterr().err
    assert "sqpp" in told
    assert "Did you mean 'sqp'?" in told


def test_options_are_frozen() -> None:
    for options in OPTIONS.values():
        with pytest.raises(FrozenInstanceError):
            setattr(options, fields(options)[0].name, 0)
