from __future__ import annotations

from collections.abc import AsyncIterator

import anyio
import pytest

from service.intake import IntakeError
from service.work.body import IN_MEMORY, receive


async def chunks(content: bytes, size: int = 50_000) -> AsyncIterator[bytes]:
    for start in range(0, len(content), size):
        yield content[start : start + size]


@pytest.mark.parametrize("size", [0, 1, IN_MEMORY, IN_MEMORY + 1, 3 * IN_MEMORY])
def test_a_body_is_what_was_sent_and_leaves_no_file(size: int) -> None:
    content = bytes(range(256)) * (size // 256 + 1)
    content = content[:size]

    async def main() -> None:
        async with receive(chunks(content), None, size) as body:
            assert body.read() == content
            assert (body.path is None) == (size <= IN_MEMORY)
            assert len(body.content) <= IN_MEMORY
        assert body.path is None or not body.path.exists()

    anyio.run(main)


@pytest.mark.parametrize("announced", [None, 10, 11])
def test_one_byte_too_many_is_refused(announced: int | None) -> None:
    async def main() -> None:
        async with receive(chunks(b"x" * 11, 4), announced, 10):
            pytest.fail("it was not refused")

    with pytest.raises(IntakeError) as caught:
        anyio.run(main)
    assert caught.value.status == 413


def test_what_is_announced_as_too_large_is_not_read() -> None:
    async def nothing() -> AsyncIterator[bytes]:
        pytest.fail("it was read")
        yield b""

    async def main() -> None:
        async with receive(nothing(), 11, 10):
            pytest.fail("it was not refused")

    with pytest.raises(IntakeError):
        anyio.run(main)
