"""Every value of a parameter set with how it is known; and what must hold between values, or the set is refused."""

import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import date as day
from typing import Any, cast, get_args

from pydantic import ValidationError

from cleaning.parameters.chemistries import with_chemistries
from cleaning.parameters.model import Known, Liquid, Parameters, Provenance
from specs.spec import Bounds
from specs.yaml.located import Located, YamlPath, spell_path
from specs.yaml.problems import Problem
from specs.yaml.schema import name_nearest

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
    plain = parameters.model_dump(mode="json", exclude_none=True, by_alias=True, exclude={*_NOT_VALUES})
    found: list[Assumption] = []
    for path, value in _named_values(plain, ""):
        holds_blocks = isinstance(value, list) and any(isinstance(each, dict) for each in cast("list[object]", value))
        if value != [] and not isinstance(value, dict) and not holds_blocks:
            found.append(Assumption(path, _written(value), parameters.known(path)))
    return tuple(found)


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


_DATE = re.compile(r"\d{4}-\d{2}-\d{2}")
_TEXTS = (("parameters",), ("description",), ("extends",))
_FITTED = ("calibrated", "synthetic")
_ORDERED = (
    ("limits", "gap_marginal", "gap_dirty"),
    ("limits", "rinse_fail_mohm", "rinse_warn_mohm"),
    ("drying", "receding_deg", "advancing_deg"),
)
"""Block, value, and the value of the block that it must not exceed."""


def find_problems(parameters: Parameters, root: Located) -> list[Problem]:
    """Look for what makes a set useless, or its provenance untrue, although each value is well formed.

    Args:
        parameters: The set.
        root: Its resolved tree: a value that was inherited bears the mark of the file it stands in.
    """
    problems = [*_check_values(parameters), *_check_order(parameters), *_check_provenance(parameters)]
    problems += _check_ranges(parameters)
    return [*problems, *_check_inherited(root)]


def is_day(date: str) -> bool:
    """Whether a date is one of the calendar, written as in 2026-11-21."""
    try:
        return _DATE.fullmatch(date) is not None and bool(day.fromisoformat(date))
    except ValueError:
        return False


def value_paths(value: Any, path: YamlPath = ()) -> Iterator[YamlPath]:
    """Give the path of every single value in a tree of mappings; a list counts as one."""
    if isinstance(value, dict):
        for key, inner in cast("dict[str, Any]", value).items():
            yield from value_paths(inner, (*path, key))
    else:
        yield path


def _check_values(parameters: Parameters) -> Iterator[Problem]:
    missing = {"hollow_cone", "full_cone", "flat_fan", "air_knife"} - set(parameters.spray.flow_exponent)
    if missing:
        yield Problem(("spray", "flow_exponent"), f"is missing for {', '.join(sorted(missing))}; liquids have 0.5")
    for name, liquid in parameters.liquids.items():
        if liquid.use == "wash" and liquid.concentration_pct == 0:
            message = "must be above 0 for washing: without it nothing softens. 100 if the liquid itself is the agent"
            yield Problem(("liquids", name, "concentration_pct"), message, (("liquids", name, "use"),))
    yield from _check_cascade(parameters)
    drying = parameters.drying
    if drying.bake_min > 0 and drying.bake_c is None:
        yield Problem(("drying", "bake_min"), "needs the temperature of the bake too: bake_c", (("drying", "bake_c"),))
    if drying.bake_c is not None and drying.bake_min == 0:
        yield Problem(("drying", "bake_c"), "needs the time of the bake too: bake_min", (("drying", "bake_min"),))


def _check_cascade(parameters: Parameters) -> Iterator[Problem]:
    """Tanks hold rinse water that the set has, each its own."""
    tanks = [] if parameters.rinse.cascade is None else parameters.rinse.cascade.tanks
    for row, tank in enumerate(tanks):
        at: YamlPath = ("rinse", "cascade", "tanks", row, "solution")
        liquids = with_chemistries(parameters, [tank.solution]).liquids
        liquid = liquids.get(tank.solution)
        if liquid is None:
            yield Problem(at, f"is not among liquids; {name_nearest(tank.solution, list(liquids))}")
        elif liquid.use != "rinse":
            yield Problem(at, f"{tank.solution} is for {liquid.use}, not for rinse")
        elif tank.solution in [each.solution for each in tanks[:row]]:
            yield Problem(at, f"{tank.solution} has a tank already; each tank has a solution of its own")


def _check_ranges(parameters: Parameters) -> Iterator[Problem]:
    """A range reaches no farther than a value may; only the ends are tried."""
    plain = parameters.model_dump(mode="python", exclude_unset=True)
    lows, highs = dict[str, float](), dict[str, float]()
    for path, entry in parameters.provenance.items():
        value: Any = plain
        for key in keys_of(path):
            value = cast("dict[str, Any]", value).get(key) if isinstance(value, dict) else None
        if entry.within_factor is not None and isinstance(value, int | float) and not isinstance(value, bool):
            lows[path], highs[path] = value / entry.within_factor, value * entry.within_factor
    # No value's bounds depend on another value: where all ends pass together each passes, and most sets are so.
    if _may_be(parameters, lows) and _may_be(parameters, highs):
        return
    for path in lows:
        for end in (lows[path], highs[path]):
            if not _may_be(parameters, {path: end}):
                message = f"leads to {end:.4g}, which {path} cannot be; lower it"
                yield Problem(("provenance", path, "within_factor"), message)
                break


def _may_be(parameters: Parameters, values: dict[str, float]) -> bool:
    try:
        Parameters.model_validate(with_values(parameters, values).model_dump(exclude_unset=True))
    except ValidationError:
        return False
    return True


def _check_order(parameters: Parameters) -> Iterator[Problem]:
    """Pairs whose lower number comes first, and values that another one bounds."""
    pairs: list[tuple[YamlPath, tuple[float, float] | None]] = [
        *((("liquids", name, "window_c"), liquid.window_c) for name, liquid in parameters.liquids.items()),
        *(
            (("liquids", name, "concentration_window_pct"), liquid.concentration_window_pct)
            for name, liquid in parameters.liquids.items()
        ),
        *((("parts", row, "standoff_um"), part.standoff_um) for row, part in enumerate(parameters.parts)),
        *((("parts", row, "window_c"), part.window_c) for row, part in enumerate(parameters.parts)),
        *((("provenance", name, "interval"), entry.interval) for name, entry in parameters.provenance.items()),
    ]
    for path, pair in pairs:
        if pair is not None and pair[0] > pair[1]:
            yield Problem(path, f"[{pair[0]:g}, {pair[1]:g}]: the lower number comes first")
    for block, lower, upper in _ORDERED:
        values = getattr(parameters, block)
        low, high = getattr(values, lower), getattr(values, upper)
        if low > high:
            message = f"must be at most {upper}, {high:g}, not {low:g}"
            yield Problem((block, lower), message, ((block, upper),))


def _check_provenance(parameters: Parameters) -> Iterator[Problem]:
    named = dict(_named_values(parameters.model_dump(mode="json", exclude={"provenance"}), ""))
    for name, entry in parameters.provenance.items():
        at: YamlPath = ("provenance", name)
        if entry.date and not is_day(entry.date):  # the type looks at the digits alone
            yield Problem((*at, "date"), f"{entry.date!r} is no day of the calendar")
        if name in named:
            yield from _check_fit(at, entry, named[name])
            continue
        block = name.rpartition(".")[0]
        while block and block not in named:
            block = block.rpartition(".")[0]
        within = [each for each in named if each.rpartition(".")[0] == block] or list(named)
        message = f"names nothing of this set; {name_nearest(name, within)}"
        yield Problem(at, message, (tuple(name.split(".")),))


def _named_values(value: Any, name: str) -> Iterator[tuple[str, Any]]:
    """Give every value and block by the path that provenance calls it."""
    if isinstance(value, dict):
        for key, inner in cast("dict[str, Any]", value).items():
            inner_name = f"{name}.{key}" if name else key
            yield inner_name, inner
            yield from _named_values(inner, inner_name)
    elif isinstance(value, list):
        for index, inner in enumerate(cast("list[Any]", value)):
            if isinstance(inner, dict):
                yield f"{name}[{index}]", inner
                yield from _named_values(cast("dict[str, Any]", inner), f"{name}[{index}]")


def _check_fit(at: YamlPath, entry: Provenance, value: Any) -> Iterator[Problem]:
    """A value that claims to be fitted states how well, and is the one that was fitted."""
    if entry.known in _FITTED and (entry.samples is None or entry.rms is None):
        yield Problem((*at, "known"), f"{entry.known} needs samples and rms too: what was fitted, and how well")
    if entry.interval is None:
        return
    low, high = entry.interval
    if not isinstance(value, int | float):
        yield Problem((*at, "interval"), "is that of one value; name the value, not the block around it")
    elif low <= high and not low <= value <= high:
        message = (
            f"{value:g} lies outside {low:g} to {high:g}: the value was changed, so state anew where it comes from"
        )
        yield Problem((*at, "interval"), message, (tuple(str(at[-1]).split(".")),))


def _check_inherited(root: Located) -> Iterator[Problem]:
    """A set that changes a value states where the new one comes from: what it inherits is of the old one."""
    own, tree = root.mark.file, root.value
    provenance = root.get("provenance")
    if not isinstance(tree, dict) or provenance is None or not isinstance(provenance.value, dict):
        return
    entries = provenance.value
    reported: set[YamlPath] = set()
    for path in value_paths({key: node.plain() for key, node in tree.items() if key != "provenance"}):
        if path in _TEXTS or root.at(path).mark.file != own:
            continue
        covering = (".".join(map(str, path[:length])) for length in range(len(path), 0, -1))
        name = next((name for name in covering if name in entries), None)
        if name is None or entries[name].mark.file == own:
            continue
        liquid = root.at(path[:2])
        whole = name == "liquids" and all(liquid.at(at).mark.file == own for at in value_paths(liquid.plain()))
        where = path[:2] if whole else path
        if where not in reported:
            reported.add(where)
            message = (
                f"is stated here, but its provenance is inherited and is of another value; add to "
                f"provenance: {spell_path(where)}: {{known: proposed, source: ...}}"
            )
            yield Problem(where, message)
