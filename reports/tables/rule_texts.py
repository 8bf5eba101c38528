"""What a person must know to read a cleaning report: the grades, how values are known, what is left out."""

from cleaning.parameters.model import Known
from cleaning.verdicts.rules import Grade, Verdict

GRADES: dict[Grade, str] = {
    "A": "geometry and balances",
    "B": "physics, with parameters from the literature or proposed",
    "C": "removal kinetics: for ranking only, until they are calibrated",
}

VERDICT_WORDS: dict[Verdict, str] = {
    "dirty": "is predicted to stay dirty",
    "marginal": "is near a limit",
    "no verdict": "is outside of what the model holds for",
    "clean": "is predicted to be clean",
}

KNOWN_WORDS: dict[Known, str] = {
    "source": "read in a source",
    "derived": "calculated",
    "literature": "believed from the literature, unchecked",
    "proposed": "proposed by us",
    "calibrated": "fitted to your measurements",
    "synthetic": "fitted to made-up data",
}

CAVEAT = (
    "This is a prediction and no proof of cleanliness. Qualify the process by surface insulation resistance (SIR) or "
    "ion chromatography (IC) on coupons that stand for the board."
)
UNCALIBRATED = "Its removal kinetics are uncalibrated: take it as a ranking of components, not as amounts."
CALIBRATED = "Its removal kinetics were fitted to measurements that the parameter set names."
SYNTHETIC = "Some of its parameters were fitted to made-up data: it demonstrates the method and nothing else."

LIMITS: tuple[str, ...] = (
    "No constant of the kinetics and none of the edge pressure has been checked by experiment. The pressure that the "
    "film raises at the edge of a component is the most uncertain link; film depth, its decay and its retention can "
    "change a residue by a factor of two to four.",
    "Contact angles and surface tensions are typical values. Measure those of your solution, board and flux.",
    "Not in the model: foam and splashing, bubbles that are trapped, puddles around tall parts, residue that settles "
    "again elsewhere, a cleaning agent that is used up, flux that hardened in a long reflow, flux that flows unlike "
    "water, capillary bridges at the necks of balls, a board that bends.",
    "Solder balls count as cylinders of their mean diameter.",
    "The ionic index is an estimate from dilution. It cannot be compared with an extract (ROSE) or with IC.",
    "Surfaces inside of connectors, under shields and in blind holes are not judged; their area is given as hidden.",
    "The influence of washing time on residue is stronger here than in the one published study of it.",
)
