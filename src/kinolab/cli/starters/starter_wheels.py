"""What ``plan new --wheels`` writes: a robot on two wheels, the registered ``diff_drive``."""

from importlib.resources import files

_SOURCE = files("kinolab.systems").joinpath("diff_drive.py").read_text(encoding="utf-8")
_HEADING = '''"""A machine of one's own: a robot on two driven wheels.

Plan for it:  plan {name}.toml
"""
'''
MACHINE = _HEADING + _SOURCE.partition("\n")[2].replace("diff_drive", "{name}")

TITLE = "A robot drives round a wall"
SCENARIO = """
[world]
bounds = {{ x = [0, 5], y = [0, 4] }}     # [m]
ground = "plane"
clearance = 0.05                        # [m] kept from obstacles, for what is not as planned

[[world.obstacle]]
name = "wall"
box = [0.2, 2.5, 0.5]                   # [m] full edges
position = [2.5, 1.25, 0.25]            # [m] centre

[start]
x = 1.0
y = 1.0

[goal]                                  # parked on the other side
x = 4.0
y = 1.0
at_rest = true
tolerance = 0.1                         # [m] and [rad/s]
reserve = 0.3                           # share of it that the plan leaves to the execution

[bounds]                                # of 0.6 N m: the rest is left to correct errors with
left = [-0.45, 0.45]
right = [-0.45, 0.45]

[planner]
time_limit = 30.0                       # [s]
"""
