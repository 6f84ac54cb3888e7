"""One answer without parameters: ``/reconstruct`` and ``/diagnose``, through HTTP."""

from __future__ import annotations

import io
from typing import Any

import httpx
import numpy as np
import pytest
import shapely
from expect import is_problem
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from core.methods import diagnose, reconstruct
from core.parameters import PcaParameters, SkeletonParameters
from core.truth import point_set
from service.answers import DiagnosisAnswer, ReconstructAnswer

Points = np.ndarray
PATHS = ["/reconstruct", "/diagnose"]
each_path = pytest.mark.parametrize("path", PATHS)


def reconstructed(client: httpx.Client, points: Points, **body: Any) -> ReconstructAnswer:
    response = client.post("/reconstruct", json={"points": points.tolist(), **body})
    assert response.status_code == 200, response.text
    return ReconstructAnswer.model_validate(response.json())


def diagnosed(client: httpx.Client, points: Points, **body: Any) -> DiagnosisAnswer:
    response = client.post("/diagnose", json={"points": points.tolist(), **body})
    assert response.status_code == 200, response.text
    return DiagnosisAnswer.model_validate(response.json())


@pytest.fixture(scope="module")
def eight() -> Points:
    return point_set("figure_8", n=1000).points


def doubled(distance: float, sigma: float) -> Points:
    """A circle, over a quarter of which there are two branches at a distance, with Gaussian noise."""
    rng = np.random.default_rng(0)
    angle = rng.uniform(0, 2 * np.pi, 3000)
    side = np.where(angle < np.pi / 2, rng.choice([-0.5, 0.5], 3000), 0.0)
    radius = 1 + distance * side
    places = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    return places + rng.normal(0, sigma, places.shape)


# --- the answer to points alone ---------------------------------------------------------------------


def test_points_alone_are_enough(client: httpx.Client, eight: Points) -> None:
    answer = reconstructed(client, eight)
    assert [curve.closed for curve in answer.curves] == [True]
    assert len(answer.crossings) == 1
    truth = point_set("figure_8", n=10).curves[0].vertices
    found = np.array(answer.curves[0].vertices)
    gaps = shapely.distance(shapely.points(found), shapely.LinearRing(truth))
    assert np.sqrt(np.mean(gaps**2)) < answer.sampling.sigma / 2


def test_the_service_answers_what_the_library_does(client: httpx.Client, eight: Points) -> None:
    own, answer = reconstruct(eight), reconstructed(client, eight)
    assert (answer.method, answer.reason) == (own.method, own.reason)
    assert [curve.vertices for curve in answer.curves] == [curve.vertices.tolist() for curve in own.curves]
    told, read = diagnose(eight), diagnosed(client, eight)
    assert (read.method, read.verdict, read.curves) == (told.method, told.verdict, told.curves)


@pytest.mark.parametrize("path", [*PATHS, "/reconstruct/pca", "/reconstruct/skeleton"])
def test_the_sampling_is_told_everywhere(client: httpx.Client, eight: Points, path: str) -> None:
    sampling = client.post(path, json={"points": eight.tolist()}).json()["sampling"]
    drawn = point_set("figure_8", n=1000)
    assert sampling["sigma"] == pytest.approx(drawn.sigma, rel=0.1)
    assert sampling["density"] == pytest.approx(1000 / drawn.curves[0].length, rel=0.1)


@pytest.mark.parametrize("path", ["/reconstruct", "/reconstruct/pca", "/reconstruct/skeleton"])
@pytest.mark.parametrize("name", ["figure_8", "s_shape", "trefoil"])
def test_every_vertex_has_its_standard_error(client: httpx.Client, path: str, name: str) -> None:
    points = point_set(name, n=1200).points
    answer = client.post(path, json={"points": points.tolist()}).json()
    assert answer["curves"]
    for curve in answer["curves"]:
        errors = curve["standard_errors"]
        assert len(errors) == len(curve["vertices"])
        assert min(errors) > 0
        assert np.median(errors) < answer["sampling"]["sigma"]


def test_curves_that_were_not_fitted_have_none(client: httpx.Client, eight: Points) -> None:
    answer = reconstructed(client, eight, parameters={"refine": False})
    assert [curve.standard_errors for curve in answer.curves] == [None]


def test_the_decision_says_what_spoke_for_it(client: httpx.Client, eight: Points) -> None:
    answer = reconstructed(client, eight)
    (decision,), (other,) = answer.decisions, answer.alternatives
    assert decision.method == answer.method != other.method
    assert decision.reason == answer.reason
    assert decision.nats == 0 <= other.nats
    assert (decision.curves, decision.closed, decision.crossings) == (1, 1, 1)
    assert 0.9 < decision.explained <= 1
    assert decision.sigma == pytest.approx(answer.sampling.sigma, rel=0.2)


def test_every_component_has_its_own_decision(client: httpx.Client) -> None:
    points = point_set("disjoint", n=1600).points
    answer, told = reconstructed(client, points), diagnosed(client, points)
    assert len(answer.curves) == told.curves == 4
    assert told.closed == 2
    components = {curve.component for curve in answer.curves}
    for decisions in (answer.decisions, told.decisions):
        assert {decision.component for decision in decisions} == components
        assert sum(decision.curves for decision in decisions) == 4
    assert {one.component for one in answer.alternatives} <= components


@pytest.mark.parametrize(("name", "closed"), [("trefoil", True), ("helix", False)])
def test_curves_in_space_have_no_tape(client: httpx.Client, name: str, closed: bool) -> None:
    points = point_set(name, n=1200).points
    answer = reconstructed(client, points, include=["stages"])
    assert answer.method == "pca"
    assert [curve.closed for curve in answer.curves] == [closed]
    assert {len(vertex) for vertex in answer.curves[0].vertices} == {3}
    assert answer.tape is answer.tape_components is answer.containment is answer.graph is None
    assert not answer.alternatives


def test_the_tape_is_there_where_a_component_has_one(client: httpx.Client, eight: Points) -> None:
    answer = reconstructed(client, eight, parameters={"method": "skeleton"}, include=["stages"])
    assert answer.method == "skeleton"
    assert answer.tape is not None
    assert answer.tape_components == [0]
    assert answer.graph is not None
    assert answer.containment is not None
    assert answer.stages is not None
    assert hasattr(answer.stages, "delaunay")
    assert not answer.alternatives


# --- parameters -------------------------------------------------------------------------------------


def test_parameters_of_both_methods_can_be_given_at_once(client: httpx.Client, eight: Points) -> None:
    radius = 0.3 * float(np.ptp(eight)) / 4
    parameters = {"radius": radius, "step": radius / 2, "crossings": "split", "f_d": 1.4, "prune": 2.5}
    answer = reconstructed(client, eight, parameters=parameters)
    assert (len(answer.curves), len(answer.crossings)) == (2, 0)
    queried = client.post(
        "/reconstruct", params=parameters, content=npy(eight), headers={"Content-Type": "application/x-npy"}
    )
    assert queried.json()["curves"] == [curve.model_dump() for curve in answer.curves]


def npy(points: Points) -> bytes:
    file = io.BytesIO()
    np.save(file, points)
    return file.getvalue()


@pytest.mark.parametrize("method", ["pca", "skeleton"])
def test_a_method_that_is_asked_for_is_the_one_that_is_run(
    client: httpx.Client, eight: Points, method: str
) -> None:
    answer = reconstructed(client, eight, parameters={"method": method})
    assert answer.method == method
    assert {one.method for one in answer.decisions} == {method}
    assert diagnosed(client, eight, parameters={"method": method}).method == method


@each_path
def test_every_parameter_of_both_methods_is_known(client: httpx.Client, path: str) -> None:
    for model in (PcaParameters, SkeletonParameters):
        for name, field in model.model_fields.items():
            body = {"points": [[0.0, 0.0]], "parameters": {name: field.default}}
            is_problem(client.post(path, json=body), 422, "degenerate-input")


@each_path
def test_parameters_that_are_unknown_or_wrong_are_refused_where_they_are(
    client: httpx.Client, path: str
) -> None:
    wrong: dict[str, object] = {"method": "tape", "depth": 1, "crossings": "loop", "radius": 0, "f_d": "1"}
    body = {"points": [[0.0, 0.0]] * 9, "parameters": wrong}
    errors = is_problem(client.post(path, json=body), 422, "invalid-parameter")["errors"]
    assert {tuple(item["loc"]) for item in errors} == {("body", "parameters", name) for name in wrong}


def test_a_diagnosis_has_nothing_to_include(client: httpx.Client, eight: Points) -> None:
    response = client.post("/diagnose", json={"points": eight.tolist(), "include": ["stages"]})
    assert is_problem(response, 422)["errors"][0]["loc"][:2] == ["body", "include"]


@each_path
@pytest.mark.parametrize(
    "points",
    [[[0.0, 0.0]], [[3.0, 3.0]] * 40, [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]],
    ids=["one", "same", "three"],
)
def test_points_that_determine_no_curve_are_refused(
    client: httpx.Client, path: str, points: list[list[float]]
) -> None:
    response = client.post(path, json={"points": points})
    assert is_problem(response, 422, "degenerate-input")["errors"][0]["loc"] == ["body", "points"]


# --- diagnosis --------------------------------------------------------------------------------------


def test_near_branches_are_told_with_their_place_and_advice(client: httpx.Client) -> None:
    points = doubled(0.06, 0.02)
    for answer in (diagnosed(client, points), reconstructed(client, points)):
        nyquist = answer.sampling.nyquist
        assert not nyquist.compliant
        assert nyquist.violations
        for violation in nyquist.violations:
            assert violation.kind in {"branches-too-near", "branches-hidden"}
            assert violation.gap_sigmas == pytest.approx(3, abs=1)
            assert violation.reason
            assert violation.advice
            x, y = violation.location
            assert np.hypot(x, y) == pytest.approx(1, abs=0.06)
            assert -0.1 < np.arctan2(y, x) < np.pi / 2 + 0.1
    assert "not good enough" in diagnosed(client, points).verdict


def test_one_branch_is_good_enough(client: httpx.Client) -> None:
    answer = diagnosed(client, doubled(0, 0.02))
    assert answer.sampling.nyquist.compliant
    assert answer.sampling.nyquist.violations == []
    assert (answer.curves, answer.closed) == (1, 1)
    assert answer.sampling.sigma == pytest.approx(0.02, rel=0.05)
    assert answer.sampling.sigma_error is not None
    assert abs(answer.sampling.sigma - 0.02) < 4 * answer.sampling.sigma_error


def test_a_gap_that_chance_does_not_leave_is_told(client: httpx.Client) -> None:
    points = doubled(0, 0.02)
    cut = points[np.abs(np.arctan2(points[:, 1], points[:, 0]) - 1) > 0.06]
    whole, answer = (diagnosed(client, one).sampling.largest_gap for one in (points, cut))
    assert whole is not None
    assert answer is not None
    assert whole.spacings < whole.expected
    assert answer.spacings > whole.spacings
    assert answer.length == pytest.approx(0.12, abs=0.04)
    assert np.hypot(*answer.location) == pytest.approx(1, abs=0.05)


def test_a_diagnosis_can_be_read(client: httpx.Client, eight: Points) -> None:
    body = {"points": eight.tolist()}
    response = client.post("/diagnose", json=body, headers={"Accept": "text/plain"})
    assert response.headers["content-type"] == "text/plain; charset=utf-8"
    answer = diagnosed(client, eight)
    assert response.text.startswith(answer.verdict[:40])
    assert f"sigma {answer.sampling.sigma:.4g}" in response.text


# --- whatever is sent ---------------------------------------------------------------------------------

coordinates = st.one_of(
    st.integers(-3, 3).map(float),
    st.floats(-1, 1),
    st.floats(allow_nan=False, allow_infinity=False),
)
clouds = st.integers(2, 3).flatmap(
    lambda dimension: st.lists(
        st.lists(coordinates, min_size=dimension, max_size=dimension), min_size=1, max_size=40
    )
)
choices: st.SearchStrategy[dict[str, Any]] = st.fixed_dictionaries(
    {},
    optional={
        "method": st.sampled_from(["auto", "pca", "skeleton"]),
        "crossings": st.sampled_from(["through", "split", "waist", "graph"]),
        "outliers": st.sampled_from(["auto", "keep", "reject"]),
        "refine": st.booleans(),
        "planar": st.sampled_from([None, True, False]),
        "estimator": st.sampled_from(["pca", "least_squares"]),
        "epsilon": st.floats(1e-6, 1e6),
        "radius": st.floats(1e-6, 1e6),
        "step": st.floats(1e-6, 1e6),
        "max_uses": st.integers(1, 9),
        "min_component_size": st.integers(1, 50),
        "f_d": st.floats(1e-3, 100),
        "f_a": st.floats(1e-3, 1e3),
        "f_l": st.floats(1e-3, 1e3),
        "prune": st.floats(0, 100),
    },
)
FUZZ = settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def sound(client: httpx.Client, path: str, body: dict[str, Any], form: str) -> None:
    """Post; the answer is as documented, or a problem that says where."""
    response = client.post(f"{path}?format={form}", json=body)
    if response.status_code != 200:
        assert is_problem(response, 422)["errors"]
    elif form == "json":
        models = {"/reconstruct": ReconstructAnswer, "/diagnose": DiagnosisAnswer}
        models[path].model_validate(response.json())


@FUZZ
@given(points=clouds, parameters=choices)
@pytest.mark.parametrize(("path", "form"), [("/reconstruct", "json"), ("/diagnose", "json")])
def test_any_points_have_a_sound_answer_or_are_refused(
    client: httpx.Client, path: str, form: str, points: list[list[float]], parameters: dict[str, Any]
) -> None:
    sound(client, path, {"points": points, "parameters": parameters}, form)


def quantised(seed: int, step: float, name: str) -> list[list[float]]:
    points = point_set(name, n=150, seed=seed).points
    return [[round(x / step) * step for x in row] for row in points.tolist()]


@FUZZ
@given(
    seed=st.integers(0, 1000),
    step=st.sampled_from([1e-6, 0.05, 0.2]),
    name=st.sampled_from(["figure_8", "wasp_waist", "trefoil", "two_circles", "star"]),
    parameters=choices,
    target=st.sampled_from(
        [("/reconstruct", "json"), ("/reconstruct", "svg"), ("/diagnose", "json"), ("/diagnose", "svg"),
         ("/diagnose", "txt")]
    ),
)  # fmt: skip
def test_few_coarse_samples_with_any_parameters_have_a_sound_answer(
    client: httpx.Client,
    seed: int,
    step: float,
    name: str,
    parameters: dict[str, Any],
    target: tuple[str, str],
) -> None:
    path, form = target
    sound(client, path, {"points": quantised(seed, step, name), "parameters": parameters}, form)
