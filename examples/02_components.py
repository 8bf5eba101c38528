"""What was understood of a board: its components as a table.

python examples/02_components.py [BOARD]
"""

import sys

import washboard as wb


def main(board: str = "tiny") -> None:
    """Print a line for each component, the tallest first."""
    opened = wb.open_board(board)
    print(f"{opened.name}: {len(opened.components)} components")
    for each in sorted(opened.components, key=lambda component: -component.height_mm):
        print(f"  {each.name:6} {each.package or 'no package':28} {each.side:6} {each.height_mm:5.2f} mm high")


if __name__ == "__main__":
    main(*sys.argv[1:])
