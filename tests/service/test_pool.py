from __future__ import annotations

import os
import signal
from collections.abc import Awaitable, Callable
from pathlib import Path

import anyio
import pytest

from service.errors import DeadlineExceeded, QueueFull, TaskFailed, WorkerLost
from service.work import Pool, PoolOptions, open_pool


def in_pool(
    scenario: Callable[[Pool], Awaitable[None]],
    *,
    workers: int = 1,
    queue_length: int = 10,
    deadline: float = 20.0,
    warm_up: tuple[str, tuple[object, ...]] | None = None,
) -> None:
    """Run a scenario in a pool of real processes."""

    async def main() -> None:
        options = PoolOptions(workers, queue_length, deadline, warm_up, {"TAPELINE_TEST": "here"})
        with anyio.fail_after(60):
            async with open_pool(options) as pool:
                await scenario(pool)

    anyio.run(main)


async def until(condition: Callable[[], bool]) -> None:
    while not condition():
        await anyio.sleep(0.01)


def gone(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    return False


def test_calls_run_in_another_process_and_answer() -> None:
    async def scenario(pool: Pool) -> None:
        assert await pool.run("calls:add", 2, 3) == 5
        assert await pool.run("calls:pid") != os.getpid()

    in_pool(scenario)


def test_a_worker_is_used_again() -> None:
    async def scenario(pool: Pool) -> None:
        assert await pool.run("calls:pid") == await pool.run("calls:pid")

    in_pool(scenario)


def test_workers_have_one_thread_each_and_what_they_are_given() -> None:
    async def scenario(pool: Pool) -> None:
        for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
            assert await pool.run("calls:environment", name) == "1"
        assert await pool.run("calls:environment", "TAPELINE_TEST") == "here"

    in_pool(scenario)


@pytest.mark.parametrize("size", [0, 1, 65_536, 5_000_000])
def test_content_of_any_size_passes_both_ways(size: int) -> None:
    async def scenario(pool: Pool) -> None:
        content = os.urandom(size)
        assert await pool.run("calls:echo", content) == content

    in_pool(scenario)


def test_what_libraries_print_does_not_disturb_the_answers() -> None:
    async def scenario(pool: Pool) -> None:
        assert await pool.run("calls:chatter") == "quiet"
        assert await pool.run("calls:add", 1, 1) == 2

    in_pool(scenario)


def test_a_defect_is_reported_with_its_traceback_and_the_worker_lives_on() -> None:
    async def scenario(pool: Pool) -> None:
        before = await pool.run("calls:pid")
        with pytest.raises(TaskFailed, match="LookupError: a defect"):
            await pool.run("calls:fail")
        assert await pool.run("calls:pid") == before

    in_pool(scenario)


def test_a_call_whose_worker_dies_is_tried_once_more(tmp_path: Path) -> None:
    async def scenario(pool: Pool) -> None:
        assert await pool.run("calls:die_once", str(tmp_path / "marker")) == "survived"

    in_pool(scenario)


def test_a_call_that_kills_two_workers_is_given_up_and_others_go_on() -> None:
    async def scenario(pool: Pool) -> None:
        async def deadly() -> None:
            with pytest.raises(WorkerLost):
                await pool.run("calls:die")

        async with anyio.create_task_group() as group:
            group.start_soon(deadly)
            for _ in range(5):
                assert await pool.run("calls:add", 1, 2) == 3

    in_pool(scenario, workers=2)


def test_the_deadline_ends_the_computation_and_its_process() -> None:
    async def scenario(pool: Pool) -> None:
        process = await pool.run("calls:pid")
        with pytest.raises(DeadlineExceeded) as caught:
            await pool.run("calls:busy", 60.0)
        assert caught.value.retry_after is None  # the same again would take as long
        await until(lambda: gone(process))
        assert await pool.run("calls:add", 1, 2) == 3

    in_pool(scenario, deadline=1.5)


def test_the_deadline_counts_waiting_too() -> None:
    async def scenario(pool: Pool) -> None:
        async def waits() -> None:
            with pytest.raises(DeadlineExceeded) as caught:
                await pool.run("calls:add", 1, 2)
            assert caught.value.retry_after is not None

        async def works() -> None:
            with pytest.raises(DeadlineExceeded):
                await pool.run("calls:busy", 60.0)

        await until(lambda: pool.warm == 1)
        with anyio.CancelScope() as scope:
            async with anyio.create_task_group() as group:
                group.start_soon(works)
                await anyio.sleep(0)
                group.start_soon(waits)
        assert not scope.cancelled_caught

    in_pool(scenario, deadline=1.0)


def test_no_more_calls_wait_than_may() -> None:
    async def scenario(pool: Pool) -> None:
        await until(lambda: pool.warm == 1)
        async with anyio.create_task_group() as group:
            for _ in range(3):  # one works, two wait
                group.start_soon(pool.run, "calls:busy", 0.5)
            await until(lambda: pool.waiting == 2)
            with pytest.raises(QueueFull) as caught:
                await pool.run("calls:add", 1, 2)
            assert caught.value.retry_after is not None
            assert caught.value.retry_after >= 1
        assert await pool.run("calls:add", 1, 2) == 3

    in_pool(scenario, queue_length=2)


def test_calls_that_come_at_once_are_counted_too() -> None:
    async def scenario(pool: Pool) -> None:
        await until(lambda: pool.warm == 2)
        refused = []

        async def call() -> None:
            try:
                await pool.run("calls:busy", 0.3)
            except QueueFull as error:
                refused.append(error)

        async with anyio.create_task_group() as group:
            for _ in range(10):  # two work, three wait
                group.start_soon(call)
        assert len(refused) == 5

    in_pool(scenario, workers=2, queue_length=3)


def test_without_a_queue_free_workers_still_take_calls() -> None:
    async def scenario(pool: Pool) -> None:
        await until(lambda: pool.warm == 1)
        assert await pool.run("calls:add", 1, 2) == 3

    in_pool(scenario, queue_length=0)


def test_a_cancelled_call_leaves_the_queue_or_ends_its_worker() -> None:
    async def scenario(pool: Pool) -> None:
        first = await pool.run("calls:pid")
        started = anyio.Event()
        with anyio.move_on_after(0.5):
            async with anyio.create_task_group() as group:
                group.start_soon(lambda: pool.run("calls:busy", 60.0, started=started))
                await started.wait()
                group.start_soon(pool.run, "calls:busy", 60.0)
        assert pool.waiting == 0
        assert await pool.run("calls:pid") != first

    in_pool(scenario)


def test_a_worker_that_dies_idle_is_replaced() -> None:
    async def scenario(pool: Pool) -> None:
        first = await pool.run("calls:pid")
        os.kill(first, signal.SIGKILL)
        assert await pool.run("calls:pid") != first
        await until(lambda: pool.warm == 1)

    in_pool(scenario)


def test_every_worker_is_warm_before_it_takes_calls(tmp_path: Path) -> None:
    log = tmp_path / "log"

    async def scenario(pool: Pool) -> None:
        assert not pool.ready
        warm = str(await pool.run("calls:pid"))
        assert warm in log.read_text()
        await until(lambda: pool.ready)
        assert len(log.read_text().splitlines()) == 2
        os.kill(int(warm), signal.SIGKILL)
        await until(lambda: len(log.read_text().splitlines()) == 3)

    in_pool(scenario, workers=2, warm_up=("calls:slow_start", (str(log),)))


def test_a_pool_that_cannot_warm_up_is_never_ready() -> None:
    async def scenario(pool: Pool) -> None:
        with pytest.raises(DeadlineExceeded):
            await pool.run("calls:add", 1, 2)
        assert not pool.ready

    in_pool(scenario, deadline=1.0, warm_up=("calls:never_starts", ()))


def test_the_pool_leaves_no_process_behind() -> None:
    seen: list[int] = []

    async def scenario(pool: Pool) -> None:
        seen.append(await pool.run("calls:pid"))
        started = anyio.Event()
        async with anyio.create_task_group() as group:
            group.start_soon(lambda: pool.run("calls:busy", 60.0, started=started))
            await started.wait()
            group.cancel_scope.cancel()

    in_pool(scenario, workers=2)
    assert gone(seen[0])
