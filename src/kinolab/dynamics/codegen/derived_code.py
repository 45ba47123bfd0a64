"""From a mechanism to machine code: derived, emitted, compiled."""

from __future__ import annotations

import math
from typing import Any

from kinolab.dynamics.codegen.closed_loop import emit_closed_loop
from kinolab.dynamics.codegen.emission import emit_module
from kinolab.dynamics.codegen.exports import results_of
from kinolab.dynamics.codegen.llvm_jit import compile_ir
from kinolab.dynamics.derivation.derivation import derive
from kinolab.dynamics.language.feedback import Feedback
from kinolab.dynamics.language.mechanism import Mechanism


def derived_code(system: Mechanism, law: Feedback | None) -> tuple[dict[str, Any], bytes]:
    """Derive and compile a mechanism; returns facts about it, and the machine code.

    Args:
        system: The mechanism.
        law: Its feedback; functions of inputs are then functions of the law's references, too.

    Raises:
        InputError: If the mechanism cannot be derived.
    """
    d = derive(system)
    nx, nu = len(d.state), len(d.binding.inputs)
    sizes = {name: len(nodes) for name, nodes in results_of(d).items()}
    sizes |= {"f": nx, "frames_jacobian": nx * len(d.frames), "jacobian": nx * (nx + nu)}
    text = emit_module(d)
    if law is not None:
        along = nx + len(law.references)
        sizes |= {"jacobian": nx * along, "law": nu, "law_jacobian": nu * along}
        text += "\n" + emit_closed_loop(d, system, law)
    facts = {"sizes": sizes, "independent": d.independent, "redundant": d.redundant}
    facts["quasi"] = [
        {
            "name": v.name,
            "unit": v.unit,
            "speed": v.speed if math.isfinite(v.speed) else None,
            "scale": v.scale,
            "direction": v.direction or str(v.velocity),
        }
        for v in d.quasi
    ]
    return facts, compile_ir(text)
