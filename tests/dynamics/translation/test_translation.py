"""CasADi's functions and compiled C give what the machine code gives."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinolab import cli, systems
from kinolab.dynamics import Model
from kinolab.errors import InputError
from kinolab.numerics.arrays import Array
from tests.support import needs

AGREE = 1e-12  # relative to the largest entry
# Free angles, a constraint of rolling, closed loops, an attitude, drag and buoyancy.
MACHINES = ("pendulum", "rolling_disk", "crane", "five_bar", "quad3d_v0", "submarine", "car")
FLAGS = ("-std=c99", "-O1", "-ffp-contract=off", "-Wall", "-Wextra", "-Wpedantic", "-Werror")


def instants(model: Model) -> list[tuple[Array, Array]]:
    """Return random states that keep the constraints, and inputs."""
    generator = np.random.default_rng(2)
    low, high = np.clip(model.state_bounds, -1.0, 1.0).T
    found = []
    for _ in range(4):
        x = generator.uniform(low, np.maximum(high, low + 1e-6))
        for _ in range(8):  # onto closed loops
            x = model.project(x)
        found.append((x, generator.uniform(*model.control_bounds.T)))
    return found


def agree(ours: Any, theirs: Array) -> None:
    """Compare results of CasADi, a matrix, with those of machine code."""
    found = np.asarray(ours, dtype=float).reshape(theirs.shape)
    assert np.abs(found - theirs).max() <= AGREE * max(1.0, np.abs(theirs).max())


@needs("casadi")
@pytest.mark.parametrize("name", MACHINES)
def test_casadi_s_functions_agree(name: str) -> None:
    system = systems.get(name)
    model, functions = system.model(), system.to_casadi()
    p = functions.p
    for x, u in instants(model):
        agree(functions.f(x, u, p), model.f(x, u))
        agree(functions.step(x, u, 0.02, p), model.step(x, u, 0.02))
        agree(functions.energy(x, u, p), np.array(model.energy(x, u)))
        agree(functions.frames(x, p), model.frames(x).ravel())
        by_x, by_u = functions.jacobian(x, u, p)
        agree(by_x, model.jacobian(x, u)[0])
        agree(by_u, model.jacobian(x, u)[1])


@needs("casadi")
def test_casadi_s_jacobian_is_that_of_finite_differences() -> None:
    """Of f itself, so that not both can be wrong alike."""
    system = systems.get("crane")
    model, functions = system.model(), system.to_casadi()
    for x, u in instants(model):
        by_x = np.asarray(functions.jacobian(x, u, functions.p)[0])
        for k in range(model.nx):
            ahead, behind = x.copy(), x.copy()
            ahead[k], behind[k] = x[k] + 1e-6, x[k] - 1e-6
            slope = (model.f(ahead, u) - model.f(behind, u)) / 2e-6
            assert np.abs(by_x[:, k] - slope).max() < 1e-6 * max(1.0, np.abs(slope).max())


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
@pytest.mark.parametrize("name", MACHINES)
def test_compiled_c_passes_its_own_test(name: str, tmp_path: Path) -> None:
    assert cli.run(["export", name, "--out", str(tmp_path)]) == 0
    sources = [f"{name}.c", f"{name}_test.c"]
    subprocess.run(["cc", *FLAGS, *sources, "-lm", "-o", "test"], cwd=tmp_path, check=True)
    told = subprocess.run(["./test"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (told.returncode, told.stdout) == (0, "0 differences\n")


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
def test_the_test_in_c_finds_a_wrong_sign(tmp_path: Path) -> None:
    files = systems.get("pendulum").to_c()
    files["pendulum.c"] = files["pendulum.c"].replace("out[1] = ", "out[1] = -")
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    sources = [name for name in files if name.endswith(".c")]
    subprocess.run(["cc", *FLAGS, *sources, "-lm", "-o", "test"], cwd=tmp_path, check=True)
    told = subprocess.run(["./test"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert told.returncode == 1
    assert "f 0, entry 1" in told.stdout


@needs("casadi")
def test_machines_with_modes_or_feedback_are_refused() -> None:
    with pytest.raises(InputError, match="it has modes"):
        systems.get("biped").to_c()
    with pytest.raises(InputError, match="Translate its plant"):
        systems.get("unicycle").to_casadi()
    assert systems.get("unicycle").with_feedback(None).to_c()


@pytest.mark.skipif(shutil.which("c++") is None, reason="needs a C++ compiler")
def test_c_plus_plus_may_include_the_header(tmp_path: Path) -> None:
    """And gets what Python has: a Jacobian by columns, and a mass matrix."""
    assert cli.run(["export", "acrobot_v0", "--out", str(tmp_path)]) == 0
    (tmp_path / "main.cpp").write_text(
        '#include "acrobot_v0.h"\n#include <cstdio>\n'
        "int main() { const double x[] = {0.3, -0.8, 1.0, 2.0}, u[] = {4.0};\n"
        "  double J[ACROBOT_V0_JACOBIAN], M[ACROBOT_V0_MASS_MATRIX];\n"
        "  int bad = acrobot_v0_jacobian(x, u, acrobot_v0_p, J);\n"
        "  bad += acrobot_v0_mass_matrix(x, acrobot_v0_p, M);\n"
        '  for (double v : J) std::printf("%.17g ", v);\n'
        '  for (double v : M) std::printf("%.17g ", v);\n  return bad; }\n'
    )
    compiled = ["cc", "-std=c99", "-c", "acrobot_v0.c"]
    subprocess.run(compiled, cwd=tmp_path, check=True)
    linked = ["c++", "main.cpp", "acrobot_v0.o", "-lm", "-o", "main"]
    subprocess.run(linked, cwd=tmp_path, check=True)
    told = subprocess.run(["./main"], cwd=tmp_path, capture_output=True, text=True, check=True)
    found, model = np.array(told.stdout.split(), dtype=float), systems.get("acrobot_v0").model()
    x, u = [0.3, -0.8, 1.0, 2.0], [4.0]
    agree(found[:20].reshape(5, 4).T, np.hstack(model.jacobian(x, u)))
    agree(found[20:], model.mass_matrix(x).ravel())
