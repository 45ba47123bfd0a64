"""The geoms of an MJCF file: what collides, what is drawn, and the solids behind planes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from kinolab.concurrency.stages import doing
from kinolab.dynamics.language.shapes import Box, Capsule, Cylinder, Shape, Sphere
from kinolab.errors import InputError, printable
from kinolab.numerics.arrays import Array
from kinolab.robots.mjcf.compiled_model import WORLD_BODY, CompiledModel
from kinolab.robots.solids.convex_parts import enclosing_shapes
from kinolab.robots.solids.enclosing import enclosing_shape
from kinolab.robots.tree.kinematic_tree import Inertial, Link, PlacedShape, VisibleMesh, pose_of
from kinolab.world.shapes.shape_surfaces import Faces

# [m], edges of the cube that stands for the half-space behind a plane, which has no end: in its
# middle a surface is where it should be but for rounding, 1e-10 m
DEEP = 2e6
LEVEL = 1e-9  # of a plane's normal, and of its height in [m]: less is rounding


class GeomReader:
    """Converts geoms to solids and meshes.

    Args:
        shapes: Whether to read any.
        convex_parts: How many parts a mesh may be divided into; None: it is enclosed whole.
    """

    def __init__(self, compiled: CompiledModel, *, shapes: bool, convex_parts: int | None) -> None:
        self._compiled, self._model = compiled, compiled.model
        self._shapes, self._convex_parts = shapes, convex_parts
        self._placed = compiled.mujoco.MjData(self._model)
        compiled.mujoco.mj_kinematics(self._model, self._placed)

    def link(self, body: int, inertial: Inertial | None) -> tuple[Link, list[Link]]:
        """Return a body as a link, and what collides of one that stands, in links of its own."""
        stands, name = self._stands(body), self._compiled.bodies[body]
        doing(f"reading {printable(f'{self._compiled.path.name}: body {name}')}")
        geoms = () if stands else self.solid_geoms(body)
        solids = tuple(s for g in geoms for s in self._solids(g))
        visible = tuple(self._visible(body)) if self._shapes else ()
        around = [
            Link(
                f"{name} {self._compiled.geoms[g]}{f' {k + 1}' if k else ''}",
                solids=(solid,),
                visible=tuple(self._patch(g)),
                stands=True,
                hidden=bool(visible),
            )
            for g in (self.solid_geoms(body) if stands else ())
            for k, solid in enumerate(self._solids(g))
        ]
        return Link(name, inertial, solids, visible), around

    def _stands(self, body: int) -> bool:
        """Whether a body is fixed to the world, and something of it collides."""
        model, above = self._model, body
        while above != WORLD_BODY and not model.body_jntnum[above]:
            above = int(model.body_parentid[above])
        return above == WORLD_BODY and any(map(self._collides, self.solid_geoms(body)))

    def _collides(self, g: int) -> bool:
        return bool(self._model.geom_contype[g] or self._model.geom_conaffinity[g])

    def solid_geoms(self, body: int) -> list[int]:
        """Return the geoms that collide, or those that are drawn where none does."""
        first = int(self._model.body_geomadr[body])
        own = range(first, first + int(self._model.body_geomnum[body])) if self._shapes else ()
        return [g for g in own if self._collides(g)] or [*own]

    def _solids(self, g: int) -> Iterator[PlacedShape]:
        """Yield the shapes of a geom."""
        model, types = self._model, self._compiled.mujoco.mjtGeom
        pose = pose_of(model.geom_pos[g], self._compiled.turn(model.geom_quat[g]))
        red, green, blue, _ = map(float, model.geom_rgba[g])
        kind = int(model.geom_type[g])
        if kind == int(types.mjGEOM_MESH):
            solids = self._around_mesh(int(model.geom_dataid[g]))
        elif self._is_plane(g):
            solids = self._behind_plane(g) if self._collides(g) else []
        else:
            shape = self._shape(g)
            solids = [] if shape is None else [PlacedShape(shape, np.eye(4))]
        for solid in solids:
            yield replace(solid, pose=pose @ solid.pose, color=(red, green, blue))

    def _behind_plane(self, g: int) -> list[PlacedShape]:
        """Return the solid behind a plane, in its frame; none of the ground, of scenarios."""
        if self._is_ground(g):
            return []
        turn = self._placed.geom_xmat[g].reshape(3, 3)
        centre = -turn.T @ self._placed.geom_xpos[g]  # the world's origin, wherever its own lies
        centre[2] = -DEEP / 2
        if any(self.grounds()) and abs(turn[2, 2]) < LEVEL:  # a wall stands on the ground
            centre += DEEP / 2 * turn[2]
        return [PlacedShape(Box(DEEP, DEEP, DEEP), pose_of(centre, np.eye(3)))]

    def grounds(self) -> Iterator[str]:
        """Yield the planes that are the ground, by name; none without shapes."""
        for g in filter(self._is_plane, range(self._model.ngeom if self._shapes else 0)):
            if self._collides(g) and self._is_ground(g):
                yield self._compiled.geoms[g]

    def _patch(self, g: int) -> Iterator[VisibleMesh]:
        """Yield what is drawn of a plane; of one without an end, as much as the model is large."""
        model = self._model
        if not self._is_plane(g):
            return
        x, y = (float(half) or float(model.stat.extent) for half in model.geom_size[g, :2])
        corners = np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]])
        faces = np.array([[0, 1, 2], [0, 2, 3]])
        yield self._drawn(g, self._compiled.geoms[g], corners, faces, model.geom_rgba[g])

    def _drawn(self, g: int, name: str, vertices: Array, faces: Faces, rgba: Array) -> VisibleMesh:
        """Return a mesh as it is drawn, of vertices (n, 3) in a geom's frame in one colour."""
        colors = np.tile(np.array(rgba[:3], dtype=float), (len(faces), 1))
        placed = (
            vertices @ self._compiled.turn(self._model.geom_quat[g]).T + self._model.geom_pos[g]
        )
        return VisibleMesh(name, placed, faces, colors)

    def _is_plane(self, g: int) -> bool:
        return int(self._model.geom_type[g]) == int(self._compiled.mujoco.mjtGeom.mjGEOM_PLANE)

    def _is_ground(self, plane: int) -> bool:
        """Whether a plane is that of the world's ground: z = 0, from above."""
        level = float(self._placed.geom_xmat[plane, 8]) > 1.0 - LEVEL
        return level and abs(float(self._placed.geom_xpos[plane, 2])) < LEVEL

    def _visible(self, body: int) -> Iterator[VisibleMesh]:
        """Yield the meshes that are drawn: those that do not collide, where there are any."""
        model = self._model
        first = int(model.body_geomadr[body])
        meshes = [
            g
            for g in range(first, first + int(model.body_geomnum[body]))
            if model.geom_type[g] == int(self._compiled.mujoco.mjtGeom.mjGEOM_MESH)
        ]
        only = [g for g in meshes if not (model.geom_contype[g] or model.geom_conaffinity[g])]
        for g in only or meshes:
            where, vertices, faces = self._mesh(int(model.geom_dataid[g]))
            material = int(model.geom_matid[g])
            color = model.geom_rgba[g] if material < 0 else model.mat_rgba[material]
            yield self._drawn(g, where, vertices, faces, color)

    def _mesh(self, mesh: int) -> tuple[str, Array, Faces]:
        """Return what a mesh is called, its vertices (n, 3) in [m] and its faces (m, 3)."""
        model = self._model
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        vertices = np.array(model.mesh_vert[first : first + count], dtype=float)
        first, count = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        faces = np.array(model.mesh_face[first : first + count], dtype=np.int64)
        return f"mesh {self._compiled.names('MESH', model.nmesh, 'mesh')[mesh]}", vertices, faces

    def _around_mesh(self, mesh: int) -> list[PlacedShape]:
        """Return solids around a mesh."""
        where, vertices, faces = self._mesh(mesh)
        try:
            return enclosing_shapes(vertices, faces, self._convex_parts, where)
        except InputError as error:
            for one in error.mistakes:
                self._compiled.cannot(f"{one.where}: {one.what}", one.remedy)
            return [enclosing_shape(vertices)]

    def _shape(self, g: int) -> Shape | None:
        """Return a geom's shape, neither of a mesh nor of a plane; None where it has none."""
        model, types = self._model, self._compiled.mujoco.mjtGeom
        a, b, c = map(float, model.geom_size[g])
        kind = types(int(model.geom_type[g]))
        if kind == types.mjGEOM_SPHERE:
            return Sphere(a)
        if kind == types.mjGEOM_CAPSULE:
            return Capsule(a, 2 * b)
        if kind == types.mjGEOM_CYLINDER:
            return Cylinder(a, 2 * b)
        if kind in (types.mjGEOM_BOX, types.mjGEOM_ELLIPSOID):
            return Box(2 * a, 2 * b, 2 * c)
        word = kind.name.removeprefix("mjGEOM_").lower()
        what = f"geom {self._compiled.geoms[g]} has the type {word}, which is no solid here."
        self._compiled.cannot(what, "Write it as meshes, or as obstacles of a scenario.")
        return None
