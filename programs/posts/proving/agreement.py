"""What a comparison of a program's text with its plan has found: differences, worst values, what belongs together."""

from dataclasses import dataclass, field
from math import degrees

from geometry.arrays import Scalars
from programs.motion.installation import Installation
from programs.motion.lower import Capability
from programs.motion.steps import Event, Line, Reach
from programs.pose import Pose, angle, distance
from programs.posts.rebuilt import ReadSignal, ReadStep, Rebuilt, TextPlace
from programs.posts.writing.axes import allowed_on, units_of
from specs.source import Source

POSE_MM, POSE_DEG = 0.01, 0.01
"""Within which poses agree."""


@dataclass(frozen=True, slots=True)
class Match:
    """A motion that was read, and the part of a planned one that it is."""

    step: int
    """Of those that were read."""
    planned: Line | Reach
    begin: float
    end: float
    """Shares of the planned line at its ends; 0 and 1 of a joint motion."""

    def inside(self, share: float) -> float:
        """Give the share of this part at one of the planned line; a part at its very end may have no extent."""
        size = self.end - self.begin
        return (share - self.begin) / size if size > 0.0 else 0.0


@dataclass(frozen=True, slots=True)
class Firing:
    """A signal that was read, and the planned one that it is."""

    step: int
    """Of those that were read: the line that carries it, or the output before one."""
    signal: ReadSignal
    line: Line
    event: Event


@dataclass(frozen=True, slots=True)
class Difference:
    """What a text does otherwise than planned."""

    message: str
    place: TextPlace | None
    """Statement that does it, where that is known."""
    made_by: Source
    """What was planned there."""

    def __str__(self) -> str:
        """Place in the text, place in the recipe, message."""
        place = f"{self.place.file}:{self.place.line}: " if self.place else ""
        return f"{place}{self.made_by or 'program'}: {self.message}"


@dataclass(frozen=True, slots=True)
class Agreement:
    """How closely a program that was read back does what was planned."""

    differences: tuple[Difference, ...]
    """Beyond the tolerances of ``measure``; some twenty at most."""
    place_mm: float = 0.0
    """Largest distance of the orifice from its planned place at the ends and in the middle of lines."""
    turn_deg: float = 0.0
    """Largest angle from the planned orientation there."""
    event_s: float = 0.0
    """Largest time between a signal and the planned one."""
    matches: tuple[Match, ...] = ()
    """Motions that were read, in order."""
    firings: tuple[Firing, ...] = ()
    """Signals on lines that were read, in order."""

    def describe(self) -> str:
        """State the worst values in words."""
        return (
            f"places within {self.place_mm:.4f} mm and {self.turn_deg:.4f} deg, "
            f"signals within {1e3 * self.event_s:.2f} ms of the plan"
        )


@dataclass(slots=True)
class Record:
    """What was found so far while two programs are compared side by side."""

    installation: Installation
    rebuilt: Rebuilt
    at: int = 0
    """The next step that was read."""
    differences: list[Difference] = field(default_factory=list[Difference])
    place_mm: float = 0.0
    turn_deg: float = 0.0
    event_s: float = 0.0
    """The worst so far."""
    matches: list[Match] = field(default_factory=list[Match])
    firings: list[Firing] = field(default_factory=list[Firing])
    units: Scalars = field(init=False)
    """From ``units_of``."""
    allowed: Scalars = field(init=False)
    """From ``allowed_on``."""
    most: tuple[float, float] = field(init=False)
    """The most that is allowed, mm and degrees."""

    def __post_init__(self) -> None:
        """Keep what all lines have in common."""
        self.units = units_of(self.installation)
        self.allowed = allowed_on(self.units, self.installation)
        slides = self.units == 1.0
        self.most = float(self.allowed[slides].max(initial=0.0)), float(self.allowed[~slides].max(initial=0.0))

    @property
    def capability(self) -> Capability:
        """What the language can time, and its steps."""
        return self.rebuilt.capability

    @property
    def read(self) -> tuple[ReadStep, ...]:
        """Steps that were read."""
        return self.rebuilt.steps

    def agreement(self) -> Agreement:
        """Give what was found."""
        return Agreement(
            tuple(self.differences),
            self.place_mm,
            self.turn_deg,
            self.event_s,
            tuple(self.matches),
            tuple(self.firings),
        )

    def differ(self, message: str, made_by: Source, step: int | None = None) -> None:
        """Add a difference at a step that was read; at the last one if that is not given."""
        at = max(self.at - 1, 0) if step is None else step
        self.differences.append(Difference(message, self.rebuilt.place(at), made_by))

    def is_same_pose(self, planned: Pose, read: Pose) -> bool:
        """Whether poses agree; keeps how far they are apart."""
        apart_mm, apart_deg = distance(planned, read), degrees(angle(planned, read))
        self.place_mm, self.turn_deg = max(self.place_mm, apart_mm), max(self.turn_deg, apart_deg)
        return apart_mm <= POSE_MM and apart_deg <= POSE_DEG


def is_same_pose(one: Pose, other: Pose) -> bool:
    """Whether poses agree."""
    return distance(one, other) <= POSE_MM and degrees(angle(one, other)) <= POSE_DEG
