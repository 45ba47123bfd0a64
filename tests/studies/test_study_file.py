"""The file of a study: every mistake is told at once, with its place and what would work."""

from __future__ import annotations

from pathlib import Path

import pytest

from kinolab.errors import InputError
from kinolab.studies.expansion import expanded
from kinolab.studies.study_file import read_study
from tests.studies.tiny_study import TINY, study_in
from tests.support import OPEN, within


def refused(folder: Path, text: str) -> list[str]:
    """Return what is said of a study's file."""
    with pytest.raises(InputError) as caught:
        study_in(folder, text)
    assert all(mistake.where and mistake.remedy for mistake in caught.value.mistakes)
    return str(caught.value).splitlines()


def refused_before_runs(folder: Path, text: str) -> list[str]:
    """Return what is said of a study once its scenarios are read."""
    with pytest.raises(InputError) as caught:
        expanded(study_in(folder, text), folder / "root")
    return str(caught.value).splitlines()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("seed = 3", "tiny.toml seed: no key is called 'seed'. Did you mean 'seeds'?"),
        ("schema_version = 1", "tiny.toml schema_version: no key is called 'schema_version'."),
        ('path = "x"', "tiny.toml path: no key is called 'path'."),
        ("seeds = 0", "tiny.toml seeds: 0 does not fit here. How many"),
        ("seeds = 1_000_000_000", "tiny.toml seeds: 1000000000 does not fit here. How many"),
        ("seeds = [1, -1]", "tiny.toml seeds.2: -1 does not fit here."),
        ("seeds = [9223372036854775808]", "tiny.toml seeds.1: 9223372036854775808 does not fit"),
        ("seeds = []", "tiny.toml seeds: [] does not fit here."),
        ("seeds = true", "tiny.toml seeds: true does not fit here."),
        ("limits = 3", "tiny.toml limits: 3 does not fit here."),
        ("[limits]\ncpu = nan", "tiny.toml limits.cpu: nan does not fit here. Processor time"),
        ("[limits]\nmemry = 1", "tiny.toml limits.memry: no key is called 'memry'. Did you mean"),
        ("[sweep]\nx = []", "tiny.toml sweep.x: [] does not fit here. Lists of values"),
        ("[sweep]\nx = [1, inf]", "tiny.toml sweep.x.2: inf does not fit here."),
        ("[sweep]\nx = [1979-05-27]", "tiny.toml sweep.x.1: 1979-05-27 does not fit here."),
        ('[sweep]\n"planner.name" = ["rrt"]', 'tiny.toml "planner.name": this is not set here. L'),
        ('[settings]\n"planner.seed" = 1', 'tiny.toml "planner.seed": this is not set here. Give'),
        (
            "[settings]\n'planner . \"name\"' = 1",
            'tiny.toml "planner . \\"name\\"": this is not set',
        ),
        ('[settings]\nplanner = { name = "sst" }', "tiny.toml planner: this is not set here. Give"),
        ("[limits]\niterations = 9223372036854775808", "tiny.toml limits.iterations: 9223372036"),
        ("[case]\nseeds = 2", "tiny.toml case: { seeds = 2 } does not fit here. [[case]]:"),
        ("[[case]]\nseed = 2", "tiny.toml [[case]] 1 seed: no key is called 'seed'."),
        (
            "[sweep]\na = [1]\n[sobol]\npoints = 2\nranges.a = { from = 0, to = 1 }",
            "tiny.toml a: it is swept twice. Leave one out.",
        ),
        (
            "[sobol]\npoints = 2\nranges.a = { from = 2, to = 1 }",
            "tiny.toml sobol.ranges.a: its from is not below its to. By key",
        ),
        (
            '[sobol]\npoints = 2\nranges.a = { from = 0, to = 1, scale = "log" }',
            "tiny.toml sobol.ranges.a: a logarithmic scale needs values above 0.",
        ),
        (
            "[sobol]\npoints = 2\nranges.a = { from = -1e308, to = 1e308 }",
            "tiny.toml sobol.ranges.a: it is wider than numbers reach.",
        ),
        (
            "[sobol]\npoints = 0\nranges.a = { low = 0, to = 1 }",
            "tiny.toml sobol.points: 0 does not fit here. How many; a power of 2 is best.",
        ),
        ("[sweep]\na = [1.0, nan]", "tiny.toml sweep.a.2: nan does not fit here."),
        (
            "[sweep]\na = [[1.0, inf]]",
            "tiny.toml sweep.a.1: [1.0, inf] does not fit here.",
        ),
        (
            "[settings]\na = { b = [0, [-1e999]] }",
            "tiny.toml settings.a: { b = [0, [-inf]] } does not fit here.",
        ),
    ],
)
def test_a_mistake_is_told_with_its_place_and_what_would_work(
    tmp_path: Path, text: str, said: str
) -> None:
    assert refused(tmp_path, TINY + text)[0].startswith(said)


def test_all_mistakes_are_told_at_once(tmp_path: Path) -> None:
    text = (
        'titel = 3\n[[case]]\nplanners = [3, { nam = "a" }]\n[case.settings]\n"planner.name" = 2\n'
    )
    told = refused(tmp_path, text)
    assert sorted(line.split(":")[0] for line in told) == [
        "tiny.toml [[case]] 1",
        'tiny.toml [[case]] 1 "planner.name"',
        "tiny.toml [[case]] 1 planners.1",
        "tiny.toml [[case]] 1 planners.2.nam",
        "tiny.toml [[case]] 1 planners.2.name",
        "tiny.toml schema",
        "tiny.toml titel",
        "tiny.toml title",
    ]
    assert told[-2].endswith('no scenarios are named. Write scenarios = ["…"].')


def test_a_planner_of_a_list_has_no_other_name_among_its_settings(tmp_path: Path) -> None:
    """Tables would show its runs under a name that is not theirs."""
    own = '[{ name = "rrt_fast", settings = { name = "sst", goal_bias = 0.1, seed = 3 } }]'
    assert refused(tmp_path, TINY.replace('["kpiece_fast"]', own)) == [
        'tiny.toml "planner.name": this is not set here. List planners under planners.',
        'tiny.toml "planner.seed": this is not set here. Give seeds.',
    ]


def test_a_key_of_a_case_replaces_that_of_the_study(tmp_path: Path) -> None:
    study = study_in(tmp_path, f"{TINY}seeds = 3\n[[case]]\nseeds = 5\n[[case]]\nimprove = true\n")
    assert [(case.seeds, case.improve) for case in study.cases] == [(5, None), (3, True)]


def test_a_scenario_is_no_study(tmp_path: Path) -> None:
    (told,) = refused(tmp_path, OPEN)
    assert told == (
        f"tiny.toml: this is a scenario, not a study. `plan {tmp_path / 'tiny.toml'}` plans it."
    )


def test_a_file_that_is_not_there_is_told(tmp_path: Path) -> None:
    study_in(tmp_path, TINY)
    with pytest.raises(InputError, match=r"there is no file .*tinny.toml. Did you mean"):
        read_study(tmp_path / "tinny.toml")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a =", "this is not TOML: "),
        (f"{TINY}x = {'[' * 50_000}", "its lists or tables are nested too deep."),
        (f"{TINY}seeds = {'9' * 5000}", "one of its numbers is too long to read."),
        (f"{TINY}seeds = [{'9' * 4000}]", "does not fit here."),
        (f"{TINY}a{'.a' * 100_000} = 1", "a key has more than 32 parts with dots between them."),
        (TINY + "\n".join(f"a{k} = 1" for k in range(50_000)), "there are more mistakes"),
        (f"{TINY}[sweep]\n" + "\n".join(f"a{k} = [1]" for k in range(50_000)), "Lists of values"),
    ],
    ids=["broken", "deep", "huge", "large", "parts", "keys", "swept"],
)
def test_hostile_files_are_refused_soon(tmp_path: Path, text: str, said: str) -> None:
    with within(60):
        assert said in "\n".join(refused(tmp_path, text))


def test_too_many_runs_are_counted_and_never_made(tmp_path: Path) -> None:
    """10^64 settings times 10^6 seeds: no list of them fits into any memory."""
    sweep = "\n".join(f'"planner.a{k}" = [{", ".join(map(str, range(10)))}]' for k in range(64))
    with within(60):
        (told,) = refused_before_runs(tmp_path, f"{TINY}seeds = 1_000_000\n[sweep]\n{sweep}\n")
    assert told == f"tiny.toml: it has {10**70} runs. At most 1000000 are made."


def test_mistakes_in_scenarios_planners_and_settings_are_told_for_all_cases(
    tmp_path: Path,
) -> None:
    text = """
schema = 1
title = "t"
[[case]]
scenarios = ["pendulum_swingupp", "pendulum_swingup"]
planners = ["kpiece_fastt", { name = "rrt_fast", label = "mine", settings = { goal_bia = 0.1 } }]
[[case]]
scenarios = ["pendulum_swingup"]
planners = ["rrt_fast"]
sweep = { "planner.goal_bias" = [0.1, 3.0] }
[[case]]
scenarios = ["pendulum_swingup"]
planners = ["rrt_fast"]
sobol = { points = 4, ranges = { "planner.goal_bia" = { from = 0.1, to = 0.2 } } }
"""
    told = "\n".join(refused_before_runs(tmp_path, text))
    for said in (
        "tiny.toml [[case]] 1 pendulum_swingupp, kpiece_fastt: ",
        "tiny.toml [[case]] 1 pendulum_swingup, kpiece_fastt: ",
        "Did you mean 'kpiece_fast'?",
        "tiny.toml [[case]] 1 pendulum_swingup, mine: ",
        "Did you mean 'goal_bias'?",
        "tiny.toml [[case]] 2 pendulum_swingup, rrt_fast: ",
        "3.0",
        "tiny.toml [[case]] 3 pendulum_swingup, rrt_fast: ",
    ):
        assert said in told


def test_two_planners_of_one_name_need_labels(tmp_path: Path) -> None:
    """Otherwise a table would join their runs in one line."""
    one = '{ name = "rrt_fast", settings = { goal_bias = 0.1 } }'
    text = TINY.replace('["kpiece_fast"]', f"[{one}, {one.replace('0.1', '0.2')}]")
    (told,) = refused_before_runs(tmp_path, text)
    assert told.startswith("tiny.toml: 'rrt_fast' on 'pendulum_swingup' already names something")
    labelled = text.replace("0.2 } }", '0.2 }, label = "eager" }')
    runs = expanded(study_in(tmp_path, labelled), tmp_path / "root").runs
    assert [run.planner for run in runs] == ["rrt_fast", "eager"]
