"""Built-in point sets and solids with exact truth, metrics against it, and the oracle's floor."""

from core.truth.catalogue import describe, family, hard_names, held_apart_names, held_out_names, names
from core.truth.clearance import Clearance, clearance
from core.truth.conditions import PLAIN, Conditions
from core.truth.families import Family
from core.truth.metrics import Score, score
from core.truth.objects import Solid, distances, reference_mesh, solid, solid_names
from core.truth.oracle import oracle_rms
from core.truth.point_sets import PointSet, TrueCurve, point_set
from core.truth.readings import Reading, Readings, readings
from core.truth.scanner import Scanner, scan

__all__ = [
    "PLAIN",
    "Clearance",
    "Conditions",
    "Family",
    "PointSet",
    "Reading",
    "Readings",
    "Scanner",
    "Score",
    "Solid",
    "TrueCurve",
    "clearance",
    "describe",
    "distances",
    "family",
    "hard_names",
    "held_apart_names",
    "held_out_names",
    "names",
    "oracle_rms",
    "point_set",
    "readings",
    "reference_mesh",
    "scan",
    "score",
    "solid",
    "solid_names",
]
