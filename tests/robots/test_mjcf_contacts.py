"""What an MJCF file lets touch: as MuJoCo's own collision detection has it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.problem.warnings import problem_warnings
from kinolab.robots import read_mjcf
from kinolab.robots.mjcf.mjcf_tree import allowed_pairs

mujoco: Any = pytest.importorskip("mujoco")


def heap(generator: np.random.Generator, exclude: str, pair: str) -> Any:
    """Five bodies in one place, of one or two balls with random bits."""
    bits = 'contype="{}" conaffinity="{}"'
    bodies = "".join(
        f'<body name="{k}"><freejoint/>'
        + "".join(
            f'<geom name="{k}{n}" size="0.1" {bits.format(*generator.integers(4, size=2))}/>'
            for n in range(1 + k % 2)
        )
        + "</body>"
        for k in range(5)
    )
    text = f"<mujoco><worldbody>{bodies}</worldbody><contact>{exclude}{pair}</contact></mujoco>"
    return mujoco.MjModel.from_xml_string(text)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("exclude", ["", '<exclude body1="3" body2="1"/>'])
@pytest.mark.parametrize("pair", ["", '<pair geom1="31" geom2="10"/>'])
def test_the_filter_is_mujoco_s(seed: int, exclude: str, pair: str) -> None:
    model = heap(np.random.default_rng(seed), exclude, pair)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    names = [model.body(k).name for k in range(model.nbody)]
    touching = {
        frozenset(names[model.geom_bodyid[g]] for g in contact.geom) for contact in data.contact
    }
    solids = [[g for g in range(model.ngeom) if model.geom_bodyid[g] == b] for b in range(6)]
    free = allowed_pairs(model, names, solids)
    assert touching.isdisjoint(free)
    assert len(touching) + len(free) == 5 * 4 / 2


ARMS = """<mujoco><worldbody><body name="base" pos="0 0 1"><joint name="turn" axis="0 0 1"/>
  <geom name="hub" size="0.05" mass="1"/>
  <body name="left" pos="0 1 0"><joint name="l" type="slide" axis="0 1 0" range="-2 2"/>
    <geom name="gl" size="0.1" mass="1" {}/></body>
  <body name="right" pos="0 -1 0"><joint name="r" type="slide" axis="0 1 0" range="-2 2"/>
    <geom name="gr" size="0.1" mass="1" {}/></body></body></worldbody>
  <actuator><motor joint="l" ctrlrange="-1 1"/><motor joint="r" ctrlrange="-1 1"/></actuator>
  <contact>{}</contact></mujoco>"""
EXCLUDED = '<exclude body1="right" body2="left"/>'
WANTED = '<pair geom1="gl" geom2="gr"/>'
NONE = 'contype="0" conaffinity="0"'


@pytest.mark.parametrize(
    ("left", "right", "contact", "watched"),
    [
        ("", "", "", True),
        ('contype="2"', 'conaffinity="2"', "", True),
        ('contype="2"', 'contype="4"', "", False),
        (NONE, "", "", False),
        (NONE, NONE, WANTED, True),
        ("", "", EXCLUDED, False),
        ("", "", EXCLUDED + WANTED, True),
    ],
)
def test_what_a_file_lets_touch_is_not_watched_and_told(
    tmp_path: Path, left: str, right: str, contact: str, watched: bool
) -> None:
    (tmp_path / "arms.xml").write_text(ARMS.format(left, right, contact))
    (tmp_path / "s.toml").write_text(
        'schema = 1\ntitle = "t"\n[system]\nfile = "arms.xml"\n[goal]\nl = 0.5\n'
        "[bounds]\nturn_dot = [-1, 1]\nl_dot = [-1, 1]\nr_dot = [-1, 1]\n"
    )
    problem = kinolab.load(tmp_path / "s.toml")
    assert (("left", "right") in problem.system.collisions) is watched
    told = [one for one in problem_warnings(problem) if "touch" in one]
    said = "These bodies may touch each other unnoticed: left and right."
    assert told == ([] if watched else [said])


def test_robots_of_one_file_are_kept_apart_whatever_it_says(tmp_path: Path) -> None:
    bodies = "".join(
        f'<body name="{name}" pos="{x} 0 0"><joint name="{name}x" type="slide" axis="1 0 0"/>'
        '<geom size="0.1" mass="1" conaffinity="0"/></body>'
        for name, x in (("A", 0), ("B", 3))
    )
    (tmp_path / "two.xml").write_text(f"<mujoco><worldbody>{bodies}</worldbody></mujoco>")
    system = read_mjcf(tmp_path / "two.xml")
    assert (system.collisions, system.unwatched) == ((("A", "B"),), ())
