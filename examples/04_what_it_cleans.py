"""What a program cleans: the verdict on each component, and one of them in detail.

python examples/04_what_it_cleans.py [BOARD] [RECIPE] [COMPONENT]
"""

import sys

import washboard as wb


def main(board: str = "tiny", recipe: str = "smt-aqueous", component: str = "U1") -> None:
    """Analyse a plan, and print the verdicts, the worst rule and the residue."""
    clean = wb.analyse(wb.plan(board, recipe))
    print(f"the worst verdict is {clean.verdict}")
    for each in clean.verdicts:
        residue = "" if each.residue is None else f", {each.residue:.1%} left under it"
        print(f"  {each.component}: {each.outcome}, by {each.rule}{residue}")
    for judgement in clean.component(component).judgements:
        print(f"{component}: {judgement.name} {judgement.verdict}")


if __name__ == "__main__":
    main(*sys.argv[1:])
