"""The documents are true where a program can tell, and the repository keeps to its own rules."""

from __future__ import annotations

import ast
import re
import subprocess
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DOCUMENTS = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
ALGORITHM = (ROOT / "docs" / "algorithm.md").read_text(encoding="utf-8")
LOCKS = sorted(ROOT.glob("requirements*.lock"))


def name(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


# --- documents ----------------------------------------------------------------------------------------


def anchors(text: str) -> set[str]:
    """Return the anchors that the headings of a document have on code-hosting sites."""
    headings = re.findall(r"^#+ (.+)$", text, flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("path", DOCUMENTS, ids=name)
def test_every_link_leads_somewhere(path: Path) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)", path.read_text(encoding="utf-8")):
        if not re.match(r"[a-z]+:", target):
            file, _, anchor = target.partition("#")
            led = path.parent / file if file else path
            assert led.exists(), target
            assert not anchor or anchor in anchors(led.read_text(encoding="utf-8")), target


@pytest.mark.parametrize("path", sorted((ROOT / "docs" / "decisions").iterdir()), ids=name)
def test_a_decision_says_what_and_why(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert re.match(r"# \S", text)
    assert text.index("\n**Decision.** ") < text.index("\n**Why.** ")
    assert len(text.splitlines()) <= 40


def test_every_module_of_the_method_is_described() -> None:
    others = {"__init__", "errors", "parameters", "results", "sampling_block"}
    files = [
        *(ROOT / "core").glob("*.py"),
        *(
            path
            for part in ("cloud", "diagnosis", "march", "refine", "surface", "tape")
            for path in (ROOT / "core" / part).glob("*.py")
        ),
        *(ROOT / "core" / "truth" / f"{part}.py" for part in ("fields", "objects", "scanner", "stacks")),
    ]
    modules = {name(path).removesuffix(".py").replace("/", ".") for path in files if path.stem not in others}
    named = set(re.findall(r"`(core\.[a-z_.]+)`", ALGORITHM))
    assert named == modules


def constants() -> list[tuple[str, str]]:
    return re.findall(r"^\| `(core\.[\w.]+)` \| ([^|]+) \|", ALGORITHM, flags=re.MULTILINE)


@pytest.mark.parametrize(("constant", "value"), constants(), ids=lambda text: text)
def test_a_constant_has_the_value_that_is_told(constant: str, value: str) -> None:
    module, _, attribute = constant.rpartition(".")
    assert getattr(import_module(module), attribute) == ast.literal_eval(value)


def test_constants_are_told() -> None:
    assert len(constants()) > 20


def test_the_changelog_names_every_path() -> None:
    from service.processes import PROCESSES  # noqa: PLC0415 # only this test needs it

    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert all(f"`POST {row.path}`" in text for row in PROCESSES)


# --- the repository -----------------------------------------------------------------------------------


def files() -> list[Path]:
    """Return the text files under version control, and those that are about to be."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, check=True).stdout  # noqa: S603
    paths = [ROOT / entry for entry in listed.decode().split("\0") if entry]
    return [path for path in paths if path.is_file() and b"\0" not in path.read_bytes()]


# put together here, or this file would name them
HOSTS = [
    ".".join(parts)
    for parts in (
        ("pypi", "org"),
        ("pythonhosted", "org"),
        ("npmjs", "org"),
        ("crates", "io"),
        ("deb", "debian", "org"),
        ("proxy", "golang", "org"),
    )
]
FOLDERS = re.compile(
    r"(?<![\w.)}\]])/(?:" + "|".join(["work", "tmp", "root", "home", "Users"]) + r")(?![\w-])"
)


def test_no_file_names_a_package_registry_or_a_folder_of_some_machine() -> None:
    listed = files()
    assert ROOT / "README.md" in listed
    found = {
        name(path): hits
        for path in listed
        if (hits := [host for host in HOSTS if host in (text := path.read_text(encoding="utf-8"))]
            + FOLDERS.findall(text))
    }  # fmt: skip
    assert not found


@pytest.mark.parametrize("path", LOCKS, ids=name)
def test_every_locked_package_has_a_version_and_hashes(path: Path) -> None:
    text = re.sub(r"\\\n\s*", "", path.read_text(encoding="utf-8"))
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    assert lines
    for line in lines:
        assert re.match(r"[a-z0-9][a-z0-9.-]*==\S+ .*--hash=sha256:[0-9a-f]{64}", line), line


def test_the_tests_add_packages_to_the_lock_and_change_none() -> None:
    run, tests = (
        set(
            re.findall(
                r"^[a-z0-9][^=\s]*==\S+", (ROOT / lock).read_text(encoding="utf-8"), flags=re.MULTILINE
            )
        )
        for lock in ("requirements.lock", "requirements-test.lock")
    )
    assert run < tests
