import numpy as np
import pytest

from core.cloud.sampling import Sample
from core.march.prune import prune_fragments, without_blobs, without_overlaps
from tests.core.march.walks import fragment
from tests.core.shapes import arc, in_space, line

SIGMA = 0.01


def bow(start, end, radius=1.0):
    """Points of an arc about the origin, between two angles."""
    angle = np.linspace(start, end, max(3, round(abs(end - start) / 0.1)))
    return radius * np.column_stack((np.cos(angle), np.sin(angle)))


def ring_of(radius=1.0):
    return fragment(bow(0.0, 2 * np.pi - 0.1, radius), closed=True)


def test_the_only_fragment_stays():
    sample = Sample.of(in_space(arc(2000, SIGMA)))
    one = ring_of()
    assert prune_fragments(sample, [one], SIGMA) == [one]


@pytest.mark.parametrize("first", [True, False])
def test_a_march_over_a_stretch_already_marched_is_dropped(first):
    sample = Sample.of(in_space(arc(2000, SIGMA)))
    whole, again = ring_of(), fragment(bow(1.0, 2.0, 1.01))
    given = [again, whole] if first else [whole, again]
    assert prune_fragments(sample, given, SIGMA) == [whole]


def test_of_twins_one_stays():
    sample = Sample.of(in_space(arc(2000, SIGMA)))
    assert len(prune_fragments(sample, [ring_of(), ring_of(1.002)], SIGMA)) == 1


def test_halves_and_neighbours_stay():
    sample = Sample.of(in_space(np.concatenate((arc(2000, SIGMA), arc(3000, SIGMA, 1.5)))))
    kept = [fragment(bow(0.0, 3.2)), fragment(bow(3.2, 6.2)), ring_of(1.5)]
    assert prune_fragments(sample, kept, SIGMA) == kept


def test_a_fragment_through_nothing_is_dropped():
    sample = Sample.of(in_space(arc(2000, SIGMA)))
    stray = fragment(np.column_stack((np.linspace(-0.5, 0.5, 20), np.zeros(20))))
    whole = ring_of()
    assert prune_fragments(sample, [stray, whole], SIGMA) == [whole]


def test_crossing_fragments_both_stay():
    sticks = line(1000, SIGMA, 2.0), line(1000, SIGMA, 2.0, seed=1)[:, ::-1]
    sample = Sample.of(in_space(np.concatenate(sticks)))
    along = np.column_stack((np.linspace(-1, 1, 20), np.zeros(20)))
    both = [fragment(along), fragment(along[:, ::-1])]
    assert prune_fragments(sample, both, SIGMA) == both


def test_fragments_end_to_end_keep_their_nodes():
    both = [fragment(bow(0.0, 1.5)), fragment(bow(1.7, 3.0))]
    for before, after in zip(both, without_overlaps(both), strict=True):
        np.testing.assert_array_equal(before.nodes, after.nodes)


@pytest.mark.parametrize("reverse", [True, False])
def test_an_end_that_runs_along_another_is_shortened(reverse):
    second = bow(1.4, 3.0)
    both = [fragment(bow(0.0, 1.8)), fragment(second[::-1] if reverse else second)]
    short = without_overlaps(both)
    assert sum(len(f.nodes) for f in short) < sum(len(f.nodes) for f in both)
    # Together they still reach from end to end, with hardly any stretch covered twice.
    angles = [np.arctan2(f.centres[:, 1], f.centres[:, 0]) for f in short]
    assert min(a.min() for a in angles) == pytest.approx(0.0, abs=1e-9)
    assert max(a.max() for a in angles) == pytest.approx(3.0, abs=1e-9)
    assert min(a.max() for a in angles) - max(a.min() for a in angles) < 0.2


def test_a_march_that_ran_past_its_start_is_shortened():
    (short,) = without_overlaps([fragment(bow(0.0, 2 * np.pi + 0.6))])
    turn = np.unwrap(np.arctan2(short.centres[:, 1], short.centres[:, 0]))
    assert 2 * np.pi - 0.4 < turn[-1] - turn[0] < 2 * np.pi + 0.2


def test_a_crossing_is_no_overlap():
    along = np.column_stack((np.linspace(-1, 1, 20), np.zeros(20)))
    both = [fragment(along), fragment(along[:11, ::-1])]
    assert [len(f.nodes) for f in without_overlaps(both)] == [20, 11]


def test_parallel_stretches_are_no_overlap():
    both = [fragment(bow(0.0, 2.0, 1.0)), fragment(bow(0.0, 2.0, 1.2))]
    assert [len(f.nodes) for f in without_overlaps(both)] == [len(f.nodes) for f in both]


def clump(place, count=40, width=3 * SIGMA, seed=0):
    return np.asarray(place) + width * np.random.default_rng(seed).normal(size=(count, 2))


def through(place, length=6 * SIGMA):
    return fragment(np.asarray(place) + np.column_stack((np.linspace(-0.5, 0.5, 5) * length, np.zeros(5))))


@pytest.mark.parametrize("place", [(0.0, 0.0), (1.0 + 12 * SIGMA, 0.0)], ids=["far", "near"])
def test_a_fragment_through_a_clump_of_outliers_is_dropped(place):
    sample = Sample.of(in_space(np.concatenate((arc(2000, SIGMA), clump(place)))))
    whole = ring_of()
    assert without_blobs(sample, [whole, through(place)], SIGMA, True) == [whole]


def test_a_small_ring_beside_a_large_one_stays():
    small = arc(80, SIGMA, 5 * SIGMA)
    sample = Sample.of(in_space(np.concatenate((arc(2000, SIGMA), small))))
    both = [ring_of(), fragment(bow(0.0, 6.0, 5 * SIGMA), closed=True)]
    assert without_blobs(sample, both, SIGMA, True) == both


def test_clumps_alone_stay():
    sample = Sample.of(in_space(clump((0.0, 0.0))))
    only = [through((0.0, 0.0))]
    assert without_blobs(sample, only, SIGMA, True) == only


def test_a_net_of_short_pieces_keeps_them():
    pieces = [fragment(bow(a, a + 0.13)) for a in np.arange(0.0, 6.2, 0.15)]
    sample = Sample.of(in_space(arc(2000, SIGMA)))
    assert without_blobs(sample, pieces, SIGMA, True) == pieces
