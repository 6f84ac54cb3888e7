"""The comparison with peers, without any peer: our own side, the reading of graphs, and the page."""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.peers import page, pictures
from benchmarks.peers.choice import LIMITS, TOLERANCES, best_score, readings_of
from benchmarks.peers.contestants import CONTESTANTS, named
from benchmarks.peers.environment import LOCK, ROOT
from benchmarks.peers.graphs import branches, curves_of_graph, smoothed
from benchmarks.peers.measuring import row_of, told_of
from benchmarks.peers.process import ENDED, LATE, Process
from benchmarks.peers.raster import Raster
from benchmarks.peers.rows import Row, append, load
from benchmarks.peers.sets import FAMILIES, GROUPS, Plan, Set, group_of
from benchmarks.peers.summary import Figures, better, common
from benchmarks.peers.told import Answer
from benchmarks.peers.worker import LOADERS
from core.truth import oracle_rms, point_set
from core.truth.intersections import crossings

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Graph = tuple[Floats, Ints]

PLAN = Plan(("s_shape", "bean"), (300, 1000), 0.01, (0.005, 0.01), 1000, (1000, 10_000))


def chain(places: Floats) -> Graph:
    """A graph that is one polyline."""
    return np.asarray(places, float), np.column_stack((np.arange(len(places) - 1), np.arange(1, len(places))))


def union(*graphs: Graph) -> Graph:
    """Graphs beside each other; vertices at the same place are one."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in graphs)])
    vertices = np.concatenate([vertices for vertices, _ in graphs])
    edges = np.concatenate([edges + start for (_, edges), start in zip(graphs, starts[:-1], strict=True)])
    places, number = np.unique(np.round(vertices, 9), axis=0, return_inverse=True)
    return places, number.reshape(-1)[edges]


def segment(start: tuple[float, float], end: tuple[float, float], pieces: int = 20) -> Graph:
    return chain(np.linspace(start, end, pieces + 1))


def ring(count: int = 60) -> Graph:
    turn = 2 * np.pi * np.arange(count) / count
    places = np.column_stack((np.cos(turn), np.sin(turn)))
    return places, np.column_stack((np.arange(count), (np.arange(count) + 1) % count))


def test_a_ring_of_edges_is_one_closed_curve_through_all_vertices() -> None:
    vertices, edges = ring()
    ((line, closed),) = curves_of_graph(vertices, edges, 0.1)
    assert closed
    assert sorted(map(tuple, line)) == sorted(map(tuple, vertices))


def test_a_chain_of_edges_is_one_open_curve_whatever_the_order_of_its_edges() -> None:
    vertices, edges = segment((0, 0), (3, 1))
    shuffled = np.random.default_rng(0).permutation(edges)[:, ::-1]
    ((line, closed),) = curves_of_graph(vertices, shuffled, 0.1)
    assert not closed
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    assert steps.sum() == pytest.approx(np.hypot(3, 1))


def test_curves_go_straight_through_a_crossing() -> None:
    cross = union(segment((-1, 0), (1, 0)), segment((0, -1), (0, 1)))
    curves = curves_of_graph(*cross, 0.2)
    assert [closed for _, closed in curves] == [False, False]
    assert len(crossings(curves).locations) == 1
    assert all(np.ptp(line, axis=0).min() == pytest.approx(0.0) for line, _ in curves)


def test_a_short_bridge_between_two_forks_is_one_crossing() -> None:
    bridge = union(
        segment((-1, -1), (0, 0)),
        segment((-1, 1), (0, 0)),
        segment((0, 0), (0.1, 0), 2),
        segment((0.1, 0), (1.1, 1)),
        segment((0.1, 0), (1.1, -1)),
    )
    crossing = curves_of_graph(*bridge, 0.3)
    assert len(crossing) == 2
    assert len(crossings(crossing).locations) == 1
    assert len(branches(*bridge)) == 5


def test_short_spurs_and_specks_are_dropped_and_long_branches_stay() -> None:
    trunk, spur = segment((0, 0), (4, 0), 40), segment((1, 0), (1, 0.2), 2)
    branch, speck = segment((3, 0), (3, 1), 10), segment((2, 2), (2.1, 2), 2)
    curves = curves_of_graph(*union(trunk, spur, branch, speck), 0.3)
    lengths = sorted(float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()) for line, _ in curves)
    assert lengths == pytest.approx([1.0, 4.0])


def test_a_gap_between_loose_ends_is_bridged_up_to_the_limit() -> None:
    torn = union(segment((0, 0), (1, 0)), segment((1.2, 0), (2.2, 0)))
    assert len(curves_of_graph(*torn, 0.3)) == 1
    assert len(curves_of_graph(*torn, 0.15)) == 2


def test_a_graph_without_edges_is_no_curve() -> None:
    assert curves_of_graph(np.zeros((3, 2)), np.zeros((0, 2), np.int64), 1.0) == []


@pytest.mark.parametrize("closed", [True, False])
def test_a_smoothing_spline_comes_nearer_to_a_jagged_circle(closed: bool) -> None:
    vertices = ring(200)[0]
    jagged = vertices + np.random.default_rng(1).normal(scale=0.02, size=vertices.shape)
    ((line, still),) = smoothed([(jagged, closed)], 0.02)
    assert still == closed
    radius = np.linalg.norm(line, axis=1)
    assert np.sqrt(np.mean((radius - 1) ** 2)) < 0.5 * 0.02


def test_a_raster_counts_every_sample_and_gives_its_place_back() -> None:
    points = np.random.default_rng(2).normal(size=(500, 2)) * (3.0, 1.0) + (100.0, -7.0)
    raster = Raster.of(points, 0.25)
    assert raster.counts.sum() == len(points)
    centres = raster.points(np.argwhere(raster.counts > 0))
    nearest = np.abs(points[:, None] - centres[None]).max(axis=2).min(axis=1)
    assert nearest.max() <= 0.125 + 1e-9


def test_the_best_answer_has_the_right_topology_first_then_the_least_error() -> None:
    sample = point_set("bean", n=500, seed=3)
    true = [(one.vertices, one.closed) for one in sample.curves]
    far = [(true[0][0] + 0.5 * sample.sigma, True)]
    opened = [(true[0][0], False)]
    best = best_score([[], opened, far, true], sample)
    assert best is not None
    assert best[0] == 3
    second = best_score([[], opened, far], sample)
    assert second is not None
    assert second[0] == 2
    assert best_score([[], [(np.full((4, 2), np.nan), True)]], sample) is None


def test_an_answer_is_read_with_every_limit_and_every_smoothness() -> None:
    vertices, edges = ring()
    graph = list(readings_of(Answer(vertices=vertices, edges=edges), 0.01))
    assert len(graph) == len(LIMITS) * (1 + len(TOLERANCES))
    ready = list(readings_of(Answer(curves=[(vertices, True)]), 0.01))
    assert len(ready) == 1 + len(TOLERANCES)


def test_our_own_side_runs_in_a_process_and_is_scored() -> None:
    one = Set("bean", 400, 0.01, 5)
    sample = point_set(one.family, n=one.n, sigma=one.sigma, seed=one.seed)
    process = Process([sys.executable, "-m", "benchmarks.peers.worker", "pca"], 60.0, ROOT)
    try:
        attempts = process.ask(sample.points, sample.curve_of, told_of(sample))
    finally:
        process.stop()
    row = row_of("pca", one, sample, oracle_rms(sample), attempts)
    assert row.problem == ""
    assert row.topology
    assert row.rms == row.rule_rms
    assert row.seconds > 0
    assert row.ratio < 2.0


def test_a_contestant_that_answers_too_late_has_no_answer() -> None:
    sample = point_set("bean", n=50)
    idle = [sys.executable, "-c", "import time; time.sleep(60)"]
    attempts = Process(idle, 0.2, ROOT, starting=0.2).ask(sample.points, sample.curve_of, told_of(sample))
    row = row_of("prinpy", Set("bean", 50, 0.01, 0), sample, 1.0, attempts)
    assert row.problem == LATE
    assert not row.topology


def test_a_contestant_that_dies_has_no_answer() -> None:
    sample = point_set("bean", n=50)
    attempts = Process([sys.executable, "-c", ""], 30.0, ROOT).ask(
        sample.points, sample.curve_of, told_of(sample)
    )
    assert [(one.problem, one.answer) for one in attempts] == [(ENDED, None)]


def test_every_contestant_can_be_run_and_every_family_has_a_group() -> None:
    assert set(LOADERS) == {one.name for one in CONTESTANTS}
    assert {group_of(name) for name in FAMILIES} == set(GROUPS)
    assert all(one.about and one.rule_about and one.licence for one in CONTESTANTS if not one.own)


def test_the_peers_are_locked_with_hashes_and_no_host() -> None:
    text = LOCK.read_text()
    assert "://" not in text
    packages = re.findall(r"^([a-z0-9-]+)==.*\\$(?=\n    --hash=sha256:)", text, re.MULTILINE)
    pinned = re.findall(r"^[a-z0-9-]+==", text, re.MULTILINE)
    assert len(packages) == len(pinned)
    assert {name for one in CONTESTANTS for name in one.packages} <= set(packages)


def rows(peer_error: float) -> list[Row]:
    """Both sides on a small plan, the peer with a chosen error, and one peer that does not answer."""
    result = []
    for family in PLAN.families:
        for n, sigma in ((300, 0.01), (1000, 0.01), (1000, 0.005)):
            base = Row(
                "auto", family, n, sigma, 0, False, "", "none", 0, 0.1, True, True, True, 0.2, 0.2, 0.5, 0.2
            )
            peer = replace(base, contestant="skeletonize", rms=peer_error, rule_topology=True, rule_rms=0.4)
            silent = Row("cgal", family, n, sigma, 0, False, LATE, "t", 0, 60.0)
            result += [base, peer, silent]
    result += [replace(row, timed=True, n=n) for row in result[:3] for n in PLAN.timed]
    return result


def test_rows_outlive_the_run_and_later_ones_replace_earlier_ones(tmp_path: Path) -> None:
    file = tmp_path / "rows.jsonl"
    before, after = rows(0.3), rows(0.4)
    append(file, before)
    append(file, after)
    assert repr(load(file)) == repr(after)  # as text, for NaN is not NaN


def test_sets_without_an_answer_count_as_infinite_errors() -> None:
    silent = [row for row in rows(0.3) if row.contestant == "cgal" and not row.timed]
    got = Figures.of(silent)
    assert got.silent == got.late == got.sets == 6
    assert got.topology == 0.0
    assert np.isinf(got.ratio_all)


def test_sets_that_not_all_were_measured_on_count_for_none() -> None:
    every = rows(0.3)
    lacking = [row for row in every if row.timed or row.contestant != "cgal" or row.family != "bean"]
    kept = common(lacking)
    assert {row.family for row in kept if not row.timed} == {"s_shape"}
    assert [row for row in kept if row.timed] == [row for row in every if row.timed]
    assert len(common(every)) == len(every)


def test_the_page_says_where_a_peer_is_better_and_only_there() -> None:
    title = named("skeletonize").title
    assert better(rows(0.3), PLAN, "auto") == []
    found = better(rows(0.1), PLAN, "auto")
    assert len(found) == 6  # two kinds of curve, two sizes, two noises
    assert all(title in line for line in found)


def test_the_page_has_every_table_and_picture(tmp_path: Path) -> None:
    origin = page.Origin("a machine", {"skan": "1.2"}, {"numpy": "3.4"}, 1, 120.0)
    written = page.write(rows(0.3), PLAN, origin, tmp_path).read_text()
    for head in page.HEADS.values():
        assert head in written
    for name in (pictures.ERROR, pictures.SUCCESS, pictures.TIME):
        assert f"figures/{name}" in written
        assert (tmp_path / "figures" / name).stat().st_size > 0
    assert "1.50" in written  # the peer's ratio
    assert "a machine" in written


def test_the_page_in_docs_is_the_generators(tmp_path: Path) -> None:
    origin = page.Origin("a machine", {}, {}, 1, 120.0)
    fresh = page.write(rows(0.3), PLAN, origin, tmp_path).read_text()
    kept = (ROOT / "docs" / "peers.md").read_text()
    assert headings(kept) == headings(fresh)
    for head in page.HEADS.values():
        assert head in kept
    for name in FAMILIES:
        assert re.search(rf"^\| {name}\*? \|", kept, re.MULTILINE)
    assert all(one.title in kept for one in CONTESTANTS if not one.own)
    assert (ROOT / "docs" / "figures" / pictures.ERROR).exists()


def headings(text: str) -> list[str]:
    return re.findall(r"^#+ .*$", text, re.MULTILINE)
