"""Rigid motions."""

from __future__ import annotations

from cmath import exp
from collections.abc import Mapping, Sequence
from math import cos, sin, tan
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from kinolab.testing.answers.judging import (
    Exercise,
    WrongAnswerError,
    require_model,
    require_motion,
    require_values,
)

G, LENGTH = 9.81, 1.0  # [m/s^2], [m] of the rod
HITCH, BAR = 0.5, 1.2  # [m] behind the car's axle, and of the trailer
CARS = [(0.0, 0.0, 0.0, 0.0), (1.0, -2.0, 0.7, 0.4), (-3.0, 0.5, -2.0, 1.1), (2.0, 2.0, 1.6, -0.8)]


def _moving() -> list[tuple[np.ndarray, np.ndarray]]:
    """Frames and their derivatives, under velocities along the world's axes."""
    cases: list[tuple[np.ndarray, np.ndarray]] = []
    for turned in Rotation.random(4, random_state=2).as_matrix():
        place, linear, angular = np.random.default_rng(len(cases)).uniform(-2.0, 2.0, (3, 3))
        g, g_dot = np.eye(4), np.zeros((4, 4))
        g[:3, :3], g[:3, 3] = turned, place
        g_dot[:3, :3], g_dot[:3, 3] = np.cross(angular, turned, axisb=0, axisc=0), linear
        cases.append((g, g_dot))
    return cases


def _body_velocity(g: np.ndarray, g_dot: np.ndarray) -> np.ndarray:
    """Of how the axes turn: twice the angular velocity is the sum of axis x rate over them."""
    axes = g[:3, :3]
    angular = np.cross(axes, g_dot[:3, :3], axis=0).sum(axis=1) / 2.0
    return np.concatenate([axes.T @ g_dot[:3, 3], axes.T @ angular])


def _trailer(x: float, y: float, psi: float, beta: float) -> list[float]:
    """In the complex plane."""
    place = complex(x, y) - exp(1j * psi) * (HITCH + BAR * exp(1j * beta))
    return [place.real, place.imag, psi + beta]


def _rod(answer: Any) -> None:
    """Of T = m l^2 / 6 (beta_dot^2 + sin(beta)^2 alpha_dot^2), by hand; and where it hangs then.

    The equations of motion are the same if an angle counts the other way.
    """

    def accelerations(state: Mapping[str, float], _: Sequence[float]) -> dict[str, float]:
        beta, turn, swing = (state[name] for name in ("beta", "alpha_dot", "beta_dot"))
        return {
            "alpha": -2.0 * turn * swing / tan(beta),
            "beta": turn**2 * sin(beta) * cos(beta) - 1.5 * G / LENGTH * sin(beta),
        }

    require_motion(answer, ["alpha", "beta"], accelerations)
    model = require_model(answer)
    if len(answer.bodies) > 1:  # what of the rod each of them is, cannot be known
        return
    x = np.zeros(model.nx)
    x[[model.state_names.index(name) for name in ("alpha", "beta")]] = 0.3, 0.8
    middle = np.asarray(model.frames(x))[0].reshape(3, 4)[:, 3]
    along = np.array([sin(0.8) * cos(0.3), sin(0.8) * sin(0.3), cos(0.8)])
    if not np.allclose(middle, -LENGTH / 2.0 * along, atol=1e-6):  # [m]
        own, due = (", ".join(f"{x:.4g}" for x in at) for at in (middle, -LENGTH / 2.0 * along))
        what = f"at alpha = 0.3, beta = 0.8 its centre of mass is at ({own})"
        raise WrongAnswerError(what, f"({due})")


EXERCISES = (
    Exercise("2.1", 2, lambda a: require_values(a, _body_velocity, _moving())),
    Exercise("2.2", 2, lambda answer: require_values(answer, _trailer, CARS)),
    Exercise("2.3", 3, _rod),
)
