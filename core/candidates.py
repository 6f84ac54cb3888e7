"""What each method makes of one component: curves after the common refinement.

A march (§4.2), a tape with its skeleton (§4.3 - 4.5), or, where samples are too sparse for either,
each sample joined to its neighbours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from core.march.chain import chain_neighbours
from core.march.fragments import Pace
from core.march.solve import Marched, solve_march
from core.parameters import PcaParameters, SkeletonParameters
from core.prepared import Prepared
from core.progress import Progress, tell
from core.refine.blobs import is_blob
from core.refine.hairpins import hairpins, without
from core.refine.polyline import Polyline
from core.refine.principal_curve import CUT, SEEN, Refined, as_they_are, refine_curves
from core.refine.project import project
from core.solved import Solved
from core.tape.readings import Reading, read_crossings
from core.tape.small_triangles import Smallness
from core.tape.solve import Choices, Taped, solve_tape

__all__ = ["Candidate", "Clump", "by_march", "by_neighbours", "by_tape", "crossings_read", "hairpins_cut"]

Floats = NDArray[np.float64]

LEAST_EXPLAINED = 0.9  # share of samples on the found curves, below which neighbours are linked instead
CUTS = {"auto": CUT, "keep": 5.0, "reject": 3.0}  # in sigma
FEW_CUTS = 4
AROUND = 2.0  # in sigma: how far a clump reaches beyond the curve through it
BEGUN = 0.5  # fraction of a method's work after which its curves are there, and to be refined
TOUCHING = 4.0  # in sigma: a curve that ends this near another ends on it


@dataclass(frozen=True, slots=True, eq=False)
class Clump:
    """A clump of outliers: its samples lie within ``radius`` of ``centre`` (3,)."""

    centre: Floats
    radius: float


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """Curves of one component, and how they were found; neither march nor tape for linked neighbours.

    Attributes
    ----------
    refined : Refined
    march : Marched or None
    tape : Taped or None
    clumps : tuple of Clump
        Clumps of outliers that curves were drawn through, and left out.
    """

    refined: Refined
    march: Marched | None = None
    tape: Taped | None = None
    clumps: tuple[Clump, ...] = ()

    @property
    def explained(self) -> float:
        """Share of the samples that lie on the curves."""
        return float(np.mean(self.refined.feet.curve >= 0))

    @property
    def leaves_too_many(self) -> bool:
        """Whether too few samples lie on the curves."""
        return self.explained < LEAST_EXPLAINED

    def solved(self, one: Prepared) -> Solved:
        """Put it together with its component for the report."""
        return Solved(
            component=one.component,
            members=one.members,
            points=one.sample.points,
            frame=one.frame,
            refined=self.refined,
            outliers=one.parameters.outliers,
            bent=None if one.quasi_planar else "projected" if one.frame.flat else "marched in 3D",
            scale=one.scale,
            march=self.march,
            tape=self.tape,
        )


def by_march(
    one: Prepared,
    parameters: PcaParameters,
    factors: Sequence[float] | None = None,
    progress: Progress | None = None,
) -> Candidate | None:
    """Curves by the PCA march (§4.2); None where nothing lines up.

    Parameters
    ----------
    one : Prepared
    parameters : PcaParameters
    factors : sequence of float, optional
        On the local radius, all of which are tried.
    progress : Progress, optional
    """
    if one.scale is None:
        return None
    pace = Pace(
        one.scale,
        one.extent,
        one.frame.flat,
        radius=(parameters.radius or 0.0) / one.frame.scale,
        step=(parameters.step or 0.0) / one.frame.scale,
        max_uses=parameters.max_uses or 0,
        estimator=parameters.estimator,
        seed=parameters.seed,
    )
    tell(progress, 0.0, "marching")
    marched = solve_march(one.once, pace, factors)
    tell(progress, BEGUN, "refining the march")
    refined, clumps = _refined(one, marched.curves, one.scale.sigma)
    return None if refined is None else Candidate(refined, march=marched, clumps=clumps)


def by_tape(
    one: Prepared,
    parameters: SkeletonParameters,
    levels: Sequence[float] | None = None,
    progress: Progress | None = None,
) -> Candidate | None:
    """Curves by the tape polygon and its skeleton (§4.3 - 4.5), straight through crossings.

    None where no tape has a skeleton, or its curves stray.

    Parameters
    ----------
    one : Prepared
        In its best plane.
    parameters : SkeletonParameters
    levels : sequence of float, optional
        Factors on the tape's scale, all of which are tried.
    progress : Progress, optional
    """
    if one.scale is None:
        return None
    choices = Choices(
        Smallness(parameters.f_d, parameters.f_a, parameters.f_l),
        parameters.resample / one.frame.scale if parameters.resample else None,
        parameters.prune,
    )
    tell(progress, 0.0, "building the tape")
    taped = solve_tape(one.once, one.scale, one.extent, choices, levels)
    if taped is None:
        return None
    tell(progress, BEGUN, "refining the skeleton")
    refined, clumps = _refined(one, taped.curves, taped.sigma)
    return None if refined is None else Candidate(refined, tape=taped, clumps=clumps)


def by_neighbours(one: Prepared) -> Candidate | None:
    """Each sample joined to its neighbours, where sparse samples form chains; None where they do not.

    Parameters
    ----------
    one : Prepared
    """
    chain = chain_neighbours(one.sample.points)
    return None if chain is None else Candidate(_as_they_are(one, chain, 0.0))


def hairpins_cut(one: Prepared, candidate: Candidate) -> list[Candidate]:
    """Try without the hairpins: ends of neighbouring branches may have been joined round the corner.

    Parameters
    ----------
    one : Prepared
    candidate : Candidate

    Returns
    -------
    list of Candidate
        All hairpins cut, and each alone where there are a few.
    """
    refined = candidate.refined
    lines, sigma = refined.curves, refined.sigma
    cuts = [(k, place) for k, line in enumerate(lines) for place in hairpins(line, sigma)]
    if not cuts or not sigma > 0.0:
        return []
    choices = [cuts] if len(cuts) == 1 or len(cuts) > FEW_CUTS else [cuts, *([cut] for cut in cuts)]
    out = []
    for chosen in choices:
        pieces = [
            piece
            for k, line in enumerate(lines)
            for piece in without(line, [place for n, place in chosen if n == k], sigma)
        ]
        cut, clumps = _refined(one, pieces, sigma)
        if cut is not None:
            out.append(replace(candidate, refined=cut, clumps=(*candidate.clumps, *clumps)))
    return out


def crossings_read(one: Prepared, candidate: Candidate, crossings: Reading) -> Candidate:
    """Read the crossings of curves that go straight through them in another way (§5.2).

    Parameters
    ----------
    one : Prepared
    candidate : Candidate
    crossings : {"through", "split", "waist", "graph"}
    """
    if crossings == "through":
        return candidate
    refined = candidate.refined
    read = read_crossings(refined.curves, crossings, refined.sigma, TOUCHING * refined.sigma)
    kept = _as_they_are(one, read, refined.sigma)  # with the wished spacing of vertices
    errors = tuple(_errors_on(line, refined) for line in kept.curves)
    return replace(candidate, refined=replace(kept, sigma=refined.sigma, errors=errors))


def _errors_on(line: Polyline, refined: Refined) -> Floats:
    """Standard errors at the vertices of a curve that was made of pieces of refined ones."""
    feet = project(line.vertices, refined.curves, float(np.ptp(line.vertices, axis=0).max()) + 1e-9)
    errors = np.full(len(line.vertices), np.nan)
    for k, (whole, known) in enumerate(zip(refined.curves, refined.errors, strict=True)):
        near = feet.curve == k
        around = np.append(known, known[0]) if whole.closed else known
        errors[near] = np.interp(feet.station[near], whole.stations, around)
    return errors


def _refined(
    one: Prepared, curves: Sequence[Polyline], sigma: float
) -> tuple[Refined | None, tuple[Clump, ...]]:
    """The common refinement, without clumps of outliers; None where the curves stray from their samples."""
    if not curves:
        return None, ()
    refined = _settled(one, curves, sigma)
    courses = _without_clumps(one, refined)
    clumps = tuple(_clump(line, refined.sigma) for line in refined.curves if line not in courses)
    if clumps:
        refined = _settled(one, courses, sigma)
    if not _strays(refined, one.sample.points):
        return refined, clumps
    rough = _as_they_are(one, curves, sigma)  # a blob without a course: no fit holds
    return None if _strays(rough, one.sample.points) else rough, ()


def _settled(one: Prepared, curves: Sequence[Polyline], sigma: float) -> Refined:
    cut = CUTS[one.parameters.outliers]
    settle = refine_curves if one.parameters.refine else as_they_are
    refined = settle(one.fitted, curves, sigma, one.frame.flat, cut, one.spacing)
    if one.fitted.points is one.sample.points:
        return refined
    largest = max(noise.largest for noise in refined.noises) if refined.noises else refined.sigmas.max()
    reach = max(float(largest) * max(cut, SEEN), 1e-9)
    return replace(refined, feet=project(one.sample.points, refined.curves, reach))


def _without_clumps(one: Prepared, refined: Refined) -> list[Polyline]:
    """Leave out curves through clumps of outliers beside the others, unless all are such."""
    lines = list(refined.curves)
    flat, sigma = one.frame.flat, refined.sigma
    if len(lines) < 2 or not sigma > 0.0:
        return lines
    courses = [
        line
        for line in lines
        if not is_blob(one.sample.few, line, sigma, flat, [other for other in lines if other is not line])
    ]
    return courses or lines


def _clump(line: Polyline, sigma: float) -> Clump:
    """Where the samples of a curve through a clump lie."""
    centre = line.vertices.mean(axis=0)
    radius = float(np.linalg.norm(line.vertices - centre, axis=1).max())
    return Clump(centre, radius + AROUND * sigma)


def _as_they_are(one: Prepared, curves: Sequence[Polyline], sigma: float) -> Refined:
    cut = CUTS[one.parameters.outliers]
    return as_they_are(one.sample, curves, sigma, one.frame.flat, cut, one.spacing)


def _strays(refined: Refined, points: Floats) -> bool:
    """Whether a curve leaves the box of its points by more than a quarter of the box."""
    low, high = points.min(axis=0), points.max(axis=0)
    room = 0.25 * float(np.max(high - low))
    return any(np.any((c.vertices < low - room) | (c.vertices > high + room)) for c in refined.curves)
