"""Fuzz every reader as the commands call it, with seeded mutations of valid files, and print a table.

    python tools/fuzz_readers.py --cases 200000 --seed 1 --jobs 2
    python tools/fuzz_readers.py --cases 5000 --only kicad,idf

A case is faulty if it takes more than 5 s or 1 GB, ends its process, prints anything, or is refused by anything but one
clear error with the name of the file. Faulty inputs are made smaller and saved with ``--save``. Exit code 1: there are.
"""

import argparse
import json
import math
import multiprocessing
import os
import re
import select
import signal
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent)]

from reader_fuzz.readers import Reader, make_readers
from reader_fuzz.worker import LIMIT_S, Outcome, content_of, prepare_folder, run_cases, run_one

_SILENT_S = 12 * LIMIT_S
"""Of wall time: a case that waits uses no processor time."""

_CHUNK = 500
_WEIGHTS = {"step": 0.1, "gap": 0.02, "cell": 0.3, "parameters": 0.3}
"""Share of the cases where it is not 1: those that take long get fewer."""

_PROBES = 150


@dataclass
class Row:
    """What a reader did."""

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


def outcomes(reader: Reader, name: str, seed: int, cases: range) -> Iterator[Outcome]:
    """Run cases in a worker; a new one goes on behind a case that ended the last."""
    at = cases.start
    with tempfile.TemporaryDirectory(prefix="fuzz-") as folder:
        while at < cases.stop:
            receive, send = os.pipe()
            worker = os.fork()
            if worker == 0:
                os.close(receive)
                try:
                    run_cases(reader, name, seed, range(at, cases.stop), send, Path(folder))
                finally:
                    os._exit(0)
            os.close(send)
            for line in _lines(receive):
                outcome = Outcome(**json.loads(line))
                at = outcome.case + 1
                yield outcome
            os.kill(worker, signal.SIGKILL)
            status = os.waitpid(worker, 0)[1]
            if at < cases.stop:
                yield Outcome(at, "fault", LIMIT_S, 0.0, f"ended its process: {_end(status)}")
                at += 1


def _end(status: int) -> str:
    number = os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0
    return {0: f"exit {status}", signal.SIGXCPU: "slow", signal.SIGKILL: "silent"}.get(number, f"signal {number}")


def _lines(receive: int) -> Iterator[str]:
    """Yield lines until the worker ends, or is silent."""
    with os.fdopen(receive, "rb", buffering=0) as stream:
        rest = b""
        while select.select([stream], [], [], _SILENT_S)[0]:
            part = stream.read(1 << 16)
            if not part:
                return
            *whole, rest = (rest + part).split(b"\n")
            yield from (line.decode() for line in whole)


def run_chunk(job: tuple[str, int, range]) -> tuple[str, list[Outcome]]:
    """Run some cases of one reader."""
    name, seed, cases = job
    return name, list(outcomes(_READERS[name], name, seed, cases))


def warm_up(names: list[str]) -> None:
    """Read every valid file once: what is loaded or compiled at the first call counts for no case.

    Raises:
        JobError: one of them is refused.
    """
    for name in names:
        reader = _READERS[name]
        with tempfile.TemporaryDirectory(prefix="fuzz-") as folder:
            prepare_folder(reader, Path(folder))
            for content in reader.seeds:
                (Path(folder) / reader.file).write_bytes(content)
                reader.read(Path(folder) / reader.file)


def probe(reader: Reader, content: bytes) -> str:
    """Give the kind of fault of one content, empty if there is none."""
    fixed = Reader((content,), reader.file, reader.read, reader.beside)
    with tempfile.TemporaryDirectory(prefix="fuzz-") as folder:
        receive, send = os.pipe()
        worker = os.fork()
        if worker == 0:
            from reader_fuzz import worker as runner

            os.close(receive)
            try:
                runner._prepare(fixed, Path(folder))
                os.write(send, json.dumps(kind_of(run_one(fixed, content, 0, Path(folder)).message)).encode())
            finally:
                os._exit(0)
        os.close(send)
        line = _all(receive)
        os.kill(worker, signal.SIGKILL)
        status = os.waitpid(worker, 0)[1]
    return json.loads(line) if line else kind_of(f"ended its process: {_end(status)}")


def _all(receive: int) -> str:
    with os.fdopen(receive, "rb") as stream:
        return stream.read().decode() if select.select([stream], [], [], _SILENT_S)[0] else ""


def minimise(reader: Reader, content: bytes, kind: str) -> bytes:
    """Leave out lines, then bytes, as long as the fault stays of its kind."""
    left = _PROBES
    for split in (
        lambda data: data.splitlines(keepends=True),
        lambda data: [data[i : i + 1] for i in range(len(data))],
    ):
        pieces = split(content)
        size = max(len(pieces) // 2, 1)
        while size and left > 0 and len(pieces) > 1:
            at = 0
            while at < len(pieces) and left > 0:
                fewer = pieces[:at] + pieces[at + size :]
                left -= 1
                if probe(reader, b"".join(fewer)) == kind:
                    pieces = fewer
                else:
                    at += size
            size //= 2
        content = b"".join(pieces)
        left += _PROBES
    return content


def main() -> int:
    """Run the fuzz; 1 if a case was faulty."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=2000, help="of all readers together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="readers, with commas between them")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--save", type=Path, help="folder for the faulty inputs, made smaller")
    given = parser.parse_args()
    names = given.only.split(",") if given.only else list(_READERS)
    unknown = [name for name in names if name not in _READERS]
    if unknown:
        parser.error(f"no reader {unknown[0]}; known are {', '.join(_READERS)}")
    weights = {name: _WEIGHTS.get(name, 1.0) for name in names}
    shares = {name: math.ceil(given.cases * weight / sum(weights.values())) for name, weight in weights.items()}
    jobs = [
        (name, given.seed, range(at, min(at + _CHUNK, shares[name])))
        for at in range(0, max(shares.values()), _CHUNK)
        for name in names
        if at < shares[name]
    ]
    rows = {name: Row() for name in names}
    warm_up(names)
    started = time.monotonic()
    with multiprocessing.get_context("fork").Pool(given.jobs) as pool:
        for name, found in pool.imap_unordered(run_chunk, jobs):
            for outcome in found:
                rows[name].add(outcome)
    seconds = time.monotonic() - started
    columns = f"{'cases':>7} {'refused':>8} {'accepted':>8} {'ms a case':>9} {'slowest s':>9} {'largest MB':>10}"
    print(f"{'reader':<12} {columns} {'faults':>6}")
    for name, row in rows.items():
        mean_ms = 1000.0 * row.seconds / max(row.cases, 1)
        print(
            f"{name:<12} {row.cases:>7} {row.refused:>8} {row.accepted:>8} {mean_ms:>9.1f} {row.slowest:>9.2f} "
            f"{row.largest:>10.0f} {row.faulty:>6}"
        )
    total = sum(row.cases for row in rows.values())
    print(f"{total} cases in {seconds:.0f} s: {total / max(seconds, 1e-9):.0f} a second")
    for name, row in rows.items():
        for kind, outcome in row.faults.items():
            print(f"FAULT {name} case {outcome.case}: {outcome.message[:300]!r}")
            if given.save is not None:
                given.save.mkdir(parents=True, exist_ok=True)
                content = minimise(_READERS[name], content_of(_READERS[name], name, given.seed, outcome.case), kind)
                (given.save / f"{name}-{outcome.case}.in").write_bytes(content)
    return int(any(row.faulty for row in rows.values()))


_READERS = make_readers()
if __name__ == "__main__":
    sys.exit(main())
