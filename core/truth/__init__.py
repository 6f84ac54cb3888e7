"""Built-in point sets with exact truth, metrics against it, and the oracle's floor."""

from core.truth.families import Family
from core.truth.metrics import Score, score
from core.truth.oracle import oracle_rms
from core.truth.point_sets import PointSet, TrueCurve, describe, family, held_out_names, names, point_set
from core.truth.readings import Reading, Readings, readings

__all__ = [
    "Family",
    "PointSet",
    "Reading",
    "Readings",
    "Score",
    "TrueCurve",
    "describe",
    "family",
    "held_out_names",
    "names",
    "oracle_rms",
    "point_set",
    "readings",
    "score",
]
