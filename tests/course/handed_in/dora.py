# %%
import numpy as np
from kinolab.testing import check

check("4.1", 3.92)

# %%


def solve(M, f, w, w_dot_q_dot):
    n, k = len(f), len(w)
    block = np.block([[M, -w.T], [w, np.zeros((k, k))]])
    return np.linalg.solve(block, np.concatenate([f, -w_dot_q_dot]))


check("4.2", solve)

# %%
from kinolab.dynamics import *  # noqa: E402
from sympy import cos, sin  # noqa: E402

m, R, slope = parameter("m", 1.0, "kg"), parameter("R", 0.25, "m"), parameter("slope", np.pi / 18)
x, y, psi, phi = length("x"), length("y"), angle("psi"), angle("phi")
upright = move(x, y, R) @ rot_z(psi)
A = m * R**2 / 2
coin = Body("coin", upright @ rot_y(phi), mass=m, inertia=(A / 2, A, A / 2))
V = velocity(upright)
downhill = System(
    "downhill",
    bodies=[coin],
    constraints=[zero(V.y, "no sideslip"), zero(V.x - R * rate(phi), "rolling")],
    gravity=Gravity((sin(slope), 0, -cos(slope)), 9.81),
)
check("4.3", downhill)
