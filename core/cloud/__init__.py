"""A point set before any method: validation, partition, frames (§3.1, §3.3, §4.1, §4.2.1).

The names below are imported when they are first used: most need compiled code, which a
process that only passes point sets on never has to load. The partition itself shares its
module's name and is imported from there: :func:`core.cloud.partition.partition`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from core.cloud.epsilon import estimate_epsilon, least_component_size
    from core.cloud.frame import Plane, is_quasi_planar, principal_frame
    from core.cloud.linkage import components
    from core.cloud.points import Normalisation, as_points, centred

__all__ = [
    "Normalisation",
    "Plane",
    "as_points",
    "centred",
    "components",
    "estimate_epsilon",
    "is_quasi_planar",
    "least_component_size",
    "principal_frame",
]

_MODULES = {
    "Normalisation": "core.cloud.points",
    "Plane": "core.cloud.frame",
    "as_points": "core.cloud.points",
    "centred": "core.cloud.points",
    "components": "core.cloud.linkage",
    "estimate_epsilon": "core.cloud.epsilon",
    "is_quasi_planar": "core.cloud.frame",
    "least_component_size": "core.cloud.epsilon",
    "principal_frame": "core.cloud.frame",
}


def __getattr__(name: str) -> object:
    if name in _MODULES:
        return getattr(import_module(_MODULES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
