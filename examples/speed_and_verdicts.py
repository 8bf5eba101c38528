"""The effect of one speed on the verdicts: plan and analyse a board at several speeds of one template.

python examples/speed_and_verdicts.py [BOARD] [TEMPLATE] [SPEED ...]
"""

import sys
from collections import Counter
from pathlib import Path

from boards.load import load_board
from cleaning.analyse import analyse
from cleaning.parameters.load import load_parameters
from recipes.load import load_recipe
from rulesengine.planning.pipeline import run


def main(board: str = "tiny", template: str = "around", *speeds_mm_s: str) -> None:
    """Print time and verdicts for each speed of a template."""
    loaded, recipe, parameters = load_board(Path(board)), load_recipe("smt-aqueous"), load_parameters()
    before = None
    for speed_mm_s in map(float, speeds_mm_s or ("60", "30", "15")):
        spec = recipe.templates[template].model_copy(update={"speed_mm_s": speed_mm_s})
        changed = recipe.model_copy(update={"templates": {**recipe.templates, template: spec}})
        before = run(changed, loaded, before=before)  # strokes of templates that stay as they are are not planned again
        report = analyse(before.program, loaded, changed, parameters)
        verdicts = Counter(part.verdict for part in report.parts)
        counts = ", ".join(f"{count} {verdict}" for verdict, count in sorted(verdicts.items()))
        print(f"{template} at {speed_mm_s:g} mm/s: {before.program.totals.duration_s:.0f} s, {counts}")


if __name__ == "__main__":
    main(*sys.argv[1:])
