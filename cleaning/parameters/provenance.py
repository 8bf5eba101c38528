"""What an analysis takes for granted: every value of a parameter set, with how it is known."""

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, cast, get_args

from cleaning.parameters.model import Known, Liquid, Parameters, Provenance
from specs.spec import Bounds

_NOT_VALUES = ("parameters", "description", "provenance", "extends")
"""Keys that name and document a set; no number follows from them."""


@dataclass(frozen=True, slots=True)
class Assumption:
    """One value of a parameter set."""

    path: str
    """Such as ``"soil.k1_per_s"``."""
    value: str
    """As one would write it in the file."""
    provenance: Provenance

    @property
    def known(self) -> Known:
        """How it is known."""
        return self.provenance.known


def assumptions_of(parameters: Parameters) -> tuple[Assumption, ...]:
    """List every value that a parameter set states, in its order; what is left out is no assumption."""
    plain = cast("dict[str, object]", parameters.model_dump(mode="json", exclude_none=True, by_alias=True))
    leaves = [leaf for key, value in plain.items() if key not in _NOT_VALUES for leaf in _leaves(key, value)]
    return tuple(Assumption(path, value, parameters.known(path)) for path, value in leaves)


def _leaves(path: str, value: object) -> Iterator[tuple[str, str]]:
    if isinstance(value, dict):
        for key, inner in cast("dict[str, object]", value).items():
            yield from _leaves(f"{path}.{key}", inner)
    elif isinstance(value, list) and any(isinstance(each, dict) for each in cast("list[object]", value)):
        for index, inner in enumerate(cast("list[object]", value)):
            yield from _leaves(f"{path}[{index}]", inner)
    elif value != []:
        yield path, _written(value)


def _written(value: object) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, list):
        inner = (
            each if not isinstance(each, str) else json.dumps(each, ensure_ascii=False)
            for each in cast("list[object]", value)
        )
        return f"[{', '.join(map(_written, inner))}]"
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def with_values(parameters: Parameters, values: Mapping[str, float]) -> Parameters:
    """Give the parameters with other values at some paths."""
    changed: Any = parameters
    for path, value in values.items():
        changed = _with_value(changed, keys_of(path), value)
    return cast("Parameters", changed)


def keys_of(path: str) -> list[str]:
    """Keys of a path; the name of a liquid may have points."""
    block, _, rest = path.partition(".")
    return [block, *rest.rsplit(".", 1)] if block == "liquids" else path.split(".")


def _with_value(holder: Any, keys: list[str], value: float) -> Any:
    key, *rest = keys
    if isinstance(holder, dict):
        held = cast("dict[str, Any]", holder)
        return {**held, key: _with_value(held[key], rest, value) if rest else value}
    inner = _with_value(getattr(holder, key), rest, value) if rest else value
    return holder.model_copy(update={key: inner})


def bounds_at(path: str) -> tuple[float, float]:
    """Give the least and the most that the value at a path may be, by its type; infinite where that has no bounds."""
    *blocks, field = keys_of(path)
    holder: Any = Liquid if blocks[0] == "liquids" else Parameters.model_fields[blocks[0]].annotation
    info = holder.model_fields[field]
    found = _bounds_in((info.annotation, *info.metadata))
    return (-math.inf, math.inf) if found is None else (found.least, found.most)


def _bounds_in(types: tuple[Any, ...]) -> Bounds | None:
    """Find the bounds in a type, which those of an optional value are one level down in."""
    found = (each if isinstance(each, Bounds) else _bounds_in(get_args(each)) for each in types)
    return next((each for each in found if each is not None), None)
