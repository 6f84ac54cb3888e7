import pickle

import pytest

from core import errors
from core.errors import DegenerateInput, InvalidInput, InvalidParameter, InvalidPoints, TapelineError

KINDS = [InvalidInput, InvalidPoints, InvalidParameter, DegenerateInput]


def test_all_errors_have_one_root():
    for name in errors.__all__:
        assert issubclass(getattr(errors, name), TapelineError)
    for kind in KINDS:
        assert issubclass(kind, InvalidInput)


@pytest.mark.parametrize("kind", KINDS)
def test_an_error_says_what_and_where(kind):
    error = kind("What is wrong.", ("points", 17, 1))
    assert str(error) == error.message == "What is wrong."
    assert error.loc == ("points", 17, 1)
    assert error.kind == kind.kind


@pytest.mark.parametrize("kind", KINDS)
def test_an_error_crosses_process_borders_whole(kind):
    error = kind("What is wrong.", ("points", 17, 1), "of-its-own")
    copy = pickle.loads(pickle.dumps(error))  # noqa: S301 - our own bytes
    assert type(copy) is kind
    assert (copy.message, copy.loc, copy.kind, str(copy)) == (
        error.message,
        error.loc,
        "of-its-own",
        "What is wrong.",
    )


def test_kinds_are_distinct_and_in_kebab_case():
    kinds = [kind.kind for kind in KINDS]
    assert len(set(kinds)) == len(kinds)
    assert all(k == k.lower() and " " not in k and "_" not in k for k in kinds)


def test_a_kind_of_its_own_leaves_the_class_alone():
    DegenerateInput("x", (), "other")
    assert DegenerateInput("x").kind == "degenerate-input"
