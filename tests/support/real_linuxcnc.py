"""LinuxCNC's real motion controller, headless: it runs a program, and every servo cycle is logged.

The controller counts its time in servo cycles of 1 ms, so what it does is the same on a busy machine. It needs Debian's
``linuxcnc-uspace``, and root, who gives each run namespaces of its own: two controllers of one machine would share
their memory. ``rtapi_app`` in turn refuses root, so the run itself is an ordinary user's.
"""

import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

USER = "nobody"
CYCLE_S = 1e-3
MISSING = next(
    (f"{tool} is not there: the real controller is not tried" for tool in ("linuxcnc", "script", "unshare", "runuser")
     if shutil.which(tool) is None),
    "" if os.geteuid() == 0 else "only root can give a controller namespaces of its own",
)  # fmt: skip
"""Why no run is possible; empty where one is."""

_READING_V = 10.0
"""All analog inputs, so that loops that wait for a quantity end after one turn."""
_PROGRAM = "program"
_LOG = "log"
_DISPLAY = """#!/usr/bin/python3
import os, signal, subprocess, sys, time
import linuxcnc
command, status, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
def report():
    while message := errors.poll():
        print("MESSAGE", message[1], flush=True)
def do(action, *words):
    getattr(command, action)(*words)
    command.wait_complete()
def kill_task():
    task = subprocess.run(["pidof", "milltask"], capture_output=True, text=True, check=True).stdout.split()
    os.kill(int(task[0]), signal.SIGKILL)
    time.sleep(3.0)
time.sleep(1.0)
do("state", linuxcnc.STATE_ESTOP_RESET)
do("state", linuxcnc.STATE_ON)
do("mode", linuxcnc.MODE_MANUAL)
for joint in range({joints}):
    command.home(joint)
for _ in range(200):
    status.poll()
    time.sleep(0.05)
    if all(status.homed[:{joints}]):
        break
log = subprocess.Popen(["halsampler", "log"])
subprocess.run(["halcmd", "setp", "sampler.0.enable", "1"], check=True)
do("mode", linuxcnc.MODE_AUTO)
command.program_open({program!r})
begun = time.monotonic()
command.auto(linuxcnc.AUTO_RUN, 0)
idle, changes, was_on = 0, 0, 0
while time.monotonic() < begun + {limit_s} and idle < 25:
    time.sleep(0.02)
    status.poll()
    report()
    is_on = status.dout[{stop_at} or 0]
    if {stop_at} is not None and is_on != was_on:
        changes, was_on = changes + 1, is_on
        if changes == {stop_after}:
            {stop}
    idle = idle + 1 if status.interp_state == linuxcnc.INTERP_IDLE and status.inpos else 0
print("ENDED" if idle else "STOPPED", flush=True)
report()
subprocess.run(["halcmd", "setp", "sampler.0.enable", "0"], check=True)
time.sleep(1.0)
print("OVERRUNS", subprocess.run(["halcmd", "getp", "sampler.0.overruns"], capture_output=True, text=True).stdout)
log.terminate()
"""

Stop: TypeAlias = Literal["abort", "emergency stop", "kill"]
_STOPS: dict[Stop, str] = {
    "abort": "command.abort()",
    "emergency stop": "command.state(linuxcnc.STATE_ESTOP)",
    "kill": "kill_task(); idle = 1; break",  # the task controller: no one is left to shut anything
}


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis of the machine; mm or degrees, and seconds."""

    letter: str
    turns: bool
    least: float
    most: float
    speed: float
    acceleration: float


@dataclass(frozen=True, slots=True, eq=False)
class ControllerLog:
    """What the controller did, from the first servo cycle of the program to its last."""

    joints: NDArray[np.float64]
    """(n, dof) mm and degrees, at each cycle."""
    outputs: dict[str, NDArray[np.float64]]
    """(n,) values of the outputs that the program names: ``P1`` digital, ``E0`` analog."""
    blocks: NDArray[np.int64]
    """(n,) number of the block in its file."""
    messages: tuple[str, ...]

    @property
    def seconds(self) -> NDArray[np.float64]:
        """(n,) since the first cycle."""
        return np.arange(len(self.joints)) * CYCLE_S

    def edges(self, output: str) -> list[tuple[float, bool]]:
        """Times at which a digital output changes, and to what."""
        values = self.outputs[output] > 0.5
        at = np.flatnonzero(values[1:] != values[:-1]) + 1
        return [(float(self.seconds[cycle]), bool(values[cycle])) for cycle in at]

    @property
    def moving(self) -> slice:
        """Cycles from the one before the first motion to the last in which an axis moves."""
        moves = np.flatnonzero(np.abs(np.diff(self.joints, axis=0)).max(axis=1) > 0.0)
        return slice(int(moves[0]), int(moves[-1]) + 2) if len(moves) else slice(0, 0)


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What a run finds around it."""

    interpreter: tuple[str, ...] = ()
    """Further lines of the INI file's section ``RS274NGC``."""
    contacts: tuple[int, ...] = ()
    """Digital inputs that are on."""
    stop_at: int | None = None
    """Digital output: an operator stops the program some 20 ms after it changes; ``None`` for never."""
    stop_after: int = 1
    """Which change that is: 1 where it comes on first, 2 where it is off again."""
    stop: Stop = "abort"
    """How."""
    wiring: str = ""
    """Further lines of the HAL file."""
    watch: str = ""
    """A component of these lines' own, ``task_alive.py``."""
    sampled: Mapping[str, str] = field(default_factory=dict[str, str])
    """Pins that are logged in place of the controller's own, by those."""


class ControllerError(Exception):
    """The controller did not run the program to its end."""


def run_on_linuxcnc(
    program: Path,
    axes: Sequence[Axis],
    kinematics: str = "",
    *,
    pivot_mm: float = 0.0,
    limit_s: float = 600.0,
    around: Surroundings | None = None,
) -> ControllerLog:
    """Run a program, a file or the main file of a folder of files, and log every servo cycle.

    Args:
        program: G-code.
        axes: In the order of the machine's joints.
        kinematics: As the INI file has it; left out, each joint is an axis.
        pivot_mm: Pivot length of ``5axiskins``, whose joints are X, Y, Z, B, C, W.
        limit_s: After so long the run is stopped.
        around: INI, contacts, and what an operator does; left out, a plain machine that is left alone.

    Raises:
        ControllerError: it did not end, samples were lost, or there is nothing in the log.
    """
    around = around or Surroundings()
    text = "".join(file.read_text("ascii") for file in sorted(program.parent.glob("*.ngc")))
    digital = sorted({int(number) for number in re.findall(r"M6[2-5] P(\d+)", text)})
    analog = sorted({int(number) for number in re.findall(r"M6[78] E(\d+)", text)})
    with tempfile.TemporaryDirectory(prefix="washboard-linuxcnc-") as name:
        folder = Path(name)
        shutil.copytree(
            program.parent, folder / _PROGRAM, ignore=lambda _, names: [n for n in names if n[-4:] != ".ngc"]
        )
        (folder / "machine.ini").write_text(
            _ini(axes, kinematics or _trivial(axes), 2.0 * pivot_mm, around.interpreter), "ascii"
        )
        pivot = [f"setp 5axiskins.pivot-length {pivot_mm:g}\n"] if pivot_mm else []
        (folder / "machine.hal").write_text("".join((_hal(len(axes), digital, analog, around), *pivot)), "ascii")
        (folder / "task_alive.py").write_text(around.watch, "ascii")
        (folder / "task_alive.py").chmod(0o755)
        (folder / "tool.tbl").write_text("".join(f"T{n} P{n} D0 Z0\n" for n in range(1, 10)), "ascii")
        display = folder / "display.py"
        main = str(folder / _PROGRAM / program.name)
        display.write_text(
            _DISPLAY.format(
                joints=len(axes),
                program=main,
                limit_s=limit_s,
                stop_at=around.stop_at,
                stop_after=around.stop_after,
                stop=_STOPS[around.stop],
            ),
            "ascii",
        )
        display.chmod(0o755)
        (folder / "home").mkdir()
        shutil.chown(folder, USER)
        for path in folder.rglob("*"):
            shutil.chown(path, USER)
        printed = _run(folder, limit_s + 60.0)
        log = folder / _LOG
        rows = np.loadtxt(log, ndmin=2) if log.exists() and log.stat().st_size else np.empty((0, 0))
    if "ENDED" not in printed or len(rows) == 0 or not re.search(r"OVERRUNS 0\b", printed):
        raise ControllerError(f"{program.name}: the controller did not run it to the end:\n{printed[-3000:]}")
    dof = len(axes)
    names = [*(f"P{number}" for number in digital), *(f"E{number}" for number in analog)]
    return ControllerLog(
        joints=rows[:, :dof],
        outputs={each: rows[:, dof + column] for column, each in enumerate(names)},
        blocks=rows[:, -1].astype(np.int64),
        messages=tuple(re.findall(r"^MESSAGE (.*?)\r?$", printed, re.MULTILINE)),
    )


def _run(folder: Path, limit_s: float) -> str:
    """Run the controller as an ordinary user, in namespaces of its own and with a terminal; give what it printed."""
    start = f"linuxcnc -v {folder}/machine.ini"
    command = ["runuser", "-u", USER, "--", "env", f"HOME={folder}/home", "script", "-qec", start, "/dev/null"]
    spaces = ["unshare", "--ipc", "--pid", "--net", "--mount", "--fork", "--kill-child", "--mount-proc"]
    try:
        done = subprocess.run(
            [*spaces, *command], cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, timeout=limit_s, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired as late:
        return (late.stdout or b"").decode("utf-8", "replace")
    return done.stdout.decode("utf-8", "replace")


def _trivial(axes: Sequence[Axis]) -> str:
    return f"trivkins coordinates={''.join(axis.letter for axis in axes)}"


def _ini(axes: Sequence[Axis], kinematics: str, wider_mm: float, interpreter: Sequence[str]) -> str:
    """The machine: limits of its axes, homed where they stand, at 0; tool points may go farther than joints."""
    straight = [axis for axis in axes if not axis.turns]
    turning = [axis for axis in axes if axis.turns]
    sections = {
        "EMC": ["VERSION = 1.1", "MACHINE = washboard", "DEBUG = 0"],
        "DISPLAY": ["DISPLAY = ./display.py"],
        "TASK": ["TASK = milltask", "CYCLE_TIME = 0.001"],
        "RS274NGC": ["PARAMETER_FILE = machine.var", f"SUBROUTINE_PATH = {_PROGRAM}", *interpreter],
        "EMCMOT": ["EMCMOT = motmod", "COMM_TIMEOUT = 1.0", "SERVO_PERIOD = 1000000"],
        "EMCIO": ["EMCIO = io", "CYCLE_TIME = 0.02", "TOOL_TABLE = tool.tbl"],
        "HAL": ["HALFILE = machine.hal"],
        "TRAJ": [
            f"COORDINATES = {' '.join(axis.letter for axis in axes)}",
            "LINEAR_UNITS = mm",
            "ANGULAR_UNITS = degree",
            "DEFAULT_LINEAR_VELOCITY = 100",
            f"MAX_LINEAR_VELOCITY = {sum(axis.speed**2 for axis in straight) ** 0.5:g}",
            f"MAX_ANGULAR_VELOCITY = {max((axis.speed for axis in turning), default=360.0):g}",
            "NO_FORCE_HOMING = 1",
        ],
        "KINS": [f"KINEMATICS = {kinematics}", f"JOINTS = {len(axes)}"],
    }
    for number, axis in enumerate(axes):
        limits = [
            f"MIN_LIMIT = {axis.least:g}", f"MAX_LIMIT = {axis.most:g}", f"MAX_VELOCITY = {axis.speed:g}",
            f"MAX_ACCELERATION = {axis.acceleration:g}",
        ]  # fmt: skip
        farther = 0.0 if axis.turns else wider_mm
        sections[f"AXIS_{axis.letter}"] = [
            f"MIN_LIMIT = {axis.least - farther:g}", f"MAX_LIMIT = {axis.most + farther:g}", *limits[2:],
        ]  # fmt: skip
        sections[f"JOINT_{number}"] = [
            f"TYPE = {'ANGULAR' if axis.turns else 'LINEAR'}", "HOME = 0", *limits, "FERROR = 1000",
            "MIN_FERROR = 1000", "HOME_SEQUENCE = 0", "HOME_SEARCH_VEL = 0", "HOME_LATCH_VEL = 0",
        ]  # fmt: skip
    return "".join(f"[{name}]\n" + "".join(f"{line}\n" for line in lines) for name, lines in sections.items())


def _hal(joints: int, digital: Sequence[int], analog: Sequence[int], around: Surroundings) -> str:
    """Motors that follow at once, and a sampler of joints, outputs and the block's number in each servo cycle."""
    sampled = "f" * joints + "b" * len(digital) + "f" * len(analog) + "s"
    sources = [
        *(f"motion.digital-out-{number:02d}" for number in digital),
        *(f"motion.analog-out-{number:02d}" for number in analog),
        "motion.program-line",
    ]
    lines = [
        "loadrt [KINS]KINEMATICS",
        "loadrt [EMCMOT]EMCMOT servo_period_nsec=[EMCMOT]SERVO_PERIOD num_joints=[KINS]JOINTS num_dio=64 num_aio=64",
        f"loadrt sampler depth=60000 cfg={sampled}",
        "addf motion-command-handler servo-thread",
        "addf motion-controller servo-thread",
        *around.wiring.splitlines(),
        "addf sampler.0 servo-thread",
        *(f"net j{n} joint.{n}.motor-pos-cmd => joint.{n}.motor-pos-fb sampler.0.pin.{n}" for n in range(joints)),
        *(
            f"net s{n} {around.sampled.get(source, source)} => sampler.0.pin.{joints + n}"
            for n, source in enumerate(sources)
        ),
        "setp sampler.0.enable 0",
        *(f"setp motion.analog-in-{number:02d} {_READING_V:g}" for number in range(8)),
        *(f"setp motion.digital-in-{number:02d} 1" for number in around.contacts),
        "net estop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in",
        "net prepare iocontrol.0.tool-prepare => iocontrol.0.tool-prepared",
        "net change iocontrol.0.tool-change => iocontrol.0.tool-changed",
    ]
    return "".join(f"{line}\n" for line in lines)
