"""Which bodies an MJCF file lets pass through each other, as an SRDF says of a URDF.

Source: MuJoCo's documentation, chapter Computation, section Collision detection: filtering; XML
reference, contact/pair and contact/exclude.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray


def allowed_pairs(
    model: Any, names: Sequence[str], solids: Sequence[Sequence[int]]
) -> frozenset[frozenset[str]]:
    """Return the pairs of bodies, by name, that MuJoCo's filter keeps from colliding.

    Two geoms collide if the type of one shares a bit with the affinity of the other one. Bodies do
    if some of their geoms do and no ``<exclude>`` names them, or if a ``<pair>`` names two of them.

    Args:
        model: MuJoCo's.
        names: Of the bodies.
        solids: Of each body the geoms that are solids.
    """
    types, affinities = (
        _bits(values, solids) for values in (model.geom_contype, model.geom_conaffinity)
    )
    excluded = {divmod(int(signature), 1 << 16) for signature in model.exclude_signature}
    geoms = zip(model.pair_geom1, model.pair_geom2, strict=True)
    wanted = {frozenset(int(model.geom_bodyid[g]) for g in pair) for pair in geoms}
    return frozenset(
        frozenset((names[a], names[b]))
        for a, b in combinations([body for body, own in enumerate(solids) if own], 2)
        if frozenset((a, b)) not in wanted
        and (
            not (types[a] & affinities[b] or types[b] & affinities[a])
            or {(a, b), (b, a)} & excluded
        )
    )


def _bits(values: NDArray[np.int32], solids: Sequence[Sequence[int]]) -> list[int]:
    """Return of each body the bits that any of its geoms has."""
    return [int(np.bitwise_or.reduce(values[[*own]], initial=0)) if own else 0 for own in solids]
