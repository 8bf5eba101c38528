"""Leaving out samples that lie on a line: the compiled part."""

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Points, Quaternions, Scalars
from geometry.compiled import compiled, inner
from programs.motion.steps import GOES_MM

_LARGEST_TURN_DEG = 170.0
"""A turn this far in one line could go either way round."""
_COARSE_MM = 0.06
"""Lines that would be short may be off by this much: controllers take longer.

That is half way along a chord of a rounded corner; at its ends the controller's zone cuts at most 0.05 mm off.
"""
_BACK = 1.0
"""Tolerances that the motion may seem to run back by rounding."""


@compiled
def thin(tcp: Points, quaternion: Quaternions, forced: NDArray[np.bool_], tolerance: float) -> Indices:
    """Choose samples (n,) greedily: each line goes as far as every sample on its way is within the tolerance.

    Args:
        tcp: (n, 3) mm.
        quaternion: (n, 4)
        forced: (n,) samples that remain in any case; the first and the last among them.
        tolerance: mm and degrees, at the same share of the line.
    """
    count = len(tcp)
    kept = np.empty(count, dtype=np.int64)
    kept[0] = 0
    number, first = 1, 0
    while first < count - 1:
        limit = first + 1
        while not forced[limit]:
            limit += 1
        good, step = first + 1, 1
        while good < limit:
            reach = min(good + step, limit)
            if not _is_straight(tcp, quaternion, first, reach, tolerance, tolerance):
                bad = reach
                while bad - good > 1:
                    middle = (good + bad) // 2
                    if _is_straight(tcp, quaternion, first, middle, tolerance, tolerance):
                        good = middle
                    else:
                        bad = middle
                break
            good = reach
            step *= 2
        kept[number] = good
        number += 1
        first = good
    return kept[:number].copy()


@compiled
def merge_short(
    tcp: Points,
    quaternion: Quaternions,
    times: Scalars,
    kept: Indices,
    fixed: NDArray[np.bool_],
    allowed: tuple[float, float],
) -> Indices:
    """Leave out kept samples (k,) beside lines that are too short, as far as 0.06 mm and a turn allow.

    Where they allow none to be left out, one is moved into the line beside, if that is long enough.

    Args:
        tcp: (n, 3) mm.
        quaternion: (n, 4)
        times: (n,) s
        kept: (k,) ends of lines, ascending.
        fixed: (n,) samples that remain in any case.
        allowed: Least time of a line, and degrees that the tool may be turned off its planned direction.
    """
    least_s, most_deg = allowed
    ends = list(kept)
    at = 0
    while at < len(ends) - 1:
        merged = False
        if times[ends[at + 1]] - times[ends[at]] < least_s:
            after = times[ends[at + 2]] - times[ends[at + 1]] if at + 2 < len(ends) else np.inf
            before = times[ends[at]] - times[ends[at - 1]] if at > 0 else np.inf
            for number in range(2):
                inner = at + 1 if (number == 0) == (after <= before) else at
                if inner in (0, len(ends) - 1) or fixed[ends[inner]]:
                    continue
                if _is_straight(tcp, quaternion, ends[inner - 1], ends[inner + 1], _COARSE_MM, most_deg):
                    ends.pop(inner)
                    at = max(inner - 1, 0)
                    merged = True
                    break
            for inner, step in ((at + 1, 1), (at, -1)):
                if merged or inner in (0, len(ends) - 1) or fixed[ends[inner]]:
                    continue
                if times[ends[at + 1]] - times[ends[at]] < least_s:
                    corner = (ends[inner - 1], ends[inner], ends[inner + 1])
                    ends[inner] = _longer(tcp, quaternion, times, corner, step, allowed)
        if not merged:
            at += 1
    return np.array(ends)


@compiled
def _longer(
    tcp: Points,
    quaternion: Quaternions,
    times: Scalars,
    corner: tuple[int, int, int],
    step: int,
    allowed: tuple[float, float],
) -> int:
    """Move the end of a short line so far into the one beside it that both take the least time; else leave it.

    Args:
        tcp: (n, 3) mm.
        quaternion: (n, 4)
        times: (n,) s
        corner: Samples where the first line begins, where both meet, and where the second ends.
        step: 1 if the first is short, -1 if the second is.
        allowed: Least time of a line, and degrees that the tool may be turned off its planned direction.
    """
    least_s, most_deg = allowed
    first, meets, last = corner
    short, long = (first, last) if step == 1 else (last, first)
    middle = meets + step
    while first < middle < last and abs(times[middle] - times[short]) < least_s:
        middle += step
    if not first < middle < last or abs(times[long] - times[middle]) < least_s:
        return meets
    if not _is_straight(tcp, quaternion, first, middle, _COARSE_MM, most_deg):
        return meets
    return middle if _is_straight(tcp, quaternion, middle, last, _COARSE_MM, most_deg) else meets


@compiled
def _is_straight(tcp: Points, quaternion: Quaternions, first: int, last: int, most_mm: float, most_deg: float) -> bool:
    """Whether all samples between lie on the line, in order."""
    chord = np.empty(6)
    run = np.empty(6)
    _run(tcp, quaternion, first, last, chord)
    if chord[3] ** 2 + chord[4] ** 2 + chord[5] ** 2 > _LARGEST_TURN_DEG**2:
        return False
    squared = np.sum(chord[:3] ** 2)
    axes = 3
    if squared <= GOES_MM**2:
        squared = np.sum(chord**2)
        axes = 6
    if squared == 0.0:
        return last == first + 1
    back = _BACK * most_deg / np.sqrt(squared)
    done = 0.0
    for at in range(first + 1, last):
        _run(tcp, quaternion, first, at, run)
        share = 0.0
        for axis in range(axes):
            share += run[axis] * chord[axis] / squared
        if share < done - back or share > 1.0 + back:
            return False
        done = min(max(done, share), 1.0)
        place = turn = 0.0
        for axis in range(3):
            place += (run[axis] - done * chord[axis]) ** 2
            turn += (run[axis + 3] - done * chord[axis + 3]) ** 2
        if place > most_mm**2 or turn > most_deg**2:
            return False
    return True


@inner
def _run(tcp: Points, quaternion: Quaternions, first: int, last: int, run: NDArray[np.float64]) -> None:
    """Six coordinates of a sample seen from another: mm, and axis times angle in degrees."""
    for axis in range(3):
        run[axis] = tcp[last, axis] - tcp[first, axis]
    a, b, c, d = quaternion[first]
    w, x, y, z = quaternion[last]
    real = a * w + b * x + c * y + d * z
    i = a * x - b * w - c * z + d * y
    j = a * y + b * z - c * w - d * x
    k = a * z - b * y + c * x - d * w
    if real < 0.0:
        real, i, j, k = -real, -i, -j, -k
    sine = np.sqrt(i * i + j * j + k * k)
    scale = np.degrees(2.0 * np.arctan2(sine, real)) / sine if sine > 1e-12 else 0.0
    run[3], run[4], run[5] = i * scale, j * scale, k * scale
