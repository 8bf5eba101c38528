"""A made-up table of measured cleanliness for parts of an analysed board: no measurement, and no echo of the model.

The share of residue that a tear-off shows is, for each part, 40 % of the way along the ranks of the predicted residue,
plus normal noise of 10 %; every eighth part has instead a share that is drawn without regard to the prediction. Limits
are 20 %. The seed makes the same table again.
"""

import numpy as np

from cleaning.verdicts.results import CleaningReport

LIMIT_PCT = 20.0


def measured_table(report: CleaningReport, *, parts: int, seed: int) -> str:
    """Write the table of so many parts with a gap, every second in the board's order and then the others."""
    random = np.random.default_rng(seed)
    gapped = [part for part in report.parts if part.residue is not None]
    chosen = [*gapped[::2], *gapped[1::2]][:parts]
    ranks = np.argsort(np.argsort([part.residue for part in chosen], kind="stable"), kind="stable") / (parts - 1)
    lines = ["# synthetic: made by tests/support/measured_sample.py", "component,method,value,unit,limit"]
    for number, (part, rank) in enumerate(zip(chosen, ranks, strict=True)):
        share = 100.0 * random.random() if number % 8 == 7 else 40.0 * rank + 10.0 * random.standard_normal()
        lines.append(f"{part.component},tear-off,{min(max(share, 0.0), 100.0):.2f},%,{LIMIT_PCT:g}")
    return "\n".join(lines) + "\n"
