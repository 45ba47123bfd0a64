# %%
from kinolab.testing import check

check("12.1", 3.924)

# %%
from kinolab.dynamics import *  # noqa: E402
from sympy import cos, sin  # noqa: E402

x, z, theta = length("x", speed=3.0), length("z", speed=3.0), angle("theta", speed=6.0)
hull = Body("hull", move(x, 0, z) @ rot_y(theta), mass=0.8, inertia=0.01)
left, right = Control("left", limit=(0.0, 8.0)), Control("right", limit=(0.0, 8.0))
up = left.symbol + right.symbol
tilted = (up * sin(theta), 0, up * cos(theta))  # along the world's axes
turn = (0, 0.2 * (left.symbol - right.symbol), 0)
drone = System(
    "drone",
    bodies=[hull],
    inputs=[left, right],
    efforts=[Wrench(on=hull, force=tilted, torque=turn)],
    gravity=toward("-z"),
)
check("12.2", drone)
