"""How fast and how exact the prediction of what a program cleans is: rays, stages, growth; one after the other.

Run: ``OMP_NUM_THREADS=1 python benchmarks/cleaning.py [--most 16] [BOARD]``

It has the name of a package that it and the scripts beside it import, and a script's own folder is searched first: so
it puts that folder last, and where it was itself found for the package it gives way to it.
"""

import argparse
import importlib
import sys
from pathlib import Path

sys.path.append(sys.path.pop(0))


def main(words: list[str]) -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("board", nargs="?", type=Path, default=Path("smt-demo"))
    parser.add_argument("--most", type=int, default=16, help="copies of the board in the largest panel")
    arguments = parser.parse_args(words)
    importlib.import_module("cleaning_rays").main([str(arguments.board)])
    print()
    importlib.import_module("cleaning_analysis").main([str(arguments.board), f"--most={arguments.most}"])


if __name__ == "__main__":
    main(sys.argv[1:])
else:
    del sys.modules[__name__]
    importlib.import_module(__name__)
