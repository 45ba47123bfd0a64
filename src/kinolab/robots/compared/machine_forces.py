"""What forces a machine's motion takes, by its derivation evaluated as numbers.

Equations of motion are not derived for it: power along one virtual motion, whose numbers are those
of every velocity in turn, needs neither a mass matrix nor a Jacobian of each frame.

Source: Jourdain's principle, as in Featherstone, Rigid Body Dynamics Algorithms, 2008, section 3.2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from kinolab.dynamics import System
from kinolab.dynamics.derivation.formulas import Formulas
from kinolab.dynamics.derivation.kinematics import Kinematics
from kinolab.dynamics.derivation.newton_euler import NewtonEuler
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.derivation.velocity_coordinates import unconstrained_coordinates
from kinolab.numerics.arrays import Array


class MachineForces:
    """Forces and constraints of a machine, without inputs and dry friction."""

    def __init__(self, system: System, binding: SymbolTable) -> None:
        tape, size = binding.tape, len(binding.tangent)
        # no coordinate's name has a blank
        a, w = ([tape.variable(f"{word} {k}") for k in range(size)] for word in ("a", "w"))
        whole = unconstrained_coordinates(binding)
        motions = replace(whole, accelerations=tuple(a), directions=(tuple(w),))
        massive = [body for body in system.bodies if not body.massless]
        mechanics = NewtonEuler(Kinematics(binding, motions), massive)
        (inertial,), (conservative,) = mechanics.inertial_forces(), mechanics.conservative_forces()
        (other,) = mechanics.other_forces(dry=False)
        taken = tape.sub(inertial, tape.add(conservative, other))
        gaps = [binding.lower(closure.position) for closure in system.closures]
        self._formulas = Formulas.of(tape, [taken, *tape.derivative(gaps, binding.flow(w))])
        self._known = {entry.name: 0.0 for entry in system.inputs}
        self._size = size

    def __call__(self, values: Sequence[Mapping[str, float]], a: Array) -> tuple[Array, Array]:
        """Return the forces, and how the constraints' equations open.

        Args:
            values: Of coordinates and their rates by name, in m states.
            a: Derivatives of all n velocities, shape (m, n).

        Returns:
            Forces along all velocities, shape (m, n), in [N] or [N m], and slopes of k equations,
            shape (m, k, n).
        """
        known = {name: np.array([[state[name]] for state in values]) for name in values[0]}
        known |= {name: np.array([[value]]) for name, value in self._known.items()}
        known |= {f"a {k}": a[:, k : k + 1] for k in range(self._size)}
        known |= {f"w {k}": row for k, row in enumerate(np.eye(self._size)[:, None])}
        forces, *slopes = (np.broadcast_to(v, a.shape) for v in self._formulas(known))
        return forces, np.array(slopes).reshape(len(slopes), *a.shape).swapaxes(0, 1)
