"""Runs cases one after the other in a process of its own: time, memory, what was printed, and what was raised."""

import gc
import json
import os
import random
import re
import resource
import sys
import time
import traceback
import warnings
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal, TypeAlias

import boards.formats.step
from reader_fuzz.mutation import mutate
from reader_fuzz.readers import Reader, convert_in_fork
from specs.errors import JobError

LIMIT_S = 5.0
LIMIT_MB = 1024.0
_SAFETY_BYTES = 3 << 30
_LONGEST = 1500
_NOT_A_SENTENCE = re.compile(
    r"Traceback|\b(?!(?:Board|Recipe|Cell|Program|Cleaning)Error)[A-Z]\w*(?:Error|Exception)\b"
    r"|\bat 0x[0-9a-f]{8}|array\("
)

Verdict: TypeAlias = Literal["accepted", "refused", "fault"]


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one case."""

    case: int
    verdict: Verdict
    seconds: float
    """Of processor time, its children's included."""
    megabytes: float
    """Largest resident memory above that before the case."""
    message: str


def content_of(reader: Reader, name: str, seed: int, case: int) -> bytes:
    """Give the bytes of a case: the same for the same seed, on any machine."""
    rng = random.Random(f"{seed}/{name}/{case}")
    return mutate(rng.choice(reader.seeds), reader.seeds, rng)


def run_cases(reader: Reader, name: str, seed: int, cases: range, pipe: int, folder: Path) -> None:
    """Run cases in this process and write an outcome a line."""
    _prepare(reader, folder)
    with os.fdopen(pipe, "w") as out:
        for case in cases:
            outcome = run_one(reader, content_of(reader, name, seed, case), case, folder)
            out.write(json.dumps(asdict(outcome)) + "\n")
            out.flush()


def prepare_folder(reader: Reader, folder: Path) -> None:
    """Write what lies beside the mutated file, and make the folder of that."""
    for name, content in reader.beside:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    (folder / reader.file).parent.mkdir(parents=True, exist_ok=True)


def _prepare(reader: Reader, folder: Path) -> None:
    prepare_folder(reader, folder)
    boards.formats.step.run_child = convert_in_fork
    warnings.simplefilter("always")
    printed = os.memfd_create("printed")
    for stream in (1, 2):
        os.dup2(printed, stream)
    gc.freeze()


def run_one(reader: Reader, content: bytes, case: int, folder: Path) -> Outcome:
    """Run one case."""
    file = folder / reader.file
    file.write_bytes(content)
    used = time.process_time()
    resource.setrlimit(resource.RLIMIT_CPU, (int(used + LIMIT_S) + 2, resource.RLIM_INFINITY))
    before = _memory("VmSize")
    resource.setrlimit(resource.RLIMIT_AS, (int(before * (1 << 20)) + _SAFETY_BYTES, resource.RLIM_INFINITY))
    Path("/proc/self/clear_refs").write_text("5")
    resident, children = _memory("VmRSS"), resource.getrusage(resource.RUSAGE_CHILDREN)
    verdict, message = _judge(reader, file)
    seconds = time.process_time() - used
    later = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds += later.ru_utime + later.ru_stime - children.ru_utime - children.ru_stime
    megabytes = _memory("VmHWM") - resident
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    if os.fstat(2).st_size:
        verdict, message = "fault", f"printed {os.pread(2, 400, 0)!r} ({message})"
        os.ftruncate(2, 0)
        os.lseek(2, 0, os.SEEK_SET)
    if seconds > LIMIT_S:
        verdict, message = "fault", f"slow ({message})"
    if megabytes > LIMIT_MB:
        verdict, message = "fault", f"large ({message})"
    return Outcome(case, verdict, round(seconds, 3), round(megabytes, 1), message)


def _judge(reader: Reader, file: Path) -> tuple[Verdict, str]:
    try:
        reader.read(file)
    except JobError as error:
        problem = _problem_of(str(error), file.parents[reader.file.count("/")])
        return ("fault", f"{problem}: {error}") if problem else ("refused", str(error))
    except BaseException as error:
        frame = traceback.extract_tb(error.__traceback__)[-1]
        return "fault", f"{type(error).__name__} in {Path(frame.filename).name}:{frame.lineno}: {error}"[:600]
    return "accepted", ""


def _problem_of(message: str, folder: Path) -> str:
    """Why a message is no clear error; empty if it is one. Every line is one, and the first names the file."""
    if str(folder) not in message.partition("\n")[0]:
        return "the file is not named"
    if any(not line.strip() or not line.isprintable() for line in message.split("\n")):
        return "an empty line or control characters"
    if _NOT_A_SENTENCE.search(message):
        return "a library's words"
    if max(map(len, message.split("\n"))) > _LONGEST + len(str(folder)):
        return "too long"
    return ""


def _memory(key: str) -> float:
    """A value of this process's status, MB."""
    status = Path("/proc/self/status").read_text()
    return int(status.partition(f"{key}:")[2].split()[0]) / 1024.0
