"""Plots of a plan: that they show what is in the plan, and where they are written."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.figure import Figure

import kinolab
from kinolab import systems
from kinolab.cli import run
from kinolab.dynamics.model.units import control_units, state_units
from kinolab.errors import InputError
from kinolab.problem import PlanningTask
from kinolab.runs import write_run
from kinolab.search.graph import SearchGraph
from kinolab.show.plots import plots
from kinolab.show.plots.configuration_plane import configuration_plane
from kinolab.show.plots.figure import figure_of, written
from kinolab.show.plots.plotting import phase_portraits
from kinolab.show.plots.timelines import inputs_over_time, states_over_time
from kinolab.solve import PlanResult
from kinolab.trajectory import Trajectory


@pytest.fixture(scope="module")
def problem() -> PlanningTask:
    return kinolab.load("rolling_disk_maze")


@pytest.fixture(scope="module")
def plan(problem: PlanningTask) -> PlanResult:
    return problem.solve(planner="rrt_fast", seed=1, max_iterations=30_000, optimize=False)


@pytest.fixture
def trajectory(plan: PlanResult) -> Trajectory:
    assert plan.trajectory is not None
    return plan.trajectory


def curves(figure: Figure | None) -> dict[str, np.ndarray]:
    """Every labelled curve of a figure, by its label: columns are the two axes."""
    assert figure is not None
    lines = [line for axes in figure.axes for line in axes.get_lines()]
    return {str(line.get_label()): np.asarray(line.get_xydata()) for line in lines}


def test_a_title_is_no_formula(problem: PlanningTask, trajectory: Trajectory) -> None:
    title = r"5 $ or $\frac{ <script>alert(1)</script>"
    drawn = states_over_time(problem, trajectory, title)
    text = ElementTree.fromstring(written(drawn, "svg")).itertext()
    assert title in {line.strip() for line in text}


def test_states_have_the_units_of_their_coordinates() -> None:
    names = systems.get("car").model().state_names
    units = dict(zip(names, state_units(systems.get("car").model()), strict=True))
    assert (units["x"], units["psi"], units["phi_dot"]) == ("m", "rad", "rad/s")
    satellite = systems.get("satellite").model()
    units = dict(zip(satellite.state_names, state_units(satellite), strict=True))
    assert (units["R_w"], units["R_wx"], units["wheel_x_dot"]) == ("", "rad/s", "rad/s")
    assert control_units(systems.get("motorcycle").model()) == ("m/s", "rad")
    assert control_units(systems.get("motorcycle").model().plant) == ("N m", "rad/s^2")


def test_every_state_is_drawn_over_time(problem: PlanningTask, trajectory: Trajectory) -> None:
    drawn = curves(states_over_time(problem, trajectory, ""))
    for name, column in zip(trajectory.state_names, trajectory.x.T, strict=True):
        assert np.array_equal(drawn[name], np.stack([trajectory.t, column], axis=1))


def test_inputs_are_drawn_as_they_are_held(problem: PlanningTask, trajectory: Trajectory) -> None:
    figure = inputs_over_time(problem, trajectory, "")
    assert figure is not None
    steps = [patch.get_data() for axes in figure.axes for patch in axes.patches]  # type: ignore[attr-defined]
    for column, step in zip(trajectory.u.T, steps, strict=True):
        assert np.array_equal(step.values, column)
        assert np.array_equal(step.edges, trajectory.t)


def test_a_phase_portrait_is_drawn_for_each_rate_that_is_a_state(
    problem: PlanningTask, trajectory: Trajectory
) -> None:
    figure = phase_portraits(problem, trajectory, "")
    assert figure is not None
    labels = [(axes.get_xlabel(), axes.get_ylabel()) for axes in figure.axes]
    assert labels == [("psi [rad]", "psi_dot [rad/s]"), ("phi [rad]", "phi_dot [rad/s]")]
    first = np.asarray(figure.axes[0].get_lines()[0].get_xydata())
    assert np.array_equal(first, trajectory.x[:, [2, 4]])


def test_the_configuration_plane_is_dark_where_walls_are(
    problem: PlanningTask, plan: PlanResult, trajectory: Trajectory
) -> None:
    """Asked of the mesh itself: points well inside a wall, and the plan's own places."""
    figure = configuration_plane(problem, trajectory, plan.graph, "")
    assert figure is not None
    (axes,) = figure.axes
    (image,) = axes.get_images()
    left, right, low, high = image.get_extent()
    shade = np.asarray(image.get_array())

    def share(point: np.ndarray) -> float:
        rows, columns = shade.shape
        column = int((point[0] - left) / (right - left) * columns)
        return float(shade[int((point[1] - low) / (high - low) * rows), column])

    faces = [obstacle.vertices[obstacle.faces] for obstacle in problem.world.obstacles]
    middles = np.concatenate(faces).mean(axis=1)
    level = middles[(middles[:, 2] > 0.1) & (middles[:, 2] < 0.6)][:, :2]
    seen = [share(p) for p in level if left < p[0] < right and low < p[1] < high]
    assert len(seen) > 5
    assert np.mean(np.array(seen) > 0.0) > 0.9  # of places on the walls' faces
    assert share(trajectory.x[0, :2]) == share(trajectory.x[-1, :2]) == 0.0
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [m]", "y [m]")


def test_the_configuration_plane_is_drawn_where_a_clearance_is_asked_for(
    problem: PlanningTask, trajectory: Trajectory
) -> None:
    """What is too near is as dark as a wall, so the dark grows with the clearance."""
    wider = kinolab.load("rolling_disk_maze", overrides=["world.clearance=0.1"])
    shades = []
    for one in (problem, wider):
        figure = configuration_plane(one, trajectory, None, "")
        assert figure is not None
        shades.append(np.asarray(figure.axes[0].get_images()[0].get_array()))
    assert (shades[1] >= shades[0]).all()
    assert shades[1].sum() > 1.2 * shades[0].sum()


def test_an_angle_goes_around_and_its_line_is_broken_there(
    problem: PlanningTask, trajectory: Trajectory
) -> None:
    figure = configuration_plane(problem, trajectory, None, "", ("x", "psi"))
    assert figure is not None
    path = np.asarray(figure.axes[0].get_lines()[0].get_xydata())
    assert np.nanmax(np.abs(path[:, 1])) <= np.pi
    jumps = np.abs(np.diff(path[:, 1]))
    assert np.nanmax(jumps) <= np.pi
    turned = np.floor((trajectory.x[:, 2] + np.pi) / (2 * np.pi))
    assert np.isnan(path[:, 1]).sum() == np.count_nonzero(np.diff(turned)) > 0
    with pytest.raises(InputError, match="psi"):
        configuration_plane(problem, trajectory, None, "", ("x", "psy"))


def test_a_machine_of_one_coordinate_has_no_plane() -> None:
    pendulum = kinolab.load("pendulum_swingup")
    still = Trajectory(
        np.array([0.0, 0.1]),
        np.zeros((2, 2)),
        np.zeros((1, 1)),
        pendulum.model.state_names,
        pendulum.model.control_names,
    )
    assert sorted(plots(pendulum, still)) == ["inputs.svg", "phase.svg", "states.svg"]


def test_plan_plot_writes_files_that_go_with_the_plan(
    problem: PlanningTask, plan: PlanResult, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_run(tmp_path, problem, plan)
    assert run(["plot", str(tmp_path), "--quiet"]) == 0
    printed = [Path(line) for line in capsys.readouterr().out.splitlines()]
    assert {path.name for path in printed} == {
        "states.svg",
        "inputs.svg",
        "phase.svg",
        "configuration.svg",
    }
    for path in printed:
        assert ElementTree.parse(path).getroot().tag.endswith("svg")
    first = printed[0].read_bytes()
    assert run(["plot", str(tmp_path), "--quiet"]) == 0
    assert printed[0].read_bytes() == first  # the same plan, the same bytes
    assert run(["plot", str(tmp_path), "--plane", "x"]) == 2
    assert "Write it as x,y." in capsys.readouterr().err
    write_run(tmp_path, problem, replace(plan, seed=2))
    assert not any(path.exists() for path in printed)


@pytest.mark.parametrize("value", ["nan", "inf", "-1e+308"])
def test_a_table_with_what_is_no_number_is_refused_by_line_and_column(
    value: str,
    problem: PlanningTask,
    plan: PlanResult,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    write_run(tmp_path, problem, plan)
    table = tmp_path / "trajectory.csv"
    rows = [row.split(",") for row in table.read_text().splitlines()]
    rows[4][rows[0].index("psi")] = value
    table.write_text("".join(",".join(row) + "\n" for row in rows))
    assert run(["plot", str(tmp_path), "--quiet"]) == 2
    assert f"trajectory.csv line 5 column psi: {value} is" in capsys.readouterr().err


def test_a_search_with_a_state_that_is_not_finite_is_refused_by_row_and_column(
    problem: PlanningTask, plan: PlanResult, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_run(tmp_path, problem, plan)
    assert plan.graph is not None
    x = plan.graph.x.copy()
    x[2, problem.model.state_names.index("y")] = np.nan
    graph = SearchGraph(x, plan.graph.edges)
    (tmp_path / "search.npz").write_bytes(graph.to_npz(problem.model.state_names))
    assert run(["plot", str(tmp_path), "--quiet"]) == 2
    assert "search.npz row 3 column y: nan is not finite." in capsys.readouterr().err


def test_a_title_with_dollars_is_text_and_no_formula() -> None:
    """Matplotlib takes what stands between two of them for mathematics, which this is not."""
    title = r"From $\nope{$ to 5 $"
    figure, _ = figure_of(1, 1, (3.0, 3.0), title)
    assert title in "".join(ElementTree.fromstring(written(figure, "svg")).itertext())
