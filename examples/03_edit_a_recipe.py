"""Edit a recipe: another speed, checked as its file is; the comments stay.

python examples/03_edit_a_recipe.py [RECIPE] [PATH] [VALUE] [NEW.yaml]
"""

import sys

import washboard as wb


def main(
    recipe: str = "smt-aqueous", path: str = "templates.around.speed_mm_s", value: str = "30", new: str = "mine.yaml"
) -> None:
    """Write a recipe with one other value, and show what a wrong one gives."""
    opened = wb.open_recipe(recipe)
    edited = opened.edit(path, float(value))
    print(f"{path} is {value}; comments kept: {edited.text.count('#')} of {opened.text.count('#')}")
    print(f"written {edited.save(new)}")
    try:
        opened.edit(path, -5)
    except wb.JobError as error:
        print(f"refused: {error}")


if __name__ == "__main__":
    main(*sys.argv[1:])
