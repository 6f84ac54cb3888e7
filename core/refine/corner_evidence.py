"""Whether a corner is one: the samples choose between it, the smooth course, and arcs in its place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from core.refine.corner_sets import CornerSet, SmoothCurve
from core.refine.project import project
from core.refine.sides import STEP, Nodes, Strokes, evidence, fit_strokes, line_nodes

__all__ = ["LEAST_TURN", "sharp_ones"]

Floats = NDArray[np.float64]

LEAST_TURN = np.radians(28.0)
LOSS = 5.0  # nats by which the smooth course, which has more freedom, may explain the samples better
LONG = 15.0  # in sigma: with sides shorter than this the corner must explain them better,
SUPPORT = 4.0  # by so many nats, with half the gain of the corners beside it
WEIGHT = 8.0  # nats by which the longest arc must explain the samples worse
TOTAL = 16.0  # the same, with twice the support
PLAIN_TURN = np.radians(60.0)  # for corners that turn less both grow in proportion
ROUNDER = 0.5  # nats by which some arc may explain the samples better,
LENIENCE = 0.05  # the more, the worse the longest one does,
CLEARLY_ROUNDER = 2.0  # and at most
FAR_OFF = 12.0  # nats by which the smooth course is so much worse that only this counts
ARCS = (2.0, 3.5, 6.0)  # in sigma: how far from the corner an arc leaves the sides
LONGEST_ARC = 1.25  # the same, in lengths over which the regression rounds off,
MOST_ROUND = 0.7  # and at most, in lengths of the shorter side


def sharp_ones(fit: CornerSet, curve: SmoothCurve) -> NDArray[np.bool_]:
    """Tell which corners the samples prefer to the smooth course and to arcs.

    The smooth course follows the samples with more freedom than two sides have, and may explain them a little
    better even where there is a corner; the longest arc is a smooth course of no more freedom.

    Parameters
    ----------
    fit : CornerSet
    curve : SmoothCurve

    Returns
    -------
    (J,) array of bool
    """
    nodes = fit.strokes.nodes()
    sharp = evidence(fit.samples, nodes.joined(fit.beyond), curve.sigma)
    count = len(fit.corners)
    gain = np.full(count, -np.inf)
    stations = _stations(fit, nodes, curve)
    turns = np.array([_turn(fit, j) for j in range(count)])
    for j in range(count):
        if turns[j] > LEAST_TURN:
            gain[j] = sharp - evidence(fit.samples, _smooth(fit, j, nodes, stations, curve), curve.sigma)
    support = _supported(gain, fit.strokes.ring)
    return np.array(
        [
            gain[j] > -LOSS and _is_sharp(fit, j, nodes, curve, float(gain[j]), float(support[j]))
            for j in range(count)
        ],
        np.bool_,
    )


def _is_sharp(fit: CornerSet, j: int, nodes: Nodes, curve: SmoothCurve, gain: float, support: float) -> bool:
    """Whether arcs in place of a corner explain the samples no better, and the longest one much worse.

    Where the smooth course is far off, a corner will do unless arcs are clearly better.
    """
    long = min(fit.strokes.length(k) for k in fit.sides(j)) > LONG * curve.sigma
    if not long and support < SUPPORT:
        return False
    better = _rounded(fit, j, nodes, curve)
    if long and gain > FAR_OFF:
        return bool(better.max() < CLEARLY_ROUNDER)
    gentle = max(1.0, PLAIN_TURN / _turn(fit, j))
    worse = -float(better[-1])
    beyond = min(worse - WEIGHT * gentle, worse + 2.0 * support - TOTAL * gentle)
    return bool(beyond > 0.0 and better.max() < min(ROUNDER + LENIENCE * beyond, CLEARLY_ROUNDER))


def _supported(gain: Floats, ring: bool) -> Floats:
    """Each corner's gain, with half of those of the corners that share its sides."""
    if len(gain) < 2:
        return gain
    shared = np.clip(gain, -2.0 * SUPPORT, 4.0 * SUPPORT)
    before, after = np.roll(shared, 1), np.roll(shared, -1)
    if not ring:
        before[0] = after[-1] = 0.0
    return np.asarray(gain + 0.5 * (before + after))


def _turn(fit: CornerSet, j: int) -> float:
    """Angle by which the course turns in corner ``j``."""
    before, after = fit.sides(j)
    a = fit.place(j) - fit.strokes.at(before, np.array([0.8]))[0]
    b = fit.strokes.at(after, np.array([0.2]))[0] - fit.place(j)
    cosine = float(a @ b) / max(float(np.linalg.norm(a) * np.linalg.norm(b)), 1e-300)
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))


def _stations(fit: CornerSet, nodes: Nodes, curve: SmoothCurve) -> Floats:
    """Where on the smooth curve the nodes of the sides are, wherever they have moved to."""
    nominal, line = fit.node_stations, curve.line
    feet = project(nodes.place, [line], 2.0 * curve.look)
    away = np.where(feet.curve == 0, feet.station - nominal, 0.0)
    if line.closed:
        away = (away + 0.5 * line.length) % line.length - 0.5 * line.length
    # Of a course that comes by twice the foot may lie on the other branch.
    return np.asarray(nominal + np.where(np.abs(away) < curve.look, away, 0.0))


def _smooth(fit: CornerSet, j: int, nodes: Nodes, stations: Floats, curve: SmoothCurve) -> Nodes:
    """The course with corner ``j`` as the regression left it."""
    s = float(fit.corners[j])
    at = int(np.argmin(np.abs(fit.knots - s)))
    gaps = np.diff(fit.knots)
    low = s - min(1.5 * curve.look, 0.5 * gaps[at - 1])
    high = s + min(1.5 * curve.look, 0.5 * gaps[at % len(gaps)])
    offset = stations - low
    if fit.strokes.ring:
        offset = offset % curve.line.length
    outside = (offset < 0.0) | (offset > high - low)
    return nodes.only(outside).joined(line_nodes(curve.line, low, high, curve.sigma)).joined(fit.beyond)


def _rounded(fit: CornerSet, j: int, nodes: Nodes, curve: SmoothCurve) -> Floats:
    """Nats by which arcs in place of corner ``j``, ever longer, explain the samples better."""
    before, after = fit.sides(j)
    strokes, last = fit.strokes, fit.strokes.count - 1
    rows = np.array([*strokes.rows(before), *strokes.rows(after)[1:]])
    stroke = strokes.fraction.astype(np.int64)
    counts = [int(np.count_nonzero(stroke == k)) for k in (before, after)]
    here = (stroke == before) | (stroke == after)
    others = nodes.only(~here).joined(fit.beyond)
    at = before if fit.strokes.ring else j
    low, high = fit.knots[at], fit.knots[at] + np.diff(fit.knots)[[before, after]].sum()
    samples = curve.between(float(low), float(high))
    fixed = strokes.ring or before > 0, strokes.ring or after < last
    local = replace(Strokes.of(strokes.control[rows], counts, False), bent=strokes.bent[[before, after]])
    sigma = curve.sigma
    local, sharp = fit_strokes(samples, local, others, sigma, fixed)
    lengths = local.length(0), local.length(1)
    longest = MOST_ROUND * min(lengths)
    out = []
    for reach in [
        *(r * sigma for r in ARCS if r * sigma < 0.9 * longest),
        min(longest, LONGEST_ARC * curve.look),
    ]:
        arc = local.rounded(1.0 - reach / lengths[0], reach / lengths[1], STEP * sigma)
        out.append(fit_strokes(samples, arc, others, sigma, fixed)[1] - sharp)
    return np.array(out)
