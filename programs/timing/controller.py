"""What a controller does with the lines of a program: its limits, how it passes corners, what it can hold."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import inf
from typing import Literal, TypeAlias

Blending: TypeAlias = Literal["zone", "overlap", "tolerance"]
"""How the end of a line that is passed is written, and what is done there.

``zone``: so many mm before the corner the path turns into a parabola, at most half of either line; as fast as the
accelerations allow.
``overlap``: this share of the speed is kept: one line ends while the next begins, whatever that leaves of the corner.
``tolerance``: the path leaves the corner by so many mm at most (G64 P).
"""

_NO_SOURCES: Mapping[str, str] = {}


@dataclass(frozen=True, slots=True)
class Controller:
    """The model of one controller. What a program's text states counts instead; joints have limits of their own."""

    blending: Blending
    acceleration_mm_s2: float = inf
    """Of the orifice; infinite where only the joints limit it."""
    rise_s: float = 0.0
    """In which an acceleration builds up; 0 where the jerk has no limit."""
    turn_speed_deg_s: float = inf
    """Of the tool."""
    turn_acceleration_deg_s2: float = inf
    """Of the tool."""
    joint_speed_share: float = 1.0
    """Of the joints' greatest speeds, by joint motions that state none."""
    settle_s: float = 0.0
    """At the end of a line or joint motion that stops, until the next one begins."""
    look_ahead: int = 1000
    """Lines after the one that runs that are planned: within those it must be able to stop."""
    least_line_s: float = 0.0
    """Shortest time of a line: shorter ones slow the robot down."""
    blend_acceleration_share: float = 1.0
    """Of the accelerations, where a line is passed at whose end a turning axis moves, in both lines beside it."""
    stops_in_turning_line: bool = False
    """Whether those two lines must be able to start and stop within their own lengths."""
    times_are_whole: bool = False
    """Whether a time that a line states in place of a speed is that from rest to rest, ramps included."""
    most_positions: int = 0
    """Motions that a file or routine may have; 0 where no limit is known."""
    most_lines: int = 0
    """Lines of text of a file."""
    most_bytes: int = 0
    """Bytes of a file."""
    sources: Mapping[str, str] = field(default_factory=lambda: _NO_SOURCES)
    """Where the numbers come from, by word; what is not here is assumed."""

    def with_values(self, values: Mapping[str, float | int], source: str) -> "Controller":
        """Use the numbers of a cell instead.

        Args:
            values: By the names of the attributes.
            source: Where they come from.
        """
        changed = replace(self, sources={**self.sources, **dict.fromkeys(values, source)})
        return replace(changed, **values)  # pyright: ignore[reportArgumentType]

    def source(self, word: str) -> str:
        """Where a number comes from."""
        return self.sources.get(word, "assumed")


ARM = Controller(
    blending="zone",
    acceleration_mm_s2=2000.0,
    turn_acceleration_deg_s2=1800.0,
    joint_speed_share=0.1,
    settle_s=0.05,
    look_ahead=10,
    least_line_s=0.008,
)
"""Of an arm whose controller states no more; all assumed."""
