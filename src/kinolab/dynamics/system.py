"""``System``: a mechanism with its equations of motion and compiled model as methods."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import sympy

from kinolab.dynamics.analysis.lqr_design import with_law
from kinolab.dynamics.lagrange.agreement import Agreement, compare
from kinolab.dynamics.lagrange.equations import Equations, equations_of
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.model import Model

if TYPE_CHECKING:
    from kinolab.dynamics.translation import CasadiFunctions


class System(Mechanism):
    """A mechanical system, immutable, with its equations of motion."""

    def model(self) -> Model:
        """Derive and compile the equations of motion; a regulator is designed first."""
        return Model(with_law(self))

    def equations(self) -> Equations:
        """Return human-readable equations of motion, in the author's symbols."""
        return equations_of(self)

    def agrees_with(self, equations: Sequence[sympy.Eq | sympy.Expr]) -> Agreement:
        """Compare a hand derivation with kinolab's own and name the terms that differ.

        Args:
            equations: Equations of motion in the machine's symbols, with ``acceleration(x)`` for
                second derivatives and input symbols for inputs, in any order and each up to a
                factor; with multipliers lambda_1, … (or ``force_of(constraint)``), or without.

        Returns:
            True or False, with ``.verdicts`` in words.
        """
        names = [constraint.name for constraint in self.constraints]
        return compare(self.equations(), equations, names)

    def to_c(self) -> dict[str, str]:
        """Return the equations of motion as C99 source: header, source and a test, by file name.

        Raises:
            InputError: If the machine has modes or feedback.
        """
        from kinolab.dynamics.translation import c_source

        return c_source(self.model())

    def to_casadi(self) -> CasadiFunctions:
        """Return the equations of motion as CasADi functions: f, step, jacobian, energy, frames.

        Raises:
            InputError: If the machine has modes or feedback, or CasADi is not installed.
        """
        from kinolab.dynamics.translation import casadi_functions

        return casadi_functions(self.model())

    def _repr_latex_(self) -> str:
        return self.equations()._repr_latex_()
