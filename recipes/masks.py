"""Which components the masks of a recipe treat apart (Sandia 1993, rule 3)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from recipes.classes import Mask


@dataclass(frozen=True, slots=True)
class ComponentMasks:
    """Components that masks treat apart; those in no set are served like any other."""

    avoided: tuple[tuple[str, float], ...]
    """Name and margin, mm."""
    ignored: frozenset[str]
    required: frozenset[str]
    """Must be cleaned."""


def match_masks(masks: Sequence[Mask], names: Mapping[str, str]) -> ComponentMasks:
    """Match masks against the components of a board or panel.

    Args:
        masks: The recipe's.
        names: Name of each component, to the one that patterns are compared with: its name on its own board.
    """
    avoided: dict[str, float] = {}
    ignored: set[str] = set()
    required: set[str] = set()
    for mask in masks:
        hits = [
            name
            for name, own in names.items()
            if any(matches(own, pattern) for pattern in (*mask.avoid, *mask.clean, *mask.ignore))
        ]
        if mask.avoid:
            avoided |= {name: max(mask.margin_mm, avoided.get(name, 0.0)) for name in hits}
        elif mask.clean:
            required |= set(hits)
        else:
            ignored |= set(hits)
    return ComponentMasks(tuple(avoided.items()), frozenset(ignored - required), frozenset(required))


def matches(value: str, pattern: str) -> bool:
    """Whether a shell pattern matches a value, whatever their case."""
    return fnmatchcase(value.upper(), pattern.upper())
