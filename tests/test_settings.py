"""Settings: declared once, and what is told about them is what is enforced."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import pytest
from pydantic import ValidationError

from kinolab import planners
from kinolab.errors import InputError
from kinolab.scenario import PLANNER_KEYS, PlannerSection, shared_settings
from kinolab.search import AbstractPlanner, setting
from kinolab.settings import Setting, settings_of

EVERY = [(name, entry) for name in planners.built_in() for entry in settings_of(planners.get(name))]
every_setting = pytest.mark.parametrize(
    ("planner", "entry"), EVERY, ids=[f"{name}-{entry.name}" for name, entry in EVERY]
)
every_shared = pytest.mark.parametrize("entry", shared_settings(), ids=lambda entry: entry.name)


@dataclass(frozen=True, kw_only=True)
class Base(AbstractPlanner):
    name: ClassVar[str] = "probe"

    plain: float = 5
    inherited: int = setting(3, 1, unit="steps", meaning="How long.")

    def solve(self, *_: Any) -> Any: ...


@dataclass(frozen=True, kw_only=True)
class Probe(Base):
    radius: float = setting(0.5, above=0.0, unit="m", meaning="How far.")


def misfit(**settings: object) -> str:
    with pytest.raises(InputError) as caught:
        Probe.from_settings(settings)
    return str(caught.value)


def test_a_setting_is_read_from_where_it_is_declared() -> None:
    assert settings_of(Probe) == (
        Setting("plain", 5.0),
        Setting("inherited", 3, lowest=1, unit="steps", meaning="How long."),
        Setting("radius", 0.5, above=0.0, unit="m", meaning="How far."),
    )


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ((0.5,), ""),
        (("fast",), ""),
        ((True,), "true or false"),
        ((1, 0, 5), "0 to 5"),
        ((0.5, 0.05, 1e6), "0.05 to 1000000"),
        ((1, 0), "at least 0"),
        ((1, None, 5), "at most 5"),
        ((1.0, None, 5.0, 0.0), "more than 0, at most 5"),
    ],
)
def test_a_range_reads_as_people_write_it(given: tuple[Any, ...], words: str) -> None:
    assert Setting("x", *given).range == words


def test_a_value_out_of_range_is_told_with_every_limit() -> None:
    assert misfit(radius=0) == "[planner] radius: 0 is out of range. Give more than 0.0."
    assert misfit(inherited=0) == "[planner] inherited: 0 is out of range. Give at least 1."
    both = Setting("x", 1.0, highest=5.0, above=0.0).misfit(6.0)
    assert both == ("6.0 is out of range.", "Give more than 0.0, at most 5.0.")


def test_a_value_of_another_kind_is_told_with_the_default() -> None:
    wanted = "Give a number, such as the default 0.5."
    assert misfit(radius="wide") == f"[planner] radius: 'wide' does not fit. {wanted}"
    assert misfit(radius=True) == f"[planner] radius: True does not fit. {wanted}"


def test_a_number_may_have_a_whole_default() -> None:
    """Its type is what the class says, not what the default happens to be."""
    assert Probe.from_settings({"plain": 5.5}).plain == 5.5
    assert misfit(inherited=1.5).endswith("Give a whole number, such as the default 3.")


# --- laws over every planner ---


@every_setting
def test_every_setting_says_in_a_sentence_what_it_means(planner: str, entry: Setting) -> None:
    assert entry.meaning[:1].isupper(), f"{planner} {entry.name}"
    assert entry.meaning.endswith(".")


@every_setting
def test_every_default_is_within_its_range_and_is_no_shared_key(
    planner: str, entry: Setting
) -> None:
    assert entry.misfit(entry.default) is None
    assert entry.name not in PLANNER_KEYS
    assert entry.default == getattr(planners.get(planner)(), entry.name)


def refused(planner: str, entry: Setting, value: float) -> bool:
    """Whether a value is out of a setting's range; conflicts with other settings do not count."""
    told = planners.misfits(planners.get(planner), {entry.name: value})
    return any(key == entry.name and "out of range" in what for key, what, _ in told)


@every_setting
def test_every_range_is_the_one_that_is_kept(planner: str, entry: Setting) -> None:
    for end, outside in ((entry.lowest, -1), (entry.highest, 1)):
        if end is not None:
            assert not refused(planner, entry, end)
            assert refused(planner, entry, end + outside)
    if entry.above is not None:
        assert refused(planner, entry, entry.above)


# --- the keys that planners share ---


def test_the_shared_keys_are_those_of_the_section_but_its_name() -> None:
    assert tuple(entry.name for entry in shared_settings()) == PLANNER_KEYS[1:]


@every_shared
def test_every_shared_key_says_what_it_means_and_its_unit(entry: Setting) -> None:
    assert entry.meaning.endswith(".")
    units = {"time_limit": "s", "max_iterations": "iterations", "seed": "", "improve": "s"}
    assert entry.unit == units[entry.name]
    assert getattr(PlannerSection(), entry.name) == entry.default


def takes(name: str, value: float) -> bool:
    try:
        PlannerSection.model_validate({name: value})
    except ValidationError:
        return False
    return True


@every_shared
def test_every_shared_range_is_the_one_that_the_scenario_keeps(entry: Setting) -> None:
    assert entry.above is not None or entry.lowest is not None
    for end, outside in ((entry.lowest, -1), (entry.highest, 1)):
        if end is not None:
            assert takes(entry.name, end)
            assert not takes(entry.name, end + outside)
    if entry.above is not None:
        assert not takes(entry.name, entry.above)
        assert takes(entry.name, entry.above + 1e-9)
