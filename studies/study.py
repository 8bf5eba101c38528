"""The study as a file: boards, recipes, parameter sets, varied values of the recipe, tolerances of carrying it out."""

from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from specs.spec import Bounds, Name, Spec
from specs.yaml.file_kind import FileKind
from specs.yaml.load import parse_spec, read_text
from specs.yaml.located import Located, read_yaml
from studies.errors import StudyError

MOST_JOBS = 100_000
"""A study of more would take weeks, and is a slip of the keyboard."""

Value: TypeAlias = Annotated[float, Bounds(-1_000_000, 1_000_000)]
Steps: TypeAlias = Annotated[int, Bounds(2, 1000, "", "values of a grid")]
Points: TypeAlias = Annotated[int, Bounds(2, 100_000, "", "points of a design")]
TimesDrawn: TypeAlias = Annotated[int, Bounds(2, 1000, "", "samples of tolerances")]
Seed: TypeAlias = Annotated[int, Bounds(0, 1_000_000_000)]
Deviating: TypeAlias = Annotated[float, Bounds(-1000, 1000)]
Word: TypeAlias = Annotated[str, Field(min_length=1, max_length=1000)]


class BoardEntry(Spec):
    """A board of the study, or a part; a word by itself is its ``board``."""

    board: Word = Field(
        description="A sample board or a part of the library, or the file of one; a relative path starts at the "
        "study's folder. A mesh is a part where all recipes follow the faces of parts."
    )
    parts: Word | None = Field(default=None, description="Placement or BOM table (CSV) that is joined to it.")

    @model_validator(mode="before")
    @classmethod
    def _expand_word(cls, given: Any) -> Any:
        return {"board": given} if isinstance(given, str) else given


class Variable(Spec):
    """A value of the recipes that is varied: in a list, in even steps, or anywhere between two bounds."""

    path: Word = Field(description="Where it stands in every recipe, such as templates.sweep.speed_mm_s.")
    values: list[Value | Word] | None = Field(default=None, min_length=1, max_length=1000, description="To take.")
    low: Value | None = Field(default=None, description="Least value, in place of a list.")
    high: Value | None = Field(default=None, description="Greatest value.")
    steps: Steps | None = Field(default=None, description="How many values of a grid, both ends included.")

    @model_validator(mode="after")
    def _check_form(self) -> "Variable":
        if self.values is not None:
            if (self.low, self.high, self.steps) != (None, None, None):
                raise ValueError(f"{self.path} has values and a range; leave one of them out")
        elif self.low is None or self.high is None:
            raise ValueError(f"{self.path} needs values, or low and high")
        elif self.low >= self.high:
            raise ValueError(f"{self.path} needs a high above its low")
        return self


class Grid(Spec):
    """Every combination of the values of all variables."""

    method: Literal["grid"] = Field(default="grid", description="Every combination of values.")


class LatinHypercube(Spec):
    """Points that have each variable in each of as many equal parts of its range once."""

    method: Literal["latin_hypercube"] = Field(default="latin_hypercube", description="Points that fill the ranges.")
    points: Points = Field(description="How many; each board is planned with each recipe at all of them.")
    seed: Seed = Field(default=1, description="Another one gives other points.")


class Normal(Spec):
    """Normally distributed."""

    distribution: Literal["normal"] = Field(default="normal", description="Normally distributed.")
    mean: Deviating = Field(default=0.0, description="Of the deviation.")
    sigma: Annotated[float, Bounds(0, 100, above=True)] = Field(description="Standard deviation.")


class Uniform(Spec):
    """Anywhere between two bounds, evenly."""

    distribution: Literal["uniform"] = Field(default="uniform", description="Evenly distributed.")
    low: Deviating = Field(description="Least deviation.")
    high: Deviating = Field(description="Greatest deviation.")


Distribution: TypeAlias = Annotated[Normal | Uniform, Field(discriminator="distribution")]
Quantity: TypeAlias = Literal[
    "standoff_mm", "pressure_pct", "nozzle_wear_pct", "temperature_c", "shift_x_mm", "shift_y_mm", "turn_deg"
]
LARGEST: dict[Quantity, float] = {
    "standoff_mm": 20.0,
    "pressure_pct": 60.0,
    "nozzle_wear_pct": 60.0,
    "temperature_c": 20.0,
    "shift_x_mm": 20.0,
    "shift_y_mm": 20.0,
    "turn_deg": 20.0,
}
"""Largest deviation that a distribution may reach: more is another process, and no tolerance."""
_REACH = 4.0
"""Standard deviations that count as the reach of a normal distribution; values beyond are cut off."""


class Tolerances(Spec):
    """How the carrying out of a program deviates from its plan, board by board."""

    samples: TimesDrawn = Field(default=16, description="Boards with deviations of their own for each combination.")
    seed: Seed = Field(default=1, description="Another one gives other deviations.")
    deviations: dict[Quantity, Distribution] = Field(
        min_length=1,
        description="standoff_mm: orifice farther from the board along the jet; pressure_pct: of the stated pressure; "
        "nozzle_wear_pct: more flow at the same pressure; temperature_c: warmer than stated; shift_x_mm, shift_y_mm, "
        "turn_deg: the board displaced, and turned anticlockwise about the centre of its outline.",
    )

    @model_validator(mode="after")
    def _check_reach(self) -> "Tolerances":
        for name, each in self.deviations.items():
            low, high = reach_of(each)
            if low >= high:
                raise ValueError(f"{name} needs a high above its low")
            if max(-low, high) > LARGEST[name]:
                raise ValueError(f"{name} reaches {max(-low, high):g}; at most {LARGEST[name]:g} is a tolerance")
        return self


def reach_of(distribution: Normal | Uniform) -> tuple[float, float]:
    """Give the least and the greatest deviation, in the unit of the quantity."""
    if isinstance(distribution, Uniform):
        return distribution.low, distribution.high
    return distribution.mean - _REACH * distribution.sigma, distribution.mean + _REACH * distribution.sigma


class Study(Spec):
    """Which boards are planned with which recipes, at which values, judged by which parameter sets."""

    study: Name = Field(description="Name of the study.")
    description: str = Field(default="", max_length=1000, description="What it is for.")
    boards: list[BoardEntry] = Field(min_length=1, max_length=1000, description="Boards, by name or file.")
    recipes: list[Word] = Field(min_length=1, max_length=1000, description="Recipes, by name or file.")
    parameters: list[Word] = Field(
        default=["default"], min_length=1, max_length=1000, description="Parameter sets, by name or file."
    )
    variables: list[Variable] = Field(default=[], max_length=20, description="Values of the recipes that are varied.")
    design: Annotated[Grid | LatinHypercube, Field(discriminator="method")] = Field(
        default=Grid(), description="How the values are combined."
    )
    tolerances: Tolerances | None = Field(default=None, description="Deviations of carrying a program out.")
    cell: Word | None = Field(default=None, description="Cell whose robot is checked with each program.")
    effort: Literal["fast", "full"] = Field(default="fast", description="Of the analyses.")

    @model_validator(mode="after")
    def _check_design(self) -> "Study":
        paths = [each.path for each in self.variables]
        twice = next((path for path in paths if paths.count(path) > 1), None)
        if twice is not None:
            raise ValueError(f"{twice} is varied twice")
        for each in self.variables:
            ranged = each.values is None
            if isinstance(self.design, Grid) and ranged and each.steps is None:
                raise ValueError(f"{each.path} needs steps in a grid")
            if isinstance(self.design, LatinHypercube) and each.steps is not None:
                raise ValueError(f"{each.path} has steps, which only a grid takes")
        if isinstance(self.design, LatinHypercube) and not self.variables:
            raise ValueError("a Latin hypercube needs variables")
        if self.jobs > MOST_JOBS:
            raise ValueError(f"the study has {self.jobs:,} jobs; at most {MOST_JOBS:,} can be done")
        return self

    @property
    def points(self) -> int:
        """Points of the design."""
        if isinstance(self.design, LatinHypercube):
            return self.design.points
        count = 1
        for each in self.variables:
            count *= len(each.values) if each.values is not None else each.steps or 1
        return count

    @property
    def runs(self) -> int:
        """Jobs of each combination: as planned, and with deviations."""
        return 1 + (0 if self.tolerances is None else self.tolerances.samples)

    @property
    def jobs(self) -> int:
        """All jobs, equal ones counted as often as they occur."""
        return len(self.boards) * len(self.recipes) * len(self.parameters) * self.points * self.runs


STUDY = FileKind("study", "study: NAME", "washboard study", StudyError, Study, dict[str, Path])


def load_study(file: Path) -> tuple[Study, Located]:
    """Read a study, and where each of its values was written.

    Raises:
        StudyError: it cannot be read or used; the message states where and what to do.
    """
    if not file.exists():
        raise StudyError("no such file; a study is a YAML file that begins with `study: NAME`", file=file)
    root = read_yaml(read_text(file, STUDY), file, STUDY)
    return parse_spec(root, STUDY), root


Scalar: TypeAlias = float | int | str
Point: TypeAlias = tuple[Scalar, ...]
"""A value of each variable, in the order of the study."""
Deviation: TypeAlias = tuple[tuple[Quantity, float], ...]
"""How the carrying out deviates, in the units of the names; empty where it does not."""
_DIGITS = 6


def design_points(study: Study) -> list[Point]:
    """List the points of a study's design; one, without values, where nothing is varied."""
    if isinstance(study.design, Grid):
        levels = (each.values or np.linspace(*_range(each), each.steps or 1).tolist() for each in study.variables)
        return list(product(*(map(_short, of_one) for of_one in levels)))
    unit = latin_hypercube(study.design.points, len(study.variables), study.design.seed)
    return [
        tuple(_short(_at(each, share)) for each, share in zip(study.variables, row, strict=True))
        for row in unit.tolist()
    ]


def draw_deviations(tolerances: Tolerances | None) -> list[Deviation]:
    """Draw deviations by a Latin hypercube; the same ones for every combination, so that these can be compared."""
    if tolerances is None:
        return []
    unit = latin_hypercube(tolerances.samples, len(tolerances.deviations), tolerances.seed)
    columns = [_quantiles(each, unit[:, at]) for at, each in enumerate(tolerances.deviations.values())]
    names = list(tolerances.deviations)
    return [
        tuple((name, float(f"{value:.{_DIGITS}g}")) for name, value in zip(names, row, strict=True))
        for row in zip(*columns, strict=True)
    ]


def latin_hypercube(points: int, variables: int, seed: int) -> NDArray[np.float64]:
    """(points, variables) shares of the ranges: in each variable one in each of as many equal parts, seeded.

    M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21 (1979) 239.
    """
    from scipy.stats.qmc import LatinHypercube

    return LatinHypercube(variables, rng=np.random.default_rng(seed)).random(points)


def _quantiles(distribution: Normal | Uniform, shares: NDArray[np.float64]) -> list[float]:
    from scipy.stats import truncnorm

    if isinstance(distribution, Uniform):
        return (distribution.low + shares * (distribution.high - distribution.low)).tolist()
    low, high = ((end - distribution.mean) / distribution.sigma for end in reach_of(distribution))
    return truncnorm.ppf(shares, low, high, distribution.mean, distribution.sigma).tolist()


def _at(variable: Variable, share: float) -> Scalar:
    if variable.values is not None:
        return variable.values[min(int(share * len(variable.values)), len(variable.values) - 1)]
    low, high = _range(variable)
    return low + share * (high - low)


def _range(variable: Variable) -> tuple[float, float]:
    if variable.low is None or variable.high is None:
        raise AssertionError("a variable without values has a range: the study has been checked")
    return variable.low, variable.high


def _short(value: Scalar) -> Scalar:
    """Write a number as a person would: six digits, and whole ones without a point."""
    if isinstance(value, str):
        return value
    rounded = float(f"{value:.{_DIGITS}g}")
    return int(rounded) if rounded.is_integer() else rounded
