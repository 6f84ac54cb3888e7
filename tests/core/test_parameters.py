import json

import pytest
from pydantic import ValidationError

from core.parameters import CommonParameters, PartitionParameters, PcaParameters

LENGTHS = ["epsilon", "radius", "step", "vertex_spacing"]


def test_by_default_the_data_decide():
    free = PcaParameters()
    for name in [*LENGTHS, "min_component_size", "max_uses", "planar"]:
        assert getattr(free, name) is None
    assert (free.outliers, free.refine, free.seed, free.estimator) == ("auto", True, 0, "pca")


@pytest.mark.parametrize("name", LENGTHS)
@pytest.mark.parametrize("value", [0.0, -1.0, float("inf"), float("nan"), "1", True])
def test_lengths_are_positive_finite_numbers(name, value):
    with pytest.raises(ValidationError) as raised:
        PcaParameters(**{name: value})
    assert raised.value.errors()[0]["loc"] == (name,)


@pytest.mark.parametrize("name", LENGTHS)
@pytest.mark.parametrize("value", [1e-300, 2, 1e300])
def test_any_positive_length_will_do(name, value):
    assert getattr(PcaParameters(**{name: value}), name) == value


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("min_component_size", 0),
        ("min_component_size", 2.5),
        ("max_uses", 0),
        ("seed", -1),
        ("seed", 2**32),
        ("seed", 1.0),
        ("refine", 1),
        ("planar", "true"),
        ("outliers", "drop"),
        ("estimator", "lsq"),
    ],
)
def test_values_out_of_range_or_of_another_type_are_refused(name, value):
    with pytest.raises(ValidationError) as raised:
        PcaParameters(**{name: value})
    assert raised.value.errors()[0]["loc"] == (name,)


def test_unknown_parameters_are_refused():
    for model, name in ((PcaParameters, "raduis"), (PartitionParameters, "radius")):
        with pytest.raises(ValidationError) as raised:
            model(**{name: 1.0})
        (error,) = raised.value.errors()
        assert (error["type"], error["loc"]) == ("extra_forbidden", (name,))


def test_parameters_do_not_change():
    given = PcaParameters(epsilon=1.0)
    with pytest.raises(ValidationError):
        given.epsilon = 2.0


@pytest.mark.parametrize("model", [PartitionParameters, CommonParameters, PcaParameters])
def test_every_parameter_is_described_with_a_default_that_is_valid(model):
    for name, one in model.model_fields.items():
        assert one.description
        assert not one.is_required(), name
    assert model(**model().model_dump()) == model()


@pytest.mark.parametrize("model", [PartitionParameters, CommonParameters, PcaParameters])
def test_the_schema_is_json_and_closed(model):
    schema = model.model_json_schema()
    assert schema["additionalProperties"] is False
    assert set(schema["properties"]) == set(model.model_fields)
    json.dumps(schema, allow_nan=False)


def test_a_round_trip_through_json_loses_nothing():
    given = PcaParameters(epsilon=0.1, outliers="reject", planar=False, seed=7, max_uses=3, refine=False)
    assert PcaParameters.model_validate_json(given.model_dump_json()) == given


def test_more_specific_models_only_add():
    assert set(PartitionParameters.model_fields) < set(CommonParameters.model_fields)
    assert set(CommonParameters.model_fields) < set(PcaParameters.model_fields)
