"""From range images to one closed surface (§5.1.1).

The methods are in :mod:`core.surface.methods`. Importing this package imports none of what they need:
parameters and results are for whoever only passes them on.
"""

from core.surface.parameters import ContourParameters, SliceParameters, SurfaceParameters
from core.surface.results import Contours, Mesh, Pose, RangeImage, Scans, Slice, Slices, Surface

__all__ = [
    "ContourParameters",
    "Contours",
    "Mesh",
    "Pose",
    "RangeImage",
    "Scans",
    "Slice",
    "SliceParameters",
    "Slices",
    "Surface",
    "SurfaceParameters",
]
