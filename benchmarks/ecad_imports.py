"""Time the import of a board of 2,400 parts as IPC-2581, as an ODB++ job and as Gerber X2 with a placement table.

Run: ``OMP_NUM_THREADS=1 python benchmarks/ecad_imports.py [--parts 2400] [--rounds 3]``

Chips for the most part, with ICs of up to 100 pins, on both sides; with the copper of all pins, by which rotations are
understood. Prints the processor time of each format, the fastest of the rounds, against its bound, and how much longer
a part takes than on a board of an eighth of the size. The board has the same components in all three formats.

Then the sample boards as Gerber layers with a centroid, with and without a netlist, against KiCad's files of them: the
share of the components with the same side, place, turn, plan and height, at least 95 % each.
"""

import argparse
import random
import sys
import tempfile
import time
from pathlib import Path

from shapely import box

sys.path.insert(0, str(Path(__file__).parents[1] / "tools"))
sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from ecad_writers import EcadBoard, EcadPart, gerber_copper, gerber_profile, ipc2581, odb, placement_table, write_tgz
from sample_boards.radio_stick import RADIO_STICK
from sample_boards.sensor_hub import SENSOR_HUB
from sample_boards.smt_demo import SMT_DEMO
from sample_boards.two_sided import TWO_SIDED
from sample_exports import agreement, kicad_board, write_order

from boards.board import Board
from boards.load import load_board

MOST_S = 3.0
LEAST_ALIKE = 0.95
_COLUMNS, _PITCH_MM, _RIM_MM = 60, 6.0, 6.0
_KINDS = {
    ("R0402", 1.0, 0.5, 0.35, 2): 30,
    ("C0402", 1.0, 0.5, 0.5, 2): 30,
    ("C0603", 1.6, 0.8, 0.8, 2): 12,
    ("R0603", 1.6, 0.8, 0.45, 2): 10,
    ("SOT23-3", 2.9, 1.6, 1.1, 3): 8,
    ("SOIC-8", 4.9, 3.9, 1.7, 8): 6,
    ("QFN-32", 5.0, 5.0, 0.9, 32): 3,
    ("LGA-100", 5.5, 5.5, 1.4, 100): 1,
}
"""Package, width, depth, height, pins; how many of a hundred parts have it."""


def main() -> int:
    """Measure; 0 if all formats and samples keep to the bounds."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parts", type=int, default=2400)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        small, large = write(Path(name) / "small", given.parts // 8), write(Path(name) / "large", given.parts)
        load_board(Path("tiny"))  # imports the libraries
        kept, found = True, dict[str, list[tuple[str, str]]]()
        for kind, (file, table) in large.items():
            seconds, board = fastest(file, table, given.rounds)
            few_s, few = fastest(*small[kind], given.rounds)
            growth = seconds / len(board.components) / (few_s / len(few.components))
            print(
                f"{kind:10} {len(board.components):,} parts {seconds:5.2f} s (at most {MOST_S:g}); "
                f"a part takes {growth:.2f} times as long as of {len(few.components)}",
                flush=True,
            )
            kept = kept and seconds <= MOST_S
            found[kind] = sorted((each.name, each.side) for each in board.components)
        same = all(each == found["IPC-2581"] for each in found.values())
        print(f"the same components: {'yes' if same else 'NO'}")
        alike = compare_samples(Path(name))
        return 0 if kept and same and alike else 1


def compare_samples(folder: Path) -> bool:
    """Print what sample boards have alike as KiCad's file and as an order; whether all keep to the bound."""
    least = 1.0
    for sample in (SENSOR_HUB, RADIO_STICK, TWO_SIDED, SMT_DEMO):
        file = folder / f"{sample.name}.kicad_pcb"
        file.write_text(kicad_board(sample))
        right = load_board(file)
        for words, is_named in (("with a netlist", True), ("without one", False)):
            order = write_order(sample, folder / sample.name / words, is_named=is_named)
            shares = agreement(sample, right, load_board(order))
            least = min(least, *shares.values())
            found = ", ".join(f"{key} {100.0 * share:.1f} %" for key, share in shares.items())
            print(f"{sample.name:11} {words:14} {len(right.components):3} components: {found}", flush=True)
    return least >= LEAST_ALIKE


def write(folder: Path, count: int) -> dict[str, tuple[Path, Path | None]]:
    """Write a board in each format; its file or folder, and the table that goes with it."""
    chosen = random.Random(1)
    parts: list[EcadPart] = []
    for number in range(count):
        package, width, depth, height, pins = chosen.choices(list(_KINDS), list(_KINDS.values()))[0]
        x, y = _RIM_MM + number % _COLUMNS * _PITCH_MM, _RIM_MM + number // _COLUMNS * _PITCH_MM
        turn, side = 90.0 * chosen.randrange(4), "top" if chosen.random() < 0.6 else "bottom"
        parts.append(EcadPart(f"U{number}", x, y, width, depth, height, turn, side, package, pins))
    edge = box(0.0, 0.0, 2 * _RIM_MM + _COLUMNS * _PITCH_MM, 2 * _RIM_MM + (1 + count // _COLUMNS) * _PITCH_MM)
    board = EcadBoard(edge, 1.6, tuple(parts))
    gerber, table = folder / "gerber", folder / "places.csv"
    gerber.mkdir(parents=True)
    (folder / "board.xml").write_text(ipc2581(board, copper=True))
    write_tgz(odb(board), folder / "board.tgz")
    (gerber / "edge.gbr").write_text(gerber_profile(board))
    for side in ("top", "bottom"):
        (gerber / f"{side}.gbr").write_text(gerber_copper(board, side))
    table.write_text(placement_table(board))
    return {
        "IPC-2581": (folder / "board.xml", None),
        "ODB++": (folder / "board.tgz", None),
        "Gerber X2": (gerber, table),
    }


def fastest(file: Path, table: Path | None, rounds: int) -> tuple[float, Board]:
    """Processor time of the fastest round, s, and the board."""
    times: list[float] = []
    board = None
    for _ in range(rounds):
        begun = time.process_time()
        board = load_board(file, table)
        times.append(time.process_time() - begun)
    if board is None:
        raise ValueError("no round")
    return min(times), board


if __name__ == "__main__":
    raise SystemExit(main())
