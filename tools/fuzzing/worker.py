"""Runs cases one after the other in a process of its own: time, memory, what was printed, written and raised."""

import errno
import gc
import os
import pickle
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection
from pathlib import Path
from random import Random
from types import FrameType
from typing import Any, Literal, NoReturn, TypeAlias

import boards.child
import robotcell.operate.reference.servers
import washboard.studied
import webui.live.live
import webui.server.server
from boards.child import _COLOUR, Limits
from boards.child_start import bound_resources
from commandline.process import PACKAGES
from fuzzing.targets import REFUSED, ROOT, Case, Files, Target
from specs.errors import JobError

LIMIT_S = 5.0
LIMIT_MB = 1024.0
_SAFETY_BYTES = 3 << 30
_LONGEST = 1500
_SHARE_S, _IDLE_S = 0.02, 2.0
"""A command that is at work after so long, of processor time or of waiting, has accepted its words."""
_ENDLESS_S = 1
"""Of processor time of a foreign reader's child: one STEP file in fifteen of ours has the library go on for ever."""
_PRODUCT = tuple(f"{ROOT / package}/" for package in PACKAGES)
_UNBROKEN = ("<frozen importlib", "/numba/", "/llvmlite/")
_WHOLE = 0.01
"""Share of the commands' cases that run to their end."""
_GUIDED = 0.1
"""Share of the readers' cases that are traced: those that reach new lines join the valid files."""
_QUIET_AFTER = 30
_NOT_A_SENTENCE = re.compile(
    r"Traceback|\b(?!(?:Board|Recipe|Cell|Program|Cleaning|Study)Error)[A-Z]\w*(?:Error|Exception|Warning)\b"
    rf"|\bat 0x[0-9a-f]{{8}}|array\(|site-packages|{ROOT}/\S*\.py"
)
_CHANGES = {"os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.link", "os.symlink", "os.truncate", "os.chmod"}
_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND

Verdict: TypeAlias = Literal["accepted", "refused", "fault"]


class AtWorkError(BaseException):
    """A command has accepted what it was given, and works."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one case."""

    number: int
    verdict: Verdict
    seconds: float
    """Of processor time, its children's included."""
    megabytes: float
    """Largest resident memory above that before the case."""
    message: str
    case: Case | None = None
    """Where it was faulty, or reached lines that none before did."""


@dataclass
class Guide:
    """Which lines of the product were reached, by function: those that bring nothing new are no longer traced."""

    seen: dict[int, set[int]] = field(default_factory=dict[int, set[int]])
    idle: dict[int, int] = field(default_factory=dict[int, int])
    found: bool = False

    def run(self, action: Any) -> bool:
        """Run an action; gives whether it reached a line that none before did."""
        self.found = False
        sys.settrace(self._enter)
        try:
            action()
        finally:
            sys.settrace(None)
        return self.found

    def _enter(self, frame: FrameType, event: str, argument: Any) -> Any:
        code = frame.f_code
        key = id(code)
        idle = self.idle.get(key)
        if idle is None:
            self.idle[key] = idle = 0 if code.co_filename.startswith(_PRODUCT) else _QUIET_AFTER
            self.seen[key] = set()
        if idle >= _QUIET_AFTER:
            return None
        self.idle[key] = idle + 1
        lines = self.seen[key]

        def line(frame: FrameType, event: str, argument: Any) -> Any:
            if frame.f_lineno not in lines:
                lines.add(frame.f_lineno)
                self.found, self.idle[key] = True, 0
            return line

        return line


def cases_of(target: Target, seed: int, numbers: range, pool: list[Case]) -> Iterator[tuple[int, Case]]:
    """Make cases: the same for the same seed and pool, on any machine; the first is a valid one, as it is."""
    for number in numbers:
        yield number, target.case(tuple(pool), Random(f"{seed}/{target.name}/{number}")) if number else pool[0]


def run_cases(
    target: Target, cases: Iterator[tuple[int, Case]], pool: list[Case], send: Connection, folder: Path, inputs: Files
) -> None:
    """Run cases in this process and send an outcome of each; ``pool`` grows by those that reach new lines."""
    room = _Room(target, folder, inputs)
    guide = Guide()
    for seed in pool if target.read is not None else ():
        guide.run(lambda seed=seed: room.run(0, seed, is_whole=True))
    for number, case in cases:
        (folder / "case").write_bytes(pickle.dumps(case))
        chance = Random(number).random()
        is_new = False
        if target.read is None or chance > _GUIDED:
            outcome = room.run(number, case, is_whole=target.read is not None or chance < _WHOLE)
        else:
            ends: list[Outcome] = []
            is_new = guide.run(lambda case=case, number=number, ends=ends: ends.append(room.run(number, case, True)))
            (outcome,) = ends
            if is_new and outcome.verdict != "fault" and sum(map(len, case.files.values())) < 100_000:
                pool.append(case)
        if number == 0 and outcome.verdict == "refused" and target.name not in REFUSED:
            outcome = replace(outcome, verdict="fault", message=f"a valid input is refused: {outcome.message}")
        kept = case if is_new or outcome.verdict == "fault" else None
        send.send(replace(outcome, case=kept))


class _Room:
    """A folder in which cases of one target run, and the process as they need it."""

    def __init__(self, target: Target, folder: Path, inputs: Files) -> None:
        self.target, self.folder = target, folder / "in"
        (self.folder / "tmp").mkdir(parents=True)
        self.inputs = dict(inputs) if target.command else {}
        self._write(self.inputs)
        os.chdir(self.folder)
        tempfile.tempdir = str(self.folder / "tmp")
        boards.child.run_child = run_in_fork
        for module, name in (
            (washboard.studied, "study"),
            (webui.server.server, "serve"),
            (robotcell.operate.reference.servers, "serve"),
            (webui.live.live, "LiveServer"),
        ):
            setattr(module, name, _work)
        warnings.simplefilter("always")
        for stream in (1, 2):
            os.dup2(os.memfd_create("printed"), stream)
        for number in (signal.SIGPROF, signal.SIGALRM):
            signal.signal(number, _stop)
        sys.addaudithook(self._stay)
        self.before = self._states()
        gc.freeze()

    def run(self, number: int, case: Case, is_whole: bool) -> Outcome:
        """Run one case."""
        used = time.process_time()
        limit = LIMIT_S * (4 if sys.gettrace() else 1)
        resource.setrlimit(resource.RLIMIT_CPU, (int(used + limit) + 2, resource.RLIM_INFINITY))
        before = _memory("VmSize")
        resource.setrlimit(resource.RLIMIT_AS, (int(before * (1 << 20)) + _SAFETY_BYTES, resource.RLIM_INFINITY))
        Path("/proc/self/clear_refs").write_text("5")
        resident, children = _memory("VmRSS"), resource.getrusage(resource.RUSAGE_CHILDREN)
        verdict, message = self.judge(case, is_whole)
        seconds = time.process_time() - used
        later = resource.getrusage(resource.RUSAGE_CHILDREN)
        seconds += later.ru_utime + later.ru_stime - children.ru_utime - children.ru_stime
        megabytes = _memory("VmHWM") - resident
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        if os.fstat(2).st_size:
            printed = os.pread(2, 400, 0)
            if self.target.read is not None or _is_foreign(printed.decode(errors="replace"), case):
                verdict, message = "fault", f"printed {printed!r} ({message})"
            os.ftruncate(2, 0)
            os.lseek(2, 0, os.SEEK_SET)
        if seconds > limit:
            verdict, message = "fault", f"slow ({message})"
        if megabytes > LIMIT_MB:
            verdict, message = "fault", f"large ({message})"
        return Outcome(number, verdict, round(seconds, 3), round(megabytes, 1), message)

    def judge(self, case: Case, is_whole: bool) -> tuple[Verdict, str]:
        """Run a case, and say what it came to."""
        verdict, message = "accepted", ""
        try:
            if not is_whole:
                signal.setitimer(signal.ITIMER_PROF, _SHARE_S)
            if self.target.command:
                signal.setitimer(signal.ITIMER_REAL, _IDLE_S)
            try:
                ended = self.target.run(case, self.folder)
            finally:
                signal.setitimer(signal.ITIMER_PROF, 0)
                signal.setitimer(signal.ITIMER_REAL, 0)
            if ended is not None:
                verdict, message = self._judge_end(case, *ended)
        except AtWorkError:
            self._tidy()
        except JobError as error:
            names = [Path(name).name for name in case.files]
            problem = _problem_of(str(error), [str(self.folder), *names], str(self.folder), case)
            verdict, message = ("fault", f"{problem}: {error}") if problem else ("refused", str(error))
        except BaseException as error:
            frame = traceback.extract_tb(error.__traceback__)[-1]
            place = f"{type(error).__name__} in {Path(frame.filename).name}:{frame.lineno}"
            verdict, message = "fault", f"{place}: {error}"[:600]
        return verdict, message

    def _judge_end(self, case: Case, code: int, printed: str) -> tuple[Verdict, str]:
        """Judge how a command ended, what it said, and what it left."""
        left = self._tidy()
        if code not in (0, 1, 2):
            return "fault", f"exit {code}: {printed}"[:600]
        if litter := [name for name in left if ".washboard-" in name]:
            return "fault", f"left {litter[0]} ({printed})"
        if code != 2:
            return ("fault", f"said {printed}"[:600]) if _is_foreign(printed, case) else ("accepted", "")
        problem = _problem_of(printed.strip("\n"), self.inputs.keys() & {*case.words} if case.files else [""], "", case)
        if "error: " not in printed:
            problem = "no error"
        if left:
            problem = f"wrote {left[0]} though it was refused"
        return ("fault", f"{problem}: {printed}"[:600]) if problem else ("refused", printed)

    def _tidy(self) -> list[str]:
        """Put the folder back as it was; gives what is new in it."""
        now = self._states()
        left = [name for name in now if name not in self.before and not name.startswith("tmp/")]
        for name in now.keys() - self.before.keys():
            path = self.folder / name
            shutil.rmtree(path, ignore_errors=True) if path.is_dir() else path.unlink(missing_ok=True)
        if changed := {name: text for name, text in self.inputs.items() if now.get(name) != self.before[name]}:
            self._write(changed)
            self.before = self._states()
        return left

    def _write(self, files: Files) -> None:
        for name, content in files.items():
            (self.folder / name).write_bytes(content)

    def _states(self) -> dict[str, tuple[int, int]]:
        """Every file and folder below, the deepest first."""
        found = sorted(self.folder.rglob("*"), reverse=True)
        states = {str(path.relative_to(self.folder)): path.lstat() for path in found}
        return {name: (0, 0) if path.is_dir() else (state.st_mtime_ns, state.st_size)
                for path, (name, state) in zip(found, states.items(), strict=True)}  # fmt: skip

    def _stay(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Refuse, as a system would, what changes a file outside of the folder."""
        if event not in _CHANGES and (event != "open" or not (arguments[2] or 0) & _WRITES):
            return
        place = arguments[0]
        if isinstance(place, str | bytes | os.PathLike):
            path = os.path.realpath(os.fsdecode(place))
            if not path.startswith((f"{self.folder.parent}/", "/proc/", "/dev/null")) and "__pycache__" not in path:
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(place))


def _stop(number: int, frame: FrameType | None) -> None:
    """Stop a command that is at work, in a line of the product: a library, or an import, is left to finish."""
    files: list[str] = []
    while frame is not None:
        files.append(frame.f_code.co_filename)
        frame = frame.f_back
    if not files[0].startswith(_PRODUCT) or any(word in file for file in files for word in _UNBROKEN):
        signal.setitimer(signal.ITIMER_PROF if number == signal.SIGPROF else signal.ITIMER_REAL, _SHARE_S)
        return
    raise AtWorkError


def _work(*_: object, **__: object) -> NoReturn:
    raise AtWorkError


def _is_foreign(text: str, case: Case) -> bool:
    """Whether a text has words of a library that it does not quote from the input."""
    given = " ".join((*case.words, *(content.decode(errors="replace") for content in case.files.values())))
    return any(found[0] not in given for found in _NOT_A_SENTENCE.finditer(text))


def _problem_of(message: str, named: Iterable[str], folder: str, case: Case) -> str:
    """Why a message is no clear error; empty if it is one. Every line is one, and the first names the file."""
    if not any(name in message.partition("\n")[0] for name in named):
        return "the file is not named"
    if any(not line.strip() or not line.isprintable() for line in message.split("\n")):
        return "an empty line or control characters"
    if _is_foreign(message.replace(folder, "") if folder else message, case):
        return "a library's words"
    if max(map(len, message.split("\n"))) > _LONGEST + len(folder):
        return "too long"
    return ""


def _memory(key: str) -> float:
    """A value of this process's status, MB."""
    status = Path("/proc/self/status").read_text()
    return int(status.partition(f"{key}:")[2].split()[0]) / 1024.0


def run_in_fork(read: Callable[[bytes], bytes], data: bytes, limits: Limits, _: object) -> tuple[int, bytes, str]:
    """Stand in for the child process of a foreign reader by a fork, which is there at once; with its limits."""
    out, log = os.memfd_create("output"), os.memfd_create("log")
    child = os.fork()
    if child == 0:
        try:
            sys.settrace(None)
            for each in (1, 2):
                os.dup2(log, each)
            bound_resources(min(limits.cpu_s, _ENDLESS_S), limits.memory_bytes, limits.written_bytes)
            os.write(out, read(data))
            os._exit(0)
        except BaseException as error:
            os.write(2, f"{error if isinstance(error, SystemExit) else repr(error)}\n".encode())
            os._exit(1)
    try:
        status = os.waitpid(child, 0)[1]
        code = -os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)
        content, text = (os.pread(each, 100 << 20, 0) for each in (out, log))
        return code, content, _COLOUR.sub("", text.decode(errors="replace"))
    except BaseException:
        os.kill(child, signal.SIGKILL)
        raise
    finally:
        os.close(out)
        os.close(log)
