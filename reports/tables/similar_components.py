"""Components on which a cleaning report has the same findings, put together: their numbers become ranges."""

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from cleaning.verdicts.results import Judgement, Number, Part, deciding_judgement, outcome
from cleaning.verdicts.rules import Grade, Rule, Verdict

_NUMBER = re.compile(r"(?<![^\s(])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?=$|[\s.,;:)%])")
"""A number that stands alone: the digits of a component's name are none."""
_SPAN = 2.0 / 3.0
"""Of the larger of two numbers, by which they may differ and still be much the same: up to three times."""


@dataclass(frozen=True, slots=True)
class Description:
    """Judgements of one rule on all components of a group, as one."""

    rule: Rule
    name: str
    verdict: Verdict
    grade: Grade
    because: str
    """Numbers that differ are ranges, such as ``25 to 50``."""
    advice: str
    numbers: tuple[tuple[Number, Number], ...]
    """The lowest and the highest of each."""


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """Components with much the same judgements, in the order in which they were given."""

    parts: tuple[Part, ...]
    descriptions: tuple[Description, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Of its components."""
        return tuple(part.component for part in self.parts)


@dataclass(slots=True, eq=False)
class _Open:
    """A group that may still grow."""

    parts: list[Part]
    low: list[float]
    """Of each number in its sentences."""
    high: list[float]

    def fits(self, numbers: Sequence[float]) -> bool:
        spans = zip(map(min, self.low, numbers), map(max, self.high, numbers), strict=True)
        return all(high - low <= _SPAN * max(abs(low), abs(high)) for low, high in spans)

    def take(self, part: Part, numbers: Sequence[float]) -> None:
        self.parts.append(part)
        self.low, self.high = list(map(min, self.low, numbers)), list(map(max, self.high, numbers))


def group_alike(parts: Iterable[Part], judgements_of: Callable[[Part], Sequence[Judgement]]) -> list[Group]:
    """Put components with the same judgements together; numbers may differ by a factor of three at most.

    A group stands where its first component does.

    Args:
        parts: Components, the worst first.
        judgements_of: The judgements on one of them that are described.
    """
    groups: list[_Open] = []
    alike: dict[tuple[object, ...], list[_Open]] = {}
    for part in parts:
        judgements = judgements_of(part)
        sentences = [text for each in judgements for text in (each.because, each.advice)]
        numbers = [float(found) for text in sentences for found in _NUMBER.findall(text)]
        kinds = [  # what must be the same in a group: all but the numbers
            (
                each.rule, each.name, each.verdict, each.grade, each.stage,
                *((number.name, number.unit, number.limit is None) for number in each.numbers),
            )
            for each in judgements
        ]  # fmt: skip
        texts = (_NUMBER.sub("#", text) for text in sentences)
        of_kind = alike.setdefault((outcome(part), tuple(kinds), *texts), [])
        group = next((each for each in of_kind if each.fits(numbers)), None)
        if group is None:
            group = _Open([], numbers, numbers)
            groups.append(group)
            of_kind.append(group)
        group.take(part, numbers)
    return [Group(tuple(each.parts), _describe([judgements_of(part) for part in each.parts])) for each in groups]


def describe(judgement: Judgement) -> Description:
    """Describe a single judgement."""
    return _describe([[judgement]])[0]


def _describe(judgements: Sequence[Sequence[Judgement]]) -> tuple[Description, ...]:
    """Describe the judgements on several components as one: each rule once, with its ranges."""
    found: list[Description] = []
    for of_rule in zip(*judgements, strict=True):
        first, numbers = of_rule[0], zip(*(each.numbers for each in of_rule), strict=True)
        because, advice = (_span([getattr(each, name) for each in of_rule]) for name in ("because", "advice"))
        ranges = tuple(map(_bounds, numbers))
        found.append(Description(first.rule, first.name, first.verdict, first.grade, because, advice, ranges))
    return tuple(found)


def _span(sentences: Sequence[str]) -> str:
    """Write sentences that differ in numbers only as one."""
    text, *rest = _NUMBER.split(sentences[0])
    for column, after in zip(zip(*map(_NUMBER.findall, sentences), strict=True), rest, strict=True):
        low, high = min(column, key=float), max(column, key=float)
        text += (low if float(low) == float(high) else f"{low} to {high}") + after
    return text


def _bounds(numbers: Sequence[Number]) -> tuple[Number, Number]:
    limits = [each.limit for each in numbers if each.limit is not None]
    values = [each.value for each in numbers]
    name, unit = numbers[0].name, numbers[0].unit
    lowest = Number(name, min(values), unit, min(limits, default=None))
    return lowest, Number(name, max(values), unit, max(limits, default=None))


def deciding(part: Part) -> Sequence[Judgement]:
    """Give the judgement that decides the outcome of a component."""
    return [deciding_judgement(part)]


def unclean(part: Part) -> Sequence[Judgement]:
    """Give the judgement that decides, then all others that are not clean."""
    first = deciding_judgement(part)
    return [first, *(each for each in part.judgements if each.verdict != "clean" and each is not first)]
