# %%
import numpy as np
from kinolab.testing import check


def body_velocity(g, g_dot):
    V = g_dot @ np.linalg.inv(g)
    return np.array([V[0, 3], V[1, 3], V[2, 3], V[2, 1], V[0, 2], V[1, 0]])


check("2.1", body_velocity)

# %%
from cmath import exp  # noqa: E402


def trailer(x, y, psi, beta):
    place = complex(x, y) - 0.5 * exp(1j * psi) - 1.2 * exp(1j * (psi + beta))
    return place.real, place.imag, psi + beta


check("2.2", trailer)

# %%
from kinolab.dynamics import *  # noqa: E402

alpha, beta = angle("alpha"), angle("beta")
m, l = 2.0, 1.0  # noqa: E741
J = m * l**2 / 3
bar = Body("bar", rot_z(alpha) @ rot_y(beta) @ move(0, 0, -l / 2), mass=m, inertia=(J, J, 0))
check("2.3", System("rod", bodies=[bar], gravity=toward("-z", 9.81)))
