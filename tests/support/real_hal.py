"""LinuxCNC's real HAL, headless, with the file that ``washboard operate --hal`` writes; every servo cycle is logged.

As in ``real_linuxcnc`` each run has namespaces of its own. HAL itself refuses root and is an ordinary user's; the
command runs as root, from its virtual environment.
"""

import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from real_linuxcnc import CYCLE_S, USER

WASHBOARD = f"{sys.executable} -c 'from commandline.start import main; main()'"
_INPUTS = 4
_TEST = """loadrt or2 count={inputs}
loadrt ilowpass
loadrt constant count=2
loadrt sampler depth=200000 cfg={sampled}
addf sampler.0 servo-thread
addf ilowpass.0 servo-thread
addf constant.0 servo-thread
addf constant.1 servo-thread
setp constant.0.value 10
net wb-ai-0 constant.0.out
setp constant.1.value 5
net wb-ai-1 constant.1.out
setp ilowpass.0.scale 1
setp ilowpass.0.gain 1
net wb-routine => ilowpass.0.in
net wb-routine-done ilowpass.0.out
setp sampler.0.enable 0
"""
_SCRIPT = """cd {folder}
as="runuser -u {user} -- env HOME={folder}"
for file in threads.hal cell.hal test.hal; do $as halcmd -f $file || exit 1; done
$as halsampler -t samples > /dev/null &
sleep 0.5
$as halcmd setp sampler.0.enable 1
{commands}
sleep 0.5
$as halcmd setp sampler.0.enable 0
sleep 1
echo OVERRUNS $($as halcmd getp sampler.0.overruns)
$as halrun -U
"""


@dataclass(frozen=True, slots=True, eq=False)
class HalLog:
    """What HAL did in each servo cycle."""

    joints: NDArray[np.float64]
    """(n, dof) degrees and mm."""
    valves: NDArray[np.bool_]
    """(n, valves)"""
    sequence: NDArray[np.int64]
    """(n,) sequence number of the last node passed."""
    emergency: NDArray[np.bool_]
    """(n,) whether the emergency stop is released."""
    printed: str

    def edges(self, valve: int = 0) -> list[tuple[int, bool]]:
        """Cycles at which a valve changes, and to what."""
        at = np.flatnonzero(self.valves[1:, valve] != self.valves[:-1, valve]) + 1
        return [(int(cycle), bool(self.valves[cycle, valve])) for cycle in at]


class HalError(Exception):
    """HAL did not run to the end, or samples were lost."""


def run_on_hal(table: str, cell: str, commands: str, dof: int, valves: tuple[str, ...], limit_s: float) -> HalLog:
    """Run shell commands beside HAL.

    Args:
        table: Joint table, as ``job.csv`` in the folder of the commands.
        cell: Text of the cell whose HAL file is loaded, as ``cell.yaml`` in the folder of the commands.
        commands: Of the shell; ``$washboard`` is the command.
        dof: Joints of the cell.
        valves: Names of outputs to log.
        limit_s: After so long the run is stopped.

    Raises:
        HalError: samples were lost, or there are none.
    """
    with tempfile.TemporaryDirectory(prefix="washboard-hal-") as name:
        folder = Path(name)
        (folder / "job.csv").write_text(table)
        (folder / "cell.yaml").write_text(cell)
        (folder / "threads.hal").write_text(f"loadrt threads name1=servo-thread period1={round(CYCLE_S * 1e9)}\n")
        subprocess.run(
            f"{WASHBOARD} operate --cell {folder}/cell.yaml --hal {folder}/cell.hal",
            shell=True,
            check=True,
            capture_output=True,
        )
        lines = [_TEST.format(inputs=_INPUTS, sampled="f" * dof + "b" * (len(valves) + 1) + "s")]
        sources = [*(f"wb-joint-{at}" for at in range(dof)), *(f"wb-out-{valve}" for valve in valves), "wb-in-2"]
        lines += [f"net {source} => sampler.0.pin.{at}\n" for at, source in enumerate(sources)]
        counter = sum(1 for line in (folder / "cell.hal").read_text().splitlines() if "streamer.0.pin." in line)
        lines.append(f"net wb-sequence streamer.0.pin.{counter} => sampler.0.pin.{len(sources)}\n")
        for at in range(_INPUTS):
            lines += [f"addf or2.{at} servo-thread\n", f"setp or2.{at}.in0 1\n", f"net wb-in-{at} or2.{at}.out\n"]
        (folder / "test.hal").write_text("".join((*lines, "start\n")))
        script = _SCRIPT.format(folder=folder, user=USER, commands=commands)
        (folder / "run.sh").write_text(f'washboard="{WASHBOARD}"\nrun() {{ eval "$washboard $*"; }}\n{script}')
        for path in (folder, *folder.rglob("*")):
            shutil.chown(path, USER)
        spaces = ["unshare", "--ipc", "--pid", "--net", "--mount", "--fork", "--kill-child", "--mount-proc"]
        done = subprocess.run(
            [*spaces, "bash", f"{folder}/run.sh"], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, timeout=limit_s, check=False, text=True,
        )  # fmt: skip
        samples = folder / "samples"
        rows = np.loadtxt(samples, ndmin=2) if samples.exists() and samples.stat().st_size else np.empty((0, 0))
    if "OVERRUNS 0" not in done.stdout or len(rows) == 0:
        raise HalError(done.stdout[-3000:])
    values = rows[:, 1:]
    end = dof + len(valves)
    return HalLog(
        values[:, :dof], values[:, dof:end] > 0.5, values[:, -1].astype(int), values[:, end] > 0.5, done.stdout
    )
