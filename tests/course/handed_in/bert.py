# %%
from math import cos

from kinolab.testing import check


def energies(q1, q2, q1_dot, q2_dot):
    T = q1_dot**2 + q2_dot**2 / 2 + q1_dot * q2_dot * cos(q1 + q2)
    V = -9.81 * (2 * cos(q1) + cos(q2))
    return T, V


check("3.1", energies)

# %%
from kinolab.dynamics import *  # noqa: E402

r, theta = length("r", 0.2, 3.0, speed=5.0), angle("theta", speed=10.0)
ball = Body("ball", rot_y(-theta) @ move(0, 0, -r), mass=1.0)
spring = Spring(between=(WORLD, ball.frame), stiffness=50.0, length=1.0)
elastic = System("elastic", bodies=[ball], efforts=[spring], gravity=toward("-z", 9.81))
check("3.2", elastic)

# %%
check("3.3", 3 / 2)
