import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import poisson

from core.march.walk import is_empty

EXPECTED = st.floats(0.1, 1000.0)
CONFIDENCE = st.floats(1.0, 20.0)


@settings(max_examples=100, deadline=None)
@given(EXPECTED, CONFIDENCE)
def test_a_strip_as_full_as_expected_is_no_gap(expected, confidence):
    assert not is_empty(expected, expected, confidence)
    assert not is_empty(2 * expected, expected, confidence)


@settings(max_examples=100, deadline=None)
@given(EXPECTED, CONFIDENCE)
def test_without_any_sample_the_expected_number_decides(expected, confidence):
    # exp(-e) is the chance of an empty strip.
    assert is_empty(0, expected, confidence) == (expected > confidence)


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 50), EXPECTED, CONFIDENCE, st.floats(1.0, 3.0))
def test_fewer_samples_or_more_expected_make_it_emptier(count, expected, confidence, factor):
    if is_empty(count, expected, confidence):
        assert is_empty(max(count - 1, 0), expected, confidence)
        assert is_empty(count, factor * expected, confidence)
        assert is_empty(count, expected, confidence / factor)


@pytest.mark.parametrize("expected", [3.0, 10.0, 30.0, 100.0])
@pytest.mark.parametrize("confidence", [4.0, 8.0, 12.0])
def test_chance_alone_empties_hardly_any_strip(expected, confidence):
    counts = np.arange(int(expected) + 1)
    empty = np.array([is_empty(int(c), expected, confidence) for c in counts])
    chance = poisson.pmf(counts, expected)[empty].sum()
    assert chance <= np.exp(-confidence)
