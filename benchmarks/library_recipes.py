"""The library recipes against what tuning makes of them: seconds and litres on every sample board.

Run: ``OMP_NUM_THREADS=1 python benchmarks/library_recipes.py [--analyses 40] [--write] [BOARD ...]``

The reference is ``washboard tune BOARD smt-aqueous``, which begins with the library's recipe: its shortest program for
which every requirement that a recipe can meet is met. ``--write`` keeps its seconds and litres in
``tests/golden/tuned.json``, to which the test holds the library.
"""

import argparse
import json
import sys
import time
from pathlib import Path

from boards.load import board_library, load_board
from cleaning.parameters.load import load_parameters
from cleaning.prepared_board import prepare
from recipes.load import recipe_library
from rulesengine.tuning.trial.request import AllowedChanges, ProgramLimits, TuningRequest, TuningResult
from rulesengine.tuning.trial.trial_runner import TrialRunner
from rulesengine.tuning.tune import tune
from rulesengine.tuning.variables import CHANGE_KINDS
from specs.progress import no_progress

TUNED = Path(__file__).parents[1] / "tests" / "golden" / "tuned.json"
ALLOWED = AllowedChanges(frozenset(CHANGE_KINDS) - {"pressure", "temperature"})
RECIPE = "smt-aqueous"


def tuned_on(board: str, analyses: int) -> TuningResult:
    """Tune the default recipe on a sample board."""
    prepared = prepare(load_board(board_library()[board]), load_parameters(), no_progress)
    file = recipe_library()[RECIPE]
    request = TuningRequest("clean", ProgramLimits(), ALLOWED, analyses)
    return tune(TrialRunner(file, prepared, "clean", analyses), file.read_text("utf-8"), request)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("boards", nargs="*", default=[], metavar="BOARD")
    parser.add_argument("--analyses", type=int, default=40)
    parser.add_argument("--write", action="store_true", help="keep what tuning reached for the test")
    asked = parser.parse_args()
    reached: dict[str, dict[str, float]] = {}
    print(
        f"{'board':12} {'clean':>9} {'library':>16} {'tuned':>16} {'time':>6} {'litres':>6} {'analyses':>9} {'took':>7}"
    )
    for board in asked.boards or board_library():
        begin = time.perf_counter()
        found = tuned_on(board, asked.analyses)
        took = time.perf_counter() - begin
        first, last = found.first.figures, found.last.figures
        reached[board] = {"seconds": round(last.seconds, 1), "litres": round(last.litres, 2)}
        print(
            f"{board:12} {f'{last.clean_components}/{found.last.total}':>9} "
            f"{f'{first.seconds:.0f} s {first.litres:.1f} l':>16} {f'{last.seconds:.0f} s {last.litres:.1f} l':>16} "
            f"{first.seconds / last.seconds:6.2f} {first.litres / last.litres:6.2f} {found.used:9} {took:6.0f} s",
            flush=True,
        )
    if asked.write:
        known = json.loads(TUNED.read_text("utf-8")) if TUNED.exists() else {}
        TUNED.write_text(json.dumps(dict(sorted((known | reached).items())), indent=2) + "\n", "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
