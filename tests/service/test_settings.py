from __future__ import annotations

import re
from pathlib import Path

import pytest
from pydantic import ValidationError

from service.settings import Settings

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def _bare(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    for name in Settings.model_fields:
        monkeypatch.delenv(f"TAPELINE_{name.upper()}", raising=False)


def test_the_readme_lists_every_setting_and_no_other() -> None:
    listed = re.findall(r"^\|\s*`(TAPELINE_\w+)`", (ROOT / "README.md").read_text(), flags=re.MULTILINE)
    assert sorted(listed) == sorted(f"TAPELINE_{name.upper()}" for name in Settings.model_fields)


def test_every_setting_says_what_it_is() -> None:
    assert all(field.description for field in Settings.model_fields.values())


def test_there_is_a_default_for_everything() -> None:
    settings = Settings()
    assert settings.port == 8000
    assert settings.workers >= 1


def test_the_environment_wins_over_the_file(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / ".env").write_text("TAPELINE_PORT=8001\nTAPELINE_WORKERS=3\nOTHER=1\n")
    monkeypatch.setenv("TAPELINE_PORT", "8123")
    settings = Settings()
    assert (settings.port, settings.workers) == (8123, 3)


@pytest.mark.parametrize(
    ("text", "origins"), [("", ()), ("*", ("*",)), ("http://a, http://b", ("http://a", "http://b"))]
)
def test_origins_are_separated_by_commas(
    monkeypatch: pytest.MonkeyPatch, text: str, origins: tuple[str, ...]
) -> None:
    monkeypatch.setenv("TAPELINE_CORS_ORIGINS", text)
    assert Settings().cors_origins == origins


@pytest.mark.parametrize(
    ("name", "value"),
    [("PORT", "70000"), ("WORKERS", "0"), ("DEADLINE_SECONDS", "nan"), ("LOG_LEVEL", "loud")],
)
def test_what_makes_no_sense_is_refused_at_the_start(
    monkeypatch: pytest.MonkeyPatch, name: str, value: str
) -> None:
    monkeypatch.setenv(f"TAPELINE_{name}", value)
    with pytest.raises(ValidationError):
        Settings()
