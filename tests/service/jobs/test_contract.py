"""What clients are told of jobs."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from datetime import datetime
from functools import partial
from pathlib import Path

import httpx
import numpy as np
import pytest
from conftest import Serve
from expect import is_problem

from jobs.client import ASYNC, begun, body, changes, ended, gone, info, order, ordered, until
from service.answers import StatusInfo
from service.render import FORMS

NO_SUCH_JOB = "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/no-such-job"


@pytest.fixture(scope="module")
def directory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("contract")


@pytest.fixture(scope="module")
def client(serve: Serve, directory: Path) -> Iterator[httpx.Client]:
    settings = {"workers": 1, "job_workers": 2, "job_bytes": 100_000, "deadline_seconds": 30}
    with (
        serve("some", data_dir=directory, **settings) as (url, _),
        httpx.Client(base_url=url, timeout=60) as client,
    ):
        ended(client, ordered(client))  # the worker is warm
        yield client


def times(told: dict[str, str], *names: str) -> list[datetime]:
    return [datetime.fromisoformat(told[name]) for name in names]


def test_a_client_that_prefers_so_is_told_where_its_job_is(client: httpx.Client) -> None:
    answer = order(client)
    assert answer.status_code == 201
    assert answer.headers["preference-applied"] == "respond-async"
    told = StatusInfo.model_validate_json(answer.content)
    assert answer.headers["location"] == f"/jobs/{told.jobID}"
    assert (told.processID, told.status, told.progress, told.started) == ("trial", "accepted", 0, None)
    assert told.links[0].href == answer.headers["location"]


def test_a_finished_job_tells_its_times_and_leads_to_its_results(client: httpx.Client) -> None:
    told = ended(client, ordered(client))
    assert (told["status"], told["progress"]) == ("successful", 100)
    order_of_times = times(told, "created", "started", "finished", "updated")
    assert order_of_times == sorted(order_of_times)
    results = [link for link in told["links"] if link["rel"].endswith("/results")]
    assert {link["type"] for link in results} == {FORMS["json"], FORMS["csv"]}
    for link in results:
        answer = client.get(link["href"])
        assert answer.status_code == 200
        assert answer.headers["content-type"].startswith(link["type"])


def test_waiting_for_a_job_gives_its_answer_or_tells_where_it_is(client: httpx.Client) -> None:
    at_once = order(client, {})
    waited = order(client, {"prefer": "respond-async, wait=20"})
    assert (waited.status_code, waited.content) == (200, at_once.content)
    late = order(client, {"prefer": "respond-async, wait=1"}, seconds=1.5)
    assert late.status_code == 201
    assert late.headers["preference-applied"] == "respond-async, wait=1"
    assert ended(client, late.headers["location"])["status"] == "successful"


def test_what_outlasts_the_wait_goes_on_as_a_job(client: httpx.Client, tmp_path: Path) -> None:
    answer = order(client, {"prefer": "wait=1"}, seconds=1.5, sign=str(tmp_path / "sign"))
    assert answer.status_code == 201
    assert answer.headers["preference-applied"] == "wait=1"
    job = answer.headers["location"]
    assert ended(client, job)["status"] == "successful"
    assert client.get(f"{job}/results").content == order(client, {}).content


def test_a_large_body_is_a_job_whose_answer_comes_as_if_it_were_none(client: httpx.Client) -> None:
    points = np.random.default_rng(1).uniform(0, 100, (20_000, 2)).tolist()
    before = jobs(client)
    answer = client.post("/trial", json=body(points))
    assert answer.status_code == 200
    assert len(answer.json()["labels"]) == len(points)
    assert len(jobs(client)) == len(before) + 1


def jobs(client: httpx.Client) -> list[dict[str, object]]:
    found: list[dict[str, object]] = client.get("/jobs", params={"limit": 1000}).json()["jobs"]
    return found


@pytest.mark.parametrize("path", ["/reconstruct/pca", "/partition"])
def test_a_job_gives_what_the_process_itself_answers_in_every_form(client: httpx.Client, path: str) -> None:
    angle = np.linspace(0, 2 * np.pi, 120, endpoint=False)
    points = np.column_stack([np.cos(angle), 0.7 * np.sin(angle)]).tolist()
    job = client.post(path, json=body(points), headers=ASYNC).headers["location"]
    links = [link for link in ended(client, job)["links"] if link["rel"].endswith("/results")]
    assert len(links) > 3
    for link in links:
        form = link["href"].partition("format=")[2]
        directly = client.post(path, params={"format": form}, json=body(points))
        stored = client.get(f"{job}/results", headers={"accept": directly.headers["content-type"]})
        assert stored.status_code == 200
        assert stored.headers["content-type"] == directly.headers["content-type"]
        assert stored.content == directly.content
        assert client.get(link["href"]).content == directly.content


def test_the_form_asked_for_with_the_order_is_one_of_those_of_the_process(client: httpx.Client) -> None:
    is_problem(order(client, {**ASYNC, "accept": "image/png"}), 406)
    job = ordered(client)
    ended(client, job)
    is_problem(client.get(f"{job}/results", headers={"accept": "image/png"}), 406)


def test_a_job_has_no_result_before_its_end(client: httpx.Client) -> None:
    job = ordered(client, seconds=600)
    answer = client.get(f"{job}/results")
    is_problem(answer, 404, "result-not-ready")
    assert int(answer.headers["retry-after"]) >= 1
    client.delete(job)


@pytest.mark.parametrize(
    ("sent", "status", "kind"),
    [
        (body(outcome="degenerate"), 422, "degenerate-input"),
        (body(outcome="parameter"), 422, "invalid-parameter"),
        (body(outcome="memory"), 503, "out-of-memory"),
        (body([[0, 0], [1]]), 422, None),
        (body(unknown=1), 422, None),
        ({"points": "none"}, 422, None),
    ],
)
def test_a_failed_job_gives_the_problem_that_its_process_would(
    client: httpx.Client, sent: dict[str, object], status: int, kind: str | None
) -> None:
    directly = is_problem(client.post("/trial", json=sent), status, kind)
    job = client.post("/trial", json=sent, headers=ASYNC).headers["location"]
    told = ended(client, job)
    assert (told["status"], told["message"]) == ("failed", directly["detail"])
    kept = is_problem(client.get(f"{job}/results"), status, kind)
    assert {**kept, "instance": ""} == {**directly, "instance": ""}


def test_an_unreadable_body_is_a_failed_job(client: httpx.Client) -> None:
    answer = client.post(
        "/trial", content=b"{", headers={**ASYNC, "content-type": "application/json", "accept": "text/csv"}
    )
    assert ended(client, answer.headers["location"])["status"] == "failed"
    is_problem(client.get(f"{answer.headers['location']}/results"), 400)


def test_a_defect_is_told_without_its_secrets(client: httpx.Client) -> None:
    job = ordered(client, outcome="defect")
    assert "secret" not in ended(client, job)["message"]
    assert "secret" not in client.get(f"{job}/results").text


def test_dismissing_a_running_job_ends_its_process(client: httpx.Client, tmp_path: Path) -> None:
    job, process = begun(client, tmp_path, seconds=600)
    answer = client.delete(job)
    assert (answer.status_code, answer.json()["status"]) == (200, "dismissed")
    until(lambda: gone(process), 10)
    assert info(client, job)["status"] == "dismissed"
    is_problem(client.get(f"{job}/results"), 404, "job-dismissed")
    assert client.delete(job).json()["status"] == "dismissed"


def test_a_dismissed_job_is_never_begun(client: httpx.Client, tmp_path: Path) -> None:
    busy = [begun(client, tmp_path, seconds=600)[0] for _ in range(2)]
    sign = tmp_path / "sign"
    waiting = ordered(client, sign=str(sign))
    assert client.delete(waiting).json()["status"] == "dismissed"
    for job in busy:
        client.delete(job)
    ended(client, ordered(client))
    assert not sign.exists()
    assert info(client, waiting)["status"] == "dismissed"


def test_dismissing_a_finished_job_removes_it(client: httpx.Client) -> None:
    job = ordered(client)
    ended(client, job)
    answer = client.delete(job)
    assert (answer.status_code, answer.json()["status"]) == (200, "dismissed")
    for address in (job, f"{job}/results", f"{job}/events"):
        is_problem(client.get(address), 404, NO_SUCH_JOB)
    is_problem(client.delete(job), 404, NO_SUCH_JOB)


@pytest.mark.parametrize("job", ["/jobs/none", f"/jobs/{uuid.uuid4()}", "/jobs/%00"])
def test_there_is_nothing_where_no_job_is(client: httpx.Client, job: str) -> None:
    for address in (job, f"{job}/results", f"{job}/events"):
        is_problem(client.get(address), 404, NO_SUCH_JOB)
    is_problem(client.delete(job), 404, NO_SUCH_JOB)


def test_followers_see_the_work_go_on_to_its_end(client: httpx.Client) -> None:
    job = ordered(client, seconds=2.5)
    with ThreadPoolExecutor(4) as threads:
        for seen in threads.map(lambda _: list(changes(client, job)), range(4)):
            states = [told["status"] for _, told in seen]
            assert [event for event, _ in seen] == states
            assert states == sorted(states, key=["accepted", "running", "successful"].index)
            assert states[-1] == "successful"
            progress = [told["progress"] for _, told in seen]
            assert progress == sorted(progress)
            assert len({one for one in progress if 0 < one < 100}) >= 2
            assert sum("of 2.5" in told["message"] for _, told in seen) >= 2
    assert [told["status"] for _, told in changes(client, job)] == ["successful"]


def test_followers_are_told_that_a_job_is_dismissed(client: httpx.Client, tmp_path: Path) -> None:
    job, _ = begun(client, tmp_path, seconds=600)
    with ThreadPoolExecutor(1) as threads:
        seen = threads.submit(lambda: [told["status"] for _, told in changes(client, job)])
        client.delete(job)
        assert seen.result()[-1] == "dismissed"


def test_many_who_wait_at_once_all_get_their_answers(client: httpx.Client) -> None:
    with ThreadPoolExecutor(12) as threads:
        answers = threads.map(
            lambda k: order(client, {"prefer": "respond-async, wait=25"}, seconds=k / 200), range(36)
        )
        assert [answer.status_code for answer in answers] == [200] * 36


def test_the_same_key_and_body_give_the_same_job(client: httpx.Client, tmp_path: Path) -> None:
    headers = {**ASYNC, "idempotency-key": str(uuid.uuid4())}
    sign = tmp_path / "sign"
    job = ordered(client, headers, sign=str(sign))
    ended(client, job)
    sign.unlink()
    assert ordered(client, headers, sign=str(sign)) == job
    answer = order(client, {**headers, "prefer": "wait=20"}, sign=str(sign))
    assert (answer.status_code, answer.content) == (200, client.get(f"{job}/results").content)
    assert not sign.exists()


def test_a_key_sent_many_times_at_once_gives_one_job(client: httpx.Client, tmp_path: Path) -> None:
    headers = {**ASYNC, "idempotency-key": str(uuid.uuid4())}
    before = len(jobs(client))
    sign = tmp_path / "sign"
    with ThreadPoolExecutor(8) as threads:
        found = list(threads.map(lambda _: ordered(client, headers, sign=str(sign)), range(8)))
    assert len(set(found)) == 1
    assert ended(client, found[0])["status"] == "successful"
    assert len(jobs(client)) == before + 1


def test_a_key_is_good_for_one_request_only(client: httpx.Client) -> None:
    key = {"idempotency-key": str(uuid.uuid4())}
    assert order(client, {**ASYNC, **key}).status_code == 201
    is_problem(order(client, {**ASYNC, **key}, seconds=0.5), 422, "idempotency-key-reused")
    other = client.post("/partition", json=body(), headers={**ASYNC, **key})
    is_problem(other, 422, "idempotency-key-reused")
    is_problem(client.post("/trial", params={"seconds": 0}, json=body(), headers=key), 422)


def test_one_key_for_two_processes_at_once_gives_one_job(client: httpx.Client) -> None:
    for _ in range(5):
        headers = {**ASYNC, "idempotency-key": str(uuid.uuid4())}
        send = partial(client.post, json=body(), headers=headers)
        with ThreadPoolExecutor(6) as threads:
            answers = list(threads.map(send, ["/trial", "/partition"] * 3))
        assert {answer.status_code for answer in answers} == {201, 422}
        assert len({answer.headers["location"] for answer in answers if answer.status_code == 201}) == 1


@pytest.mark.parametrize("key", ["", "x" * 256])
def test_a_key_has_a_length(client: httpx.Client, key: str) -> None:
    is_problem(order(client, {"idempotency-key": key}), 422, "invalid-parameter")


def test_preferences_that_cannot_be_read_are_passed_over(client: httpx.Client) -> None:
    for preference in ("wait=-1", "wait=1e9", "wait=²", "respond-later", ";;,=", "wait=999999999"):
        assert order(client, {"prefer": preference.encode()}).status_code == 200  # type: ignore[dict-item]


def test_results_whose_files_are_lost_are_not_found(client: httpx.Client, directory: Path) -> None:
    job = ordered(client)
    ended(client, job)
    files = [file for file in (directory / "store" / job.removeprefix("/")).rglob("*") if file.is_file()]
    assert files
    for file in files:
        file.unlink()
    for form in ("json", "csv"):
        is_problem(client.get(f"{job}/results?format={form}"), 404, "not-found")
