"""Samples of drawn curves, in units of their noise."""

import numpy as np

from core.diagnosis.across import samples_across
from core.refine.polyline import Polyline
from core.refine.project import project
from tests.core.shapes import in_space


def straight(length):
    """A straight curve along the x axis."""
    x = np.linspace(0.0, length, 200)
    return Polyline(in_space(np.column_stack((x, 0 * x))), False)


def ring(radius):
    angle = np.arange(720) * np.pi / 360
    return Polyline(in_space(radius * np.column_stack((np.cos(angle), np.sin(angle)))), True)


def beside(x, y, sigma=None, line=None):
    """What a straight curve sees of samples at (x, y)."""
    line = straight(float(np.max(x))) if line is None else line
    points = in_space(np.column_stack((x, y)))
    sigma = float(np.std(y)) if sigma is None else sigma
    feet = project(points, [line], 8 * sigma)
    (across,) = samples_across(points, [line], feet, np.array([sigma]), True)
    return across


def around(radius, n, sigma, seed):
    """What a ring sees of noisy samples of it."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0, 2 * np.pi, n)
    points = radius * np.column_stack((np.cos(angle), np.sin(angle))) + sigma * rng.normal(size=(n, 2))
    points = in_space(points)
    line = ring(radius)
    feet = project(points, [line], 8 * sigma)
    (across,) = samples_across(points, [line], feet, np.array([sigma]), True)
    return across
