"""Reports to keep: the program, a picture, the plan as data, the analysis as a page with what an operator states.

python examples/12_reports.py [BOARD] [FOLDER]
"""

import sys
from pathlib import Path

import washboard as wb
from cleaning.report import Traceability


def main(board: str = "tiny", folder: str = "reports") -> None:
    """Write everything that a job leaves into a folder."""
    place = Path(folder)
    place.mkdir(exist_ok=True)
    plan = wb.plan(board, "rinse-only")
    plan.save(place / "job.wash", picture=place / "paths.svg", report=place / "plan.json")
    opened = wb.open_program(place / "job.wash")
    wb.analyse(opened).html(place / "cleaning.html", Traceability(serial="A-0001", detergent="lot 7"))
    print(", ".join(sorted(each.name for each in place.iterdir())))


if __name__ == "__main__":
    main(*sys.argv[1:])
