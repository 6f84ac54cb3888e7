"""Who takes part, and how each is set."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["CONTESTANTS", "Contestant", "named"]


@dataclass(frozen=True, slots=True)
class Contestant:
    """A program that makes curves of points.

    Attributes
    ----------
    name : str
        As the worker knows it.
    title : str
        As the page shows it.
    own : bool
        Whether it is Tapeline's: nothing is told, chosen or smoothed.
    packages : tuple of str
        Whose versions are shown.
    licence, about : str
    rule : (int, int)
        One setting and one reading of its answer, told without the truth's help: numbers among the
        settings and among :func:`benchmarks.peers.choice.readings_of`.
    rule_about : str
    color, marker : str
        Of its line in the pictures.
    """

    name: str
    title: str
    own: bool
    packages: tuple[str, ...]
    licence: str
    about: str
    rule: tuple[int, int]
    rule_about: str
    color: str
    marker: str


CONTESTANTS = (
    Contestant("auto", "Tapeline auto", True, (), "Apache-2.0", "", (0, 0), "no parameters", "#c8102e", "o"),
    Contestant("pca", "Tapeline pca", True, (), "Apache-2.0", "", (0, 0), "no parameters", "#e88a5a", "s"),
    Contestant(
        "skeleton", "Tapeline skeleton", True, (), "Apache-2.0", "", (0, 0), "no parameters", "#8c1c4b", "D"
    ),
    Contestant(
        "skeletonize",
        "scikit-image + skan",
        False,
        ("scikit-image", "skan"),
        "BSD-3-Clause",
        "The samples are drawn as an image, pixels of 0.5 or 1 σ; filled by closing with a disk of 2 "
        "σ, 4 σ or half of the largest gap to be expected, or by a Gaussian blur of 1 σ, 2 σ or a "
        "third of that gap and a threshold of 15 or 35 % of the crest that a straight curve would "
        "have; holes up to three radii across are filled; then `skeletonize`, and `skan.Skeleton` "
        "reads the graph. 12 settings.",
        (11, 6),
        "blur of a third of the largest gap, at least 1.5 σ, level 35 %; limit 10 σ, spline 0.3 σ",
        "#1f4e79",
        "^",
    ),
    Contestant(
        "cgal",
        "CGAL transport",
        False,
        (),
        "GPL-3.0",
        "`Optimal_transportation_reconstruction_2` by a program of thirty lines, for no Python "
        "package has it; `run_under_wasserstein_tolerance` with 1.4, 2, 2.8 and 4 σ. Up to 500 "
        "samples with the exhaustive queue, beyond that with 15 random choices, and with 3000 of the "
        "samples. 4 settings.",
        (2, 6),
        "tolerance 2.8 σ; limit 10 σ, spline 0.3 σ",
        "#2e8b57",
        "v",
    ),
    Contestant(
        "elpigraph",
        "elpigraph †",
        False,
        ("elpigraph-python",),
        "GPL-3.0",
        "Told the number of curves, which of them are closed, and which samples belong to which: "
        "`computeElasticPrincipalCircle` for closed curves, `computeElasticPrincipalCurve` for open "
        "ones, with 50 nodes and λ and μ at their defaults, a tenth and a hundredth of these, and with "
        "30 nodes and a tenth; at most 3000 samples a curve. 4 settings.",
        (2, 1),
        "50 nodes, λ = 0.001, μ = 0.01, spline 0.1 σ",
        "#6a5acd",
        "P",
    ),
    Contestant(
        "pcurvepy2",
        "pcurvepy2 †",
        False,
        ("pcurvepy2",),
        "MIT",
        "The princurve of R in Python. Told the same as elpigraph; it fits open curves only, so what "
        "is told to be closed is closed by an edge. From its own start, and from a polygon with 24 "
        "vertices on the true curve; 20 iterations; the splines' sum of squares s is 0.4 n σ², from "
        "the polygon 0.2 and 0.7 n σ² too (half of the noise is along the curve); at most 3000 "
        "samples a curve. 4 settings.",
        (0, 0),
        "own start, s = 0.4 n σ²",
        "#b8860b",
        "X",
    ),
    Contestant(
        "prinpy",
        "prinpy †",
        False,
        ("prinpy",),
        "MIT",
        "Constrained local principal curves. Told the same as elpigraph, and closed likewise. "
        "`GreedyFit` with its default inner radius and 0.5, and `SVDFit`, with tolerances of 2, 4, 8 "
        "and 16 σ, the samples as they come or sorted along the principal axis; at most 3000 samples "
        "a curve. 24 settings.",
        (18, 0),
        "SVD, tolerance 4 σ",
        "#708090",
        "*",
    ),
)


def named(name: str) -> Contestant:
    """Return the contestant of a name."""
    return next(one for one in CONTESTANTS if one.name == name)
