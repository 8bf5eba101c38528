"""Reads statements by the forms that a language writes them in."""

import re
from collections.abc import Callable, Mapping, Sequence
from string import Formatter
from typing import TypeAlias

from programs.errors import ProgramError
from programs.posts.reading.statements import located, refusal

Values: TypeAlias = Mapping[str, str]
"""What stands in the fields of a form, by their names."""
FormAction: TypeAlias = Callable[[Values], None]
"""What statements do, by the values of their forms."""
Block: TypeAlias = tuple[Sequence[str], FormAction]
"""Forms of statements that belong together, and what they do."""

_OPERATORS_TEXT = re.compile(r'"[^"{}]*"')


def pattern_of(form: str, fields: Mapping[str, str]) -> str:
    """Give the pattern of what a form writes: each field is a group of its name, and is the same where it comes again.

    A text in quotes is for the operator, and may be any other.

    Args:
        form: As the writer has it.
        fields: Pattern of each field by its name; a field without a name is ``it``.
    """
    pattern, seen = "", set[str]()
    for text, field, _, _ in Formatter().parse(_OPERATORS_TEXT.sub('"{}"', form.strip())):
        pattern += re.escape(text)
        if field is None:
            continue
        if not field and text.endswith('"'):
            pattern += '[^"]*'
            continue
        name = field or "it"
        pattern += f"(?P={name})" if name in seen else f"(?P<{name}>{fields[name]})"
        seen.add(name)
    return pattern


class StatementBlock:
    """Patterns of statements that belong together, and what they do."""

    def __init__(self, forms: Sequence[str], fields: Mapping[str, str], action: FormAction) -> None:
        self.patterns = [re.compile(pattern_of(form, fields)) for form in forms]
        self.action = action

    def follow(self, statements: Sequence[str]) -> dict[str, str] | ProgramError | None:
        """Give the values of the statements to come, or why they are none of these; ``None`` where the first is not."""
        values: dict[str, str] = {}
        for at, pattern in enumerate(self.patterns):
            statement = statements[at] if at < len(statements) else ""
            match = pattern.fullmatch(statement)
            if match is None:
                why = "is not what belongs to the statement before it"
                return refusal(statement or statements[at - 1], why) if at else None
            for name, value in match.groupdict().items():
                if values.setdefault(name, value) != value:
                    return located(_differs(name), statement)
        return values


def _differs(name: str) -> str:
    """Describe a field that is not the same in all statements."""
    if name == "height":
        return "the orifice is compared with one height and raised to another."
    if name in ("input", "name", "state", "scale", "offset", "least"):
        return "what is waited for is not what is looked at then."
    if name in ("label", "ready", "index", "after"):
        return "the program goes on elsewhere than after the statements that belong together."
    return f"the {name} is not the same in the statements that belong together."
