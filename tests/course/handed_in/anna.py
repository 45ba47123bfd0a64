# %%
import numpy as np
from kinolab.testing import check


def energies(q1, q2, q1_dot, q2_dot):
    first = np.array([np.cos(q1), np.sin(q1)]) * q1_dot
    second = first + np.array([np.cos(q2), np.sin(q2)]) * q2_dot
    heights = -np.cos(q1), -np.cos(q1) - np.cos(q2)
    return (first @ first + second @ second) / 2, 9.81 * sum(heights) + 30.0


check("3.1", energies)

# %%
from kinolab.dynamics import *  # noqa: E402
from sympy import cos, sin  # noqa: E402

r, theta = length("r", 0.2, 3.0, speed=5.0), angle("theta", speed=10.0)
k, l_0, m = 50.0, 1.0, 1.0
bob = Body("bob", move(r * sin(theta), 0, -r * cos(theta)), mass=m)
stretch = Potential(k * (r - l_0) ** 2 / 2)
bungee = System("bungee", bodies=[bob], efforts=[stretch], gravity=toward("-z", 9.81))
check("3.2", bungee)

# %%
check("3.3", 2.0)
