"""The command line: the same processes, readers and forms as the web service, in this process.

The commands and their options are derived from the table of processes and the
settings. What takes long to import is imported by the command that needs it,
so that ``tapeline --help`` answers at once.

Exit status: 0 done; 1 something failed here; 2 the input or an option is wrong.
"""

from __future__ import annotations

import argparse
import os
import sys
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, Any, Literal, get_args, get_origin

from pydantic import ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from core.errors import InvalidInput
from service.cli_input import UsageError, given, methods_with, option_name, read, refusal, source
from service.cli_output import add_output, form_of, progress, write
from service.processes import PROCESSES, Process
from service.settings import Settings

if TYPE_CHECKING:
    from service.intake import ErrorItem

__all__ = ["WORKER_SETTINGS", "main"]

_WRONG_INPUT = 2
_FAILED = 1
_INTERRUPTED = 130  # the shells' way of saying SIGINT
WORKER_SETTINGS = (
    "database_url",
    "store_url",
    "data_dir",
    "job_workers",
    "job_poll_seconds",
    "job_seconds",
    "job_memory",
    "keep_seconds",
    "keep_bytes",
    "log_level",
)
"""Settings that concern a process which computes jobs."""
_EXAMPLE_FORMS = ("csv", "json", "npy")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command.

    Parameters
    ----------
    arguments : sequence of str, optional
        Those of the command line by default.

    Returns
    -------
    int
        The exit status.
    """
    options = _parser().parse_args(arguments)
    try:
        options.run(options)
    except UsageError as error:
        return _complain(str(error), _WRONG_INPUT)
    except KeyboardInterrupt:
        return _INTERRUPTED
    except BrokenPipeError:  # the reader of our output had enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # so that closing it cannot fail again
        return _FAILED
    except Exception as error:  # people at a terminal get a line, not a traceback
        return _complain(f"{type(error).__name__}: {error}", _FAILED)
    return 0


def _complain(message: str, status: int) -> int:
    sys.stderr.write(f"tapeline: {' '.join(message.split())}\n")
    return status


# --- the parser -----------------------------------------------------------------------------------


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="tapeline", description="Clean curves from noisy, unorganised point clouds.", allow_abbrev=False
    )
    parser.add_argument("--version", action="version", version=f"tapeline {_version()}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    _add_serve(commands)
    _add_worker(commands)
    for command, methods in _commands(PROCESSES).items():
        _add_process(commands, command, methods)
    _add_examples(commands)
    return parser


def _version() -> str:
    try:
        return version("tapeline")
    except PackageNotFoundError:  # run from a checkout that is not installed
        return "0"


def _commands(table: Iterable[Process]) -> dict[str, dict[str, Process]]:
    """Group the processes: ``reconstruct-pca`` is the command ``reconstruct`` with the method ``pca``.

    What works on scans is a command of its own: ``reconstruct-surface`` is ``surface``.
    """
    commands: dict[str, dict[str, Process]] = {}
    for row in table:
        command, _, method = row.id.partition("-")
        if row.takes == "scans":
            command, method = method or command, ""
        commands.setdefault(command, {})[method or "auto"] = row
    return commands


def _add_serve(commands: Any) -> None:
    text = "Serve over HTTP. What is not given here comes from the environment (TAPELINE_…) or .env."
    parser = commands.add_parser("serve", help="serve over HTTP", description=text, allow_abbrev=False)
    for name, field in Settings.model_fields.items():
        _add_option(parser, name, field)
    parser.set_defaults(run=_serve)


def _add_worker(commands: Any) -> None:
    text = (
        "Compute jobs that servers have taken, on this machine or another: they find each other by the "
        "database, and share a store. What is not given here comes from the environment (TAPELINE_…) or .env."
    )
    parser = commands.add_parser("worker", help="compute jobs", description=text, allow_abbrev=False)
    for name in WORKER_SETTINGS:
        _add_option(parser, name, Settings.model_fields[name])
    parser.set_defaults(run=_work)


def _add_process(commands: Any, command: str, methods: dict[str, Process]) -> None:
    rows = list(methods.values())
    parser = commands.add_parser(
        command,
        help=rows[0].title[:1].lower() + rows[0].title[1:],
        description=_literal(_described(methods)),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    _add_input(parser, rows[0])
    add_output(parser, rows[0].forms, "txt" if "txt" in rows[0].forms else "json")
    if len(methods) > 1:
        first = next(iter(methods))
        parser.add_argument("--method", choices=list(methods), default=first, help=f"default: {first}")
    included = sorted({name for row in rows for name in row.include})
    if included:
        parser.add_argument(
            "--include", action="append", choices=included, help="an extra part that the result shall contain"
        )
    _add_parameters(parser, methods)
    parser.set_defaults(run=_compute, methods=methods)


def _add_input(parser: argparse.ArgumentParser, row: Process) -> None:
    if row.takes == "points":
        kinds = "file of points (.csv, .txt, .xyz, .npy or .json, also with .gz), or - for standard input"
        parser.add_argument("input", help=kinds)
        return
    kinds = "files of scans: range grids (.ply) and meshes (.ply, .stl, .obj), or one .json, also .gz"
    parser.add_argument("input", nargs="+", help=f"{kinds}; or a folder of them, or - for standard input")
    parser.add_argument(
        "--conf", action="append", default=[], metavar="FILE", help="poses of the scans (Stanford .conf)"
    )


def _described(methods: dict[str, Process]) -> str:
    """Say what each method of a command does."""
    texts = {name: row.description.replace("`", "") for name, row in methods.items()}
    many = len(texts) > 1
    return "\n\n".join(
        textwrap.fill(f"--method {name}: {text}" if many else text) for name, text in texts.items()
    )


def _add_parameters(parser: argparse.ArgumentParser, methods: dict[str, Process]) -> None:
    """Add each parameter once: those that all methods have, and then those that only some have."""
    fields = {name: field for row in methods.values() for name, field in row.parameters.model_fields.items()}
    if len(methods) > 1:
        fields.pop("method", None)  # an option already: it chooses the process
    groups: dict[tuple[str, ...], Any] = {
        tuple(methods): parser.add_argument_group("parameters", "what is not given follows from the data")
    }
    for name, field in fields.items():
        owners = methods_with(name, methods)
        if owners not in groups:
            title = f"parameters of --method {' and '.join(owners)}"
            groups[owners] = parser.add_argument_group(title)
        _add_option(groups[owners], name, field)


def _add_examples(commands: Any) -> None:
    parser = commands.add_parser(
        "examples",
        help="list the built-in point sets and solids, or draw one",
        description="List the built-in point sets and solids; draw a point set, or scan a solid: -o then "
        "names the folder for its range grids (.ply) and their poses (.conf).",
        allow_abbrev=False,
    )
    parser.add_argument("name", nargs="?", help="what to draw or to scan; without it they are listed")
    add_output(parser, _EXAMPLE_FORMS, "csv")
    parser.add_argument("-n", type=int, metavar="N", help="number of samples")
    parser.add_argument(
        "--sigma", type=float, help="standard deviation of the noise, as a fraction of the size"
    )
    parser.add_argument("--outliers", type=float, help="number of outliers, as a fraction of the samples")
    parser.add_argument("--seed", type=int, help="the same seed draws the same points")
    parser.add_argument("--views", type=int, help="number of scans of a solid")
    parser.add_argument("--pixels", type=int, help="rows and columns of each scan")
    parser.set_defaults(run=_examples)


def _add_option(parser: Any, name: str, field: FieldInfo) -> None:
    """Add the option of a parameter or a setting; its text is converted where the model checks it."""
    kinds = set(_kinds(field.annotation))
    text = (field.description or "").replace("`", "").replace("Null:", "Default:")
    if field.default not in {None, (), PydanticUndefined}:
        text += f" Default: {_shown(field.default)}."
    keywords: dict[str, Any] = {"help": _literal(text)}
    choices = [choice for kind in kinds if get_origin(kind) is Literal for choice in get_args(kind)]
    if bool in kinds:
        keywords["action"] = argparse.BooleanOptionalAction
    elif choices:
        keywords["choices"] = sorted(choices)
    else:
        many = "tuple[" in str(field.annotation)
        one = "INTEGER" if int in kinds else "NUMBER" if float in kinds else "TEXT"
        keywords["metavar"] = f"{one},…" if many else one
    parser.add_argument(f"--{name.replace('_', '-')}", dest=name, default=None, **keywords)


def _shown(default: object) -> str:
    """Write a default as it would be given."""
    if isinstance(default, tuple):
        return ",".join(map(_shown, default))
    if isinstance(default, bool):
        return str(default).lower()
    return f"{default:g}" if isinstance(default, float) else str(default)


def _kinds(annotation: Any) -> Iterator[Any]:
    """Yield the alternatives of a union, without None and without ``Annotated``."""
    if get_origin(annotation) is Literal or annotation in {bool, int, float, str, NoneType}:
        yield annotation
    for part in get_args(annotation):
        if isinstance(part, type) or get_origin(part):
            yield from _kinds(part)


def _literal(text: str) -> str:
    """Keep argparse from reading a per cent sign as a format."""
    return text.replace("%", "%%")


# --- the commands ---------------------------------------------------------------------------------


def _settings(options: argparse.Namespace, names: Iterable[str]) -> Settings:
    try:
        return Settings(**given(options, names))  # type: ignore[arg-type] # text, which it converts
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        raise UsageError(f"{option_name(str(first['loc'][0]))}: {first['msg']}") from None


def _serve(options: argparse.Namespace) -> None:
    settings = _settings(options, Settings.model_fields)
    from service.app import run  # noqa: PLC0415 # a second of imports

    run(settings)


def _work(options: argparse.Namespace) -> None:
    settings = _settings(options, WORKER_SETTINGS)
    if not settings.job_workers:
        raise UsageError("--job-workers: a worker computes at least one job at a time")
    from service.jobs.keeper import compute  # noqa: PLC0415 # a second of imports

    compute(settings)


def _compute(options: argparse.Namespace) -> None:
    from service.render import encode  # noqa: PLC0415 # a tenth of a second of imports

    process = _chosen(options)
    form = form_of(options)
    submission = read(options, process)
    flags = process.flags(submission.include)
    try:
        with progress() as told:
            result = process.resolve()(submission.data, submission.parameters, progress=told, **flags)
    except InvalidInput as error:
        optional = error.loc[:1] == ("parameters",) and given(options, map(str, error.loc[1:2]))
        loc = ["query", *error.loc[1:]] if optional else ["body", *error.loc]
        item: ErrorItem = {"loc": loc, "msg": error.message, "type": error.kind}
        raise refusal([item], error.message, source(options)) from None
    for warning in getattr(result, "warnings", ()):
        sys.stderr.write(f"tapeline: warning: {warning.message}\n")
    write(encode(result, form, submission.points), options.output, form)


def _chosen(options: argparse.Namespace) -> Process:
    """Return the process that is asked for; of a command with one process ``--method`` is a parameter."""
    methods: dict[str, Process] = options.methods
    return methods[options.method] if len(methods) > 1 else next(iter(methods.values()))


def _examples(options: argparse.Namespace) -> None:
    from core.truth import names  # noqa: PLC0415 # needs scipy
    from service import examples  # noqa: PLC0415 # likewise
    from service.problems import Problem  # noqa: PLC0415 # needs the web framework

    if options.name is None:
        rows = [f"{row['name']:<16} {row['description']}\n" for row in examples.catalogue()]
        rows += [f"{name:<16} {text}, to be scanned\n" for name, text in examples.solids().items()]
        write("".join(rows).encode(), None, "text")
        return
    if options.name in examples.solids():
        _scan(options)
        return
    if options.name not in names():
        raise UsageError(
            f"{options.name}: there is no point set of this name; `tapeline examples` lists them"
        )
    form = form_of(options)
    chosen = _chosen_options(options, ("n", "sigma", "outliers", "seed"), ("views", "pixels"))
    answer = examples.draw(options.name, chosen, form, "")
    if isinstance(answer, Problem):
        raise refusal(answer.errors, answer.detail, options.name)
    write(answer.content, options.output, form)


def _scan(options: argparse.Namespace) -> None:
    """Scan a built-in solid into a folder."""
    from service.examples import scan_files  # noqa: PLC0415 # needs scipy

    chosen = _chosen_options(options, ("views", "pixels", "sigma", "seed"), ("n", "outliers", "format"))
    if options.output is None:
        raise UsageError(f"{options.name}: name a folder for the scans with -o")
    folder = Path(options.output)
    try:
        files = scan_files(options.name, chosen)
        folder.mkdir(parents=True, exist_ok=True)
    except InvalidInput as error:
        raise UsageError(
            f"--{'sigma' if error.loc == ('noise',) else error.loc[0]}: {error.message}"
        ) from None
    except OSError as error:
        raise UsageError(f"{folder}: {error.strerror}") from None
    for name, content in files.items():
        write(content, str(folder / name), "ply")


def _chosen_options(
    options: argparse.Namespace, names: Sequence[str], others: Sequence[str]
) -> dict[str, Any]:
    """Collect the options that were given; refuse those of other examples."""
    for name in others:
        if getattr(options, name) is not None:
            raise UsageError(f"{option_name(name)}: {options.name} is not drawn with this")
    return {name: getattr(options, name) for name in names if getattr(options, name) is not None}


if __name__ == "__main__":
    sys.exit(main())
