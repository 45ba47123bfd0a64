"""Small machines that bounce, hop, hit and stick, in closed form; SI units.

Ball: bounces on the ground with restitution e, at last infinitely often in finite time.
Hopper: a mass on a leg spring; its foot lands plastically and leaves once the ground would pull.
Pendulum: swings against a wall and off it with restitution e.
Impact: M (v+ - v-) = J^T L for any machine.
Blocks: pulled by a growing force, carried by a belt, thrown up an incline, under Coulomb friction.

Sources:
    Brogliato, Nonsmooth Mechanics, 3rd ed., 2016: restitution, accumulation of bounces, energy lost
        in an impact.
    Moreau, Unilateral contact and dry friction in finite freedom dynamics, 1988: an inelastic
        impact projects the velocity onto what the contacts allow, in the norm of M.
    Raibert, Legged Robots That Balance, 1986, chapter 2: a springy leg with unsprung mass.
    Byrd, Friedman, Handbook of Elliptic Integrals, 1971: K and F.
    Den Hartog, Mechanical Vibrations, 1956: stick and slip on a belt.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain, combinations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import ellipk, ellipkinc

Array = NDArray[np.float64]


# Ball


@dataclass(frozen=True)
class Ball:
    """A point that falls and bounces.

    Attributes:
        height: Where it starts above the ground in [m].
        speed: How fast it starts upwards in [m/s].
        e: Coefficient of restitution, from 0 to below 1.
        g: Gravity in [m/s^2].
    """

    height: float = 1.0
    speed: float = 0.0
    e: float = 0.8
    g: float = 9.81

    @property
    def first_speed(self) -> float:
        """How fast it meets the ground for the first time, in [m/s]."""
        return float(np.sqrt(self.speed**2 + 2 * self.g * self.height))

    @property
    def first_time(self) -> float:
        """When it does, in [s]."""
        return (self.speed + self.first_speed) / self.g

    @property
    def rest_time(self) -> float:
        """When the last of its infinitely many bounces is over, in [s]: a geometric series."""
        return self.first_time + 2 * self.first_speed / self.g * self.e / (1 - self.e)

    def bounce_times(self, count: int) -> Array:
        """Return the times of the first bounces in [s], shape (count,).

        Between bounce n and the next lies 2 e^n v / g, v being the first speed.
        """
        flights = 2 * self.first_speed / self.g * self.e ** np.arange(1, count)
        return np.asarray(self.first_time + np.concatenate([[0.0], flights.cumsum()]))

    def apexes(self, count: int) -> Array:
        """Return the greatest heights after the first bounces in [m], shape (count,)."""
        return np.asarray(
            self.first_speed**2 / (2 * self.g) * self.e ** (2 * np.arange(1, count + 1))
        )

    def state(self, t: float) -> tuple[float, float]:
        """Return height in [m] and velocity upwards in [m/s]; after a bounce at its very time."""
        if t < self.first_time:
            return self.height + self.speed * t - self.g * t**2 / 2, self.speed - self.g * t
        if t >= self.rest_time:
            return 0.0, 0.0
        # What is left of the series, r = (rest - t) / (rest - first), is e^n just after bounce n+1.
        share = (self.rest_time - t) / (self.rest_time - self.first_time)
        n = int(np.floor(np.log(share) / np.log(self.e) + 1e-12))
        since = t - self.bounce_times(n + 1)[-1]
        rebound = self.first_speed * self.e ** (n + 1)
        return rebound * since - self.g * since**2 / 2, rebound - self.g * since


# Hopper


@dataclass(frozen=True)
class Hopper:
    """A body on a spring above a foot, both moving along the vertical without loss between blows.

    States are (z, s, z_dot, s_dot): the body's height and the spring's stretch, whence the foot's
    height is z - L - s.

    Attributes:
        m: Body in [kg].
        m_f: Foot in [kg], positive.
        k: Spring in [N/m].
        L: Length of the leg at rest in [m].
        g: Gravity in [m/s^2].
    """

    m: float = 8.0
    m_f: float = 1.0
    k: float = 2000.0
    L: float = 0.8
    g: float = 9.81

    def foot(self, x: Array) -> tuple[float, float]:
        """Return the foot's height in [m] and its velocity in [m/s]."""
        return float(x[0] - self.L - x[1]), float(x[2] - x[3])

    def energy(self, x: Array) -> float:
        """Return the energy in [J]; zero at rest on the ground with a relaxed spring."""
        place, speed = self.foot(x)
        kinetic = self.m * x[2] ** 2 + self.m_f * speed**2 + self.k * x[1] ** 2
        return float(kinetic / 2 + self.g * (self.m * (x[0] - self.L) + self.m_f * place))

    def stance(self, x: Array, t: float) -> Array:
        """Return the state, shape (4,), after ``t`` in [s] with the foot on the ground.

        m s_ddot = -k s - m g: a harmonic motion about -m g / k.
        """
        w, middle = np.sqrt(self.k / self.m), -self.m * self.g / self.k
        c, s = np.cos(w * t), np.sin(w * t)
        stretch = middle + (x[1] - middle) * c + x[3] / w * s
        rate = x[3] * c - (x[1] - middle) * w * s
        return np.array([self.L + stretch, stretch, rate, rate])

    def lift_off(self, x: Array) -> float:
        """Return how long after a stance state the ground would first pull, in [s]; inf if never.

        The spring then carries the foot, s = m_f g / k, while it still lengthens.
        """
        w, middle = np.sqrt(self.k / self.m), -self.m * self.g / self.k
        size = np.hypot(x[1] - middle, x[3] / w)
        reach = self.m_f * self.g / self.k - middle
        if reach > size:
            return float(np.inf)
        phase = np.arctan2(-x[3] / w, x[1] - middle)  # s - middle = size cos(w t + phase)
        return float(np.mod(-np.arccos(reach / size) - phase, 2 * np.pi) / w)

    def flight(self, x: Array, t: float) -> Array:
        """Return the state, shape (4,), after ``t`` in [s] in the air.

        The common centre falls freely; the stretch swings about zero, with the reduced mass.
        """
        total = self.m + self.m_f
        w = np.sqrt(self.k * total / (self.m * self.m_f))
        c, s = np.cos(w * t), np.sin(w * t)
        stretch, rate = x[1] * c + x[3] / w * s, x[3] * c - x[1] * w * s
        share = self.m_f / total  # the centre lies share (L + s) below the body
        centre, velocity = x[0] - share * (self.L + x[1]), x[2] - share * x[3]
        centre, velocity = centre + velocity * t - self.g * t**2 / 2, velocity - self.g * t
        place = centre + share * (self.L + stretch)
        return np.array([place, stretch, velocity + share * rate, rate])

    def touch_down(self, x: Array) -> float:
        """Return how long after a flight state the foot is next on the ground, in [s].

        Looked for in steps of a thirtieth of the leg's swing, and refined to rounding.
        """
        w = np.sqrt(self.k * (self.m + self.m_f) / (self.m * self.m_f))
        step = 2 * np.pi / w / 30

        def height(t: float) -> float:
            return self.foot(self.flight(x, t))[0]

        t = step
        while height(t) > 0:
            t += step
        return float(brentq(height, t - step if t > step else 1e-3 * step, t, xtol=1e-15))

    def landing(self, x: Array) -> Array:
        """Return the state after the foot stopped, shape (4,); the body feels nothing."""
        return np.array([x[0], x[1], x[2], x[2]])

    def landing_loss(self, x: Array) -> float:
        """Return what the impact takes in [J], of the state before it."""
        return self.m_f * self.foot(x)[1] ** 2 / 2


def light_stance_time(v: float, k: float, m: float, g: float) -> float:
    """Return how long a mass on a massless spring stays down in [s], landing at ``v`` in [m/s].

    Stretch s + m g / k = A cos(w t + d) with A cos d = g / w^2, A sin d = v / w.
    """
    w = np.sqrt(k / m)
    return float((2 * np.pi - 2 * np.arctan2(v * w, g)) / w)


# Pendulum and wall


@dataclass(frozen=True)
class WalledPendulum:
    """A point on a rod, released at rest above a wall that it swings down to.

    Angles from hanging down, in [rad]; 0 < amplitude < pi and |wall| < amplitude.

    Attributes:
        amplitude: Where it is released.
        wall: Where the wall is; it stops what comes from greater angles.
        e: Coefficient of restitution.
        l: Rod in [m].
        g: Gravity in [m/s^2].
    """

    amplitude: float = 1.5
    wall: float = -0.3
    e: float = 0.7
    l: float = 1.0  # noqa: E741
    g: float = 9.81

    def speed(self, amplitude: float) -> float:
        """Return how fast it meets the wall from rest at an amplitude, in [rad/s]."""
        fall = np.cos(self.wall) - np.cos(amplitude)
        return float(np.sqrt(2 * self.g / self.l * fall))

    def fall_time(self, amplitude: float) -> float:
        """Return how long it takes from rest at an amplitude to the wall, in [s].

        With sin(angle / 2) = k sin(phi), k = sin(amplitude / 2), the time from the lowest point to
        an angle is sqrt(l / g) F(phi, k), and a quarter of a period sqrt(l / g) K(k).
        """
        k = np.sin(amplitude / 2)
        phi = np.arcsin(np.sin(self.wall / 2) / k)
        return float(np.sqrt(self.l / self.g) * (ellipk(k**2) - ellipkinc(phi, k**2)))

    def rebound(self, amplitude: float) -> float:
        """Return the amplitude after an impact, from the one before it.

        cos(wall) - cos(amplitude) is what the impact multiplies by e^2.
        """
        fall = self.e**2 * (np.cos(self.wall) - np.cos(amplitude))
        return float(np.arccos(np.cos(self.wall) - fall))

    def hits(self, count: int) -> tuple[Array, Array]:
        """Return times in [s] and speeds before the blows in [rad/s], shapes (count,).

        Energy brings the pendulum back as fast as it left, so that the speeds fall as e^n. The
        times accumulate where the wall leans under the pendulum (wall > 0), and nowhere else.
        """
        times, speeds = [self.fall_time(self.amplitude)], [self.speed(self.amplitude)]
        amplitude = self.amplitude
        for _ in range(count - 1):
            amplitude = self.rebound(amplitude)
            times.append(times[-1] + 2 * self.fall_time(amplitude))
            speeds.append(self.speed(amplitude))
        return np.array(times), np.array(speeds)


# Impacts of any machine


def impact(M: Array, v: Array, J: Array, e: float = 0.0) -> tuple[Array, Array]:
    """Return the velocity after an impact, shape (n,), and the impulses L, shape (k,).

    M (v+ - v) = J^T L and J v+ = -e J v: plastic at e = 0, elastic at e = 1.

    Args:
        M: Mass matrix, shape (n, n).
        v: Velocity before, shape (n,).
        J: Rows of the contacts that close, independent, shape (k, n).
        e: Restitution, the same for all rows.
    """
    k = len(J)
    saddle = np.block([[M, -J.T], [J, np.zeros((k, k))]])
    found = np.linalg.solve(saddle, np.concatenate([M @ v, -e * J @ v]))
    return found[: len(v)], found[len(v) :]


def impact_loss(M: Array, v: Array, J: Array, e: float = 0.0) -> float:
    """Return the kinetic energy that it takes in [J].

    (1 - e^2) / 2 times (J v) . A (J v), with the mass A = (J M^-1 J^T)^-1 that the contacts feel.
    """
    closing = J @ v
    felt = np.linalg.solve(J @ np.linalg.solve(M, J.T), closing)
    return float((1 - e**2) / 2 * closing @ felt)


def kept_momenta(M: Array, J: Array) -> Array:
    """Return rows whose product with v no impact changes, shape (n - k, n).

    Momenta along the velocities that leave the contacts alone: D^T M with J D = 0.
    """
    free = np.linalg.svd(J)[2][len(J) :].T
    return np.asarray(free.T @ M)


def inelastic_impact(M: Array, v: Array, J: Array) -> tuple[Array, Array]:
    """Return velocity and impulses, shapes (n,) and (k,), where contacts only push.

    The nearest of all velocities with J v+ >= 0 in the norm of M: J v+ >= 0, L >= 0, and L is zero
    where the contact opens. Found among all sets of contacts that stay closed.

    Raises:
        ArithmeticError: If no set fits, as for dependent rows.
    """
    k = len(J)
    sets = chain.from_iterable(combinations(range(k), size) for size in range(k + 1))
    for closed in map(list, sets):
        if np.linalg.matrix_rank(J[closed]) < len(closed):
            continue
        after, pushes = impact(M, v, J[closed])
        scale = 1e-12 * (1 + float(np.abs(v).max()))
        if (J @ after >= -scale).all() and (pushes >= -scale).all():
            L = np.zeros(k)
            L[closed] = pushes
            return after, L
    raise ArithmeticError("no set of contacts explains the impact")


# Blocks


@dataclass(frozen=True)
class PulledBlock:
    """A block at rest, pulled along a level by a force that grows as ``rate`` times the time.

    Attributes:
        m: Mass in [kg].
        rate: Growth of the force in [N/s].
        mu_s: Friction of the resting block.
        mu_k: Friction of the sliding block, at most ``mu_s``.
        g: Gravity in [m/s^2].
    """

    m: float = 2.0
    rate: float = 5.0
    mu_s: float = 0.6
    mu_k: float = 0.4
    g: float = 9.81

    @property
    def slip_time(self) -> float:
        """When it starts to slip, in [s]."""
        return self.mu_s * self.m * self.g / self.rate

    def state(self, t: float) -> tuple[float, float]:
        """Return place in [m] and velocity in [m/s]: m v_dot = rate t - mu_k m g."""
        t_s = self.slip_time
        if t <= t_s:
            return 0.0, 0.0
        since = t - t_s
        # The force at the slip exceeds the sliding friction by (mu_s - mu_k) m g.
        start = (self.mu_s - self.mu_k) * self.g
        jerk = self.rate / self.m
        place = start * since**2 / 2 + jerk * since**3 / 6
        return place, start * since + jerk * since**2 / 2


@dataclass(frozen=True)
class BeltBlock:
    """A block on a belt, held by a spring: it sticks, slips back, and sticks again.

    Attributes:
        m: Mass in [kg].
        k: Spring in [N/m].
        belt: Speed of the belt in [m/s], positive.
        mu_s: Friction of the sticking block.
        mu_k: Friction of the slipping block, less than ``mu_s``.
        g: Gravity in [m/s^2].
    """

    m: float = 1.0
    k: float = 100.0
    belt: float = 0.2
    mu_s: float = 0.6
    mu_k: float = 0.4
    g: float = 9.81

    @property
    def slip_place(self) -> float:
        """Stretch of the spring in [m] at which sticking ends."""
        return self.mu_s * self.m * self.g / self.k

    @property
    def middle(self) -> float:
        """Stretch in [m] about which the slipping block swings."""
        return self.mu_k * self.m * self.g / self.k

    @property
    def stick_place(self) -> float:
        """Stretch in [m] at which slipping ends: as far below the middle as it began above."""
        return 2 * self.middle - self.slip_place

    @property
    def slip_time(self) -> float:
        """How long it slips in [s], until its speed is the belt's again."""
        w = np.sqrt(self.k / self.m)
        lead = self.slip_place - self.middle
        return float((2 * np.pi - 2 * np.arctan2(lead * w, self.belt)) / w)

    @property
    def stick_time(self) -> float:
        """How long it rides on the belt in [s], once the cycle repeats."""
        return (self.slip_place - self.stick_place) / self.belt

    def state(self, t: float) -> tuple[float, float]:
        """Return stretch in [m] and velocity in [m/s], having started on the belt, unstretched."""
        first = self.slip_place / self.belt
        if t < first:
            return self.belt * t, self.belt
        t = (t - first) % (self.slip_time + self.stick_time)
        if t >= self.slip_time:
            return self.stick_place + self.belt * (t - self.slip_time), self.belt
        w, lead = np.sqrt(self.k / self.m), self.slip_place - self.middle
        c, s = np.cos(w * t), np.sin(w * t)
        place = self.middle + lead * c + self.belt / w * s
        return float(place), float(self.belt * c - lead * w * s)


@dataclass(frozen=True)
class ThrownBlock:
    """A block that is thrown up an incline and stops there, or comes back.

    Attributes:
        speed: How fast it starts uphill in [m/s].
        angle: Of the incline in [rad], between 0 and pi / 2.
        mu: Friction, at rest and sliding.
        g: Gravity in [m/s^2].
    """

    speed: float = 3.0
    angle: float = 0.4
    mu: float = 0.3
    g: float = 9.81

    @property
    def slowing(self) -> float:
        """By how much it slows uphill in [m/s^2]: weight and friction both pull down."""
        return float(self.g * (np.sin(self.angle) + self.mu * np.cos(self.angle)))

    @property
    def hastening(self) -> float:
        """By how much it then hastens downhill in [m/s^2]; zero where friction holds it."""
        return float(max(0.0, self.g * (np.sin(self.angle) - self.mu * np.cos(self.angle))))

    @property
    def stays(self) -> bool:
        """Whether friction holds it: mu >= tan(angle)."""
        return bool(self.mu >= np.tan(self.angle))

    @property
    def stop_time(self) -> float:
        """When it stops, in [s]."""
        return self.speed / self.slowing

    @property
    def stop_place(self) -> float:
        """How far uphill it stops, in [m]."""
        return self.speed**2 / (2 * self.slowing)

    @property
    def return_speed(self) -> float:
        """How fast it passes its start downhill, in [m/s]; zero where it stays."""
        return float(self.speed * np.sqrt(self.hastening / self.slowing))

    def state(self, t: float) -> tuple[float, float]:
        """Return place uphill in [m] and velocity in [m/s]."""
        if t < self.stop_time:
            return self.speed * t - self.slowing * t**2 / 2, self.speed - self.slowing * t
        since = t - self.stop_time
        return self.stop_place - self.hastening * since**2 / 2, -self.hastening * since
