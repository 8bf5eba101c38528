"""Kill and interrupt commands at random moments, and check what they leave.

    tools/interrupt_commands.py                               100 kills and 100 interrupts of plan, tune, export, ...
    tools/interrupt_commands.py --kills 3 --interrupts 3 --only plan --seed 7

Each run begins with the outputs of an earlier recipe in place and would write those of another one. After it every
output must be that of the one or of the other, byte for byte (of tuning also a whole recipe in between); after the next
writing in the folder nothing else may be there, nor a process of the run. An interrupt (SIGINT; one, two or five in a
row) must end with 130 and exactly one line on stderr. The moments begin when the command listens for signals, 50 ms
after the interpreter was started; half of them lie where a run of the same length writes its results.
"""

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from recipes.errors import RecipeError
from recipes.load import load_recipe
from reports.files.atomic_write import write_bytes_atomically
from specs.temporary import sweep

ROOT = Path(__file__).parents[1]
START = "from commandline.start import main; main()"
SAVES = """
import threading
def save():
    from webui.page.document import open_document
    from pathlib import Path
    texts = [Path(name).read_text("utf-8") for name in ("new.yaml", "old.yaml")]
    document = open_document("mine.yaml")
    while True:
        for text in texts:
            document = document.edited(text).save()
threading.Thread(target=save, daemon=True).start()
"""
"""Saves a recipe over and over, as the page does, in the process of the page's server."""
RECIPES = {"old": "speed_mm_s: 60", "new": "speed_mm_s: 55"}
BURSTS = (1, 1, 2, 5)
LISTENS_S = 60.0
ENDS_S = 120.0
SAVING_S = 1.0
"""How long a server is left to save before it is ended at the latest."""
CHILDREN_S = 5.0
"""A child is ended by its parent's end, not by the signal: it may take a moment."""


@dataclass(frozen=True)
class Job:
    """A command whose outputs differ by the recipe or board, old or new, that it is given."""

    words: tuple[str, ...]
    """``{age}`` stands for old or new."""
    outputs: tuple[str, ...]
    code: str = START
    new_only: tuple[str, ...] = ()
    """Outputs that may not be there before."""
    kept: tuple[str, ...] = ()
    """Files from which it goes on, which an interrupt leaves; with one, recipes may be those of a stage in between."""
    server: bool = False
    """It never ends by itself; an interrupt is its ordinary end."""


JOBS = {
    "plan": Job(
        ("plan", "tiny", "{age}.yaml", "-o", "a.wash", "--report", "a.json", "--picture", "a.png"),
        ("a.wash", "a.json", "a.png"),
    ),
    "tune": Job(
        ("tune", "tiny", "{age}.yaml", "--analyses", "2", "-o", "tuned.yaml", "--report", "tuned.json"),
        ("tuned.yaml", "tuned.json"),
        new_only=("tuned.yaml",),
        kept=("tuned.yaml.tuning",),
    ),
    "export": Job(("export", "{age}.wash", "--cell", "kr6-bench", "--dialect", "kuka", "-o", "robot"), ("robot",)),
    "analyse": Job(
        ("analyse", "{age}.wash", "--date", "2026-01-01", "--html", "a.html", "--json", "a.json"),
        ("a.html", "a.json"),
    ),
    "import": Job(("board", "import", "{age}.step", "-o", "a.tri.gz"), ("a.tri.gz",)),
    "save": Job(
        ("ui", "tiny", "mine.yaml", "--port", "8390"), ("mine.yaml",), code=f"{SAVES}{START}", server=True
    ),
}  # fmt: skip


@dataclass
class Tally:
    """What the runs of one job came to."""

    ends: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Bench:
    """A job with its inputs, and its outputs as they are before and after."""

    job: Job
    before: Path
    known: Mapping[str, tuple[object, object]]
    seconds: float


def main() -> None:
    """Run what the arguments name; exit 1 if there was a fault."""
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("--kills", type=int, default=100)
    reader.add_argument("--interrupts", type=int, default=100)
    reader.add_argument("--seed", type=int, default=1)
    reader.add_argument("--only", action="append", choices=JOBS, help="a command; may be repeated")
    arguments = reader.parse_args()
    chance = random.Random(arguments.seed)
    names = arguments.only or list(JOBS)
    with tempfile.TemporaryDirectory() as place:
        inputs = make_inputs(Path(place) / "inputs", names)
        benches = {name: prepare(JOBS[name], inputs, Path(place) / name) for name in names}
        tallies = {name: Tally() for name in names}
        turns = [signal.SIGKILL] * arguments.kills + [signal.SIGINT] * arguments.interrupts
        for turn, number in enumerate(turns):
            name = names[turn % len(names)]
            run_once(benches[name], number, chance, tallies[name])
    faults = 0
    for name, tally in tallies.items():
        faults += len(tally.faults)
        ends = ", ".join(f"{count} {end}" for end, count in sorted(tally.ends.items()))
        print(f"{name:<8} {benches[name].seconds:5.1f} s  {ends or 'no runs'}", *tally.faults, sep="\n  FAULT ")
    print(f"{arguments.kills} kills, {arguments.interrupts} interrupts, {faults} faults")
    sys.exit(bool(faults))


def make_inputs(folder: Path, names: Iterable[str]) -> Path:
    """Write the two recipes, and what is made of them for the commands that need it."""
    folder.mkdir()
    text = (ROOT / "recipes" / "library" / "smt-aqueous.yaml").read_text("utf-8")
    for age, speed in RECIPES.items():
        changed = text.replace(RECIPES["old"], speed).replace("recipe: smt-aqueous", f"recipe: {age}")
        (folder / f"{age}.yaml").write_text(changed, "utf-8")
        if {"export", "analyse"} & set(names):
            complete(["plan", "tiny", f"{age}.yaml", "-o", f"{age}.wash"], folder)
        if "import" in names:
            write_step(folder / f"{age}.step", 4.0 if age == "old" else 5.0)
    shutil.copy(folder / "old.yaml", folder / "mine.yaml")
    return folder


def write_step(file: Path, width: float) -> None:
    """Write a board with parts as STEP."""
    sys.path.insert(0, str(ROOT / "tests" / "support"))
    from step_writer import StepWriter  # pyright: ignore[reportMissingImports]

    parts = [
        (f"R{index}", "R_0603", (width, 3.0, 1.0), (8.0 + 10.0 * (index % 8), 8.0 + 10.0 * (index // 8), 0.0))
        for index in range(48)
    ]
    board = ("PCB", "PCB", (100.0, 80.0, 1.6), (45.0, 35.0, -1.6))
    file.write_text(StepWriter().write([board, *parts]), "utf-8")


def complete(words: list[str], folder: Path) -> float:
    """Run a command to its end; returns the seconds from when it listened for signals."""
    process = start(Job(tuple(words), ()), words, folder)
    begun = time.monotonic()
    _, errors = process.communicate()
    if process.returncode not in (0, 1):
        raise SystemExit(f"{words}: {errors}")
    return time.monotonic() - begun


def serve(words: list[str], folder: Path, job: Job) -> float:
    """Start a server, end it when it serves, and give the seconds that this took from when it listened for signals."""
    process = start(job, words, folder)
    begun = time.monotonic()
    assert process.stdout is not None
    if not process.stdout.readline():
        raise SystemExit(f"{words}: does not serve: {process.communicate()[1]}")
    seconds = time.monotonic() - begun
    process.terminate()
    process.communicate()
    return seconds


def prepare(job: Job, inputs: Path, place: Path) -> Bench:
    """Make the outputs of the old and of the new input."""
    found: dict[str, Path] = {}
    seconds = 0.0
    for age in RECIPES:
        found[age] = place / age
        shutil.copytree(inputs, found[age])
        if job.server:
            seconds = serve(list(job.words), found[age], job) + SAVING_S
            shutil.copy(inputs / f"{age}.yaml", found[age] / "mine.yaml")
        else:
            seconds = complete([word.format(age=age) for word in job.words], found[age])
    known = {name: (content(found["old"] / name), content(found["new"] / name)) for name in job.outputs}
    for name in job.new_only:
        (found["old"] / name).unlink()
        known[name] = (None, known[name][1])
    same = [name for name, (old, new) in known.items() if old == new]
    if same:
        raise SystemExit(f"{job.words}: {same} are the same for both inputs")
    return Bench(job, found["old"], known, seconds)


def run_once(bench: Bench, number: signal.Signals, chance: random.Random, tally: Tally) -> None:
    """End one run at a random moment, and check what it leaves."""
    with tempfile.TemporaryDirectory() as place:
        folder, temporary = Path(place) / "work", Path(place) / "tmp"
        shutil.copytree(bench.before, folder)
        temporary.mkdir()
        process = start(bench.job, [word.format(age="new") for word in bench.job.words], folder, temporary)
        moment = bench.seconds * chance.choice((chance.uniform(0.0, 1.0), chance.uniform(0.85, 1.05)))
        burst = 1 if number == signal.SIGKILL else chance.choice(BURSTS)
        time.sleep(moment)
        for _ in range(burst):
            process.send_signal(number)
            time.sleep(0.001)
        try:
            out, errors = process.communicate(timeout=ENDS_S)
        except subprocess.TimeoutExpired:
            process.kill()
            out, errors = process.communicate()
            errors += "DID NOT END"
        end, faults = judge_end(bench.job, number, process.returncode, (out, errors))
        states = {name: state_of(content(folder / name), known) for name, known in bench.known.items()}
        if bench.job.kept:
            states |= {name: "between" for name, state in states.items() if state == "other" and reads(folder / name)}
        faults += [f"{name} is neither old nor new" for name, state in states.items() if state == "other"]
        faults += left_behind(bench, folder, temporary)
        tally.ends[f"{end} {'/'.join(sorted(set(states.values())))}"] += 1
        tally.faults += [f"{number.name} x{burst} at {moment:.3f} s: {fault}" for fault in faults]


def judge_end(job: Job, number: signal.Signals, code: int, printed: tuple[str, str]) -> tuple[str, list[str]]:
    """How a run ended, and what is wrong with that."""
    out, errors = printed
    if number == signal.SIGKILL:
        return ("killed" if code == -signal.SIGKILL else "done"), []
    if job.server and code == 0:
        return "stopped", [] if (out.endswith("Stopped.\n"), errors) == (True, "") else [f"printed {out!r} {errors!r}"]
    if code == 130:
        right = errors.startswith("error: interrupted; ") and errors.count("\n") == 1 and errors.endswith("\n")
        return "interrupted", [] if right else [f"printed {errors!r}"]
    return "done", [] if code in (0, 1) and errors == "" else [f"exit {code}, printed {errors!r}"]


def left_behind(bench: Bench, folder: Path, temporary: Path) -> list[str]:
    """Processes that live on, and files that are still there after the next writing."""
    deadline = time.monotonic() + CHILDREN_S
    while (children := processes_of(temporary)) and time.monotonic() < deadline:
        time.sleep(0.02)
    faults = [f"a process lives on: {line}" for line in children]
    write_bytes_atomically(folder / "next", b"")
    sweep(temporary)
    expected = {each.name for each in bench.before.iterdir()} | {
        "next",
        ".washboard",
        *bench.job.outputs,
        *bench.job.kept,
    }
    litter = [*(each.name for each in folder.iterdir() if each.name not in expected)]
    litter += [each.name for each in temporary.iterdir() if each.name.startswith((".", "washboard"))]
    return faults + [f"{name} is left" for name in litter]


def processes_of(temporary: Path) -> list[str]:
    """Command lines of the processes that were started with this folder for temporary files."""
    found: list[str] = []
    for each in Path("/proc").glob("[0-9]*"):
        try:
            if os.fsencode(f"TMPDIR={temporary}") in (each / "environ").read_bytes().split(b"\0"):
                found.append((each / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")[:80])
        except OSError:
            continue
    return found


def start(job: Job, words: list[str], folder: Path, temporary: Path | None = None) -> subprocess.Popen[str]:
    """Start a command, and wait until it listens for signals."""
    more = {} if temporary is None else {"TMPDIR": str(temporary)}
    process = subprocess.Popen(
        [sys.executable, "-c", job.code, *words], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)} | more,
    )  # fmt: skip
    deadline = time.monotonic() + LISTENS_S
    while process.poll() is None and not listens(process.pid):
        if time.monotonic() > deadline:
            raise SystemExit(f"{words}: does not listen for signals")
        time.sleep(0.001)
    return process


def listens(pid: int) -> bool:
    """Whether a process has a handler for SIGTERM; the interpreter itself has none."""
    try:
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    except OSError:
        return True
    caught = next((int(line.split()[1], 16) for line in lines if line.startswith("SigCgt")), 0)
    return bool(caught >> (signal.SIGTERM - 1) & 1)


def content(path: Path) -> object:
    """Bytes of a file, or those of all files in a folder; ``None`` where nothing is."""
    if path.is_dir():
        return {each.name: each.read_bytes() for each in path.iterdir()}
    return path.read_bytes() if path.exists() else None


def reads(path: Path) -> bool:
    """Whether a file is a whole recipe."""
    try:
        load_recipe(path)
    except RecipeError:
        return False
    return path.suffix == ".yaml"


def state_of(found: object, known: tuple[object, object]) -> str:
    """Old, new, or other."""
    return "old" if found == known[0] else "new" if found == known[1] else "other"


if __name__ == "__main__":
    main()
