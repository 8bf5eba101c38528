"""What is wrong with a YAML file, in an engineer's words: pydantic's errors translated, all problems in one error."""

import difflib
import re
from dataclasses import dataclass
from typing import Any, cast

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from specs.yaml.document import Document
from specs.yaml.keys import known_keys, name_nearest
from specs.yaml.located import Key, Located, YamlPath, spell_path

_LISTED = 10
_NAME_RULE = "a name begins with a letter and holds letters, digits and _ . - only"
_BRANCH = re.compile(
    r"(constrained-)?(float|int|str)$|(dict|literal)\[|[A-Z]\w+$"
)  # pydantic's tags of a union's branches
_WANTED = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "text (put it in quotes)",
    "bool_type": "true or false",
    "list_type": "a list",
    "tuple_type": "a list",
    "dict_type": "a mapping",
    "model_type": "a mapping",
    "model_attributes_type": "a mapping",
}
_BOUNDS = {
    "greater_than": ("above", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("below", "lt"),
    "less_than_equal": ("at most", "le"),
}


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that must be changed before the file can be used."""

    path: YamlPath
    message: str


@dataclass(frozen=True, slots=True)
class _Complaint:
    path: YamlPath
    error: ErrorDetails
    in_union: bool
    """Whether one branch of a union complains; another may suit the value better."""


def raise_problems(problems: list[Problem], root: Located, document: Document) -> None:
    """Raise one error for all problems: the first in the order of the files, then the others in short.

    Raises:
        JobError: the document's own, if there is at least one problem.
    """
    if not problems:
        return
    placed = [(root.at(problem.path).mark, problem) for problem in problems]
    placed.sort(key=lambda pair: (pair[0].file != root.mark.file, pair[0].file, pair[0].line))
    (mark, first), *others = placed
    message = first.message
    if others:
        listed = [f"  {m.file}:{m.line}: {spell_path(p.path)}: {p.message}" for m, p in others[:_LISTED]]
        more = [] if len(others) <= _LISTED else [f"  … and {len(others) - _LISTED} more"]
        message = "\n".join([f"{message}\nand {len(others)} more:", *listed, *more])
    raise document.error(message, path=spell_path(first.path), file=mark.file, line=mark.line)


def translate(error: ValidationError, root: Located, document: Document) -> list[Problem]:
    """Turn pydantic's errors into problems whose paths are those of the YAML file."""
    located = [_locate(details, root) for details in error.errors(include_url=False)]
    data = root.plain()
    misspelt = {_meant(each, data, document) for each in located if each.error["type"] == "extra_forbidden"}
    complaints = [each for each in located if each.error["type"] != "missing" or each.path not in misspelt]
    problems: dict[YamlPath, Problem] = {}
    for complaint in complaints:
        rivals = [other for other in complaints if other.in_union and _is_within(other.path, complaint.path)]
        if complaint.in_union and _is_of_type(complaint):
            if any(other.path != complaint.path or not _is_of_type(other) for other in rivals):
                continue
            problem = Problem(complaint.path, _say_union(rivals))
        else:
            problem = _say(complaint, data, document)
        problems.setdefault(problem.path, problem)
    return list(problems.values())


def _meant(complaint: _Complaint, data: Any, document: Document) -> YamlPath:
    """Give the path of the key that an unknown one was probably meant to be; that one is not missing, then."""
    known = known_keys(complaint.path[:-1], data, document)
    near = difflib.get_close_matches(str(complaint.path[-1]), known, n=1)
    return (*complaint.path[:-1], *near)


def _locate(details: ErrorDetails, root: Located) -> _Complaint:
    """Strip what pydantic adds to a path: tags of unions and marks of keys, which are no keys of the file."""
    path: list[Key] = []
    node: Located = root
    in_union = False
    for index, key in enumerate(details["loc"]):
        inner = node.get(key)
        if inner is not None:
            path.append(key)
            node = inner
        elif details["type"] == "missing" and index == len(details["loc"]) - 1:
            path.append(key)
        else:
            in_union |= isinstance(key, str) and _BRANCH.match(key) is not None
    return _Complaint(tuple(path), details, in_union)


def _is_within(path: YamlPath, outer: YamlPath) -> bool:
    return path[: len(outer)] == outer


def _is_of_type(complaint: _Complaint) -> bool:
    return complaint.error["type"] in _WANTED or complaint.error["type"] == "literal_error"


def _say_union(complaints: list[_Complaint]) -> str:
    wanted = [_want(each.error) + " by class" * (each.error["type"] == "dict_type") for each in complaints]
    listed = " or ".join(dict.fromkeys(wanted))
    return f"must be {listed}, not {_show(complaints[0].error['input'])}"


def _want(error: ErrorDetails) -> str:
    if error["type"] == "literal_error":
        return str(error.get("ctx", {}).get("expected", "")).replace("'", "")
    return _WANTED[error["type"]]


def _say(complaint: _Complaint, data: Any, document: Document) -> Problem:
    """Write one complaint for a person; its path may move to the key that has to be changed."""
    path, error, context = complaint.path, complaint.error, complaint.error.get("ctx", {})
    outer, key = path[:-1], path[-1] if path else ""
    match error["type"]:
        case "missing" if isinstance(key, int):
            return Problem(outer, f"needs a value number {key + 1}")
        case "missing":
            description = known_keys(outer, data, document).get(str(key), {}).get("description", "")
            return Problem(path, f"is missing. {description}".rstrip())
        case "extra_forbidden":
            return Problem(path, f"unknown key; {name_nearest(str(key), known_keys(outer, data, document))}")
        case "union_tag_invalid":
            known = [tag.strip(" '") for tag in str(context["expected_tags"]).split(",")]
            tag_path = (*path, str(context["discriminator"]).strip("'"))
            return Problem(
                tag_path, f"{_show(context['tag'])} is not known; {name_nearest(str(context['tag']), known)}"
            )
        case "union_tag_not_found":
            tag_path = (*path, str(context["discriminator"]).strip("'"))
            return Problem(tag_path, "is missing; it says what kind this is")
        case _:
            return Problem(path, _say_value(error, context))


def _say_value(error: ErrorDetails, context: dict[str, Any]) -> str:
    kind = error["type"]
    if kind == "literal_error":
        choices = re.findall(r"'([^']*)'", str(context["expected"]))
        return f"{_show(error['input'])} is not known; {name_nearest(str(error['input']), choices)}"
    if kind in _WANTED:
        return f"must be {_want(error)}, not {_show(error['input'])}"
    if kind in _BOUNDS:
        word, bound = _BOUNDS[kind]
        return f"must be {word} {context[bound]:g}, not {_show(error['input'])}"
    match kind:
        case "finite_number":
            return f"must be a finite number, not {_show(error['input'])}"
        case "string_pattern_mismatch":
            return f"{_show(error['input'])} does not fit; {_say_pattern(str(context['pattern']))}"
        case "too_short":
            return f"needs at least {context['min_length']}, has {context['actual_length']}"
        case "too_long":
            return f"takes at most {context['max_length']}, has {context['actual_length']}"
        case "value_error":
            return error["msg"].removeprefix("Value error, ")
        case _:
            return error["msg"]


def _say_pattern(pattern: str) -> str:
    return _NAME_RULE if pattern.startswith("^[A-Za-z]") else f"it must match {pattern}"


def _show(value: Any) -> str:
    """Write a wrong value briefly."""
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list | tuple):
        return f"a list of {len(cast('list[Any]', value))}"
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    text = repr(value) if isinstance(value, str) else f"{value}"
    return text if len(text) <= 60 else f"{text[:57]}…"
