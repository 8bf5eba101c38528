"""Mutate every input: files of every reader, and every parameter of every command; print cases and defects by target.

    python tools/fuzz.py --cases 1000000 --jobs 2              what `make fuzz` does
    python tools/fuzz.py --cases 5000 --only "KiCad,plan *" --grow tests/fuzz/corpus
    python tools/fuzz.py --cases 50000 --seed 7 --into rows    one of several runs, and the table of all, seed by seed

Of seventy cases 69 go to readers, as many to each, and one to parameters. Small files are mutated more often than
large ones, and long insertions are rare: a case takes 2 to 35 ms of processor time, STEP up to 60, and YAML and
programs of several files more than others.
A case is faulty if it takes more than 5 s or 1 GB, ends its process, prints a library's words, leaves or writes what it
must not, ends with an internal error, or is refused by anything but one clear error with the name of the file. Faulty
inputs are made smaller and saved with ``--save``. Exit code 1: there are.
"""

import argparse
import importlib
import math
import multiprocessing
import os
import pickle
import re
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from hashlib import sha256
from multiprocessing.connection import Connection, Pipe
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1])]

from fuzzing.targets import (
    Case,
    Files,
    Target,
    import_product,
    lacking,
    make_inputs,
    make_targets,
    with_valid_seeds,
)
from fuzzing.worker import LIMIT_S, Outcome, cases_of, run_cases

_SILENT_S = 12 * LIMIT_S
"""Of wall time: a case that waits uses no processor time."""
_CHUNK = 2000
_PROBES = 150
Cases = Callable[[int, list[Case]], Iterator[tuple[int, Case]]]


@dataclass
class Row:
    """What a target did."""

    cases: int = 0
    refused: int = 0
    accepted: int = 0
    seconds: float = 0.0
    slowest: float = 0.0
    largest: float = 0.0
    faults: dict[str, Outcome] = field(default_factory=dict)
    """One of each kind."""
    faulty: int = 0

    def add(self, outcome: Outcome) -> None:
        """Count an outcome."""
        self.cases += 1
        self.refused += outcome.verdict == "refused"
        self.accepted += outcome.verdict == "accepted"
        self.seconds += outcome.seconds
        self.slowest = max(self.slowest, outcome.seconds)
        self.largest = max(self.largest, outcome.megabytes)
        if outcome.verdict == "fault":
            self.faulty += 1
            self.faults.setdefault(kind_of(outcome.message), outcome)


def kind_of(message: str) -> str:
    """Give the kind of a fault: its message without what differs from case to case."""
    return re.sub(r"/\S+|'[^']*'|\d+", "_", message)[:70]


def outcomes(target: Target, inputs: Files, cases: Cases, count: range) -> Iterator[Outcome]:
    """Run cases in a worker; a new one goes on behind a case that ended the last."""
    at, pool = count.start, list(target.seeds)
    while at < count.stop:
        with tempfile.TemporaryDirectory(prefix="fuzz-") as folder:
            receive, send = Pipe(duplex=False)
            worker = os.fork()
            if worker == 0:
                receive.close()
                try:
                    run_cases(target, cases(at, pool), pool, send, Path(folder), inputs)
                except Exception:
                    Path(folder, "defect of the tool").write_text(traceback.format_exc(), "utf-8")
                finally:
                    os._exit(0)
            send.close()
            for outcome in _received(receive):
                at = outcome.number + 1
                pool += [outcome.case] if outcome.case and outcome.verdict != "fault" else []
                yield outcome
            os.kill(worker, signal.SIGKILL)
            status = os.waitpid(worker, 0)[1]
            if (defect := Path(folder, "defect of the tool")).exists():
                raise RuntimeError(defect.read_text("utf-8"))
            if at < count.stop:
                last = Path(folder, "case")
                case = pickle.loads(last.read_bytes()) if last.exists() else None
                yield Outcome(at, "fault", LIMIT_S, 0.0, f"ended its process: {_end(status)}", case)
                at += 1


def _end(status: int) -> str:
    number = os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0
    return {0: f"exit {os.WEXITSTATUS(status)}", signal.SIGXCPU: "slow", signal.SIGKILL: "silent"}.get(
        number, f"signal {number}"
    )


def _received(receive: Connection) -> Iterator[Outcome]:
    """Yield outcomes until the worker ends, or is silent."""
    with receive:
        while receive.poll(_SILENT_S):
            try:
                yield receive.recv()
            except EOFError:
                return


def run_chunk(job: tuple[str, int, range]) -> tuple[str, list[Outcome]]:
    """Run some cases of one target."""
    name, seed, numbers = job
    target = _TARGETS[name]

    def cases(at: int, pool: list[Case]) -> Iterator[tuple[int, Case]]:
        return cases_of(target, seed, range(at, numbers.stop), pool)

    return name, [_again(target, outcome) for outcome in outcomes(target, _INPUTS, cases, numbers)]


def _again(target: Target, outcome: Outcome) -> Outcome:
    """Run a case that ended by its time once more: on a busy machine, or before anything is compiled, any may."""
    case = outcome.case if outcome.message.endswith((": slow", ": silent")) else None
    if case is None or probe(target, case):
        return outcome
    return replace(outcome, verdict="accepted", message="", case=None)


def probe(target: Target, case: Case) -> str:
    """Give the kind of fault of one case, empty if there is none."""
    (outcome,) = outcomes(replace(target, seeds=()), _INPUTS, lambda at, pool: iter([(0, case)]), range(1))
    return kind_of(outcome.message) if outcome.verdict == "fault" else ""


def minimise(target: Target, case: Case, kind: str) -> Case:
    """Leave out lines, then bytes, of each changed file, as long as the fault stays of its kind."""
    for name, content in case.files.items():
        if any(each.files.get(name) == content for each in target.seeds):
            continue
        for split in (lambda data: data.splitlines(keepends=True), lambda data: [bytes([each]) for each in data]):
            pieces, left = split(case.files[name]), _PROBES
            size = max(len(pieces) // 2, 1)
            while size and left > 0 and len(pieces) > 1:
                at = 0
                while at < len(pieces) and left > 0:
                    fewer = pieces[:at] + pieces[at + size :]
                    left -= 1
                    if probe(target, replace(case, files={**case.files, name: b"".join(fewer)})) == kind:
                        pieces = fewer
                    else:
                        at += size
                size //= 2
            case = replace(case, files={**case.files, name: b"".join(pieces)})
    return case


def save(folder: Path, case: Case) -> None:
    """Write a case as the corpus has it."""
    name = sha256(pickle.dumps(case)).hexdigest()[:8]
    for each, content in case.files.items():
        inside = each.split("/")[1:] or [each]
        place = folder / name / "/".join(inside) if len(case.files) > 1 else folder / f"{name}{Path(each).suffix}"
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(content)
    if case.words:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{name}.words").write_text(repr(case.words), "utf-8", "backslashreplace")


def shares_of(targets: list[Target], cases: int) -> dict[str, int]:
    """Divide cases over targets evenly, by their weights."""
    whole = sum(target.weight for target in targets)
    return {target.name: math.ceil(cases * target.weight / whole) for target in targets}


def arguments() -> argparse.Namespace:
    """Read the words of this tool."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=2000, help="of all targets together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="*", help="targets, as KiCad or 'plan *', with commas between them")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--save", type=Path, help="folder for the faulty inputs, made smaller")
    parser.add_argument(
        "--into", type=Path, help="file with the rows of earlier runs, which those of this are added to"
    )
    parser.add_argument("--grow", type=Path, help="folder for the inputs that reached new lines, one in each chunk")
    return parser.parse_args()


def main() -> int:
    """Run the fuzz; 1 if a case was faulty."""
    given = arguments()
    names = [name for name in _TARGETS if any(fnmatchcase(name, each) for each in given.only.split(","))]
    chosen = {name: with_valid_seeds(_TARGETS[name]) for name in names}
    if lacks := lacking(chosen):
        raise SystemExit(f"{lacks[0]} takes none of its files: put a valid one into tests/fuzz/corpus/{lacks[0]}")
    _TARGETS.update(chosen)
    import_product()
    importlib.import_module("cascadio")  # the library of STEP: here once rather than in each child
    earlier = given.into is not None and given.into.exists()
    rows: dict[str, Row] = pickle.loads(given.into.read_bytes()) if earlier else {}
    rows |= {name: Row() for name in chosen if name not in rows}
    started = time.monotonic()
    jobs = jobs_of(shares_of([*chosen.values()], given.cases), given.seed)
    with multiprocessing.get_context("fork").Pool(given.jobs) as pool:
        for done, (name, found) in enumerate(pool.imap_unordered(run_chunk, jobs), start=1):
            for outcome in found:
                rows[name].add(outcome)
            grown = [each.case for each in found if each.case and each.verdict == "accepted"]
            if given.grow is not None and grown:
                save(given.grow / name, min(grown, key=lambda case: sum(map(len, case.files.values()))))
            if given.into is not None:
                given.into.write_bytes(pickle.dumps(rows))
            if done % 50 == 0:
                total, seconds = sum(row.cases for row in rows.values()), time.monotonic() - started
                print(f"{total} cases, {seconds:.0f} s", file=sys.stderr)
    print_table(rows)
    for name, row in rows.items():
        for kind, outcome in row.faults.items():
            words = f" {' '.join(outcome.case.words)!r}" if outcome.case and outcome.case.words else ""
            print(f"FAULT {name} case {outcome.number}{words[:300]}: {outcome.message[:300]!r}")
            if given.save is not None and outcome.case is not None:
                save(given.save / name, minimise(_TARGETS[name], outcome.case, kind))
    return int(any(row.faulty for row in rows.values()))


def jobs_of(shares: dict[str, int], seed: int) -> list[tuple[str, int, range]]:
    """Divide the cases of each target into chunks, so that all targets advance evenly."""
    return [
        (name, seed, range(at, min(at + _CHUNK, share)))
        for at in range(0, max(shares.values(), default=0), _CHUNK)
        for name, share in shares.items()
        if at < share
    ]


def print_table(rows: dict[str, Row]) -> None:
    """Print what became of the cases by target."""
    columns = f"{'cases':>7} {'refused':>8} {'accepted':>8} {'ms a case':>9} {'slowest s':>9} {'largest MB':>10}"
    print(f"{'target':<40} {columns} {'faults':>6}")
    for name, row in rows.items():
        mean_ms = 1000.0 * row.seconds / max(row.cases, 1)
        print(
            f"{name:<40} {row.cases:>7} {row.refused:>8} {row.accepted:>8} {mean_ms:>9.1f} {row.slowest:>9.2f} "
            f"{row.largest:>10.0f} {row.faulty:>6}"
        )
    total, seconds = (sum(each) for each in zip(*((row.cases, row.seconds) for row in rows.values()), strict=True))
    print(f"{total} cases in {seconds:.0f} s of processor time: {1000.0 * seconds / max(total, 1):.1f} ms a case")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="fuzz-") as made:
        _INPUTS = make_inputs(Path(made))
    _TARGETS = make_targets(_INPUTS)
    sys.exit(main())
