"""From a mechanism to machine code: derived, emitted, compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from kinolab.concurrency.stages import doing
from kinolab.dynamics.codegen.cache import compiled
from kinolab.dynamics.codegen.closed_loop import emit_closed_loop
from kinolab.dynamics.codegen.emission import emit_module, operations_of
from kinolab.dynamics.codegen.exports import results_of
from kinolab.dynamics.codegen.hybrid import emit_hybrid
from kinolab.dynamics.codegen.mode_formulas import ModeFormulas
from kinolab.dynamics.derivation.derivation import Derivation, derive
from kinolab.dynamics.facts.mode_derivations import derive_modes
from kinolab.dynamics.language.feedback import Feedback
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.errors import InputError, Mistake

# Of the equations of motion. To derive and compile the 137 531 of a humanoid with 60 coordinates
# takes 40 s on an idle computer and 1.6 GB; both grow with their number.
MOST_OPERATIONS = 150_000
# To allocate registers takes 13 s for 25 488 operations, and grows with the square of their number:
# beyond a minute code is compiled without, 60 times as quickly; it runs 2 to 5 times as long.
MOST_IN_REGISTERS = 50_000


def derivations_of(system: Mechanism) -> list[Derivation]:
    """Return a mechanism's derivation, or those of all of its modes."""
    if system.modes:
        return [mode.derivation for mode in derive_modes(system)]
    return [derive(system)]


def derived_code(
    system: Mechanism,
    law: Feedback | None,
    keep: Callable[[tuple[ModeFormulas, ...]], None] = lambda _: None,
) -> tuple[dict[str, Any], bytes]:
    """Derive and compile a mechanism; returns facts about it, and the machine code.

    Args:
        law: Its feedback; functions of inputs are then functions of the law's references, too.
        keep: Takes formulas of every mode.

    Raises:
        InputError: If the mechanism cannot be derived.
    """
    if system.modes:
        modes = derive_modes(system)
        keep(tuple(ModeFormulas.of(mode.derivation) for mode in modes))
        redundant = {name: None for mode in modes for name in mode.derivation.redundant}
        facts = _facts(modes[0].derivation) | {"redundant": tuple(redundant), "lanes": False}
        return facts, compiled(emit_hybrid(modes))
    doing(f"deriving the equations of motion of {len(system.coordinates)} coordinates")
    d = derive(system)
    facts = _facts(d)
    _require_compilable(system, facts["operations"])
    doing(f"compiling equations of motion of {facts['operations']} operations")
    # 4000 operations of the equations of motion: longer ones take long to compile
    lanes = law is None and facts["operations"] <= 4000
    facts["lanes"], text = lanes, emit_module(d, lanes=lanes)
    keep((ModeFormulas.of(d),))
    if law is not None:
        nx, nu, along = len(d.state), len(d.binding.inputs), len(d.state) + len(law.references)
        facts["sizes"] |= {"jacobian": nx * along, "law": nu, "law_jacobian": nu * along}
        text += "\n" + emit_closed_loop(d, law)
    return facts, compiled(text, quick=facts["operations"] > MOST_IN_REGISTERS)


def _require_compilable(system: Mechanism, operations: int) -> None:
    """Refuse equations that are too long for a compiler.

    Raises:
        InputError: If they are.
    """
    if operations > MOST_OPERATIONS:
        count = len(system.coordinates)
        what = f"its equations of motion, of {count} coordinates, take {operations} operations"
        remedy = "Lock joints that need not move, or describe branches as machines of their own."
        told = f"{what}; {MOST_OPERATIONS} are the most that are compiled."
        raise InputError([Mistake(f"system {system.name!r}", told, remedy)])


def _facts(d: Derivation) -> dict[str, Any]:
    nx, nu = len(d.state), len(d.binding.inputs)
    sizes = {name: len(nodes) for name, nodes in results_of(d).items()}
    sizes |= {"f": nx, "frames_jacobian": nx * len(d.frames), "jacobian": nx * (nx + nu)}
    facts: dict[str, Any] = {"sizes": sizes, "independent": d.independent, "redundant": d.redundant}
    facts["operations"] = operations_of(d)
    facts["quasi"] = [
        (v.name, v.unit, v.speed, v.scale, v.direction or str(v.velocity)) for v in d.quasi
    ]
    return facts
