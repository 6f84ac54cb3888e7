"""Drop what is explained twice: whole fragments, and ends that run along other stretches."""

from __future__ import annotations

import numpy as np

from core.cloud.sampling import Sample
from core.march.fragments import Fragment
from core.march.strip import HALF_WIDTH, SIGMA
from core.march.walk import DENSITY, RADIUS
from core.refine.blobs import is_blob, is_small
from core.refine.project import project

__all__ = ["prune_fragments", "without_blobs", "without_overlaps"]

LEAST_TOLD = 0.8  # share of samples that long fragments explain before short ones count as clumps
EXCLUSIVE = 0.35  # share of a fragment's samples that no other fragment explains


def prune_fragments(sample: Sample, fragments: list[Fragment], sigma: float) -> list[Fragment]:
    """Drop fragments most of whose samples another fragment explains as well.

    Parameters
    ----------
    sample : Sample
    fragments : list of Fragment
    sigma : float
        Noise standard deviation.
    """
    reach = max(HALF_WIDTH * sigma, 1e-9)
    kept = list(fragments)
    lengths = np.array([f.length for f in kept])
    expected = lengths * [float(np.median(f.nodes[:, DENSITY])) for f in kept] * sample.thinning
    while len(kept) > 1:
        feet = project(sample.few, [f.polyline for f in kept], reach, rivals=True)
        size = len(kept)
        own = np.bincount(feet.curve[feet.curve >= 0], minlength=size)
        alone = np.bincount(feet.curve[(feet.curve >= 0) & (feet.other > reach)], minlength=size)
        share = alone / np.maximum(own, 1)
        share = np.minimum(share, alone / np.maximum(expected, 1.0))
        worst = int(np.argmin(share + 1e-6 * lengths))
        if share[worst] >= EXCLUSIVE:
            break
        del kept[worst]
        lengths, expected = np.delete(lengths, worst), np.delete(expected, worst)
    return kept


def without_blobs(sample: Sample, fragments: list[Fragment], sigma: float, flat: bool) -> list[Fragment]:
    """Drop short fragments through what is but a clump of outliers, unless no other is left.

    Parameters
    ----------
    sample : Sample
    fragments : list of Fragment
    sigma : float
        Noise standard deviation.
    flat : bool
        Whether there is one normal direction or two.
    """
    lines = [f.polyline for f in fragments]
    long = [line for line in lines if not is_small(line, sigma)]
    if not long or len(long) == len(lines):
        return fragments
    told = project(sample.few, long, max(HALF_WIDTH * sigma, 1e-9)).curve >= 0
    if np.mean(told) < LEAST_TOLD:
        return fragments
    return [
        f
        for f, line in zip(fragments, lines, strict=True)
        if not is_blob(sample.few, line, sigma, flat, [x for x in lines if x is not line])
    ]


def without_overlaps(opened: list[Fragment]) -> list[Fragment]:
    """Shorten ends that run along a stretch which another end, or their own start, covers too.

    Parameters
    ----------
    opened : list of Fragment
        Open ones.
    """
    out = list(opened)
    for k in range(len(out)):
        for last in (True, False):
            while len(out[k].nodes) > 4 and _runs_along(out, k, last):
                out[k] = Fragment(out[k].nodes[:-1] if last else out[k].nodes[1:], False)
    return out


def _runs_along(opened: list[Fragment], k: int, last: bool) -> bool:
    """Whether the end node of fragment ``k`` lies on some stretch, seen from that stretch's own fits."""
    own = opened[k].nodes if last else opened[k].nodes[::-1]
    node = own[-1]
    way = np.linalg.norm(np.diff(own[::-1, :3], axis=0), axis=1).cumsum()
    far = own[::-1][1:][way > 2.5 * node[RADIUS]]
    others = np.concatenate([far] + [f.nodes[1:-1] for j, f in enumerate(opened) if j != k])
    if not len(others):
        return False
    offset = node[:3] - others[:, :3]
    t = np.einsum("ij,ij->i", offset, others[:, 3:6])
    bow = offset - t[:, None] * others[:, 3:6] - 0.5 * t[:, None] ** 2 * others[:, 6:9]
    beside = np.linalg.norm(bow, axis=1) < 1.5 * others[:, SIGMA] + 0.05 * others[:, RADIUS]
    aligned = np.abs(others[:, 3:6] @ node[3:6]) > 0.8
    # The far end of the own course covers only what lies inward of it.
    inward = np.ones(len(others), np.bool_)
    if len(far):
        first = len(far) - 1
        inward[first] = (t[first] > 0.0) == last
    return bool(np.any(beside & aligned & inward & (np.abs(t) < 0.6 * others[:, RADIUS])))
