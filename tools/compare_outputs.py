"""Run every sample board with every library recipe in two checkouts, and compare what they write, byte for byte.

    tools/compare_outputs.py run CHECKOUT FOLDER      write programs, exports, reports and printed text into FOLDER
    tools/compare_outputs.py diff BEFORE AFTER        list the files that differ, and the lines in which they do

``--only tiny--smt-aqueous`` runs or compares only what has that in its name; ``--no-hashes`` compares without SHA-256
sums, which differ where the model of a recipe has changed; ``--numbers`` compares only the numbers of each file, in
their order, so that what differs by its words alone is not listed.

``run`` uses the Python it is started with, so both checkouts meet the same libraries. Files that are there already are
kept, so that an interrupted run goes on where it stopped.
"""

import argparse
import difflib
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

BOARDS = ("tiny", "two-sided", "radio-stick", "sensor-hub", "smt-demo")
RECIPES = ("smt-aqueous", "low-standoff", "rinse-only", "dry-only")
CELLS = ("ur5e-bench", "ur5-bench", "kr6-bench", "cairo-bench", "gantry")
DIALECTS = {
    "abb": "irb1200-bench",
    "abb-paint": "irb1200-bench",
    "fanuc": "lrmate-bench",
    "kuka": "kr6-bench",
    "linuxcnc": "gantry",
    "heidenhain": "gantry",
    "sinumerik": "gantry",
    "fanuc-cnc": "gantry",
    "ur": "ur5e-bench",
    "yaskawa": "gp8-bench",
    "epson": "c8l-bench",
    "denso": "vs060-bench",
    "melfa": "rv-4frl-bench",
    "val3": "tx2-60-bench",
    "joint-table": "ur5e-bench",
}
"""The cell of each language: a robot of its maker."""
SHOWN_LINES = 12
SHA256 = re.compile(r"\b([0-9a-f]{64}|[0-9a-f]{16})\b")
NUMBER = re.compile(r"[-+]?\d+(?:[.,]\d+)*(?:[eE][-+]?\d+)?")


def commands(board: str, recipe: str) -> Iterator[tuple[str, list[str]]]:
    """All that is run for a board and a recipe: a name for its printed text, and its words."""
    wash = f"{board}--{recipe}.wash"
    stem = wash.removesuffix(".wash")
    yield "plan", ["plan", board, recipe, "-o", wash, "--report", f"{stem}.json", "--picture", f"{stem}.svg"]
    yield "show", ["show", wash]
    yield (
        "analyse",
        ["analyse", wash, "--html", f"{stem}.html", "--json", f"{stem}-cleaning.json", "--date", "2026-01-01"],
    )
    for cell in CELLS if board == "tiny" else ("ur5e-bench", "gantry"):
        yield f"check-{cell}", ["check", wash, cell]
    for dialect, cell in DIALECTS.items():
        yield f"export-{dialect}", ["export", wash, "--cell", cell, "--dialect", dialect, "-o", f"{stem}-{dialect}"]


def nouns() -> Iterator[tuple[str, list[str]]]:
    """What is printed of boards, recipes, cells and parameter sets."""
    for board in BOARDS:
        yield f"board-{board}", ["board", "show", board, "--all"]
        yield f"classify-{board}", ["classify", board]
        yield f"import-{board}", ["board", "import", board, "-o", f"{board}.tri"]
    for recipe in RECIPES:
        yield f"recipe-{recipe}", ["recipe", "show", recipe]
        yield f"recipe-check-{recipe}", ["recipe", "check", recipe]
    for cell in CELLS:
        yield f"cell-{cell}", ["cell", "show", cell]
    yield "parameters", ["parameters", "show"]
    yield "compare", ["compare", "tiny", "smt-aqueous", "low-standoff", "--html", "c.html", "--json", "c.json"]
    yield "tune", ["tune", "tiny", "smt-aqueous", "-o", "tuned.yaml", "--report", "tuned.json"]
    yield "place", ["cell", "place", "tiny--rinse-only.wash", "ur5e-bench"]
    for kind in ("recipe", "cell", "parameters"):
        yield f"{kind}-schema", [kind, "schema"]
        yield f"{kind}-keys", [kind, "keys"]


def run(checkout: Path, folder: Path, only: str) -> None:
    """Run everything of a checkout in a folder."""
    script = tomllib.loads((checkout / "pyproject.toml").read_text("utf-8"))["project"]["scripts"]["washboard"]
    module, _, function = script.partition(":")
    start = f"import sys; sys.path.insert(0, {str(checkout)!r}); from {module} import {function} as main; main()"
    folder.mkdir(parents=True, exist_ok=True)
    environment = {**os.environ, "PYTHONPATH": str(checkout), "COLUMNS": "160", "OMP_NUM_THREADS": "1"}
    jobs = [(f"{b}--{r}-{name}", words) for b in BOARDS for r in RECIPES for name, words in commands(b, r)]
    for name, words in [*jobs, *nouns()]:
        printed = folder / f"{name}.txt"
        if printed.exists() or only not in name:
            continue
        done = subprocess.run(
            [sys.executable, "-c", start, *words],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        printed.write_text(f"{done.stdout}{done.stderr}exit {done.returncode}\n", "utf-8")
        print(done.returncode, *words, flush=True)


def diff(before: Path, after: Path, only: str, *, hashes: bool, words: bool) -> int:
    """Print the files that differ and the first lines in which they do; 1 if any does."""
    names = sorted({str(p.relative_to(f)) for f in (before, after) for p in f.rglob("*") if p.is_file()})
    names = [name for name in names if only in name]
    different = 0
    for name in names:
        one, two = (f / name for f in (before, after))
        if not (one.exists() and two.exists()):
            different += 1
            print(f"{name}: only in {before if one.exists() else after}")
            continue
        texts = [f.read_bytes().decode("utf-8", "backslashreplace") for f in (one, two)]
        if not hashes:
            texts = [SHA256.sub("#", text) for text in texts]
        if not words:
            texts = ["\n".join(NUMBER.findall(text)) for text in texts]
        if texts[0] != texts[1]:
            different += 1
            print(f"{name}:")
            lines = [text.splitlines() for text in texts]
            shown = [
                x for x in difflib.unified_diff(*lines, lineterm="", n=0) if not x.startswith(("---", "+++", "@@"))
            ]
            for line in shown[:SHOWN_LINES]:
                print(f"  {line[:200]}")
            if len(shown) > SHOWN_LINES:
                print(f"  ... {len(shown) - SHOWN_LINES} more lines")
    print(f"{len(names)} files, {different} differ")
    return 1 if different else 0


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("run", "diff"))
    parser.add_argument("first", type=Path)
    parser.add_argument("second", type=Path)
    parser.add_argument("--only", default="", metavar="TEXT")
    parser.add_argument("--no-hashes", action="store_true")
    parser.add_argument("--numbers", action="store_true")
    arguments = parser.parse_args()
    if arguments.what == "run":
        run(arguments.first.resolve(), arguments.second, arguments.only)
    else:
        sys.exit(
            diff(
                arguments.first,
                arguments.second,
                arguments.only,
                hashes=not arguments.no_hashes,
                words=not arguments.numbers,
            )
        )


if __name__ == "__main__":
    main()
