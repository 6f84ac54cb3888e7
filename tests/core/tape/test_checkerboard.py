import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from core.tape.arrangement import arrange
from core.tape.checkerboard import black_sectors
from tests.core.tape.drawings import circle, eight, odd, ribbon, scribble, segment


def sectors(arrangement):
    """Each arm with a place in the sector counter-clockwise of it, and the angle of that sector."""
    for node in arrangement.nodes:
        ways = []
        for arm in node.arms:
            v = arrangement.arcs[arm // 2].vertices
            step = (v[1] - v[0] if arm % 2 == 0 else v[-2] - v[-1])[:2]
            ways.append((np.arctan2(step[1], step[0]), np.linalg.norm(step)))
        for k, arm in enumerate(node.arms):
            (a, near), (b, far) = ways[k], ways[(k + 1) % len(ways)]
            angle = (b - a) % (2.0 * np.pi)
            middle = a + 0.5 * angle
            reach = 1e-3 * min(near, far)
            yield arm, node.place[:2] + reach * np.array((np.cos(middle), np.sin(middle))), angle


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 3))
def test_black_is_where_a_ray_crosses_closed_curves_an_odd_number_of_times(seed, count):
    rng = np.random.default_rng(seed)
    curves = [scribble(rng) for _ in range(count)]
    arrangement = arrange(curves)
    if not arrangement.arcs:
        return
    black = black_sectors(arrangement)
    # Parts that do not meet are coloured each for itself.
    parts = [{arc.curve for arc, k in zip(arrangement.arcs, arrangement.connected, strict=True) if k == n}
             for n in range(arrangement.connected.max() + 1)]  # fmt: skip
    for arm, place, angle in sectors(arrangement):
        if angle > 0.01:
            own = parts[arrangement.connected[arm // 2]]
            assert black[arm] == odd([curves[k] for k in own], place)


def test_a_part_within_another_is_white_outside():
    curves = [eight(), circle(0.0, 0.0, 3.0), circle(3.0, 0.0, 1.0)]
    arrangement = arrange(curves)
    black = black_sectors(arrangement)
    for arm, place, _ in sectors(arrangement):
        if arrangement.arcs[arm // 2].curve == 0:
            assert black[arm] == odd(curves[:1], place)


def test_the_loop_of_an_open_curve_is_black_and_its_arms_have_no_say():
    arrangement = arrange([ribbon()])
    (node,) = arrangement.nodes
    assert np.count_nonzero(black_sectors(arrangement)[list(node.arms)]) == 1


def test_an_open_curve_at_odds_with_a_closed_one_gives_in():
    curves = [circle(), segment((-2.0, 0.1), (2.0, 0.2))]
    arrangement = arrange(curves)
    black = black_sectors(arrangement)
    for arm, place, _ in sectors(arrangement):
        assert black[arm] == odd(curves[:1], place)
