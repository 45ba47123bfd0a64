"""The closed forms of bounces, hops, hits and slips against integrated motion and energy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.oracles.hopper import (
    Array,
    Ball,
    BeltBlock,
    Hopper,
    PulledBlock,
    ThrownBlock,
    WalledPendulum,
    impact,
    impact_loss,
    inelastic_impact,
    kept_momenta,
    light_stance_time,
)


def integrate(
    rate: Callable[[float, Array], Array],
    start: Array,
    end: float,
    event: Callable[[float, Array], float] | None = None,
    direction: float = 0,
) -> tuple[float, Array]:
    """Follow ``rate`` to ``end``, or to where ``event`` passes zero in its direction."""

    def passing(t: float, x: Array) -> float:
        return event(t, x) if event and t > 0 else direction

    passing.terminal, passing.direction = True, direction  # type: ignore[attr-defined]
    run = solve_ivp(
        rate, (0, end), start, "DOP853", events=passing if event else None, rtol=1e-12, atol=1e-13
    )
    return float(run.t[-1]), run.y[:, -1]


# Ball


def test_bounces_are_those_of_repeated_falls() -> None:
    ball = Ball(height=1.3, speed=0.8)
    t, v, times, apexes = 0.0, ball.speed, [], []
    z = ball.height
    for _ in range(5):
        takes = (v + np.sqrt(v**2 + 2 * ball.g * z)) / ball.g
        t, v, z = t + takes, ball.e * (ball.g * takes - v), 0.0
        times.append(t)
        apexes.append(v**2 / (2 * ball.g))
    assert ball.bounce_times(5) == pytest.approx(times, rel=1e-13)
    assert ball.apexes(5) == pytest.approx(apexes, rel=1e-13)


def test_bounces_accumulate_at_the_rest_time() -> None:
    ball = Ball()
    times = ball.bounce_times(150)
    assert times[-1] < ball.rest_time
    assert times[-1] == pytest.approx(ball.rest_time, abs=1e-12)
    closed_form = np.sqrt(2 * ball.height / ball.g) * (1 + ball.e) / (1 - ball.e)
    assert ball.rest_time == pytest.approx(closed_form)


def test_ball_is_on_the_ground_as_it_bounces_and_at_its_apex_between() -> None:
    ball = Ball(speed=1.0)
    times = ball.bounce_times(6)
    for n, t in enumerate(times):
        height, speed = ball.state(float(t))
        assert height == pytest.approx(0, abs=1e-12)
        assert speed == pytest.approx(ball.first_speed * ball.e ** (n + 1))
    middles = [ball.state(float(t)) for t in (times[1:] + times[:-1]) / 2]
    assert [z for z, _ in middles] == pytest.approx(list(ball.apexes(5)))
    assert ball.state(ball.rest_time + 1) == (0, 0)
    assert ball.state(0) == (ball.height, ball.speed)


# Hopper


def test_hopper_hops_as_integrated() -> None:
    """Landing, stance, lift-off and flight against Newton's law for two masses."""
    hopper = Hopper()
    m, m_f, k, g = hopper.m, hopper.m_f, hopper.k, hopper.g

    def stance(_: float, x: Array) -> Array:
        pull = -k * x[1] / m - g
        return np.array([x[2], x[3], pull, pull])

    def flight(_: float, x: Array) -> Array:
        body, foot = -k * x[1] / m - g, k * x[1] / m_f - g
        return np.array([x[2], x[3], body, body - foot])

    down = np.array([hopper.L, 0.0, -2.0, -0.5])
    x = hopper.landing(down)
    lost = hopper.energy(down) - hopper.energy(x)
    assert lost == pytest.approx(hopper.landing_loss(down))
    takes, left = integrate(stance, x, 2.0, lambda _, y: k * y[1] - m_f * g, 1)
    assert hopper.lift_off(x) == pytest.approx(takes, abs=1e-10)
    assert hopper.stance(x, takes) == pytest.approx(left, abs=1e-9)
    flies, landed = integrate(flight, left, 2.0, lambda _, y: hopper.foot(y)[0], -1)
    assert hopper.touch_down(left) == pytest.approx(flies, abs=1e-9)
    assert hopper.flight(left, flies) == pytest.approx(landed, abs=1e-9)
    assert hopper.energy(landed) == pytest.approx(hopper.energy(x), rel=1e-10)


def test_hopper_that_lands_softly_stays_down() -> None:
    x = np.array([0.8, 0.0, -0.01, -0.01])
    assert Hopper().lift_off(x) == np.inf


def test_light_foot_leaves_as_on_a_massless_leg() -> None:
    hopper = Hopper(m_f=1e-9)
    x = np.array([hopper.L, 0.0, -2.0, -2.0])
    expected = light_stance_time(2.0, hopper.k, hopper.m, hopper.g)
    assert hopper.lift_off(x) == pytest.approx(expected, abs=1e-9)
    assert hopper.stance(x, expected) == pytest.approx([hopper.L, 0, 2, 2], abs=1e-12)


# Pendulum


@pytest.mark.parametrize("wall", [-0.3, 0.0, 0.4])
def test_pendulum_hits_as_integrated(wall: float) -> None:
    pendulum = WalledPendulum(wall=wall)
    times, speeds = pendulum.hits(3)
    x, t = np.array([pendulum.amplitude, 0.0]), 0.0
    for n in range(3):
        takes, x = integrate(
            lambda _, y: np.array([y[1], -pendulum.g / pendulum.l * np.sin(y[0])]),
            x, 9.0, lambda _, y: y[0] - wall, -1,
        )  # fmt: skip
        t += takes
        assert times[n] == pytest.approx(t, abs=1e-9)
        assert speeds[n] == pytest.approx(-x[1], abs=1e-9)
        x = np.array([wall, -pendulum.e * x[1]])
    assert speeds == pytest.approx(speeds[0] * pendulum.e ** np.arange(3))


def test_wall_at_the_lowest_point_is_hit_every_half_swing() -> None:
    pendulum = WalledPendulum(amplitude=1e-4, wall=0.0)
    half = np.pi * np.sqrt(pendulum.l / pendulum.g)
    assert np.diff(pendulum.hits(4)[0]) == pytest.approx(half, rel=1e-8)


# Impacts


def random_impact(seed: int, n: int = 6, k: int = 3) -> tuple[Array, Array, Array]:
    random = np.random.default_rng(seed)
    root = random.normal(size=(n, n))
    return root @ root.T + np.eye(n), random.normal(size=n), random.normal(size=(k, n))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("e", [0.0, 0.6, 1.0])
def test_impact_loses_what_its_closing_speeds_carry(seed: int, e: float) -> None:
    M, v, J = random_impact(seed)
    after, impulses = impact(M, v, J, e)
    assert J @ after == pytest.approx(-e * J @ v, abs=1e-12)
    assert M @ (after - v) == pytest.approx(J.T @ impulses, abs=1e-11)
    lost = (v @ M @ v - after @ M @ after) / 2
    assert lost == pytest.approx(impact_loss(M, v, J, e), abs=1e-11)
    kept = kept_momenta(M, J)
    assert kept.shape == (3, 6)
    assert kept @ after == pytest.approx(kept @ v, abs=1e-11)


def test_elastic_balls_exchange_their_velocities() -> None:
    after, _ = impact(np.eye(2), np.array([1.0, 0.0]), np.array([[-1.0, 1.0]]), 1.0)
    assert after == pytest.approx([0, 1])


@pytest.mark.parametrize("seed", range(5))
def test_inelastic_impact_is_the_nearest_allowed_velocity(seed: int) -> None:
    M, v, J = random_impact(seed)
    after, pushes = inelastic_impact(M, v, J)
    assert (J @ after > -1e-10).all()
    assert (pushes >= -1e-10).all()
    assert pushes @ (J @ after) == pytest.approx(0, abs=1e-9)
    random = np.random.default_rng(seed)
    for other in random.normal(size=(200, 6)):
        if (J @ other >= 0).all():
            assert (other - v) @ M @ (other - v) >= (after - v) @ M @ (after - v) - 1e-9


# Blocks


def test_pulled_block_slips_as_integrated() -> None:
    block = PulledBlock()
    start, end = block.slip_time, block.slip_time + 1.5
    assert block.state(start) == (0, 0)
    _, x = integrate(
        lambda t, x: np.array([x[1], block.rate * (t + start) / block.m - block.mu_k * block.g]),
        np.zeros(2), end - start,
    )  # fmt: skip
    assert block.state(end) == pytest.approx(tuple(x), abs=1e-10)


def test_block_on_a_belt_slips_until_it_is_as_fast() -> None:
    block = BeltBlock()
    takes, x = integrate(
        lambda _, x: np.array([x[1], block.mu_k * block.g - block.k / block.m * x[0]]),
        np.array([block.slip_place, block.belt]), 5.0, lambda _, x: x[1] - block.belt, 1,
    )  # fmt: skip
    assert block.slip_time == pytest.approx(takes, abs=1e-9)
    assert block.stick_place == pytest.approx(x[0], abs=1e-9)
    first = block.slip_place / block.belt
    assert block.state(first) == pytest.approx((block.slip_place, block.belt))
    again = first + 2 * (block.slip_time + block.stick_time) + block.slip_time / 3
    assert block.state(again) == pytest.approx(block.state(first + block.slip_time / 3))


def test_thrown_block_stays_or_returns() -> None:
    steep, flat = ThrownBlock(angle=0.5, mu=0.3), ThrownBlock(angle=0.5, mu=0.6)
    assert not steep.stays
    assert flat.stays
    late = flat.stop_time + 1
    assert flat.state(late) == (flat.stop_place, 0)
    back = steep.stop_time + np.sqrt(2 * steep.stop_place / steep.hastening)
    assert steep.state(back) == pytest.approx((0, -steep.return_speed), abs=1e-12)
    # Friction takes mu m g cos(angle) over the way there and back.
    lost = (steep.speed**2 - steep.return_speed**2) / 2
    way = 2 * steep.stop_place
    assert lost == pytest.approx(steep.mu * steep.g * np.cos(steep.angle) * way)


def test_thrown_block_follows_newton() -> None:
    block, h = ThrownBlock(), 1e-4
    for t in (0.3 * block.stop_time, 2 * block.stop_time):
        (before, _), (now, v), (after, _) = (block.state(s) for s in (t - h, t, t + h))
        weight = -block.g * np.sin(block.angle)
        friction = -np.sign(v) * block.mu * block.g * np.cos(block.angle)
        assert (after - before) / (2 * h) == pytest.approx(v, abs=1e-9)
        assert (after - 2 * now + before) / h**2 == pytest.approx(weight + friction, abs=1e-5)
