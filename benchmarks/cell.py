"""The robot cell in one run: joints found, collisions looked for, and a whole program carried out.

Run: ``OMP_NUM_THREADS=1 python benchmarks/cell.py [BOARD [CELL ...]]``

Three parts that also run by themselves: ``cell_ik.py`` against EAIK called bare, ``cell_collision.py`` against
pinocchio and coal called bare, ``cell_track.py`` against the program's own time and toppra's bound.
"""

import sys

import cell_collision
import cell_ik
import cell_track


def main(words: list[str]) -> None:
    board = words[:1] or ["smt-demo"]
    print("joints")
    cell_ik.main(["--counted", "0"])
    print("\ncollisions")
    cell_collision.main(board)
    print("\nmotion")
    cell_track.main([*board, "smt-aqueous", *words[1:]])


if __name__ == "__main__":
    main(sys.argv[1:])
