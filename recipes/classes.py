"""Component classes and masks, and which components masks treat apart (Sandia 1993, rule 3)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Annotated, TypeAlias

from pydantic import Field, model_validator

from specs.spec import Bounds, Distance, Spec

Measure: TypeAlias = Annotated[float, Bounds(0, 1_000_000, what="pins, mm and mm² of components")]


class Range(Spec):
    """A closed interval; a missing end is open."""

    min: Measure | None = Field(default=None, description="Smallest value that belongs; left out, no lower end.")
    max: Measure | None = Field(default=None, description="Largest value that belongs; left out, no upper end.")

    @model_validator(mode="after")
    def _check(self) -> "Range":
        if self.min is None and self.max is None:
            raise ValueError("give min, max or both")
        if self.min is not None and self.max is not None and self.min > self.max:
            raise ValueError(f"min {self.min:g} is above max {self.max:g}")
        return self

    def holds(self, value: float) -> bool:
        """Whether the value lies in the interval, ends included."""
        return (self.min is None or value >= self.min) and (self.max is None or value <= self.max)


class ComponentClass(Spec):
    """What a component must be to belong to a class: all that is stated must hold; nothing stated takes all."""

    package: list[str] = Field(default=[], description="Shell patterns of the package name, any case; one must match.")
    refdes: list[str] = Field(default=[], description="Shell patterns of the reference designator; one must match.")
    pins: Range | None = Field(default=None, description="Number of pins.")
    area_mm2: Range | None = Field(default=None, description="Plan area.")
    height_mm: Range | None = Field(default=None, description="Height above the component's own side.")
    standoff_mm: Range | None = Field(default=None, description="Gap under the body; an unknown gap never matches.")
    neighbour_mm: Range | None = Field(default=None, description="Distance to the nearest component of the same side.")
    side: str | None = Field(default=None, pattern="^(top|bottom)$", description="top or bottom.")


class Mask(Spec):
    """Components that are treated apart; exactly one of the three lists is given, as shell patterns of refdes."""

    avoid: list[str] = Field(default=[], description="Must not be sprayed: the wave front keeps out, the jet closes.")
    clean: list[str] = Field(default=[], description="Must be cleaned: a finding if no pass serves them.")
    ignore: list[str] = Field(default=[], description="Do not care: no pass of their own, spray may touch them.")
    margin_mm: Distance = Field(default=2.5, description="Distance kept from what is avoided.")

    @model_validator(mode="after")
    def _check(self) -> "Mask":
        if sum(bool(names) for names in (self.avoid, self.clean, self.ignore)) != 1:
            raise ValueError("give exactly one of avoid, clean, ignore")
        return self


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
