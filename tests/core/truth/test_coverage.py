import numpy as np
import pytest

from core.truth import point_set
from core.truth.coverage import coverage


def ring(radius, count=400):
    angle = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
    return radius * np.column_stack((np.cos(angle), np.sin(angle)))


def test_distances_and_errors_are_those_at_the_foot():
    truth, line = point_set("circle", n=10), ring(1.1)
    error = 0.1 + 0.02 * line[:, 0]
    seen = coverage([(line, True, error)], truth)
    np.testing.assert_allclose(seen.distance, 0.1, atol=1e-4)
    np.testing.assert_allclose(seen.error, 0.1 + 0.022 * seen.place[:, 0], atol=2e-4)


@pytest.mark.parametrize(("factor", "share"), [(2.0, 0.5), (0.5, 0.0), (20.0, 1.0)])
def test_the_share_is_that_of_the_length(factor, share):
    line = ring(1.1)
    error = np.where(line[:, 1] > 0.0, 0.06, 0.02)
    seen = coverage([(line, True, error)], point_set("circle", n=10))
    assert seen.share(factor) == pytest.approx(share, abs=0.01)


def test_what_lies_beyond_an_open_end_is_left_out():
    line = ring(1.0)[:200]
    seen = coverage([(line, False, np.full(200, 0.01))], point_set("circle", n=10))
    assert len(seen.distance) == pytest.approx(1024, abs=15)
    assert seen.share() == 1.0


def test_where_nothing_is_known_nothing_is_said():
    line = ring(1.05)
    error = np.where(line[:, 0] > 0.0, np.nan, 0.1)
    truth = point_set("circle", n=10)
    seen = coverage([(line, True, error)], truth)
    assert seen.place[:, 0].max() < 0.02
    assert seen.share() == 1.0
    assert np.isnan(coverage([(line, True, np.full(400, np.nan))], truth).share())


def test_two_curves_are_told_apart():
    truth = point_set("two_circles", n=10)
    bands = [
        (one.vertices, one.closed, np.full(len(one.vertices), 0.01 * (k + 1)))
        for k, one in enumerate(truth.curves)
    ]
    seen = coverage(bands, truth)
    assert np.mean(seen.error < 0.015) == pytest.approx(
        truth.curves[0].length / sum(c.length for c in truth.curves), abs=0.01
    )


def test_coarse_chords_do_not_hide_the_foot():
    truth = point_set("circle", n=10)
    fine, coarse = ring(1.0, 3000), ring(1.0, 7)
    (one, other) = (coverage([(line, True, np.ones(len(line)))], truth).distance for line in (fine, coarse))
    assert one.max() < 1e-5
    assert other.max() == pytest.approx(1.0 - np.cos(np.pi / 7), rel=0.01)
