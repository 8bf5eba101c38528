"""Tune a recipe until every component is predicted clean, in little time.

python examples/10_tune.py [BOARD] [RECIPE] [ANALYSES] [NEW.yaml]
"""

import sys

import washboard as wb


def main(board: str = "tiny", recipe: str = "smt-aqueous", analyses: str = "6", new: str = "tuned.yaml") -> None:
    """Tune, print what each trial came to, and write the best recipe."""
    best = wb.tune(wb.plan(board, recipe), analyses=int(analyses))
    for number, trial in enumerate(best.trials, start=1):
        figures = trial.figures
        print(f"  {number}: {figures.clean_components} clean, {figures.seconds:.0f} s, {figures.litres:.2f} l")
    print(f"{'clean' if best.clean else 'not clean'}; written {best.recipe.save(new)}")


if __name__ == "__main__":
    main(*sys.argv[1:])
