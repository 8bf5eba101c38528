"""A study: one board at several speeds, computed in this process, with a table and a page.

python examples/11_study.py [BOARD] [FOLDER]
"""

import sys
from pathlib import Path

import washboard as wb

STUDY = """study: speeds
boards: [{{board: {board}}}]
recipes: [rinse-only]
variables: [{{path: templates.sweep.speed_mm_s, values: [40, 80]}}]
"""


def main(board: str = "tiny", folder: str = "speeds") -> None:
    """Write a study, compute it, and say where its page is."""
    Path("speeds.yaml").write_text(STUDY.format(board=board), "utf-8")
    done = wb.study("speeds.yaml", folder)
    print(f"{len(done.cases)} combinations, {done.computed} jobs computed; {done.page}")
    again = wb.study("speeds.yaml", folder)
    print(f"begun again: {again.computed} jobs left")


if __name__ == "__main__":
    main(*sys.argv[1:])
