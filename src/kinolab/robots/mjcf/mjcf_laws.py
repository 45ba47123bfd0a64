"""How forces of MuJoCo's actuators follow from their controls.

Source: MuJoCo's documentation, chapter Computation, section Actuation model.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.robots.actuation.actuators import Filter
from kinolab.robots.mjcf.compiled_model import CompiledModel

UNLIMITED = np.array([-math.inf, math.inf])
LAGS = ("filter", "filterexact")  # of first order: one equation, of which MuJoCo's steps differ
KNOWN = {"Dyn": ("none", "integrator", *LAGS), "Gain": ("fixed", "affine"),
         "Bias": ("none", "affine")}  # fmt: skip


@dataclass(frozen=True)
class ActuatorLaw:
    """The force (g0 + g1 L + g2 L_dot) u + b0 + b1 L + b2 L_dot along a length L.

    Attributes:
        refused: Why it is another law, if so.
        gear: By how much its length grows with its joint, tendon or site.
        gain, bias: Factors g and b, shape (3,).
        control, force: Limits (2,), infinite ones if none.
        through: What stands between its control and u, if that is a state.
    """

    refused: str
    gear: Array
    gain: Array
    bias: Array
    control: Array
    force: Array
    through: Filter | None

    @classmethod
    def of(cls, compiled: CompiledModel, k: int) -> Self:
        """Return the law of an actuator by its number."""
        model = compiled.model
        # before MuJoCo 4 every actuator had one control and one output
        at, out = (
            getattr(model, f"actuator_{word}", range(model.nu))[k] for word in ("ctrladr", "outadr")
        )
        kinds = {word: _kind(compiled, word, k) for word in KNOWN}
        factors = np.array([1.0, *[kinds["Gain"] == "affine"] * 2])
        gain = factors * model.actuator_gainprm[k, :3]
        bias = (kinds["Bias"] == "affine") * np.array(model.actuator_biasprm[k, :3])
        control = _limits(model.actuator_ctrllimited[at], model.actuator_ctrlrange[at])
        force = _limits(model.actuator_forcelimited[k], model.actuator_forcerange[k])
        lag = float(model.actuator_dynprm[k, 0]) if kinds["Dyn"] in LAGS else None
        through = None
        if kinds["Dyn"] in KNOWN["Dyn"][1:]:
            # a lag, which is 0 at first, never leaves what its controls span with that
            ends = UNLIMITED if lag is None else [min(control[0], 0.0), max(control[1], 0.0)]
            own = _limits(model.actuator_actlimited[k], model.actuator_actrange[k])
            lower, upper = np.clip(ends, *own).tolist()
            through = Filter(lag, lower, upper)
        refused = _refusal(kinds, lag, pushes=bool(gain.any()), idle=not bias.any() and not through)
        gear = np.array(model.actuator_gear[out])
        return cls(refused, gear, gain, bias, control, force, through)

    @property
    def even(self) -> bool:
        """Whether the force is the same at any length and speed."""
        return not (self.bias[1:].any() or self.gain[1:].any())

    @property
    def aims(self) -> bool:
        """Whether it is a servo, whose control has limits."""
        return bool(self.bias[1:].any()) and bool(np.isfinite(self.control).all())

    def limits(self, *, at_rest: bool = False) -> Array:
        """Return the limits (2,) of the force before its gear, infinite ones if none.

        Args:
            at_rest: Whether length and speed are always 0.
        """
        ends = UNLIMITED
        if at_rest or self.even:
            pushing = self.control
            if self.through is not None:
                pushing = np.array([self.through.lower, self.through.upper])
            g, b = float(self.gain[0]), float(self.bias[0])
            ends = np.sort(g * pushing) + b if g else np.full(2, b)
        found: Array = np.clip(ends, *self.force)
        return found

    def within(self, force: Array) -> Filter | None:
        """Return what stands before u, where limits (2,) of the force b0 + g0 u are some of it."""
        if self.through is None or not np.isfinite(force).any():
            return self.through
        ends = np.sort((force - self.bias[0]) / self.gain[0])
        lower, upper = np.clip([self.through.lower, self.through.upper], *ends).tolist()
        return Filter(self.through.time_constant, lower, upper)


def _kind(compiled: CompiledModel, word: str, k: int) -> str:
    """Return a type such as ``"Dyn"`` of an actuator's law, in lower case."""
    kinds = getattr(compiled.mujoco, f"mjt{word}")
    name: str = kinds(int(getattr(compiled.model, f"actuator_{word.lower()}type")[k])).name
    return name.rsplit("_", 1)[-1].lower()


def _limits(counts: bool, ends: Array) -> Array:
    return np.array(ends) if counts else UNLIMITED


def _refusal(kinds: dict[str, str], lag: float | None, *, pushes: bool, idle: bool) -> str:
    """Return why a law is none of a motor or servo, if so."""
    for word, known in KNOWN.items():
        if kinds[word] not in known:
            return f"its {word.lower()}type is {kinds[word]}"
    if not (pushes or idle):
        return "its gain is 0, so that it pushes whatever its control is"
    return f"its filter has the time constant {lag:g}" if lag is not None and lag <= 0.0 else ""
