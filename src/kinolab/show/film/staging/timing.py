"""Frame times of a film, and interpolation of poses at them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.numerics.manifolds.rotations import of_matrices, slerp, to_matrices
from kinolab.show.film.staging.script import Playback

MAX_FRAMES = 400  # of a GIF


def schedule(
    start: float, end: float, fps: float = 25.0, speed: float = 1.0, *, video: bool = False
) -> Playback:
    """Spread frames over a motion.

    A GIF's frame lasts a whole number of 1/100 s, so ``fps`` is met approximately, and there are at
    most ``MAX_FRAMES``: a long motion is shown faster, at a multiple of half the real speed. A
    video meets ``fps`` and may be long.

    Raises:
        ValueError: If the motion ends before it starts, or a rate is not positive.
    """
    if not (end >= start and fps > 0.0 and speed > 0.0):
        raise ValueError(
            f"a film needs end >= start, fps > 0 and speed > 0; "
            f"got start = {start}, end = {end}, fps = {fps}, speed = {speed}"
        )
    # 2 [1/100 s]; viewers slow down shorter delays
    period = 1.0 / fps if video else max(2, round(100.0 / fps)) / 100.0
    slowest = (end - start) / (((100_000 if video else MAX_FRAMES) - 1) * period)  # frames: an hour
    if speed < slowest:
        speed = float(np.ceil(2.0 * slowest - 1e-9) / 2.0)
    step = speed * period
    count = int(np.ceil((end - start) / step - 1e-9))
    times = np.append(start + step * np.arange(count), end)
    return Playback(times, period, speed)


def interpolate_poses(times: Array, poses: Array, at: Array) -> Array:
    """Interpolate poses: positions linearly, rotations by slerp.

    Args:
        times: Row times in [s], shape (nt,), not decreasing; two equal times are a jump.
        poses: Rows [R | p], shape (nt, nb, 12).
        at: Wanted times, shape (nf,).

    Returns:
        Poses, shape (nf, nb, 12).
    """
    row, weight = _bracket(times, at)
    g = poses.reshape(len(times), -1, 3, 4)
    attitudes, w = of_matrices(g[..., :3]), weight[:, None, None]
    out = np.empty((len(at), g.shape[1], 3, 4))
    out[..., 3] = (1.0 - w) * g[row, :, :, 3] + w * g[row + 1, :, :, 3]
    out[..., :3] = to_matrices(slerp(attitudes[row], attitudes[row + 1], weight[:, None]))
    return out.reshape(len(at), -1, 12)


def interpolate_lines(times: Array, lines: Array, at: Array) -> Array:
    """Interpolate segments linearly, shape (nt, nl, 2, 3) to (nf, nl, 2, 3)."""
    row, weight = _bracket(times, at)
    w = weight[:, None, None, None]
    return np.asarray((1.0 - w) * lines[row] + w * lines[row + 1])


def _bracket(times: Array, at: Array) -> tuple[NDArray[np.intp], Array]:
    """The row before each wanted time, and its fraction of the interval, in [0, 1]."""
    row = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    length = times[row + 1] - times[row]
    weight = np.divide(at - times[row], length, out=np.ones_like(at), where=length > 0.0)
    return row, np.clip(weight, 0.0, 1.0)
