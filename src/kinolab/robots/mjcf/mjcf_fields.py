"""What of MuJoCo's compiled model is read, and what may be passed over; anything else is told.

Every field of ``mjModel`` and ``mjOption`` is read, has no effect where nothing touches, or must be
neutral. One that a later MuJoCo adds is in no table, and must be zero.

Source: MuJoCo's documentation, chapter Computation; mjmodel.h.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array


def _fields_of(table: str) -> frozenset[str]:
    """Return the fields of a table with lines "prefix: names", or "name:"."""
    lines = (line.partition(":") for line in re.sub(r"\n {8}", " ", table.strip()).split("\n"))
    return frozenset(
        f"{prefix.strip()}{name}" for prefix, _, names in lines for name in names.split() or [""]
    )


READ = _fields_of("""
    body_: parentid rootid weldid mocapid jntnum jntadr geomnum geomadr pos quat ipos iquat
        mass inertia sameframe gravcomp
    jnt_: type qposadr dofadr bodyid limited actfrclimited pos axis stiffness stiffnesspoly
        range actfrcrange actgravcomp
    dof_: jntid frictionloss armature damping dampingpoly
    geom_: type contype conaffinity bodyid dataid matid size pos quat rgba
    mesh_: vertadr vertnum faceadr facenum vert face
    mat_: rgba
    site_: bodyid pos quat
    eq_: type obj1id obj2id objtype active0 data
    actuator_: trntype dyntype gaintype biastype trnid gainprm biasprm ctrllimited ctrlrange
        gear forcelimited forcerange group dynprm actlimited actrange actearly
    tendon_: type adr num actfrclimited actfrcrange stiffness stiffnesspoly damping dampingpoly
        frictionloss armature limited range lengthspring
    wrap_: type objid prm
    pair_: geom1 geom2
    exclude_: signature
    qpos_: spring
    opt_: gravity disableflags enableflags disableactuator
    qpos0:
""")
# Of contacts, solvers and pictures; what MuJoCo derives of other fields; of actuators that trntype,
# dyntype and gaintype refuse; counts.
WITHOUT_EFFECT = _fields_of("""
    body_: dofnum dofadr treeid simple subtreemass invweight0 margin user contype
        conaffinity bvhadr bvhnum
    jnt_: actuatorid group plasticadr solref solimp margin user
    dof_: bodyid parentid treeid Madr simplenum solref solimp invweight0 M0 length
    geom_: condim group priority sameframe castshadow solmix solref solimp aabb rbound
        friction margin gap fluid user
    site_: type dataid matid group sameframe size user rgba
    eq_: solimp solref
    pair_: dim signature solref solreffriction solimp margin gap friction
    tendon_: matid actuatorid group plasticadr treenum treeid width solref_lim solimp_lim
        solref_fri solimp_fri margin length0 invweight0 user rgba
    actuator_: ctrladr ctrlnum ctrlspec outadr outnum actadr actnum cranklength history historyadr
        user acc0 length0 lengthrange
    flg_: gravcomp surfacevel adhesion
    ten_: J_rownnz J_rowadr J_colind
    opt_: timestep impratio tolerance ls_tolerance noslip_tolerance ccd_tolerance
        sleep_tolerance magnetic o_margin o_solref o_solimp o_friction integrator cone
        jacobian solver iterations ls_iterations noslip_iterations ccd_iterations
        sdf_initpoints sdf_iterations apirate mpr_tolerance mpr_iterations
    plugin:
    vis:
    stat:
    names:
    names_map:
    paths:
    signature:
    opt:
""")
# Whole elements; flexes, plugins and height fields are refused where they are used.
ELEMENTS_WITHOUT_EFFECT = re.compile(
    "(bvh|oct|cam|light|tex|mat|mesh|skin|hfield|sensor|numeric|text|tuple|key|name|exclude|wrap"
    "|tree|plugin|flex|flexedge|B|C|D|M|efm0|efmC)_.*|map.2.|n[a-zA-Z0-9_]*"
)
# Why what has no counterpart has none, by what names of fields begin with.
REASONS = {
    "opt_density": "makes a fluid push on all that moves, and no fluid is modelled",
    "opt_viscosity": "makes a fluid push on all that moves, and no fluid is modelled",
    "opt_wind": "makes a fluid push on all that moves, and no fluid is modelled",
    "jnt_springyield": "is where a spring yields, which would be a state of its own",
    "tendon_springyield": "is where a spring yields, which would be a state of its own",
    "geom_adhesion": "is a force of contacts, and contacts do not push",
    "geom_surfacevel": "moves what touches, and contacts do not push",
    "actuator_history": "delays an input, whose past would be a state",
    "actuator_delay": "delays an input, whose past would be a state",
    "actuator_plugin": "is code of its own, of which no equations are derived",
    "body_plugin": "is code of its own, of which no equations are derived",
    "geom_plugin": "is code of its own, of which no equations are derived",
}
NONE = -1  # of an address or number: there is none
NEUTRAL = {"body_plugin": NONE, "geom_plugin": NONE, "actuator_plugin": NONE}
SPELLED = {
    "jnt_actfrcrange": "actuatorfrcrange",
    "jnt_limited": "range",
    "jnt_stiffnesspoly": "stiffness",
    "dof_dampingpoly": "damping",
    "tendon_stiffnesspoly": "stiffness",
    "tendon_dampingpoly": "damping",
    "actuator_dampingpoly": "damping",
    "qpos0": "ref",
    "qpos_spring": "springref",
}  # as MJCF spells what mjModel calls otherwise
ELEMENTS = {
    "body": "BODY",
    "jnt": "JOINT",
    "dof": "JOINT",
    "geom": "GEOM",
    "site": "SITE",
    "eq": "EQUALITY",
    "tendon": "TENDON",
    "actuator": "ACTUATOR",
    "pair": "PAIR",
    "mesh": "MESH",
}  # names of types of objects, by prefix

# Which fields a flag <flag name="disable"/> sets to nothing.
FLAGS = {
    "EQUALITY": "eq_active0",
    "FRICTIONLOSS": "dof_frictionloss tendon_frictionloss",
    "LIMIT": "jnt_limited tendon_limited",
    "SPRING": "jnt_stiffness jnt_stiffnesspoly tendon_stiffness tendon_stiffnesspoly",
    "DAMPER": "dof_damping dof_dampingpoly tendon_damping tendon_dampingpoly",
    "GRAVITY": "opt_gravity body_gravcomp",
    "CLAMPCTRL": "actuator_ctrllimited",
}
OTHER_FLAGS = """CONSTRAINT CONTACT ACTUATION WARMSTART FILTERPARENT REFSAFE SENSOR MIDPHASE
    EULERDAMP AUTORESET NATIVECCD ISLAND MULTICCD"""  # applied elsewhere, or without effect
ENABLING = "OVERRIDE ENERGY FWDINV INVDISCRETE SLEEP DIAGEXACT IPC SPECULATIVE"  # without effect


def disabled(mujoco: Any, model: Any) -> set[str]:
    """Return the flags that a model disables, those that others imply, too."""
    flags = int(model.opt.disableflags)
    found = {
        name.removeprefix("mjDSBL_")
        for name, bit in mujoco.mjtDisableBit.__members__.items()
        if name.startswith("mjDSBL_") and flags & int(bit)
    }
    # of the flag "constraint"
    return found | {"EQUALITY", "FRICTIONLOSS", "LIMIT"} if "CONSTRAINT" in found else found


def apply_flags(mujoco: Any, model: Any) -> None:
    """Set to nothing what a model's flags disable."""
    for flag in disabled(mujoco, model) & FLAGS.keys():
        for name in FLAGS[flag].split():
            values = _value(model, name)
            if values is not None:
                values[...] = 0


def unknown_flags(mujoco: Any, model: Any) -> Iterator[str]:
    """Yield what is said of flags that are in no table."""
    kinds = {"disable": (mujoco.mjtDisableBit, "mjDSBL_", f"{' '.join(FLAGS)} {OTHER_FLAGS}"),
             "enable": (mujoco.mjtEnableBit, "mjENBL_", ENABLING)}  # fmt: skip
    for word, (bits, prefix, known) in kinds.items():
        flags = int(getattr(model.opt, f"{word}flags"))
        for name, bit in bits.__members__.items():
            flag = name.removeprefix(prefix)
            if name.startswith(prefix) and flags & int(bit) and flag not in known.split():
                yield f'the flag {flag.lower()}="{word}" has no counterpart.'


def not_looked_at(mujoco: Any, model: Any) -> Iterator[str]:
    """Yield what is said of fields that are not read and differ from their neutral values."""
    for name in _fields(model):
        known = name in READ | WITHOUT_EFFECT or ELEMENTS_WITHOUT_EFFECT.fullmatch(name)
        if not known:
            values = _rows(model, name)
            wrong = np.any(values != NEUTRAL.get(name, 0), axis=1)
            yield from _told(mujoco, model, name, values, wrong)
    for k in range(model.nflex):
        yield f"flex {element_name(mujoco, model, 'FLEX', k)} is deformable."


def not_finite(mujoco: Any, model: Any) -> Iterator[str]:
    """Yield what is said of fields that are read and have no finite values, and of empty ranges.

    MuJoCo itself passes over a range whose end is below its beginning.
    """
    for name in _fields(model):
        if name not in READ:
            continue
        values = _rows(model, name)
        wrong = np.any(~np.isfinite(values), axis=1)
        yield from _told(mujoco, model, name, values, wrong, "is not finite")
        if name.endswith("range"):
            wrong = values[:, 0] > values[:, 1]
            yield from _told(mujoco, model, name, values, wrong, "ends below where it begins")


def element_name(mujoco: Any, model: Any, kind: str, k: int) -> str:
    """Return the name of an element of a type such as ``"JOINT"``, or its number from 1 on."""
    name = mujoco.mj_id2name(model, getattr(mujoco.mjtObj, f"mjOBJ_{kind}"), k)
    return str(name or k + 1)


def _told(
    mujoco: Any,
    model: Any,
    name: str,
    rows: Array,
    wrong: NDArray[np.bool_],
    why: str | None = None,
) -> Iterator[str]:
    """Yield an element's attribute and its value, for the first elements of which it is wrong."""
    prefix, _, rest = name.partition("_")
    attribute = SPELLED.get(name, rest or name)
    reasons = (said for begins, said in REASONS.items() if name.startswith(begins))
    why = why or next(reasons, "has no counterpart")
    if name.endswith("_limited"):  # it is more telling to show the range
        rows = _rows(model, name.replace("_limited", "_range"))
    for k in islice(np.flatnonzero(wrong).tolist(), 3):  # elements of which one message tells
        values = " ".join(f"{float(value):g}" for value in rows[k][:6])
        if prefix == "opt":
            yield f"option {attribute} is {values}, which {why}."
        elif prefix in ELEMENTS and len(rows) == _count(model, prefix):
            at = int(model.dof_jntid[k]) if prefix == "dof" else k
            kind = ELEMENTS[prefix]
            who = f"{kind.lower()} {element_name(mujoco, model, kind, at)}"
            yield f"{who} has {attribute} {values}, which {why}."
        else:
            yield f"its {attribute} is {values}, which {why}."


def _count(model: Any, prefix: str) -> int:
    counts = {"dof": "nv", "eq": "neq", "actuator": "nactuator"}
    return int(getattr(model, counts.get(prefix, f"n{prefix}"), model.nu))


def _fields(model: Any) -> Iterator[str]:
    """Yield the names of the fields of a model, then of its options, as opt_name."""
    for prefix, whole in (("", model), ("opt_", model.opt)):
        for name in dir(whole):
            if not name.startswith("_") and not callable(getattr(whole, name)):
                yield prefix + name


def _value(model: Any, name: str) -> Any:
    """Return a field of a model or, as opt_name, of its options; None before MuJoCo had it."""
    owner, own = (model.opt, name[4:]) if name.startswith("opt_") else (model, name)
    return getattr(owner, own, None)


def _rows(model: Any, name: str) -> Array:
    """Return a field's values, one row for each element."""
    values = np.asarray(_value(model, name))
    if values.dtype.kind not in "biuf":  # what has no number says something
        return np.ones((1, 1))
    single = values.ndim == 0 or name.startswith("opt_")
    shape = (1, values.size) if single else (len(values), math.prod(values.shape[1:]))
    return values.astype(np.float64).reshape(shape)
