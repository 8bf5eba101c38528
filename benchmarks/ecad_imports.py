"""Time the import of a board of 2,400 parts as IPC-2581, as an ODB++ job and as Gerber X2 with a placement table.

Run: ``OMP_NUM_THREADS=1 python benchmarks/ecad_imports.py [--parts 2400] [--rounds 3] [--large 100]``

Chips for the most part, with ICs of up to 100 pins, on both sides; with the copper of all pins, by which rotations are
understood. Prints the processor time of each format, the fastest of the rounds, against its bound, and how much longer
a part takes than on a board of an eighth of the size. The board has the same components in all three formats.

Then the sample boards as Gerber layers with a centroid, with and without a netlist, against KiCad's files of them: the
share of the components with the same side, place, turn, plan and height, at least 95 % each.

With ``--large`` instead: files of that many MB of each family, grown by copper, nets or rows, and of an eighth of it,
each read in a process of its own: processor time, peak memory, and how much longer a byte takes in the larger one.
"""

import argparse
import itertools
import random
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from shapely import box

sys.path.insert(0, str(Path(__file__).parents[1] / "tools"))
sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from ecad_writers import (
    EcadBoard,
    EcadPart,
    allegro,
    gencad,
    gerber_copper,
    gerber_profile,
    ipc2581,
    odb,
    placement_table,
    write_tgz,
)
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
    parser.add_argument("--large", type=float, metavar="MB")
    parser.add_argument("--measure", type=Path, nargs="+", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.measure:
        measure(*given.measure)
        return 0
    if given.large:
        return measure_large(given.large)
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


def measure(file: Path, table: Path | None = None) -> None:
    """Print processor time in s, peak memory in MB and the number of components of one import."""
    load_board(Path("tiny"))  # imports the libraries
    begun = time.process_time()
    board = load_board(file, table)
    seconds = time.process_time() - begun
    print(seconds, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0, len(board.components))


def measure_large(mb: float) -> int:
    """Print what files of so many MB of each family take; 0 if none takes much longer for a byte than a smaller one."""
    kept = True
    for kind in _SWOLLEN:
        found: list[tuple[float, float, float]] = []
        for size in (mb / 8.0, mb):
            with tempfile.TemporaryDirectory() as name:
                files, own = _SWOLLEN[kind](Path(name), size * 1e6)
                made = sum(each.stat().st_size for each in own) / 1e6
                words = [sys.executable, __file__, "--measure", *map(str, files)]
                run = subprocess.run(words, capture_output=True, text=True, check=False)
            if run.returncode:
                print(f"{kind:10} {made:6.1f} MB: {run.stderr.strip().splitlines()[-1]}", flush=True)
                break
            seconds, peak, count = map(float, run.stdout.split())
            found.append((seconds, made, peak))
            print(f"{kind:10} {made:6.1f} MB {seconds:7.2f} s {peak:7.0f} MB, {count:.0f} components", flush=True)
        else:
            growth = found[1][0] / found[1][1] / (found[0][0] / found[0][1])
            print(f"{kind:10} a byte takes {growth:.2f} times as long", flush=True)
            kept = kept and growth < _MOST_GROWTH
    return 0 if kept else 1


_MOST_GROWTH = 2.0


def spots(count: int) -> Iterator[tuple[float, float, float, float]]:
    """Ends of tracks on the board, mm."""
    chosen = random.Random(2)
    for _ in range(count):
        x, y = chosen.uniform(20.0, 60.0), chosen.uniform(20.0, 40.0)
        yield x, y, x + 1.0, y + 0.5


def grown(file: Path, text: str, before: str, line: str, size: float) -> Path:
    """Write a text with lines before a mark, until it has so many bytes; they hold the ends of a track."""
    head, mark, tail = text.rpartition(before)
    count = max(int((size - len(text)) / len(line.format(30.0, 30.0, 31.0, 30.5))), 1)
    with file.open("w") as out:
        out.write(head)
        for ends in spots(count):
            out.write(line.format(*ends))
        out.write(mark + tail)
    return file


Made = tuple[tuple[Path, ...], tuple[Path, ...]]
"""What is loaded, and the files that are counted."""


def _grown_ipc2581(folder: Path, size: float) -> Made:
    line = (
        '<Set><Features><Polyline><PolyBegin x="{:.5f}" y="{:.5f}"/><PolyStepSegment x="{:.5f}" y="{:.5f}"/></Polyline>'
        "</Features></Set>\n"
    )
    file = grown(folder / "b.xml", ipc2581(make_board(300), copper=True), "</LayerFeature><LayerFeature", line, size)
    return (file,), (file,)


def _grown_odb(folder: Path, size: float) -> Made:
    files = odb(make_board(300))
    files["steps/card/eda/data"] += "NET N1\n" + "".join(f"FID C 1 {number}\n" for number in range(int(size / 2 / 14)))
    lines = (f"L {x:.5f} {y:.5f} {u:.5f} {v:.5f} 0 P 0\n" for x, y, u, v in spots(int(size / 2 / 46)))
    files["steps/card/layers/top/features"] = "".join(lines)
    for name, text in files.items():
        (folder / "job" / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / "job" / name).write_text(text)
    return (folder / "job",), tuple(folder / "job" / name for name in files)


def _grown_gerber(folder: Path, size: float) -> Made:
    (folder / "layers").mkdir()
    board = make_board(300)
    (folder / "layers" / "edge.gbr").write_text(gerber_profile(board))
    line = "G01*\nX{0:.0f}000000Y{1:.0f}000000D02*\nX{2:.0f}500000Y{3:.0f}250000D01*\n"
    copper = gerber_copper(board, "top").replace("M02*", "%TD*%\nM02*")
    file = grown(folder / "layers" / "top.gbr", copper, "M02*", line, size)
    table = folder / "places.csv"
    table.write_text(placement_table(board))
    return (folder / "layers", table), (file,)


def _grown_pads(folder: Path, size: float) -> Made:
    layers, table = _grown_gerber(folder, 0.0)[0]
    line = "X{0:.0f}000000Y{1:.0f}000000D03*\n"
    copper = gerber_copper(make_board(300), "top").replace("M02*", "%TD*%\nM02*")
    file = grown(layers / "top.gbr", copper, "M02*", line, size)
    return (layers, table), (file,)


def _grown_kicad(folder: Path, size: float) -> Made:
    line = '(segment (start {:.4f} -{:.4f}) (end {:.4f} -{:.4f}) (width 0.2) (layer "F.Cu") (net 1))\n'
    file = grown(folder / "b.kicad_pcb", kicad_board(SENSOR_HUB), ")", line, size)
    return (file,), (file,)


def _grown_eagle(folder: Path, size: float) -> Made:
    corpus = Path(__file__).parents[1] / "tests" / "boards" / "data" / "small.brd"
    line = '<wire x1="{:.4f}" y1="{:.4f}" x2="{:.4f}" y2="{:.4f}" width="0.2" layer="1"/>\n'
    file = grown(folder / "b.brd", corpus.read_text(), "</plain>", line, size)
    return (file,), (file,)


def _grown_gencad(folder: Path, size: float) -> Made:
    line = "ROUTE N1\nTRACK T1\nLINE {:.5f} {:.5f} {:.5f} {:.5f}\n"
    file = grown(folder / "b.cad", gencad(make_board(300), "MM"), "$ENDROUTES", line, size)
    return (file,), (file,)


def _grown_allegro(folder: Path, size: float) -> Made:
    """Its files hold parts, pins and the edge alone."""
    count, file = 100, folder / "b.fab"
    each = len(allegro(make_board(count), "MILLIMETERS")) / count
    file.write_text(allegro(make_board(min(int(size / each), 20_000)), "MILLIMETERS"))
    return (file,), (file,)


def _grown_netlist(folder: Path, size: float) -> Made:
    order = write_order(SENSOR_HUB, folder / "order")
    line = "317GND              VIA         D0118PA00X+{0:06.0f}Y+{1:06.0f}X0276Y0000R000S3\n"
    file = grown(order / "card.ipc", (order / "card.ipc").read_text(), "999", line, size)
    return (order,), (file,)


def _grown_table(folder: Path, size: float) -> Made:
    order = write_order(SENSOR_HUB, folder / "order")
    file, rows = order / "bom.csv", itertools.count(1)
    with file.open("w") as out:
        out.write("Designator,Value,Footprint,Manufacturer Part Number\n")
        while out.tell() < size:
            out.write("".join(f"Z{next(rows)},10k,R_0603,RC0603FR-0710KL\n" for _ in range(1000)))
    return (order,), (file,)


_SWOLLEN = {
    "IPC-2581": _grown_ipc2581,
    "ODB++": _grown_odb,
    "Gerber": _grown_gerber,
    "pads": _grown_pads,
    "KiCad": _grown_kicad,
    "Eagle": _grown_eagle,
    "GenCAD": _grown_gencad,
    "Allegro": _grown_allegro,
    "netlist": _grown_netlist,
    "table": _grown_table,
}
"""By family, what writes a file of so many bytes into a folder."""


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


def make_board(count: int) -> EcadBoard:
    """A board of so many parts in columns, on both sides."""
    chosen = random.Random(1)
    parts: list[EcadPart] = []
    for number in range(count):
        package, width, depth, height, pins = chosen.choices(list(_KINDS), list(_KINDS.values()))[0]
        x, y = _RIM_MM + number % _COLUMNS * _PITCH_MM, _RIM_MM + number // _COLUMNS * _PITCH_MM
        turn, side = 90.0 * chosen.randrange(4), "top" if chosen.random() < 0.6 else "bottom"
        parts.append(EcadPart(f"U{number}", x, y, width, depth, height, turn, side, package, pins))
    edge = box(0.0, 0.0, 2 * _RIM_MM + _COLUMNS * _PITCH_MM, 2 * _RIM_MM + (1 + count // _COLUMNS) * _PITCH_MM)
    return EcadBoard(edge, 1.6, tuple(parts))


def write(folder: Path, count: int) -> dict[str, tuple[Path, Path | None]]:
    """Write a board in each format; its file or folder, and the table that goes with it."""
    board = make_board(count)
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
