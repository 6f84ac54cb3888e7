"""Noisy slices of solids whose contours are known, for the tests of contours."""

from __future__ import annotations

import numpy as np

from core.surface.axis import axis_frame
from core.surface.results import ContourLevel, Slice

RADII = np.array([30.0, 22.0, 40.0])  # of an ellipsoid
SIGMA = 0.1


def noisy(lines: list[np.ndarray], spacing: float, rng: np.random.Generator) -> np.ndarray:
    """Samples along closed lines at about this spacing, with noise across and along."""
    points = []
    for line in lines:
        ring = np.vstack((line, line[:1]))
        arc = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))))
        places = rng.uniform(0.0, arc[-1], size=int(arc[-1] / spacing))
        points.append(np.stack([np.interp(places, arc, ring[:, k]) for k in range(2)], axis=1))
    every = np.concatenate(points)
    return every + SIGMA * rng.normal(size=every.shape)


def ellipse(height: float) -> np.ndarray:
    """The contour of the ellipsoid at a height."""
    turn = np.linspace(0.0, 2 * np.pi, 400, endpoint=False)
    size = np.sqrt(max(1.0 - (height / RADII[2]) ** 2, 0.0))
    return size * RADII[:2] * np.stack((np.cos(turn), np.sin(turn)), axis=1)


def slice_of(lines: list[np.ndarray], height: float, seed: int, axis=(0.0, 0.0, 1.0), spacing=0.25) -> Slice:
    """Noisy samples of contours, in place; none without contours."""
    if not lines:
        return Slice(height, np.zeros((0, 3)))
    flat = noisy(lines, spacing, np.random.default_rng([seed, round(1000 * height) + 10**6]))
    return Slice(height, axis_frame(axis).lift(flat, height))


def without_sector(one: Slice, start: float, share: float) -> Slice:
    """A slice about the z axis that has lost a share of its turn."""
    angle = np.mod(np.arctan2(one.points[:, 1], one.points[:, 0]) - start, 2 * np.pi)
    return Slice(one.height, one.points[angle > 2 * np.pi * share])


def rms(level: ContourLevel) -> float:
    """RMS distance of a level's vertices from the ellipsoid, in its plane, to first order."""
    vertices = np.concatenate([one.vertices for one in level.curves])
    flat = vertices[:, :2]
    value = np.sum((vertices / RADII) ** 2, axis=1) - 1.0
    return float(np.sqrt(np.mean((value / np.linalg.norm(2.0 * flat / RADII[:2] ** 2, axis=1)) ** 2)))
