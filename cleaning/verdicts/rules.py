"""Registry of the verdict rules: id, title, meaning, grade, and the verdicts that each may give."""

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

Grade: TypeAlias = Literal["A", "B", "C"]
"""A: geometry and balances; B: physics, parameters of the literature; C: uncalibrated kinetics, proposed limits."""
Verdict: TypeAlias = Literal["clean", "marginal", "dirty", "no verdict", "avoided"]
"""As predicted. ``no verdict``: outside of what the model holds for. ``avoided``: a mask keeps the jet off it."""
VERDICTS: tuple[Verdict, ...] = ("dirty", "marginal", "no verdict", "clean", "avoided")
"""Worst first."""
Outcome: TypeAlias = Verdict | Literal["clean, wet"]
"""What becomes of a component: how clean it comes out, and apart from that whether it stays wet where it is clean."""
OUTCOMES: tuple[Outcome, ...] = ("dirty", "marginal", "clean, wet", "no verdict", "clean", "avoided")
"""Worst first: water that is left is near a limit too."""
_PAGE = "docs/cleaning.md"


@dataclass(frozen=True, slots=True, order=True)
class Rule:
    """One rule of the verdicts. Rules are equal, and ordered, by their ids."""

    id: str
    """``"R1"``, ``"R2"`` and so on, as reports have it."""
    title: str = field(compare=False)
    """Name of the rule's judgements, unless they distinguish variants: ``"missed"`` or ``"shadowed"``."""
    meaning: str = field(compare=False)
    """What it looks for, in one sentence."""
    grade: Grade = field(compare=False)
    """What it rests on."""
    verdicts: tuple[Verdict, ...] = field(compare=False)
    """Verdicts that its judgements may carry, worst first."""

    def __str__(self) -> str:
        """Give the id."""
        return self.id

    @property
    def page(self) -> str:
        """Place in the documentation."""
        return f"{_PAGE}#{self.id.lower()}"


MISSED = Rule("R1", "missed", "An exposed surface is never hit by the jet.", "A", ("dirty", "marginal"))
UNDER_EXPOSED = Rule(
    "R2",
    "under-exposed",
    "Too little solution lands on an exposed surface or flows over it, or the wave front passes too quickly.",
    "C",
    ("dirty", "marginal", "clean"),
)
DAMAGE_RISK = Rule("R3", "damage risk", "The jet presses harder than a component is stated to bear.", "A", ("dirty",))
DRY_GAP = Rule(
    "R4", "dry gap", "No edge is pressed hard enough to drive the liquid into the gap: it stays dry.", "B", ("dirty",)
)
PLUGGED_GAP = Rule("R5", "plugged", "Residue fills the gap so far that nothing flows through.", "B", ("dirty",))
NOT_FLUSHED = Rule(
    "R6",
    "not flushed",
    "The liquid in the gap is renewed too seldom to carry the residue away.",
    "B",
    ("dirty", "marginal"),
)
RESIDUE_LEFT = Rule(
    "R7",
    "residue",
    "More residue is left under the part than is allowed, on average or in its worst tenth.",
    "C",
    ("dirty", "marginal", "clean"),
)
ONE_SIDED = Rule(
    "R8",
    "one-sided",
    "Part of the gap is flushed from no side: a pass is missing on the side that is named.",
    "B",
    ("marginal",),
)
SPENT_BATH = Rule(
    "R9", "change bath", "The bath carries more non-volatile residue than is allowed.", "B", ("marginal",)
)
INCOMPLETE_RINSE = Rule(
    "R10",
    "incomplete rinse",
    "Rinse water is renewed too seldom under the part, or is not pure enough.",
    "B",
    ("dirty", "marginal"),
)
IONIC_RESIDUE = Rule(
    "R11",
    "ionic",
    "The estimated ionic index is above the limit that you set; without one the rule does not apply.",
    "C",
    ("dirty",),
)
WET_GAP = Rule(
    "R12",
    "wet under part",
    "Blow-off does not clear the gap, and what is left needs longer to evaporate than the board stays warm.",
    "B",
    ("marginal", "clean"),
)
PROCESS_WINDOW = Rule(
    "R13",
    "process",
    "A temperature, a concentration, the flux or a material does not suit the solution or the component.",
    "B",
    ("dirty", "marginal"),
)
MODEL_LIMIT = Rule(
    "R14",
    "model limit",
    "The case lies outside of what the model holds for: no verdict is given.",
    "A",
    ("no verdict",),
)
AVOIDED = Rule(
    "R15",
    "avoided",
    "A mask keeps the jet off the component: it is not to be cleaned, and what reaches it all the same is stated.",
    "A",
    ("avoided",),
)

RULES: tuple[Rule, ...] = tuple(each for each in tuple(globals().values()) if isinstance(each, Rule))
"""All of them, in the order of this file."""
