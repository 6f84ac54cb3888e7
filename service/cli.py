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
from service.processes import PROCESSES, Process
from service.settings import Settings

if TYPE_CHECKING:
    from service.intake import ErrorItem, Submission

__all__ = ["WORKER_SETTINGS", "main"]

_WRONG_INPUT = 2
_FAILED = 1
_INTERRUPTED = 130  # the shells' way of saying SIGINT
_UNLIMITED = 2**60
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
_MAGIC = ((b"\x93NUMPY", "application/x-npy"), (b"{", "application/json"), (b"", "text/csv"))
_GZIP = b"\x1f\x8b"


class _UsageError(Exception):
    """What was asked for cannot be done; the message says why, in one line."""


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
    except _UsageError as error:
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
    """Group the processes: ``reconstruct-pca`` is the command ``reconstruct`` with the method ``pca``."""
    commands: dict[str, dict[str, Process]] = {}
    for row in table:
        command, _, method = row.id.partition("-")
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
    parser.add_argument(
        "input",
        help="file of points (.csv, .txt, .xyz, .npy or .json, also with .gz), or - for standard input",
    )
    _add_output(parser, rows[0].forms, "txt" if "txt" in rows[0].forms else "json")
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
        owners = _methods_with(name, methods)
        if owners not in groups:
            title = f"parameters of --method {' and '.join(owners)}"
            groups[owners] = parser.add_argument_group(title)
        _add_option(groups[owners], name, field)


def _methods_with(name: str, methods: dict[str, Process]) -> tuple[str, ...]:
    """Name the methods of a command that have a parameter."""
    return tuple(method for method, row in methods.items() if name in row.parameters.model_fields)


def _add_examples(commands: Any) -> None:
    parser = commands.add_parser(
        "examples",
        help="list the built-in point sets, or draw one",
        description="List the built-in point sets, or draw one of them.",
        allow_abbrev=False,
    )
    parser.add_argument("name", nargs="?", help="the point set to draw; without it they are listed")
    _add_output(parser, _EXAMPLE_FORMS, "csv")
    parser.add_argument("-n", type=int, metavar="N", help="number of samples")
    parser.add_argument(
        "--sigma", type=float, help="standard deviation of the noise, as a fraction of the size"
    )
    parser.add_argument("--outliers", type=float, help="number of outliers, as a fraction of the samples")
    parser.add_argument("--seed", type=int, help="the same seed draws the same points")
    parser.set_defaults(run=_examples)


def _add_output(parser: argparse.ArgumentParser, forms: Sequence[str], default: str) -> None:
    parser.add_argument("-o", "--output", metavar="FILE", help="file to write; default: standard output")
    parser.add_argument(
        "--format", choices=forms, help=f"form of the output; default: by the name of the file, or {default}"
    )
    if "json" in forms and default != "json":
        parser.add_argument(
            "--json", action="store_const", const="json", dest="format", help="the same as --format json"
        )
    parser.set_defaults(forms=forms, default_form=default)


def _add_option(parser: Any, name: str, field: FieldInfo) -> None:
    """Add the option of a parameter or a setting; its text is converted where the model checks it."""
    kinds = set(_kinds(field.annotation))
    text = (field.description or "").replace("`", "").replace("Null:", "Default:")
    if field.default not in {None, (), PydanticUndefined}:
        text += f" Default: {str(field.default).lower() if bool in kinds else field.default}."
    keywords: dict[str, Any] = {"help": _literal(text)}
    choices = [choice for kind in kinds if get_origin(kind) is Literal for choice in get_args(kind)]
    if bool in kinds:
        keywords["action"] = argparse.BooleanOptionalAction
    elif choices:
        keywords["choices"] = sorted(choices)
    else:
        keywords["metavar"] = "INTEGER" if int in kinds else "NUMBER" if float in kinds else "TEXT"
    parser.add_argument(f"--{name.replace('_', '-')}", dest=name, default=None, **keywords)


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


def _given(options: argparse.Namespace, names: Iterable[str]) -> dict[str, str]:
    """Collect the options that were given, as text."""
    values = {name: getattr(options, name, None) for name in names}
    return {
        name: str(value).lower() if isinstance(value, bool) else value
        for name, value in values.items()
        if value is not None
    }


# --- the commands ---------------------------------------------------------------------------------


def _settings(options: argparse.Namespace, names: Iterable[str]) -> Settings:
    try:
        return Settings(**_given(options, names))  # type: ignore[arg-type] # text, which it converts
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        raise _UsageError(f"{_option(str(first['loc'][0]))}: {first['msg']}") from None


def _serve(options: argparse.Namespace) -> None:
    settings = _settings(options, Settings.model_fields)
    from service.app import run  # noqa: PLC0415 # a second of imports

    run(settings)


def _work(options: argparse.Namespace) -> None:
    settings = _settings(options, WORKER_SETTINGS)
    if not settings.job_workers:
        raise _UsageError("--job-workers: a worker computes at least one job at a time")
    from service.jobs.keeper import compute  # noqa: PLC0415 # a second of imports

    compute(settings)


def _compute(options: argparse.Namespace) -> None:
    from service.render import encode  # noqa: PLC0415 # a tenth of a second of imports

    process = _chosen(options)
    form = _form(options)
    submission = _read(options, process)
    flags = {name: name in submission.include for name in process.include}
    try:
        result = process.resolve()(submission.points, submission.parameters, **flags)
    except InvalidInput as error:
        item: ErrorItem = {"loc": ["body", *error.loc], "msg": error.message, "type": error.kind}
        raise _refusal([item], error.message, options.input) from None
    for warning in getattr(result, "warnings", ()):
        sys.stderr.write(f"tapeline: warning: {warning.message}\n")
    _write(encode(result, form, submission.points), options.output, form)


def _chosen(options: argparse.Namespace) -> Process:
    """Return the process that is asked for; of a command with one process ``--method`` is a parameter."""
    methods: dict[str, Process] = options.methods
    return methods[options.method] if len(methods) > 1 else next(iter(methods.values()))


def _read(options: argparse.Namespace, process: Process) -> Submission:
    from service.intake import IntakeError, Limits, decode, decompress, media_type_of_name  # noqa: PLC0415 # see above

    media_type, encoding = media_type_of_name(options.input)
    body = _bytes_of(options.input)
    _refuse_other_methods(options, process)
    query = [*_given(options, process.parameters.model_fields).items()]
    query += [("include", name) for name in getattr(options, "include", None) or ()]
    try:
        plain = decompress(body, encoding or ("gzip" if body.startswith(_GZIP) else None), _UNLIMITED)
        media_type = media_type or next(name for magic, name in _MAGIC if plain.startswith(magic))
        limits = Limits(max_points=_UNLIMITED, max_bytes=_UNLIMITED)
        return decode(plain, media_type, None, query, process.parameters, process.include, limits)
    except IntakeError as error:
        raise _refusal(error.errors, error.detail, options.input) from None


def _refuse_other_methods(options: argparse.Namespace, process: Process) -> None:
    """Say which methods an option belongs to, when it is none of the one that is asked for."""
    every = {name for row in options.methods.values() for name in row.parameters.model_fields}
    for name in _given(options, sorted(every - process.parameters.model_fields.keys() - {"method"})):
        owners = " or ".join(_methods_with(name, options.methods))
        raise _UsageError(f"{_option(name)}: a parameter of another method; add --method {owners}")


def _bytes_of(name: str) -> bytes:
    try:
        return sys.stdin.buffer.read() if name == "-" else Path(name).read_bytes()
    except OSError as error:
        raise _UsageError(f"{name}: {error.strerror}") from None


def _examples(options: argparse.Namespace) -> None:
    from core.truth import names  # noqa: PLC0415 # needs scipy
    from service import examples  # noqa: PLC0415 # likewise
    from service.problems import Problem  # noqa: PLC0415 # needs the web framework

    if options.name is None:
        rows = [f"{row['name']:<16} {row['description']}\n" for row in examples.catalogue()]
        _write("".join(rows).encode(), None, "text")
        return
    if options.name not in names():
        raise _UsageError(
            f"{options.name}: there is no point set of this name; `tapeline examples` lists them"
        )
    form = _form(options)
    chosen = {name: getattr(options, name) for name in ("n", "sigma", "outliers", "seed")}
    answer = examples.draw(options.name, {k: v for k, v in chosen.items() if v is not None}, form, "")
    if isinstance(answer, Problem):
        raise _refusal(answer.errors, answer.detail, options.name)
    _write(answer.content, options.output, form)


def _form(options: argparse.Namespace) -> str:
    """Form of the output: as asked for, or by the ending of the file's name."""
    if options.format or options.output is None:
        return options.format or options.default_form  # type: ignore[no-any-return] # a Namespace has no types
    form = Path(options.output).suffix.lower().removeprefix(".")
    if form not in options.forms:
        raise _UsageError(
            f"{options.output}: choose a name that ends in .{', .'.join(options.forms)}, or --format"
        )
    return form


def _write(content: bytes, output: str | None, form: str) -> None:
    if output is None:
        if form in {"png", "npy"} and sys.stdout.isatty():
            raise _UsageError(f"{form} is not for terminals; name a file with -o")
        sys.stdout.buffer.write(content)
        sys.stdout.buffer.flush()
        return
    try:
        Path(output).write_bytes(content)
    except OSError as error:
        raise _UsageError(f"{output}: {error.strerror}") from None


def _refusal(errors: Sequence[ErrorItem], detail: str, name: str) -> _UsageError:
    """Say in one line what is wrong and where: in which option, or in which row of which file."""
    if not errors:
        return _UsageError(f"{name}: {detail}")
    loc, message = errors[0]["loc"], errors[0]["msg"]
    more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
    if loc[0] == "query":
        return _UsageError(f"{_option(str(loc[1]))}: {message}{more}")
    place = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in loc[1:])
    return _UsageError(f"{name}: {place.removeprefix('.')}{': ' if place else ''}{message}{more}")


def _option(name: str) -> str:
    return f"{'-' if len(name) == 1 else '--'}{name.replace('_', '-')}"


if __name__ == "__main__":
    sys.exit(main())
