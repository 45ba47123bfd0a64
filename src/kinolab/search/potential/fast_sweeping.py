"""Arrival times of a front on a grid: the eikonal equation |grad t| = 1/speed by fast sweeping.

Each time is the least over all points around a corner, between which times are interpolated, of the
time there and the straight way on. Around the source, where fronts are curved most, interpolated
times are too late; there they are corrected by what straight rays from the source lack.

Source: Tsai, Cheng, Osher, Zhao, Fast sweeping algorithms for a class of Hamilton-Jacobi equations,
SIAM J. Numer. Anal. 41, 2003; for the correction, Fomel, Luo, Zhao, Fast sweeping method for the
factored eikonal equation, J. Comp. Phys. 228, 2009.
"""

from __future__ import annotations

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel


def arrival_times(speed: Array, source: Array) -> Array:
    """Return arrival times at the corners of cells of size 1, one more per axis than cells.

    A time depends on smaller ones alone, so the sweeps end with nothing left to change, after as
    many as the longest path has turns.

    Args:
        speed: One entry per cell, shape (nx, ny) or (nx, ny, nz), positive.
        source: Integer coordinates of the corner whose time is 0, shape (2,) or (3,).
    """
    slowness = np.atleast_3d(1.0 / speed)
    plane = speed.ndim == 2
    times = np.full([*(n + 1 for n in speed.shape), 1][:3], np.inf)
    origin = np.append(source, 0.0)[:3]
    times[tuple(origin.astype(int))] = 0.0
    while _sweep(times, slowness, origin):
        pass
    return times[:, :, 0] if plane else times


@kernel
def _sweep(times, slowness, origin):  # type: ignore[no-untyped-def]
    """Update times once along each diagonal; return whether one fell.

    Args:
        times: At corners, shape (nx + 1, ny + 1, nz + 1), or (nx + 1, ny + 1, 1) in a plane.
        slowness: Of cells, shape (nx, ny, nz).
        origin: Where the source is, shape (3,).
    """
    nx, ny, nz = times.shape
    fell = False
    for octant in range(8 if nz > 1 else 4):
        sx, sy, sz = 1 - 2 * (octant & 1), 1 - (octant & 2), 1 - (octant & 4) // 2
        for a in range(nx):
            i = a if sx > 0 else nx - 1 - a
            for b in range(ny):
                j = b if sy > 0 else ny - 1 - b
                for c in range(nz):
                    k = c if sz > 0 else nz - 1 - c
                    time = _time(times, slowness, origin, i, j, k, sx, sy, sz)
                    if time < times[i, j, k]:
                        times[i, j, k] = time
                        fell = True
    return fell


@kernel
def _time(times, slowness, origin, i, j, k, sx, sy, sz):  # type: ignore[no-untyped-def]
    """Return when a front arrives at corner i, j, k that comes along the diagonal sx, sy, sz.

    It comes through one of the six tetrahedra of the cell behind, of which each has an edge, the
    diagonal of a face and the diagonal of the cell, or along one of their triangles and edges; in
    these it may go in any cell that they belong to.

    Args:
        times: As ``_sweep`` has them, shape (nx + 1, ny + 1, nz + 1).
        slowness: Of cells, shape (nx, ny, nz).
        origin: Where the source is, shape (3,).
        i, j, k: The corner.
        sx, sy, sz: Where the front goes, 1 or -1 along each axis.
    """
    p, q, r = i - (sx + 1) // 2, j - (sy + 1) // 2, k - (sz + 1) // 2  # the cell behind
    cell = _slowness(slowness, p, q, r)
    at_x, at_y = _slowness(slowness, p + sx, q, r), _slowness(slowness, p, q + sy, r)
    at_z = _slowness(slowness, p, q, r + sz)
    x, cx = _behind(times, origin, i, j, k, sx, 0, 0)
    y, cy = _behind(times, origin, i, j, k, 0, sy, 0)
    xy, cxy = _behind(times, origin, i, j, k, sx, sy, 0)
    least = min(
        x + min(cell, at_y, at_z, _slowness(slowness, p, q + sy, r + sz)),
        y + min(cell, at_x, at_z, _slowness(slowness, p + sx, q, r + sz)),
        xy + np.sqrt(2.0) * min(cell, at_z),
        _through_segment(x, cx, xy, cxy, min(cell, at_z), 1.0, 1.0),
        _through_segment(y, cy, xy, cxy, min(cell, at_z), 1.0, 1.0),
    )
    if times.shape[2] == 1:
        return least
    z, cz = _behind(times, origin, i, j, k, 0, 0, sz)
    xz, cxz = _behind(times, origin, i, j, k, sx, 0, sz)
    yz, cyz = _behind(times, origin, i, j, k, 0, sy, sz)
    xyz, cxyz = _behind(times, origin, i, j, k, sx, sy, sz)
    return min(
        least,
        z + min(cell, at_x, at_y, _slowness(slowness, p + sx, q + sy, r)),
        xz + np.sqrt(2.0) * min(cell, at_y),
        yz + np.sqrt(2.0) * min(cell, at_x),
        xyz + np.sqrt(3.0) * cell,
        _through_segment(x, cx, xz, cxz, min(cell, at_y), 1.0, 1.0),
        _through_segment(z, cz, xz, cxz, min(cell, at_y), 1.0, 1.0),
        _through_segment(y, cy, yz, cyz, min(cell, at_x), 1.0, 1.0),
        _through_segment(z, cz, yz, cyz, min(cell, at_x), 1.0, 1.0),
        _through_segment(x, cx, xyz, cxyz, cell, 1.0, 2.0),
        _through_segment(y, cy, xyz, cxyz, cell, 1.0, 2.0),
        _through_segment(z, cz, xyz, cxyz, cell, 1.0, 2.0),
        _through_segment(xy, cxy, xyz, cxyz, cell, 2.0, 1.0),
        _through_segment(xz, cxz, xyz, cxyz, cell, 2.0, 1.0),
        _through_segment(yz, cyz, xyz, cxyz, cell, 2.0, 1.0),
        _through_triangle(x, cx, xy, cxy, xyz, cxyz, cell),
        _through_triangle(x, cx, xz, cxz, xyz, cxyz, cell),
        _through_triangle(y, cy, xy, cxy, xyz, cxyz, cell),
        _through_triangle(y, cy, yz, cyz, xyz, cxyz, cell),
        _through_triangle(z, cz, xz, cxz, xyz, cxyz, cell),
        _through_triangle(z, cz, yz, cyz, xyz, cxyz, cell),
    )


@kernel
def _slowness(slowness, p, q, r):  # type: ignore[no-untyped-def]
    """Return the slowness of a cell, or of the nearest one of the grid."""
    nx, ny, nz = slowness.shape
    return slowness[min(max(p, 0), nx - 1), min(max(q, 0), ny - 1), min(max(r, 0), nz - 1)]


@kernel
def _behind(times, origin, i, j, k, sx, sy, sz):  # type: ignore[no-untyped-def]
    """Return the time of the corner sx, sy, sz behind i, j, k, and its correction at speed 1.

    The correction is what the distance from the source curves upward between the two.

    Args:
        times: As ``_sweep`` has them, shape (nx + 1, ny + 1, nz + 1).
        origin: Where the source is, shape (3,).
        i, j, k: The corner.
        sx, sy, sz: Steps from the one behind, each -1, 0 or 1.
    """
    nx, ny, nz = times.shape
    a, b, c = i - sx, j - sy, k - sz
    if not (0 <= a < nx and 0 <= b < ny and 0 <= c < nz):
        return np.inf, 0.0
    x, y, z = i - origin[0], j - origin[1], k - origin[2]
    ray = max(np.sqrt(x * x + y * y + z * z), 1e-300)
    before = np.sqrt((x - sx) ** 2 + (y - sy) ** 2 + (z - sz) ** 2)
    return times[a, b, c], ray - before - (sx * x + sy * y + sz * z) / ray


@kernel
def _through_segment(p, cp, q, cq, s, n, m):  # type: ignore[no-untyped-def]
    """Return the earliest time by way of a segment, inf if that is at one of its ends.

    The least of p - g (p - q) + s sqrt(n + m g^2) for 0 < g < 1.

    Args:
        p: Time at its nearer end, to which it is perpendicular.
        q: Time at its farther end.
        cp, cq: Their corrections at speed 1.
        s: Slowness.
        n: Squared distance of the nearer end.
        m: Squared length of the segment.
    """
    if not (q < p < np.inf):
        return np.inf
    fall = p + s * cp - q - s * cq
    if fall <= 0.0 or fall * fall * (n + m) >= m * m * s * s:
        return np.inf
    time = p + s * cp + np.sqrt(n * (s * s - fall * fall / m))
    return time if time > p else np.inf


@kernel
def _through_triangle(p, cp, q, cq, r, cr, s):  # type: ignore[no-untyped-def]
    """Return the earliest time by way of a triangle, inf if that is on one of its sides.

    Its corners are at squared distances 1, 2 and 3, each perpendicular to what leads to the next.

    Args:
        p, q, r: Times at its corners.
        cp, cq, cr: Their corrections at speed 1.
        s: Slowness.
    """
    if not (r < p < np.inf and q < np.inf):
        return np.inf
    first, second = p + s * cp - q - s * cq, q + s * cq - r - s * cr
    square = s * s - first * first - second * second
    if not (0.0 < second < first and first * first < square):
        return np.inf
    time = p + s * cp + np.sqrt(square)
    return time if time > max(p, q) else np.inf
