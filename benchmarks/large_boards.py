"""Plan, check, analyse and export boards of up to 5,000 parts: time, peak memory, what is written, and their growth.

Run: ``OMP_NUM_THREADS=1 python benchmarks/large_boards.py [--sizes 1250,2500,5000] [--keep FOLDER]``

Every command runs as it is started from a terminal, in a process of its own, with all it reads and writes: ``plan``
with its report, ``check`` in the gantry of the library, its travel, frame and table as large as the board needs, with
its report and the program as the robot does it, ``analyse`` with its data and its report, and ``export`` in three
languages. The boards are those of ``generated_boards.py``.

Processor time (user and system) is the measure, since other users disturb the clock. A second table has exponents of
seconds, peak memory and bytes: the slopes of their logarithms over that of the parts, by least squares over all sizes.
The last row is that of n log n.
"""

import argparse
import math
import os
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tools"))

import numpy as np
from generated_boards import generated_board
from ruamel.yaml import YAML

from boards.formats.tri.tri import write_tri

_ROOT = Path(__file__).parents[1]
_START = "from commandline.start import main; main()"
_RECIPE = "smt-aqueous"
_LANGUAGES = {
    "linuxcnc": ["-o", "linuxcnc"],
    "joint-table": ["-o", "joints.csv"],
    "ur": ["-o", "ur", "--without-joints"],
}
"""Options of the export by language."""
_OUTPUTS = frozenset({"-o", "--report", "--json", "--html"})
"""Options before the name of what is written."""
_AROUND_MM = 160.0
"""Travel beyond the board's rim: the knife and tilted jets leave it."""
_LIBRARY_TRAVEL_MM = 300.0
"""To each side, for which the frame and the table of the library's gantry are made."""


@dataclass(frozen=True, slots=True)
class Usage:
    """What a process took."""

    clock_s: float
    processor_s: float
    peak_mb: float
    """Largest resident memory."""
    written_mb: float = 0.0


def run(words: list[str], folder: Path) -> Usage:
    """Run a command in a process of its own; its words on the screen go to a file.

    Raises:
        RuntimeError: it failed, or the robot cannot do the program: that was not measured. An analysis ends with 1
            where the board is not predicted clean.
    """
    printed = folder / f"{words[0]}.txt"
    begin = time.perf_counter()
    with printed.open("w") as out:
        process = subprocess.Popen(
            [sys.executable, "-c", _START, *words],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(_ROOT)},
            stdout=out,
            stderr=subprocess.STDOUT,
        )
        _, status, usage = os.wait4(process.pid, 0)
    clock = time.perf_counter() - begin
    if os.waitstatus_to_exitcode(status) > (words[0] == "analyse"):
        raise RuntimeError(f"{' '.join(words)} failed:\n{printed.read_text()[-2000:]}")
    return Usage(clock, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024)


def write_board(parts: int, folder: Path) -> None:
    """Write the board of a size, and the cell that reaches all of it."""
    bodies = generated_board(parts)
    (folder / "board.tri").write_text(write_tri(bodies))
    width, depth = bodies[0].patches.reshape(-1, 3).max(axis=0)[:2].tolist()
    write_cell(width, depth, folder)


def write_cell(width: float, depth: float, folder: Path) -> Path:
    """Write the gantry of the library with travel, frame and table for a board of that size, mm; return its file."""
    yaml = YAML(typ="safe")
    library = _ROOT / "robotcell" / "library"
    cell = yaml.load(library / "cells" / "gantry.yaml")
    robot = yaml.load(library / "robots" / "gantry" / "gantry.yaml")
    far = width / 2 + _AROUND_MM, depth / 2 + _AROUND_MM
    for name, most in zip("XY", far, strict=True):
        robot["joints"][name]["position_mm"] = [-most, most]
    cell["tool_change_deg_mm"][:2] = [-far[0], -far[1]]  # front left, away from the board
    more = [max(most - _LIBRARY_TRAVEL_MM, 0.0) for most in far]
    _widen_frame(library / "robots" / "gantry" / "gantry.urdf", more, folder / "gantry.urdf")
    cell["fixtures"]["table"]["size_mm"][:2] = [900.0 + 2.0 * each for each in more]
    robot["urdf"] = "gantry.urdf"
    cell["robot"] = {key: robot[key] for key in ("urdf", "base_link", "flange_link", "joints")}
    cell["board"]["pose"]["xyz_mm"] = [-width / 2, -depth / 2, 60.0]
    with (folder / "cell.yaml").open("w") as file:
        yaml.dump(cell, file)
    return folder / "cell.yaml"


def _widen_frame(source: Path, more: list[float], target: Path) -> None:
    """Make the rails of the base longer and set them apart, and make the bridge longer, by (x, y) mm to each side."""
    tree = ET.parse(source)
    x, y = (each / 1000.0 for each in more)
    for link, longer in (("base", (2.0 * x, 0.0)), ("bridge", (0.0, 2.0 * y))):
        for collision in tree.iterfind(f"link[@name='{link}']/collision"):
            box, origin = collision.find("geometry/box"), collision.find("origin")
            width, depth, height = (float(word) for word in box.get("size").split())
            box.set("size", f"{width + longer[0]:g} {depth + longer[1]:g} {height:g}")
            if link == "base":
                left, front, low = (float(word) for word in origin.get("xyz").split())
                origin.set("xyz", f"{left:g} {front + math.copysign(y, front):g} {low:g}")
    tree.write(target)


def measure(folder: Path) -> Iterator[tuple[str, Usage]]:
    """Plan, check, analyse and export the board of a folder: what each command took, as soon as it is known."""
    board = ["--board", "board.tri"]
    commands = {
        "plan": ["plan", "board.tri", _RECIPE, "-o", "board.wash", "--report", "plan.json"],
        "check": ["check", "board.wash", "cell.yaml", *board, "--report", "check.json", "-o", "robot.wash"],
        "analyse, report": ["analyse", "board.wash", "board.tri", "--json", "cleaning.json", "--html", "cleaning.html"],
        **{
            f"export {language}": [
                "export",
                "board.wash",
                "--cell",
                "cell.yaml",
                *board,
                "--dialect",
                language,
                *options,
            ]
            for language, options in _LANGUAGES.items()
        },
    }
    for name, words in commands.items():
        usage = run(words, folder)
        written = sum(size_of(folder / words[at + 1]) for at, word in enumerate(words) if word in _OUTPUTS)
        yield name, replace(usage, written_mb=written / 1e6)


def size_of(path: Path) -> int:
    """Give the bytes of a file, or of all files of a folder."""
    return sum(each.stat().st_size for each in (path.rglob("*") if path.is_dir() else [path]) if each.is_file())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", default="1250,2500,5000", help="numbers of parts, ascending")
    parser.add_argument("--keep", type=Path, help="folder for boards, programs and reports")
    words = parser.parse_args()
    sizes = [int(each) for each in words.sizes.split(",")]
    print("| parts | | processor, s | clock, s | peak, MB | written, MB |")
    print("| --: | --- | --: | --: | --: | --: |")
    taken: dict[str, list[Usage]] = {}
    with tempfile.TemporaryDirectory() as scratch:
        for parts in sizes:
            folder = (words.keep or Path(scratch)) / str(parts)
            folder.mkdir(parents=True, exist_ok=True)
            # A process starts with the peak of the one that it comes from: the board is made in another one too.
            maker = get_context("spawn").Process(target=write_board, args=(parts, folder))
            maker.start()
            maker.join()
            for name, usage in measure(folder):
                taken.setdefault(name, []).append(usage)
                print(
                    f"| {parts:,} | {name} | {usage.processor_s:.1f} | {usage.clock_s:.1f} | {usage.peak_mb:,.0f} | "
                    f"{usage.written_mb:.1f} |",
                    flush=True,
                )
    if len(sizes) > 1:
        print_exponents(sizes, taken)


def print_exponents(sizes: Sequence[int], taken: dict[str, list[Usage]]) -> None:
    """Print how fast each command grows."""
    print("\n| exponent of | seconds | peak memory | bytes |\n| --- | --: | --: | --: |")
    for name, usages in taken.items():
        columns = ([getattr(each, word) for each in usages] for word in ("processor_s", "peak_mb", "written_mb"))
        print(f"| {name} | {' | '.join(f'{exponent(sizes, column):.2f}' for column in columns)} |")
    print(f"| n log n | {exponent(sizes, [each * math.log(each) for each in sizes]):.2f} | | |")


def exponent(sizes: Sequence[int], values: Sequence[float]) -> float:
    """Give the slope of the logarithm of values over that of sizes, by least squares."""
    return float(np.polyfit(np.log(sizes), np.log(values), 1)[0])


if __name__ == "__main__":
    main()
