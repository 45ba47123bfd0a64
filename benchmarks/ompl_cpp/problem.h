// The two problems in numbers; ../versus/disk.toml and crane.toml say the same to kinolab, and
// tests/test_benchmarks.py compares them. SI units, radians.
#pragma once

// Both: a step of the propagation is made of SUBSTEPS steps of Runge and Kutta's.
static constexpr double P_STEP = 0.05;
static constexpr int P_SUBSTEPS = 5;
static constexpr int P_MIN_STEPS = 1;
static constexpr int P_MAX_STEPS = 20;

// A coin that rolls upright: x, y, psi, phi and the rates of psi and phi; drive and steer.
static constexpr double P_DISK_RADIUS = 0.25;
static constexpr double P_DISK_THICKNESS = 0.05;
static constexpr double P_DISK_MASS = 1.0;
static constexpr double P_DISK_ROLL_INERTIA = 0.03125;
static constexpr double P_DISK_TURN_INERTIA = 0.015625;
static constexpr double P_DISK_INPUT[] = {1.0, 0.5};
static constexpr double P_DISK_LOWER[] = {0.0, 0.0, -4.0, -12.0};  // of x, y and the rates
static constexpr double P_DISK_UPPER[] = {10.0, 10.0, 4.0, 12.0};
static constexpr double P_DISK_WEIGHT[] = {1.0, 1.0, 0.5, 0.001, 0.1, 0.1};
static constexpr double P_DISK_START[] = {1.0, 1.0, 0.0, 0.0, 0.0, 0.0};
static constexpr double P_DISK_GOAL[] = {9.0, 9.0};
static constexpr double P_DISK_GOAL_RADIUS = 0.5;
static constexpr double P_DISK_BOXES[][6] = {  // centre and full edges
    {5.0, 0.0, 0.5, 10.2, 0.2, 1.0},
    {5.0, 10.0, 0.5, 10.2, 0.2, 1.0},
    {0.0, 5.0, 0.5, 0.2, 10.2, 1.0},
    {10.0, 5.0, 0.5, 0.2, 10.2, 1.0},
    {3.3, 3.3, 0.5, 0.2, 6.8, 1.0},
    {6.6, 6.7, 0.5, 0.2, 6.8, 1.0},
    {2.45, 3.3, 0.5, 1.9, 0.2, 1.0},
    {0.8, 5.6, 0.5, 1.8, 0.2, 1.0},
    {4.1, 3.3, 0.5, 1.8, 0.2, 1.0},
    {5.8, 6.6, 0.5, 1.8, 0.2, 1.0},
    {7.4, 5.0, 0.5, 1.8, 0.2, 1.0},
    {9.2, 7.0, 0.5, 1.8, 0.2, 1.0},
};

// A trolley that hoists a load: x, l, theta and their rates; the force along the rail, and that of
// the rope less the load's weight.
static constexpr double P_CRANE_TROLLEY = 10.0;
static constexpr double P_CRANE_LOAD = 5.0;
static constexpr double P_CRANE_GRAVITY = 9.81;
static constexpr double P_CRANE_HEIGHT = 5.0;
static constexpr double P_CRANE_EDGE = 0.6;  // of the load
static constexpr double P_CRANE_INPUT[] = {20.0, 15.0};
static constexpr double P_CRANE_LOWER[] = {0.0, 0.5, -1.0, -3.0, -2.0, -2.0};
static constexpr double P_CRANE_UPPER[] = {10.0, 4.5, 1.0, 3.0, 2.0, 2.0};
static constexpr double P_CRANE_WEIGHT[] = {1.0, 1.0, 1.0, 0.4, 0.4, 0.4};
static constexpr double P_CRANE_START[] = {1.0, 4.0, 0.0, 0.0, 0.0, 0.0};
static constexpr double P_CRANE_GOAL[] = {9.0, 4.0, 0.0, 0.0, 0.0, 0.0};
static constexpr double P_CRANE_GOAL_WEIGHT[] = {1.0, 1.0, 1.0, 0.4, 0.4, 0.4};
static constexpr double P_CRANE_GOAL_RADIUS = 0.17;
static constexpr double P_CRANE_BOXES[][6] = {
    {3.0, 0.0, 0.5, 1.0, 1.0, 1.0},
    {3.0, 0.0, 1.5, 1.0, 1.0, 1.0},
    {5.0, 0.0, 0.5, 1.0, 1.0, 1.0},
    {5.0, 0.0, 1.5, 1.0, 1.0, 1.0},
    {5.0, 0.0, 2.5, 1.0, 1.0, 1.0},
    {7.0, 0.0, 0.5, 1.0, 1.0, 1.0},
    {7.0, 0.0, 1.5, 1.0, 1.0, 1.0},
    {7.0, 0.0, 2.5, 1.0, 1.0, 1.0},
};
