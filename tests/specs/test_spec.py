"""Every number of every YAML file has bounds, which keep what is far beyond all machines out."""

from collections.abc import Iterator
from importlib import import_module
from typing import Annotated, Any, cast

import pytest
from pydantic import ValidationError

from specs.spec import Bounds, Spec, write_number


def models() -> list[type[Spec]]:
    """Every model of YAML files, however deep it is derived."""
    for module in ("recipes.recipe", "robotcell.cell.spec", "cleaning.parameters.model"):
        import_module(module)
    found: list[type[Spec]] = []
    todo = [Spec]
    while todo:
        derived = [each for each in todo.pop().__subclasses__() if not each.__module__.startswith("test")]
        found += derived
        todo += derived
    return found


def numbers(node: Any, place: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Every schema of a number within a schema, and where."""
    if isinstance(node, list):
        for index, inner in enumerate(cast("list[Any]", node)):
            yield from numbers(inner, f"{place}[{index}]")
    elif isinstance(node, dict):
        schema = cast("dict[str, Any]", node)
        if schema.get("type") in ("number", "integer") and not {"enum", "const"} & schema.keys():
            yield place, schema
        for key, inner in schema.items():
            if key not in ("default", "enum", "const"):
                yield from numbers(inner, f"{place}.{key}")


@pytest.mark.parametrize("model", models(), ids=lambda model: f"{model.__module__}.{model.__name__}")
def test_every_number_has_finite_bounds(model: type[Spec]) -> None:
    for place, schema in numbers(model.model_json_schema(by_alias=True)["properties"], model.__name__):
        low = schema.get("minimum", schema.get("exclusiveMinimum"))
        high = schema.get("maximum", schema.get("exclusiveMaximum"))
        assert low is not None, (
            f"{place} has no lower bound; give it a type with Bounds, such as those of specs/spec.py"
        )
        assert high is not None, (
            f"{place} has no upper bound; give it a type with Bounds, such as those of specs/spec.py"
        )
        assert -1e12 <= low < high <= 1e12


def test_the_models_of_all_kinds_of_file_are_walked() -> None:
    assert {"Recipe", "Raster", "Wavefront", "CellSpec", "RobotFile", "Parameters", "Soil"} <= {
        model.__name__ for model in models()
    }


class Sample(Spec):
    """A few numbers."""

    length: Annotated[float, Bounds(0, 1000, "mm", "lengths", above=True)] = 1
    share: Annotated[float, Bounds(0, 1, below=True)] = 0
    count: Annotated[int, Bounds(2, 9)] = 2


@pytest.mark.parametrize(
    ("name", "value", "bound", "reason"),
    [
        ("length", 0, "above 0 mm", ": lengths range from 0 to 1,000 mm"),
        ("length", 1000.5, "at most 1,000 mm", ": lengths range from 0 to 1,000 mm"),
        ("share", 1.0, "below 1", ""),
        ("share", -0.1, "at least 0", ""),
        ("count", 1, "at least 2", ""),
        ("count", 10**400, "at most 9", ""),
    ],
)
def test_a_number_out_of_bounds_is_refused_with_the_bound(name: str, value: float, bound: str, reason: str) -> None:
    with pytest.raises(ValidationError) as caught:
        Sample.model_validate({name: value})
    (error,) = caught.value.errors()
    assert error["loc"] == (name,)
    assert error.get("ctx") == {"bound": bound, "reason": reason}


@pytest.mark.parametrize(("name", "value"), [("length", 1000), ("length", 1e-300), ("share", 0), ("count", 9)])
def test_bounds_belong_to_the_range_unless_they_are_open(name: str, value: float) -> None:
    assert getattr(Sample.model_validate({name: value}), name) == value


def test_bounds_are_written_for_people() -> None:
    assert [write_number(each) for each in (1000, 0.01, -1e6, 2.5)] == ["1,000", "0.01", "-1,000,000", "2.5"]
