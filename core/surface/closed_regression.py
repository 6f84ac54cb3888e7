"""Local regression along a closed contour: samples in bins, windows that vary, vertices; compiled.

Order four, as :mod:`core.refine.regression` has it for any curve; what is closed has no ends to look out for.
The half-widths of windows are those of least C_p (Mallows 1973), place by place.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from core.refine.regression import INSIDE, solve

__all__ = ["LEVELS", "NARROWEST", "bins_of", "half_widths", "nearest_on", "vertices_of"]

AROUND = 1.0 / 8.0  # of a contour, to both sides: places that choose a half-width together
DETAIL = 8.0  # bins in half a window, at least
LEVELS = 7  # of bins, each twice as wide as those before
NARROWEST = 5.0  # in sigma: below, wiggles reinforce themselves from pass to pass
TOLERATED = 0.2  # of the standard error, by which chords may deviate
UNSURE = 2.0  # leverage: beyond, the samples are to one side, and lower orders are nearer to them
WINDOW = 2  # segments to both sides of where a foot was


@njit(cache=True)
def nearest_on(points, ring, stations, segment):  # type: ignore[no-untyped-def]
    """Arc lengths of the nearest places on a closed polyline, from segments that are near.

    Also the distances, negative to the right of it.
    """
    count, size = ring.shape[0], points.shape[0]
    station, distance = np.empty(size), np.empty(size)
    for i in range(size):
        x, y, middle = points[i, 0], points[i, 1], segment[i]
        best, foot, where, left = np.inf, stations[middle % count], middle, True
        for _ in range(count):
            for step in range(-WINDOW, WINDOW + 1):
                a = (middle + step) % count
                b = (a + 1) % count
                ux, uy, dx, dy = (
                    ring[b, 0] - ring[a, 0],
                    ring[b, 1] - ring[a, 1],
                    x - ring[a, 0],
                    y - ring[a, 1],
                )
                square = ux * ux + uy * uy
                t = min(max((dx * ux + dy * uy) / square, 0.0), 1.0) if square > 0.0 else 0.0
                away = (dx - t * ux) ** 2 + (dy - t * uy) ** 2
                if away < best:
                    best, where, left = away, middle + step, ux * dy >= uy * dx
                    foot = stations[a] + t * (stations[a + 1] - stations[a])
            if abs(where - middle) < WINDOW:
                break
            middle = where
        station[i], distance[i] = foot, np.sqrt(best) if left else -np.sqrt(best)
    return station, distance


@njit(cache=True)
def bins_of(points, at, distance, cut, length, count):  # type: ignore[no-untyped-def]
    """Sums over equal intervals of arc length, and over twice, four times as wide ones.

    A sample counts for the two bins whose middles enclose it, in proportion. Returns the number of bins
    of each level of width, and rows of one array: station, count and place (x, y) of the mean sample of
    each bin. There the bins of a level of n begin at column 6 (count - n), three turns of them, so that
    windows need not look for the seam.
    """
    size = np.zeros(LEVELS, np.int64)
    table = np.zeros((4, 6 * count))
    width = length / count
    size[0] = count
    for i in range(points.shape[0]):
        if not abs(distance[i]) <= cut:
            continue
        u = at[i] / width - 0.5
        b = int(np.floor(u))
        for side in range(2):
            share = u - b if side == 1 else 1.0 - (u - b)
            c = (b + side) % count
            table[0, c] += share * (u - b - side) * width
            table[1, c] += share
            table[2, c] += share * points[i, 0]
            table[3, c] += share * points[i, 1]
    for level in range(LEVELS - 1):
        if size[level] % 2 or size[level] < 16:
            break
        size[level + 1] = size[level] // 2
        _merge(table, 6 * (count - size[level]), 6 * (count - size[level + 1]), size[level + 1], width)
        width *= 2.0
    for level in range(LEVELS):
        _turn(table, 6 * (count - size[level]), size[level], length)
    return size, table


@njit(cache=True)
def _merge(table, begin, end, count, width):  # type: ignore[no-untyped-def]
    """Sum pairs of bins; first moments are about the middles of bins."""
    for c in range(count):
        for half in range(2):
            b = begin + 2 * c + half
            table[0, end + c] += table[0, b] + (half - 0.5) * width * table[1, b]
            for k in range(1, 4):
                table[k, end + c] += table[k, b]


@njit(cache=True)
def _turn(table, begin, count, length):  # type: ignore[no-untyped-def]
    """Means from sums, for a turn before the seam, one after it and one more."""
    for c in range(begin, begin + count):
        full = table[1, c] if table[1, c] > 0.0 else 1.0
        table[0, c] = (c - begin + 0.5) * (length / count) + table[0, c] / full - length
        table[2, c] /= full
        table[3, c] /= full
        for turn in range(1, 3):
            for k in range(4):
                table[k, c + turn * count] = table[k, c]
            table[0, c + turn * count] += turn * length


@njit(cache=True)
def _level(size, width, length, detail):  # type: ignore[no-untyped-def]
    """The level of the widest bins of which half a window holds enough."""
    level = 0
    while level + 1 < LEVELS and size[level + 1] and width / length * size[level + 1] >= detail:
        level += 1
    return level


@njit(cache=True)
def _window(table, begin, count, length, s, h, moments, target):  # type: ignore[no-untyped-def]
    """Moments of the window around ``s``; returns the number of bins with samples in it."""
    width = length / count
    m0 = m1 = m2 = m3 = m4 = m5 = m6 = m7 = m8 = 0.0
    x0 = x1 = x2 = x3 = x4 = y0 = y1 = y2 = y3 = y4 = 0.0
    used, middle = 0, begin + count
    first, last = middle + int(np.floor((s - h) / width)) - 1, middle + int(np.floor((s + h) / width)) + 1
    for b in range(max(first, begin), min(last, begin + 3 * count - 1) + 1):
        u = (table[0, b] - s) / h
        w = table[1, b] * (1.0 - u * u)
        if not w > 0.0:
            continue
        used += 1
        x, y = table[2, b], table[3, b]
        m0, x0, y0, w = m0 + w, x0 + w * x, y0 + w * y, w * u
        m1, x1, y1, w = m1 + w, x1 + w * x, y1 + w * y, w * u
        m2, x2, y2, w = m2 + w, x2 + w * x, y2 + w * y, w * u
        m3, x3, y3, w = m3 + w, x3 + w * x, y3 + w * y, w * u
        m4, x4, y4, w = m4 + w, x4 + w * x, y4 + w * y, w * u
        m5, w = m5 + w, w * u
        m6, w = m6 + w, w * u
        m7, m8 = m7 + w, m8 + w * u
    moments[0], moments[1], moments[2], moments[3], moments[4] = m0, m1, m2, m3, m4
    moments[5], moments[6], moments[7], moments[8] = m5, m6, m7, m8
    target[0, 0], target[0, 1], target[0, 2], target[0, 3], target[0, 4] = x0, x1, x2, x3, x4
    target[1, 0], target[1, 1], target[1, 2], target[1, 3], target[1, 4] = y0, y1, y2, y3, y4
    return used


@njit(cache=True)
def _fit(table, begin, count, length, s, h, shift, room, weights):  # type: ignore[no-untyped-def]
    """Local regression at station ``s``, of the highest order that the window's samples allow.

    Leaves in ``weights`` the polynomial that gives the weights of samples in the place, moved by
    ``shift`` times the second derivative there, and in that derivative.
    Returns the order, -1 without samples; ``room`` then holds the sums that they are applied to.
    """
    moments, target, m = room
    used = _window(table, begin, count, length, s, h, moments, target)
    while used < INSIDE + 2 and h < 0.5 * length:
        h = min(1.3 * h, 0.5 * length)
        used = _window(table, begin, count, length, s, h, moments, target)
    for order in range(INSIDE, -1, -1):
        if used <= order + 1 and order > 0:
            continue
        for a in range(order + 1):
            for b in range(order + 1):
                m[a, b] = moments[a + b]
        for a in range(5):
            weights[a, 0] = weights[a, 1] = 0.0
        weights[0, 0] = 1.0
        if order >= 2:
            weights[2, 0], weights[2, 1] = 2.0 * shift / (h * h), 2.0 / (h * h)
        if solve(m, weights, order + 1) and (order == 0 or abs(weights[0, 0]) <= UNSURE):
            return order
    return -1


@njit(cache=True)
def half_widths(bins, least, most, length, price, ratio, places):  # type: ignore[no-untyped-def]
    """Half-widths of windows at equally distant places, each of least C_p around there."""
    size, table = bins
    high = min(most, 0.5 * length)
    low = min(max(least, 2.5 * length / size[0]), high)
    count = max(int(np.log(high / low) / np.log(ratio)) + 1, 2)
    ratio = (high / low) ** (1.0 / (count - 1))
    places = min(places, size[0])
    scores = np.zeros((count, places))
    room, weights = (np.empty(9), np.empty((2, 5)), np.empty((5, 5))), np.empty((5, 2))
    for c in range(count):
        h = low * ratio**c
        n = size[_level(size, h, length, DETAIL)]
        shift = _shift(length, n) - _shift(length, size[0])
        for j in range(places):
            b = size[0] + j * size[0] // places
            if table[1, b] <= 0.0:
                continue
            if _fit(table, 6 * (size[0] - n), n, length, table[0, b], h, shift, room, weights) >= 0:
                dx = table[2, b] - _sum(weights, 0, room[1], 0)
                dy = table[3, b] - _sum(weights, 0, room[1], 1)
                scores[c, j] = table[1, b] * (dx * dx + dy * dy + price * weights[0, 0])
    return _smooth(_least(_around(scores), np.log(low), np.log(ratio)))


@njit(cache=True)
def _shift(length, count):  # type: ignore[no-untyped-def]
    """What times the second derivative undoes the pull of chords: half the variance within a bin."""
    return -((length / count) ** 2) / 24.0


@njit(cache=True)
def _sum(weights, column, target, row):  # type: ignore[no-untyped-def]
    """Apply weights to the sums of a window."""
    total = 0.0
    for a in range(5):
        total += weights[a, column] * target[row, a]
    return total


@njit(cache=True)
def _around(scores):  # type: ignore[no-untyped-def]
    """Sums over the places around each one."""
    count, places = scores.shape
    half = max(int(AROUND * places), 1)
    out = np.empty_like(scores)
    for c in range(count):
        total = 0.0
        for j in range(-half, half + 1):
            total += scores[c, j % places]
        for j in range(places):
            out[c, j] = total
            total += scores[c, (j + half + 1) % places] - scores[c, (j - half) % places]
    return out


@njit(cache=True)
def _least(scores, low, step):  # type: ignore[no-untyped-def]
    """Logarithms of the half-widths of least score, at the vertex of the parabola through it."""
    count, places = scores.shape
    out = np.empty(places)
    for j in range(places):
        c = 0
        for k in range(1, count):
            if scores[k, j] < scores[c, j]:
                c = k
        shift = 0.0
        if 0 < c < count - 1:
            rise = scores[c - 1, j] - 2.0 * scores[c, j] + scores[c + 1, j]
            shift = 0.5 * (scores[c - 1, j] - scores[c + 1, j]) / rise if rise > 0.0 else 0.0
        out[j] = low + (c + shift) * step
    return out


@njit(cache=True)
def _smooth(logarithms):  # type: ignore[no-untyped-def]
    """Half-widths that change gradually along the contour."""
    places = logarithms.shape[0]
    half = max(int(AROUND * places), 1)
    out = np.empty(places)
    for j in range(places):
        total, weights = 0.0, 0.0
        for k in range(-half, half + 1):
            weight = 1.0 - abs(k) / (half + 1.0)
            total += weight * logarithms[(j + k) % places]
            weights += weight
        out[j] = np.exp(total / weights)
    return out


@njit(cache=True)
def vertices_of(bins, widths, length, sigma, count):  # type: ignore[no-untyped-def]
    """The fit at equally distant stations, and how long chords may be there."""
    size, table = bins
    places = widths.shape[0]
    room, weights = (np.empty(9), np.empty((2, 5)), np.empty((5, 5))), np.empty((5, 2))
    out, chords = np.empty((count, 2)), np.empty(count)
    for j in range(count):
        u = j * places / count
        k = int(u)
        h = min((1.0 - (u - k)) * widths[k % places] + (u - k) * widths[(k + 1) % places], 0.5 * length)
        n = size[_level(size, h, length, DETAIL)]
        shift = 0.5 * min(sigma, h / NARROWEST) ** 2 + _shift(length, n) + _shift(length, size[0])
        _fit(table, 6 * (size[0] - n), n, length, j * length / count, h, shift, room, weights)
        bend = 0.0
        for d in range(2):
            out[j, d] = _sum(weights, 0, room[1], d)
            bend += _sum(weights, 1, room[1], d) ** 2
        error = max(sigma * np.sqrt(max(weights[0, 0], 0.0)), 1e-9 * length)
        chords[j] = min(np.sqrt(8.0 * TOLERATED * error / max(np.sqrt(bend), 1e-9 / length)), 0.25 * h)
    return out, chords
