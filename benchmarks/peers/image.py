"""The peer scikit-image with skan: the skeleton of a picture of the samples, as a graph."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from skan import Skeleton
from skimage.morphology import disk, skeletonize

from benchmarks.peers.raster import Raster
from benchmarks.peers.told import Answer, Told

__all__ = ["run", "settings"]

Floats = NDArray[np.float64]
Image = NDArray[np.bool_]
Setting = tuple[str, float, float, float]

HOLE = 3.0  # closing radii, or blurs, across: smaller holes are no part of a shape


def settings(told: Told, n: int) -> Iterator[tuple[str, Setting]]:
    """Yield closings of an occupied picture, and thresholds of a blurred one; lengths in sigma."""
    bridge = told.largest_gap(n) / told.sigma / 2
    for pixel in (0.5, 1.0):
        for radius in (2.0, 4.0, max(bridge, 1.0)):
            yield f"pixel {pixel:g} σ, closing {radius:.1f} σ", ("close", pixel, radius, 0.0)
    for blur in (1.0, 2.0, max(bridge / 1.5, 1.5)):
        for level in (0.15, 0.35):
            yield f"pixel 0.5 σ, blur {blur:.1f} σ, level {level:.0%}", ("blur", 0.5, blur, level)


def run(points: Floats, told: Told, setting: Setting) -> Answer:
    """Draw the samples, fill, thin, and read the pixels that are left as a graph."""
    way, pixel, size, level = setting
    raster = Raster.of(points, pixel * told.sigma)
    size /= pixel
    if way == "close":
        filled = _closed(raster.counts > 0, size)
    else:
        spread = np.hypot(size * raster.pixel, told.sigma)
        crest = len(points) / told.length / (np.sqrt(2 * np.pi) * spread) * raster.pixel**2
        filled = ndimage.gaussian_filter(raster.counts, size, mode="constant") > level * crest
    skeleton = Skeleton(skeletonize(_without_holes(filled, HOLE * size)))
    paths = skeleton.paths_list()
    edges = np.concatenate([np.column_stack((path[:-1], path[1:])) for path in paths])
    return Answer(vertices=raster.points(skeleton.coordinates), edges=edges.astype(np.int64))


def _closed(image: Image, radius: float) -> Image:
    """Close an image by a disk; by distances, whose cost does not grow with the radius."""
    if radius <= 3.0:
        return np.asarray(ndimage.binary_closing(image, disk(max(1, round(radius)))))
    grown = ndimage.distance_transform_edt(~image) <= radius
    return np.asarray(ndimage.distance_transform_edt(grown) > radius)


def _without_holes(image: Image, diameter: float) -> Image:
    """Fill holes whose area is below that of a disk."""
    label, count = ndimage.label(~image)
    area = np.bincount(label.ravel(), minlength=count + 1)
    small = area < np.pi * diameter**2 / 4
    small[0] = False
    return image | small[label]
