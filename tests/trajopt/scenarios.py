"""Scenarios that no tree solves soon: what swings and flies, in the benchmark dynobench's steps."""

from __future__ import annotations

FLY = """
schema = 1
title = "A planar rotor climbs by a metre"
system = { name = "quad2d_v0" }
bounds = { x = [-1, 1], y = [-1, 2] }
[goal]
x = 0.0
y = 1.0
theta = 0.0
at_rest = true
tolerance = 0.03
[integration]
method = "euler"
step = 0.01
truth = "discrete"
"""
SWING_UP = """
schema = 1
title = "An acrobot swings up"
system = { name = "acrobot_v0" }
[goal]
q1 = 3.141592653589793
q2 = 0.0
at_rest = true
tolerance = 0.05
[integration]
method = "euler"
step = 0.01
truth = "discrete"
"""
DISCRETE = (FLY, SWING_UP)
