"""Gymnasium's own checker, and what an episode must be."""

from __future__ import annotations

import copy
import pickle
import warnings
from typing import Any

import numpy as np
import pytest

import kinolab
import kinolab.gym
from kinolab.errors import InputError
from tests.support import OPEN, WALL

gymnasium = pytest.importorskip("gymnasium")
ResetNeeded = pytest.importorskip("gymnasium.error").ResetNeeded
check_env = pytest.importorskip("gymnasium.utils.env_checker").check_env

WALL_FACE = 2.95  # [m] where the wall of WALL begins
NAMES = ("pendulum_swingup", "rolling_disk_maze", "satellite_pointing")


@pytest.mark.parametrize("name", NAMES)
def test_gymnasium_s_checker_passes(name: str) -> None:
    env = kinolab.gym.make(name, render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*does not have a spec|.*alternative render")
        warnings.filterwarnings("ignore", message=".*Box observation space m.*infinity")
        check_env(env)


def test_a_plan_s_inputs_lead_an_episode_to_the_goal() -> None:
    """Planner and environment obey the same law: what one found, the other rewards."""
    problem = kinolab.load("pendulum_swingup")
    plan = problem.solve(seed=1, improve=0, optimize=False)
    assert plan.trajectory is not None
    env = kinolab.gym.make(problem, reward="sparse")
    env.reset(seed=0)
    rewards, ended, info = [], False, {}
    for action in env.actions(plan.trajectory):
        assert not ended
        _, reward, ended, truncated, info = env.step(action)
        assert not truncated
        rewards.append(reward)
    assert ended
    assert info["is_success"]
    assert rewards == [0.0] * (len(rewards) - 1) + [1.0]
    assert info["x"] == pytest.approx(plan.trajectory.x[-1], abs=0.05)  # one step's error grows


def test_a_wall_ends_the_episode(tmp_path: Any) -> None:
    path = tmp_path / "wall.toml"
    path.write_text(OPEN + WALL)
    beyond = kinolab.load(path, overrides=["goal.x=4.5"])
    env = kinolab.gym.make(beyond, reward="sparse")
    env.reset()
    model = env.problem.model
    forward = np.zeros(model.nu, dtype=np.float32)
    forward[model.control_names.index("drive")] = 1.0
    ended, before, info = False, env.problem.start, {"t": 0.0}
    while not ended:
        push = forward * (info["t"] < 0.5)  # it rolls on: nothing brakes it
        _, reward, ended, truncated, info = env.step(push)
        assert not truncated
        before = before if ended else info["x"]
    assert info["failed"] == "collision"
    assert reward == -1.0
    radius = env.problem.bodies[0].shapes[0].radius
    assert before[0] + radius <= WALL_FACE < info["x"][0] + radius + 0.01


def test_shaped_rewards_add_up_to_the_part_of_the_way_that_was_made() -> None:
    """Ng, Harada, Russell, Policy invariance under reward transformations, 1999: they telescope."""
    env = kinolab.gym.make("rolling_disk_maze")
    generator = np.random.default_rng(3)
    env.reset(seed=1)
    first, total, ended = env.problem.goal_excess(env.problem.start), 0.0, False
    for _ in range(20):
        action = generator.uniform(-1, 1, env.problem.model.nu).astype(np.float32)
        _, reward, ended, _, info = env.step(action)
        total += reward
        if ended:
            break
    left = env.problem.goal_excess(info["x"])
    assert total + bool(info["failed"]) == pytest.approx((first - left) / first, rel=1e-9)


def test_an_episode_is_truncated_at_its_duration() -> None:
    env = kinolab.gym.make("pendulum_swingup", duration=0.5)
    env.reset()
    steps = 0
    while True:
        *_, ended, truncated, info = env.step(np.zeros(1, dtype=np.float32))
        steps += 1
        if truncated or ended:
            break
    assert truncated
    assert not ended
    assert info["t"] == pytest.approx(0.5)


def test_random_starts_are_free_and_depend_on_the_seed_alone() -> None:
    env = kinolab.gym.make("rolling_disk_maze", starts="anywhere")
    first = [env.reset(seed=5)[1]["x"], env.reset()[1]["x"]]
    again = [env.reset(seed=5)[1]["x"], env.reset()[1]["x"]]
    assert np.array_equal(first, again)
    assert not np.array_equal(*first)
    for x in first:
        assert not env.problem.checker().collides(*env.problem.placement(x))


def test_observations_are_named_and_on_the_circle() -> None:
    env = kinolab.gym.make("pendulum_swingup")
    seen, _ = env.reset(options={"x": [2.0, 1.0]})
    assert env.observation_names == ["cos theta", "sin theta", "theta_dot"]
    assert seen[:2] == pytest.approx([np.cos(2.0), np.sin(2.0)])


def test_copies_do_what_single_environments_do() -> None:
    count, steps = 5, 60
    vector = kinolab.gym.make("rolling_disk_maze", num_envs=count)
    singles = [kinolab.gym.make("rolling_disk_maze") for _ in range(count)]
    seen, _ = vector.reset(seed=1)
    for k, env in enumerate(singles):
        assert np.array_equal(env.reset()[0], seen[k])
    generator, ended = np.random.default_rng(0), np.zeros(count, dtype=bool)
    episodes = 0
    for _ in range(steps):
        actions = generator.uniform(-1, 1, vector.action_space.shape).astype(np.float32)
        seen, rewards, terminated, truncated, _ = vector.step(actions)
        for k, env in enumerate(singles):
            anew = ended[k]  # this step only resets it
            expected = (env.reset()[0], 0.0, False, False) if anew else env.step(actions[k])[:4]
            assert np.array_equal(seen[k], expected[0])
            assert rewards[k] == pytest.approx(expected[1])
            assert (terminated[k], truncated[k]) == expected[2:]
        ended = terminated | truncated
        episodes += int(ended.sum())
    assert episodes > 0


def test_the_machine_moves_as_the_equations_say() -> None:
    """SciPy's integrator, which shares nothing with the compiled step."""
    from scipy.integrate import solve_ivp

    env = kinolab.gym.make("pendulum_swingup")
    env.reset()
    model, x = env.problem.model, env.problem.start
    *_, info = env.step(np.array([0.5], dtype=np.float32))
    u = [0.5 * model.control_bounds[0, 1]]
    span = (0.0, env.problem.step)
    exact = solve_ivp(lambda _, s: model.f(s, u), span, x, rtol=1e-10, atol=1e-12).y[:, -1]
    assert info["x"] == pytest.approx(exact, abs=1e-5)


@pytest.mark.parametrize("action", [[], [0.0, 0.0], [[0.0]], 0.0, [np.nan], None, "left", [np.inf]])
def test_actions_that_are_none_are_refused(action: Any) -> None:
    env = kinolab.gym.make("pendulum_swingup")
    env.reset()
    with pytest.raises(InputError, match=r"^action: it .* shape \(1,\)"):
        env.step(action)


@pytest.mark.parametrize("shape", [(1, 1), (2, 1), (4,), (4, 2), (3, 1)])
def test_a_vector_s_actions_have_a_row_for_each_copy(shape: tuple[int, ...]) -> None:
    vector = kinolab.gym.make("pendulum_swingup", num_envs=4)
    vector.reset(seed=1)
    with pytest.raises(InputError, match=r"it must be \(4, 1\)"):
        vector.step(np.zeros(shape, dtype=np.float32))


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"x": [np.nan, 0.0]}, "not finite"),
        ({"x": [0.0]}, r"it must be \(2,\)"),
        ({"x": "here"}, "not made of numbers"),
        ({"y": 1}, "no option is called 'y'"),
        ("x", 'Give {"x": state} or None'),
    ],
)
def test_options_of_reset_are_checked(options: Any, text: str) -> None:
    for env in (
        kinolab.gym.make("pendulum_swingup"),
        kinolab.gym.make("pendulum_swingup", num_envs=2),
    ):
        with pytest.raises(InputError, match=text):
            env.reset(options=options)


def test_actions_of_feedback_are_its_references() -> None:
    problem = kinolab.load("falling_disk_slalom")
    plan = problem.solve(seed=1, improve=0, optimize=False)
    assert plan.trajectory is not None
    env = kinolab.gym.make(problem, reward="sparse")
    env.reset()
    for action in env.actions(plan.trajectory):
        *_, ended, _, info = env.step(action)
        if ended:
            break
    assert info["is_success"]


def test_actions_of_other_motions_are_refused() -> None:
    env = kinolab.gym.make("pendulum_swingup")
    other = kinolab.simulate(kinolab.load("rolling_disk_maze"), duration=0.5)
    with pytest.raises(InputError, match="those of pendulum are theta, theta_dot"):
        env.actions(other)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"reward": "dense"}, "no reward is called 'dense'"),
        ({"starts": "random"}, "no starts is called 'random'"),
        ({"duration": -1.0}, "-1.0 s is no duration"),
        ({"num_envs": 0}, "Give a number from 1 to 100000"),
        ({"num_envs": 10**9}, "Give a number from 1 to 100000"),
        ({"reward": 3}, "make reward"),
        ({"duration": "10"}, "make duration"),
        ({"num_envs": 2, "render_mode": "rgb_array"}, "draws nothing"),
        ({"render_mode": "human"}, 'Give "rgb_array" or None'),
    ],
)
def test_arguments_that_do_not_fit_are_named(options: dict[str, Any], text: str) -> None:
    with pytest.raises(InputError, match=text):
        kinolab.gym.make("pendulum_swingup", **options)


def test_a_frame_shows_the_machine() -> None:
    env = kinolab.gym.make("rolling_disk_maze", render_mode="rgb_array")
    env.reset()
    before = env.render()
    for _ in range(20):
        env.step(np.array([1.0, 0.0], dtype=np.float32))
    after = env.render()
    assert before is not None
    assert after is not None
    assert before.shape == (480, 640, 3)
    assert np.any(before != after)


def test_no_step_comes_before_the_first_reset() -> None:
    for count in (None, 2):
        env = kinolab.gym.make("pendulum_swingup", num_envs=count)
        with pytest.raises(ResetNeeded, match=r"no episode has begun\. Call reset\(\) first\."):
            env.step(env.action_space.sample())
    with pytest.raises(ResetNeeded):
        kinolab.gym.make("pendulum_swingup", render_mode="rgb_array").render()


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
@pytest.mark.parametrize("count", [None, 3])
def test_a_copy_goes_on_where_the_first_one_is(copied: Any, count: int | None) -> None:
    """And what becomes of it leaves the first one alone."""
    env = kinolab.gym.make("pendulum_swingup", num_envs=count, starts="anywhere")
    env.reset(seed=4)
    action = env.action_space.sample()
    env.step(action)
    other = copied(env)
    states = [other.step(action)[-1]["x"] for _ in range(3)]
    assert np.array_equal([env.step(action)[-1]["x"] for _ in range(3)], states)
    assert np.array_equal(env.reset()[1]["x"], other.reset()[1]["x"])  # the same random numbers


def test_gymnasium_makes_built_in_scenarios_by_id() -> None:
    env = gymnasium.make("kinolab/pendulum_swingup-v0", reward="sparse")
    assert env.unwrapped.problem.name == "pendulum_swingup"
    assert env.spec is not None
    assert env.spec.id == "kinolab/pendulum_swingup-v0"
    copies = gymnasium.make_vec("kinolab/rolling_disk_maze-v0", num_envs=2)
    assert copies.reset(seed=1)[0].shape[0] == 2
