"""``System``: a mechanism with its equations of motion and compiled model as methods."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Self

import sympy

from kinolab.dynamics.analysis.lqr_design import with_law
from kinolab.dynamics.lagrange.agreement import Agreement, compare
from kinolab.dynamics.lagrange.energies import energy_length
from kinolab.dynamics.lagrange.equations import MAX_SIMPLIFIED, Equations, equations_of
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.model.model import Model

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from kinolab.dynamics.analysis.flatness_of import FlatnessFound
    from kinolab.dynamics.language.inputs import Limit
    from kinolab.dynamics.translation import CasadiFunctions, SympyModel


class System(Mechanism):
    """A mechanical system, immutable, with its equations of motion."""

    def model(self) -> Model:
        """Derive and compile the equations of motion; a regulator is designed first."""
        return Model(with_law(self))

    def flatness(self) -> FlatnessFound:
        """Return which outputs of the machine are flat, or why it is not, as far as is known.

        Raises:
            InputError: If it cannot be derived, or has modes.
        """
        from kinolab.dynamics.analysis.flatness_of import flatness_of

        return flatness_of(self)

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

    def to_sympy(self) -> SympyModel:
        """Return the equations of motion as SymPy expressions, with common subexpressions.

        Raises:
            InputError: If the machine has modes or feedback.
        """
        from kinolab.dynamics.translation import sympy_model

        return sympy_model(self.model())

    def to_control(self, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> Any:
        """Return the linearisation about a state as a ``control.StateSpace`` of python-control.

        Its states and inputs are deviations from x and u, its outputs all states.

        Args:
            x: State, shape (nx,).
            u: Inputs, shape (nu,); zero when left out.
            parameters: Values that differ from the machine's own.

        Raises:
            InputError: If python-control is not installed, or a shape does not fit.
            SingularError: Where the equations of motion have no unique solution.
        """
        from kinolab.dynamics.translation import control_system

        return control_system(self.model(), x, u, **parameters)

    def with_gain(
        self,
        gain: ArrayLike,
        x: ArrayLike,
        u: ArrayLike = (),
        *,
        references: Mapping[str, Limit],
    ) -> Self:
        """Return the machine under the law u - K (x_now - x), such as ``control.lqr`` designs.

        Args:
            gain: K, shape (nu, nx).
            x: The state that is held, shape (nx,).
            u: The inputs that hold it, shape (nu,); zero when left out.
            references: Entries of x that planners choose, by name, with their limits; that of a
                state ``x`` is called ``x_set``.

        Raises:
            InputError: With everything that does not fit.
        """
        from kinolab.dynamics.analysis.state_feedback import state_feedback

        plant = self.with_feedback(None)
        law = state_feedback(plant.model(), gain, x, u, references=references)
        return plant.with_feedback(law)

    def _repr_latex_(self) -> str | None:
        """Show the equations of motion in a notebook where they are short; else its name."""
        if self.modes or energy_length(self, MAX_SIMPLIFIED) > MAX_SIMPLIFIED:
            return None
        return self.equations()._repr_latex_()
