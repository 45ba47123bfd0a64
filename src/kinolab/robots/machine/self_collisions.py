"""Which bodies of a robot may not touch each other.

All that can touch, but for neighbours, which always do, and for those of one robot that a file lets
touch, or whose solids touch where it rests: it could not begin. What is not watched is told.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations, product
from typing import NamedTuple, TypeAlias

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.robots.tree.kinematic_tree import (
    SIZES,
    Joint,
    KinematicTree,
    PlacedShape,
    from_the_root,
    led,
    link_poses,
)
from kinolab.world.distances.gjk import Convex, separation
from kinolab.world.shapes.geometry import sizes
from kinolab.world.shapes.shrinking import shrunk_shape

ROUNDED = 1e-6  # [m], a gap that is none but for rounding of a file's numbers
UNLIMITED = math.pi  # what is drawn from where a joint has no limits

Pairs: TypeAlias = list[tuple[str, str]]  # of bodies, by name


class NamedShape(NamedTuple):
    """A shape of a body, fixed to a link."""

    body: str
    link: str
    shape: PlacedShape


class Watch(NamedTuple):
    """The pairs that must not touch, and those that can and are not watched."""

    kept: Pairs
    unwatched: Pairs


def kept_apart(tree: KinematicTree, shapes: Sequence[NamedShape]) -> Watch:
    """Return which bodies of a robot must not touch each other."""
    spheres, tops, solids = _spheres(tree, shapes), _robots(tree), _at_rest(tree, shapes)
    watched: dict[tuple[str, str], bool] = {}
    for i, j in _candidates(tree, shapes):
        if not _can_touch(spheres[i], spheres[j]):
            continue
        pair, links = (shapes[i].body, shapes[j].body), (shapes[i].link, shapes[j].link)
        of_one = tops[links[0]] == tops[links[1]]
        kept = not of_one or (
            frozenset(links) not in tree.allowed and separation(solids[i], solids[j]) > ROUNDED
        )
        watched[pair] = watched.get(pair, True) and kept
    return _sorted_out(watched)


def kept_from_surroundings(tree: KinematicTree, shapes: Sequence[NamedShape]) -> Watch:
    """Return which bodies must not touch what stands around a robot.

    All that moves counts, the world's neighbours included, but for what is in the surroundings
    where the robot rests, or rests on them and never sinks in. What moves freely rests nowhere.
    """
    standing = {joint.child: joint.parent for joint in tree.joints if joint.child in _stands(tree)}
    if not standing:
        return Watch([], [])
    part, free, solids = _parts(tree), _free(tree), _at_rest(tree, shapes)
    carrier = {joint.child: joint.parent for joint in tree.joints}
    watched: dict[tuple[str, str], bool] = {}
    neighbours: set[tuple[str, str]] = set()
    for i, j in product(range(len(shapes)), repeat=2):
        wall, other = shapes[i], shapes[j]
        if wall.link not in standing or part[other.link] == tree.root.name:
            continue
        pair = wall.body, other.body
        separate = other.link in free or separation(solids[i], solids[j]) > ROUNDED
        watched[pair] = watched.get(pair, True) and (separate or _sinks(tree, wall, other))
        if standing[wall.link] == carrier[part[other.link]] != tree.root.name:
            neighbours.add(pair)
    found = _sorted_out(watched)
    return found._replace(unwatched=[pair for pair in found.unwatched if pair not in neighbours])


def _sorted_out(watched: Mapping[tuple[str, str], bool]) -> Watch:
    kept = [pair for pair, apart in watched.items() if apart]
    return Watch(kept, [pair for pair, apart in watched.items() if not apart])


def _stands(tree: KinematicTree) -> set[str]:
    return {link.name for link in tree.links if link.stands}


def _at_rest(tree: KinematicTree, shapes: Sequence[NamedShape]) -> list[Convex]:
    """Return the shapes where the robot rests."""
    places = link_poses(tree, _rest(tree))
    return [_convex(entry, places[entry.link]) for entry in shapes]


def _sinks(tree: KinematicTree, wall: NamedShape, other: NamedShape) -> bool:
    """Whether what rests on a solid, not in it, is in it at other positions of the joints."""
    # 1e-3 [m] by which a shape may be in what it rests on, since files round
    core = replace(other.shape, shape=shrunk_shape(other.shape.shape, 1e-3))
    generator = np.random.default_rng(0)
    for k in range(300 + 1):  # random positions of all joints
        places = link_poses(tree, _random_positions(tree, generator) if k else _rest(tree))
        inner = _convex(other._replace(shape=core), places[other.link])
        if separation(_convex(wall, places[wall.link]), inner) <= 0.0:
            return k > 0
    return False


def _free(tree: KinematicTree) -> set[str]:
    """Return the links that hang from a joint that moves freely."""
    found: set[str] = set()
    for joint in from_the_root(tree):
        if joint.kind == "floating" or joint.parent in found:
            found.add(joint.child)
    return found


def _candidates(tree: KinematicTree, shapes: Sequence[NamedShape]) -> Iterator[tuple[int, int]]:
    """Yield the pairs of shapes that are neither fixed to each other nor neighbours."""
    rigid, root = _parts(tree), tree.root.name
    apart = {one.name for one in tree.joints if one.held or rigid[one.child] == root}
    part = _parts(tree, apart)
    joined = {
        frozenset((part[joint.parent], part[joint.child]))
        for joint in tree.joints
        if joint.kind != "fixed" or joint.name in apart
    }
    joined |= {frozenset((part[loop.first], part[loop.second])) for loop in tree.closures}
    standing = _stands(tree)
    for i, j in combinations(range(len(shapes)), 2):
        a, b = shapes[i].link, shapes[j].link
        if standing & {a, b}:
            continue
        if rigid[a] != rigid[b] and frozenset((part[a], part[b])) not in joined:
            yield i, j


_Spheres: TypeAlias = Mapping[str, tuple[Array, float]]  # centre and radius, by the link it is in


def _spheres(tree: KinematicTree, shapes: Sequence[NamedShape]) -> list[_Spheres]:
    """Return, for each shape and each link that it hangs from, a sphere that it never leaves."""
    above = {joint.child: joint for joint in tree.joints}
    joints = {joint.name: joint for joint in tree.joints}
    found: list[_Spheres] = []
    for entry in shapes:
        x, y, z, r, length = (float(getattr(entry.shape.shape, name, 0.0)) for name in SIZES)
        centre, radius = entry.shape.pose[:3, 3], math.hypot(x, y, z) / 2 + r + length / 2
        own, link = {entry.link: (centre, radius)}, entry.link
        while link in above:
            joint = above[link]
            if joint.kind in ("revolute", "ball"):
                radius += float(np.linalg.norm(centre - joint.anchor))
                centre = joint.anchor
            elif joint.kind == "prismatic":
                radius += max(abs(at - joint.zero) for at in _range(joint, joints))
            elif joint.kind != "fixed":
                radius = math.inf
            centre, link = joint.pose[:3, :3] @ centre + joint.pose[:3, 3], joint.parent
            own[link] = centre, radius
        found.append(own)
    return found


def _range(joint: Joint, joints: Mapping[str, Joint]) -> tuple[float, float]:
    """Return between which positions a joint moves, with the one that it follows."""
    name, factor, offset = led(joint, joints)
    low, high = joints[name].lower, joints[name].upper
    return (factor * low + offset, factor * high + offset) if factor else (offset, offset)


def _can_touch(first: _Spheres, second: _Spheres) -> bool:
    """Whether spheres meet in the last link that both shapes hang from."""
    link = next(name for name in first if name in second)
    (a, r), (b, s) = first[link], second[link]
    return float(np.linalg.norm(a - b)) <= r + s


def _robots(tree: KinematicTree) -> Mapping[str, str]:
    """Return of every link the robot that it belongs to: several may stand in one world."""
    root = tree.root
    found = {root.name: root.name}
    for joint in from_the_root(tree):
        stands = joint.parent == root.name and root.inertial is None and joint.kind != "fixed"
        found[joint.child] = joint.child if stands else found[joint.parent]
    return {name: "" if top == root.name else top for name, top in found.items()}


def _parts(tree: KinematicTree, apart: Collection[str] = ()) -> Mapping[str, str]:
    """Return of every link the first one of those that it is fixed to; empty links are passed.

    Joints that are named keep links ``apart`` as if they moved. By those that are locked, or fixed
    to the root, what hangs from one side is no neighbour of the other side, as a post on a base is
    none of an arm beside it.
    """
    empty = {link.name for link in tree.links if not link.solids and link.inertial is None}
    part = {tree.root.name: tree.root.name}
    for joint in from_the_root(tree):
        fixed = joint.kind == "fixed" and joint.name not in apart
        passed = fixed or (joint.parent in empty and joint.parent != tree.root.name)
        part[joint.child] = part[joint.parent] if passed else joint.child
    return part


def _movable(tree: KinematicTree) -> Iterator[Joint]:
    """Yield the joints with a position of their own."""
    for joint in tree.joints:
        if joint.kind in ("revolute", "prismatic") and joint.mimics is None:
            yield joint


def _random_positions(tree: KinematicTree, generator: np.random.Generator) -> dict[str, float]:
    return {
        joint.name: generator.uniform(max(joint.lower, -UNLIMITED), min(joint.upper, UNLIMITED))
        for joint in _movable(tree)
    }


def _rest(tree: KinematicTree) -> dict[str, float]:
    """Return where joints rest: at 0, of a robot with loops where its file has them closed."""
    return {
        joint.name: min(max(joint.zero if tree.closures else 0.0, joint.lower), joint.upper)
        for joint in _movable(tree)
    }


def _convex(entry: NamedShape, link: Array) -> Convex:
    kind, half = sizes(entry.shape.shape)
    pose = link @ entry.shape.pose
    return Convex(int(kind), half, np.ascontiguousarray(pose[:3, :3]), pose[:3, 3].copy())
