"""From a study to its runs: their number, their order, their points and their identities."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from kinolab.studies.expansion import expanded, run_count, sobol_points
from kinolab.studies.run_study import StudyFolder, StudyPart
from kinolab.studies.study_file import Sobol
from tests.studies.tiny_study import TINY, study_in
from tests.support import needs

SWEPT = """\
schema = 1
title = "t"
scenarios = ["pendulum_swingup"]
planners = ["kpiece_fast", "rrt_fast"]
seeds = [4, 2]
[sweep]
"goal.tolerance.theta" = [0.1, 0.2]
"metric.theta_dot" = [0.3, 0.4, 0.5]
[sobol]
points = 4
[sobol.ranges]
"start.theta" = { from = -0.1, to = 0.1 }
"""


def test_seeds_vary_slowest_and_sequences_fastest(tmp_path: Path) -> None:
    """2 seeds x 2 planners x (2 x 3) of a grid x 4 points of a sequence: 96 runs."""
    study = study_in(tmp_path, SWEPT)
    runs = expanded(study, tmp_path / "root").runs
    assert len(runs) == run_count(study) == 96
    assert [run.index for run in runs] == [*range(96)]
    assert [run.seed for run in runs] == [2] * 48 + [4] * 48
    assert [run.planner for run in runs] == (["kpiece_fast"] * 24 + ["rrt_fast"] * 24) * 2
    grid = [tuple(value for _, value in run.settings[:2]) for run in runs[:24]]
    assert grid[::4] == [(0.1, 0.3), (0.1, 0.4), (0.1, 0.5), (0.2, 0.3), (0.2, 0.4), (0.2, 0.5)]
    points = [run.settings[2][1] for run in runs]
    assert points == points[:4] * 24
    assert len(set(points[:4])) == 4


def sequence(points: int, **ranges: tuple[float, float, str]) -> list[dict[str, float]]:
    told = {k: {"from": a, "to": b, "scale": s} for k, (a, b, s) in ranges.items()}
    sobol = Sobol.model_validate({"points": points, "seed": 3, "ranges": told})
    return [dict(point) for point in sobol_points(sobol)]


@pytest.mark.parametrize("k", [0, 3, 6])
def test_each_stratum_of_each_axis_has_one_point(k: int) -> None:
    """Any 2^k first points of the sequence, scrambled or not, are a Latin hypercube.

    On a logarithmic scale the strata are equal in the logarithm.
    """
    n = 2**k
    found = sequence(n, a=(-2.0, 6.0, "linear"), b=(1e-3, 10.0, "log"), c=(1e-300, 1e300, "log"))
    strata = {
        "a": [(point["a"] + 2.0) / 8.0 for point in found],
        "b": [math.log10(point["b"] / 1e-3) / 4.0 for point in found],
        "c": [(math.log10(point["c"]) + 300.0) / 600.0 for point in found],
    }
    for shares in strata.values():
        assert sorted(math.floor(share * n) for share in shares) == [*range(n)]


def test_points_are_the_first_of_a_longer_sequence() -> None:
    ranges = {"a": (0.0, 1.0, "linear"), "b": (0.0, 1.0, "linear")}
    assert sequence(5, **ranges) == sequence(8, **ranges)[:5]


def identities(folder: Path, text: str) -> list[str]:
    study = study_in(folder, text)
    runs = expanded(study, folder / "root").runs
    return [run.identity(study.limits.model_dump()) for run in runs]


def test_the_same_study_has_the_same_identities_and_another_one_others(tmp_path: Path) -> None:
    mesh = tmp_path / "post.off"
    mesh.write_text("OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n")
    (tmp_path / "mine.toml").write_text(
        'schema = 1\ntitle = "t"\n[system]\nname = "pendulum"\n'
        '[[world.obstacle]]\nmesh = "post.off"\nposition = [5.0, 5.0, 5.0]\n'
        "[goal]\ntheta = 0.5\ntolerance = 0.2\n"
    )
    text = TINY.replace("pendulum_swingup", "mine.toml") + "seeds = [1, 2]\n"
    first = identities(tmp_path, text)
    assert len(set(first)) == 2
    assert identities(tmp_path, text) == first
    changed = [
        text.replace("[1, 2]", "[1, 3]"),
        text + "improve = true\n",
        text + "check = true\n",
        text + "[limits]\niterations = 5\n",
        text + "[limits]\nmemory = 500\n",
        text + '[settings]\n"start.theta" = 0.1\n',
        text + '[sweep]\n"start.theta" = [0.1]\n',
        text.replace("kpiece", "rrt"),
    ]
    others = [identities(tmp_path, other) for other in changed]
    assert others[0][0] == first[0]
    mesh.write_text(mesh.read_text().replace("0 0 1\n", "0 0 2\n", 1))
    others.append(identities(tmp_path, text))
    assert len({first[1], *(other[1] for other in others)}) == 1 + len(others)


@needs("pyarrow")
def test_parts_are_disjoint_and_complete(tmp_path: Path) -> None:
    runs = StudyFolder(study_in(tmp_path, TINY + "seeds = 11\n"), tmp_path / "out").runs.runs
    parts = [[run.index for run in runs if StudyPart(k, 3).has(run)] for k in (1, 2, 3)]
    assert parts == [[0, 3, 6, 9], [1, 4, 7, 10], [2, 5, 8]]
