"""How old is what the page of ``washboard ui`` shows of a running operation, and how long its STOP takes.

Run: ``OMP_NUM_THREADS=1 python benchmarks/live.py [RUNS] [PICTURES]``

Three processes, as on a machine: the page's server, the operation, and here a controller behind Modbus with the
browser. Ages are those that the page itself shows: of the band, from the browser's request to the operating process,
and of the robot in the scene, by way of the server of the page; the operation's clock is the reference. The stop is
pressed while the page's server is halted (SIGSTOP) and takes from the click until every valve is shut. Chromium has
no graphics card here and draws on the processors that serve. Every number is also given as a share of 200 ms.
"""

import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "support"))

import numpy as np
from driven_page import DrivenPage, open_chromium
from model_controller import ModbusController, ModelController, free_port
from operated import model_of

from robotcell.cell.load import cell_library, read_cell
from robotcell.operate.nodes import read_job
from robotcell.operate.reference.program import program_for

ALLOWED_MS = 200.0
LOOKS, EVERY_MS = 300, 50
MOST_S = 120.0
WATCHDOG_S = 0.5
"""The browser draws on the cores of the operating process, which waits for one now and then."""
CELL, BOARD, RECIPE = "cairo-bench", "tiny", "smt-aqueous"
WASHBOARD = [str(Path(sys.executable).with_name("washboard"))]
AGES = """() => {
  const read = selector => {
    const text = document.querySelector(selector).textContent, number = parseFloat(text.replace(/^[^0-9]*/, ''));
    return Number.isNaN(number) ? null : / s old/.test(text) ? 1000 * number : number;
  };
  return [read('#wb-live [data-live=age]'), read('#wb-live-scene')];
}"""

CLICK = """() => {
  const clicked = performance.timeOrigin + performance.now();
  document.querySelector('#wb-live [data-live=stop]').click();
  return clicked;
}"""


@contextmanager
def process(folder: Path, *words: str) -> Iterator[subprocess.Popen[str]]:
    """A washboard command, ended by its own id."""
    with subprocess.Popen(
        [*WASHBOARD, *words], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as running:
        try:
            yield running
        finally:
            running.send_signal(signal.SIGCONT)
            running.terminate()
            running.wait(30)


def prepare(folder: Path) -> tuple[ModbusController, ModelController]:
    """Plan and export a program, and serve a controller for it."""
    subprocess.run(
        [*WASHBOARD, "plan", BOARD, RECIPE, "-o", "job.wash"], cwd=folder, check=True, stdout=subprocess.DEVNULL
    )
    text = cell_library()[CELL].read_text("utf-8")
    (folder / "bench.yaml").write_text(text)
    export = [
        "export",
        "job.wash",
        "--cell",
        "bench.yaml",
        "--board",
        BOARD,
        "--dialect",
        "joint-table",
        "-o",
        "job.csv",
    ]
    subprocess.run([*WASHBOARD, *export], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    loaded = read_cell(folder / "bench.yaml")
    job, program = read_job((folder / "job.csv").read_text(), loaded), program_for(loaded)
    model = model_of(job, haste=1.0, inputs=program.inputs, readings=program.readings)
    controller = ModbusController(model, loaded=loaded)
    link = re.sub(r"(?m)^  link: .*$", f"  link: {controller.link}\n  watchdog_s: {WATCHDOG_S}", text)
    assert link != text
    (folder / "bench.yaml").write_text(link)
    return controller, model


def measure(folder: Path, model: ModelController, pictures: Path | None) -> tuple[np.ndarray, float]:
    """Ages (looks, 2) in ms of band and scene, and the seconds from the click until every valve is shut."""
    ui_port = free_port()
    ui_words = ("ui", BOARD, RECIPE, "--cell", "bench.yaml", "--port", str(ui_port))
    with (
        process(folder, *ui_words) as ui,
        process(folder, "operate", "job.csv", "--cell", "bench.yaml", "--live", "0"),
        open_chromium() as browser,
    ):
        assert ui.stdout is not None
        (address,) = re.findall(r"Washboard is at (\S+)", ui.stdout.readline())
        window = browser.new_page(viewport={"width": 1440, "height": 900})
        tab = DrivenPage(browser, address, window, all_frames=True)
        tab.tab("Live")
        tab.press("Watch")
        tab.page.locator("#wb-live b").get_by_text("running").wait_for()
        tab.page.wait_for_function("() => /scene \\d+ ms/.test(document.getElementById('wb-live-scene').textContent)")
        ages = []
        for _ in range(LOOKS):
            ages.append(tab.page.evaluate(AGES))
            tab.page.wait_for_timeout(EVERY_MS)
        if pictures is not None:
            take_pictures(DrivenPage(browser, address, tab.page, sharpness=1.0), pictures)
        until = time.monotonic() + MOST_S
        while not model.open:
            assert time.monotonic() < until, model.mode
            time.sleep(0.01)
        ui.send_signal(signal.SIGSTOP)
        clicked = tab.page.evaluate(CLICK) / 1e3 - time.time() + time.monotonic()
        while model.open or model.switched[-1][0] < clicked:
            assert time.monotonic() < until, model.mode
            time.sleep(0.001)
        shut = model.switched[-1][0] - clicked
        if pictures is not None:
            tab.page.wait_for_timeout(1500)
            tab.picture(pictures / "live-hung.png")
    return np.array(ages, dtype=np.float64), shut


def take_pictures(tab: DrivenPage, folder: Path) -> None:
    """Pictures of the page, light and dark, with the whole cell in the scene."""
    tab.dismiss_notice()
    for name in ("light", "dark"):
        if name == "dark":
            tab.page.get_by_role("button", name="Dark colours").click()
            tab.wait_until_planned()
            tab.dismiss_notice()
        tab.tab("Robot")
        tab.press("Whole cell")
        tab.tab("Live")
        tab.page.wait_for_timeout(8000)
        tab.picture(folder / f"live-{name}.png")


def main(words: list[str]) -> None:
    runs = int(words[0]) if words else 3
    pictures = Path(words[1]) if len(words) > 1 else None
    for run in range(runs):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            controller, model = prepare(folder)
            try:
                ages, shut = measure(folder, model, pictures if run == 0 else None)
            finally:
                controller.close()
        print(f"run {run + 1}, load {os.getloadavg()[0]:.1f}")
        for what, column in zip(("band", "scene"), ages.T, strict=True):
            known = column[np.isfinite(column)]
            median, late, most = np.percentile(known, (50, 99, 100))
            print(
                f"  {what:<5} {len(known)} looks: median {median:.0f} ms, 99 % {late:.0f}, at most {most:.0f} ms: "
                f"{most / ALLOWED_MS:.2f} of {ALLOWED_MS:g} ms; {np.mean(known <= ALLOWED_MS):.1%} are not older"
            )
        print(f"  stop  {1e3 * shut:.0f} ms to valves shut, the page's server halted: {1e3 * shut / ALLOWED_MS:.2f}")


if __name__ == "__main__":
    main(sys.argv[1:])
