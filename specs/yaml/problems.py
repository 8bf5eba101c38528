"""Validation problems of a YAML file: pydantic's errors translated, all problems in one error."""

import difflib
import os
import re
from dataclasses import dataclass
from typing import Any, cast

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from specs.spec import OUT_OF_BOUNDS, Spec
from specs.yaml.file_kind import FileKind
from specs.yaml.located import Key, Located, Mark, YamlPath, spell_path
from specs.yaml.schema import kinds_with, known_keys, name_nearest

_LISTED = 10
_NAME_RULE = "a name begins with a letter and holds letters, digits and _ . - only"
_BRANCH = re.compile(
    r"(constrained-)?(float|int|str)$|function-after\[|(dict|literal)\[|[A-Z]\w+$"
)  # pydantic's tags of a union's branches
_TYPES = {
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


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that must be changed before the file can be used."""

    path: YamlPath
    message: str
    others: tuple[YamlPath, ...] = ()
    """Other values that it depends on, those first that are the likelier cause: one of them is blamed where it stands
    in the user's file and the value at the path is inherited."""


@dataclass(frozen=True, slots=True)
class _Located:
    """One of pydantic's errors and its place in the file."""

    path: YamlPath
    error: ErrorDetails
    in_union: bool
    """Whether one branch of a union refuses the value; another may suit it better."""

    @property
    def is_of_type(self) -> bool:
        return self.error["type"] in _TYPES or self.error["type"] == "literal_error"


def raise_problems(problems: list[Problem], root: Located, kind: FileKind[Spec]) -> None:
    """Raise one error for all problems: the first in the order of the files, then the others in short.

    What the user wrote is blamed before what is inherited, and nobody is sent to edit a file of the library: where an
    inherited value clashes with one of the user's, the user's is named.

    Raises:
        JobError: the kind's own, if there is at least one problem.
    """
    if not problems:
        return
    installed = {os.path.realpath(path): name for name, path in kind.library().items()}
    blamed = [(_blame(each, root, installed), each) for each in problems]
    blamed.sort(key=lambda each: ((mark := each[0][0]).file != root.mark.file, mark.file, mark.line))
    groups: dict[tuple[Mark, YamlPath, bool], list[Problem]] = {}
    for (mark, path), problem in blamed:
        groups.setdefault((mark, path, path != problem.path), []).append(problem)
    entries: list[tuple[Mark, YamlPath, str]] = []
    for (mark, path, clashes), group in groups.items():
        if clashes:
            entries.append((mark, path, _clash(group, root, installed)))
        else:
            entries += [(mark, path, problem.message) for problem in group]
    (mark, path, message), *others = entries
    if others:
        indented = [(mark, path, text.replace("\n", "\n  ")) for mark, path, text in others[:_LISTED]]
        listed = [f"  {mark.file}:{mark.line}: {spell_path(path)}: {text}" for mark, path, text in indented]
        more = [] if len(others) <= _LISTED else [f"  … and {len(others) - _LISTED} more"]
        message = "\n".join([f"{message}\nand {len(others)} more:", *listed, *more])
    raise kind.error(message, path=spell_path(path), file=mark.file, line=mark.line)


def _blame(problem: Problem, root: Located, installed: dict[str, str]) -> tuple[Mark, YamlPath]:
    """Find the value to change: that of the problem, or one it depends on that stands nearer to the user."""
    mark = root.at(problem.path).mark
    candidates = [(problem.path, mark)]
    candidates += [found for path in problem.others if (found := _written_at(path, root)) is not None]

    def distance(candidate: tuple[YamlPath, Mark]) -> int:
        file = candidate[1].file
        return 0 if file == root.mark.file else 1 + (os.path.realpath(file) in installed)

    path, mark = min(candidates, key=distance)
    if distance((path, mark)) == 2:  # an extended file of the library that does not suit: the line that names it
        path, mark = ("extends",), root.at(("extends",)).mark
    return mark, path


def _written_at(path: YamlPath, root: Located) -> tuple[YamlPath, Mark] | None:
    """Find where a value was written or, with ``null``, removed; ``None`` where it is only a default."""
    node = root
    for length, key in enumerate(path):
        if str(key) in node.removed:
            return path[: length + 1], node.removed[str(key)]
        inner = node.get(key)
        if inner is None:
            return None
        node = inner
    return path, node.mark


def _clash(group: list[Problem], root: Located, installed: dict[str, str]) -> str:
    """Describe the inherited values that a value of the user's does not suit, and what to do in the user's file."""

    def inherited(problem: Problem) -> str:
        mark = root.at(problem.path).mark
        library = installed.get(os.path.realpath(mark.file))
        return f"{spell_path(problem.path)}, inherited from {library or f'{mark.file}:{mark.line}'}"

    if len(group) == 1:
        stated = spell_path(group[0].path)
        return (
            f"does not suit {inherited(group[0])}: {group[0].message}. Change it here, or state {stated} in this file "
            "too: that overrides what is inherited, and null removes it"
        )
    listed = [f"  {inherited(problem)}: {problem.message}" for problem in group[:_LISTED]]
    more = [] if len(group) <= _LISTED else [f"  … and {len(group) - _LISTED} more"]
    head = (
        f"does not suit {len(group)} inherited values. Change it here, or state them in this file too: that overrides "
        "what is inherited, and null removes it:"
    )
    return "\n".join([head, *listed, *more])


def translate(error: ValidationError, root: Located, kind: FileKind[Spec]) -> list[Problem]:
    """Turn pydantic's errors into problems whose paths are those of the YAML file."""
    located = [_locate(details, root) for details in error.errors(include_url=False)]
    data = root.plain()
    misspelt: set[YamlPath] = set()  # keys that an unknown one was probably meant to be: they are not missing, then
    for outer, key in ((each.path[:-1], each.path[-1]) for each in located if each.error["type"] == "extra_forbidden"):
        nearest = difflib.get_close_matches(str(key), known_keys(outer, data, kind), n=1)
        misspelt.add((*outer, *nearest))
    located = [each for each in located if each.error["type"] != "missing" or each.path not in misspelt]
    problems: dict[YamlPath, Problem] = {}
    for each in located:
        path = each.path
        rivals = [other for other in located if other.in_union and other.path[: len(path)] == path]
        if each.in_union and each.is_of_type:
            if any(other.path != path or not other.is_of_type for other in rivals):
                continue
            types = [_type_name(other.error) + " by class" * (other.error["type"] == "dict_type") for other in rivals]
            message = f"must be {' or '.join(dict.fromkeys(types))}, not {_show(rivals[0].error['input'])}"
            problem = Problem(path, message)
        else:
            problem = _problem(each, data, kind)
        problems.setdefault(problem.path, problem)
    return list(problems.values())


def _locate(details: ErrorDetails, root: Located) -> _Located:
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
    return _Located(tuple(path), details, in_union)


def _type_name(error: ErrorDetails) -> str:
    if error["type"] == "literal_error":
        return str(error.get("ctx", {}).get("expected", "")).replace("'", "")
    return _TYPES[error["type"]]


def _problem(located: _Located, data: Any, kind: FileKind[Spec]) -> Problem:
    """Describe one error; its path may move to the key that has to be changed."""
    path, error, context = located.path, located.error, located.error.get("ctx", {})
    outer, key = path[:-1], path[-1] if path else ""
    match error["type"]:
        case "missing" if isinstance(key, int):
            return Problem(outer, f"needs a value number {key + 1}")
        case "missing":
            description = known_keys(outer, data, kind).get(str(key), {}).get("description", "")
            return Problem(path, f"is missing. {description}".rstrip())
        case "extra_forbidden":
            known = known_keys(outer, data, kind)
            others = kinds_with(str(key), outer, data, kind)
            text = f"{others}. Known: {', '.join(known)}" if others else f"unknown key; {name_nearest(str(key), known)}"
            return Problem(path, text)
        case "union_tag_invalid":
            known = [tag.strip(" '") for tag in str(context["expected_tags"]).split(",")]
            tag_path = (*path, str(context["discriminator"]).strip("'"))
            return Problem(
                tag_path, f"{_show(context['tag'])} is not known; {name_nearest(str(context['tag']), known)}"
            )
        case "union_tag_not_found":
            tag_path = (*path, str(context["discriminator"]).strip("'"))
            return Problem(tag_path, "is missing; it states what kind this is")
        case _:
            return Problem(path, _value_message(error, context))


def _value_message(error: ErrorDetails, context: dict[str, Any]) -> str:
    name, shown = error["type"], _show(error["input"])
    if name == "literal_error":
        choices = re.findall(r"'([^']*)'", str(context["expected"]))
        return f"{shown} is not known; {name_nearest(str(error['input']), choices)}"
    if name in _TYPES:
        return f"must be {_type_name(error)}, not {shown}"
    if name == OUT_OF_BOUNDS:
        return f"must be {context['bound']}, not {shown}{context['reason']}"
    match name:
        case "finite_number":
            return f"must be a finite number, not {shown}"
        case "string_pattern_mismatch":
            pattern = str(context["pattern"])
            rule = _NAME_RULE if pattern.startswith("^[A-Za-z]") else f"it must match {pattern}"
            return f"{shown} does not fit; {rule}"
        case "too_short":
            return f"needs at least {context['min_length']}, has {context['actual_length']}"
        case "too_long":
            return f"takes at most {context['max_length']}, has {context['actual_length']}"
        case "value_error":
            return error["msg"].removeprefix("Value error, ")
        case _:
            return error["msg"]


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
