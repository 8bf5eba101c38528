"""Time the reading of a ``.tri`` file against ``numpy.loadtxt`` on its numbers alone, and what comes after.

Run: ``OMP_NUM_THREADS=1 python -m benchmarks.load BOARD.tri [ROUNDS]``
"""

import io
import resource
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from boards.formats.tri.text import read_text
from boards.formats.tri.tri import read_tri, write_tri
from boards.understand import understand


def numeric_lines(path: Path) -> bytes:
    lines = read_text(path).split(b"\n")
    return b"\n".join(line for line in lines if line[:1].isdigit() or line[:1] in (b"-", b"+", b"."))


def fastest(work: list[tuple[str, Callable[[], object]]], rounds: int) -> dict[str, float]:
    """Run all of the work in turn, several times, and keep the fastest of each: other users disturb all alike."""
    best = {name: float("inf") for name, _ in work}
    for _ in range(rounds):
        for name, run in work:
            begin = time.perf_counter()
            run()
            best[name] = min(best[name], time.perf_counter() - begin)
    return best


def main() -> None:
    path = Path(sys.argv[1])
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 7
    begin = time.perf_counter()
    bodies, findings = read_tri(path)
    first = time.perf_counter() - begin
    numbers = numeric_lines(path)
    best = fastest(
        [("read_tri", lambda: read_tri(path)), ("numpy.loadtxt", lambda: np.loadtxt(io.BytesIO(numbers)))], rounds
    )
    best |= fastest(
        [("write_tri", lambda: write_tri(bodies)), ("understand", lambda: understand(bodies, "board", findings))], 3
    )
    print(f"{path.name}: {len(bodies)} objects, {sum(len(body.patches) for body in bodies)} patches")
    print(f"read_tri, first call   {1e3 * first:8.1f} ms")
    for name, seconds in best.items():
        print(f"{name:22} {1e3 * seconds:8.1f} ms")
    print(f"read_tri / loadtxt     {best['read_tri'] / best['numpy.loadtxt']:8.2f}")
    print(f"peak memory            {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3:8.0f} MB")


if __name__ == "__main__":
    main()
