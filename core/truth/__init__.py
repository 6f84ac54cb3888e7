"""Built-in point sets with exact truth, metrics against it, and the oracle's floor."""

from core.truth.families import Family
from core.truth.metrics import Score, score
from core.truth.oracle import oracle_rms
from core.truth.point_sets import PointSet, TrueCurve, describe, family, held_out_names, names, point_set

__all__ = [
    "Family",
    "PointSet",
    "Score",
    "TrueCurve",
    "describe",
    "family",
    "held_out_names",
    "names",
    "oracle_rms",
    "point_set",
    "score",
]
