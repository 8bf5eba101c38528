"""Boards that a browser sends: good ones, broken ones, and names that nobody should choose."""

import re
from pathlib import Path

import pytest
from driven_page import CHROMIUM, NO_CHROMIUM, DrivenPage, open_chromium
from sample_boards.write_samples import render_samples
from step_writer import StepWriter

from webui.page import project as projects
from webui.page.project import open_project
from webui.server.server import open_session, serve

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM),
]
KICAD = Path(__file__).parents[2] / "boards" / "data" / "small_v9.kicad_pcb"
CARD = [
    ("board", "card PCB", (40, 30, 1.6), (0, 0, 0)),
    ("U1", "SOIC-8", (5, 4, 1.5), (5, 5, 1.6)),
    ("R1", "R_0603", (1.6, 0.8, 0.5), (-5, 5, 1.6)),
]
SEND = """([name, text]) => {
  const files = new DataTransfer();
  files.items.add(new File([text], name));
  const input = document.querySelector('input[type=file]');
  input.files = files.files;
  input.dispatchEvent(new Event('change', {bubbles: true}));
}"""
WATCH_PROGRESS = """() => {
  window.told = new Set();
  new MutationObserver(() => {
    for (const found of document.body.innerText.matchAll(/[A-Z].*\\u2026 \\d+%/g)) window.told.add(found[0]);
  }).observe(document.body, {subtree: true, childList: true, characterData: true});
}"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    around = tmp_path_factory.mktemp("around")
    (around / "project").mkdir()
    return around / "project"


@pytest.fixture(scope="module")
def tab(folder):
    server = serve(open_session("tiny", "rinse-only"), open_project(folder), "127.0.0.1", 0)
    with open_chromium() as browser:
        tab = DrivenPage(browser, server.address)
        tab.dismiss_notice()
        tab.tab("Board")
        yield tab
        assert tab.errors == []
        assert "Traceback" not in tab.page.locator("body").inner_text()
    server.stop()


def files_around(folder):
    return sorted(str(file.relative_to(folder.parent)) for file in folder.parent.rglob("*") if file.is_file())


def send(tab, name, text):
    tab.page.evaluate(SEND, [name, text])


def refusal(tab):
    """What the page says of the last upload; the message is closed then."""
    notice = tab.page.locator(".mantine-Notification-root").filter(has_text="Not done").first
    notice.wait_for()
    said = notice.inner_text()
    notice.locator("button").click()
    notice.wait_for(state="detached")
    return said


# One test for all names: the page that they share takes ten times as long to open as one of them.
def test_boards_are_sent_kept_and_shown(tab, folder):
    contents = {
        "small.step": StepWriter().write(CARD),
        "small.tri": render_samples()["tiny.tri"],
        "small.kicad_pcb": KICAD.read_text(),
    }
    for name, text in contents.items():
        send(tab, name, text)
        tab.wait_for_input("Workpiece", "(value, name) => value === name", name)
        tab.wait_until_planned()
        assert (folder / name).read_text() == text


def test_what_takes_a_while_says_how_far_it_is(tab):
    tab.page.evaluate(WATCH_PROGRESS)
    send(tab, "demo.tri", render_samples()["smt-demo.tri.gz"])
    tab.wait_for_input("Workpiece", "(value, name) => value === name", "demo.tri")
    # Which of the stages a browser gets to draw depends on how quickly they follow each other.
    stages = re.compile("(Reading|Understanding|Planning|Refining).*\N{HORIZONTAL ELLIPSIS} \\d+%")
    shown = tab.page.evaluate("[...window.told]")
    assert any(stages.fullmatch(each) for each in shown), shown


BROKEN = {
    "text.step": ("hello", "is not a STEP file"),
    "empty.tri": ("", "empty"),
    "cut.tri": ("board-tri 1\nunits mm\nobjects 1\n", "cut.tri"),
    "cut.kicad_pcb": ("(kicad_pcb (version 20221018)", "cut.kicad_pcb"),
    "board.exe": ("MZ", "no reader for this kind of file"),
    "../../above.tri": ("x", "cannot be kept"),
    "a\0b.tri": ("x", "cannot be kept"),
    "%2e%2e%2fabove.tri": ("x", "cannot be kept"),
    ".hidden.tri": ("x", "cannot be kept"),
    f"{'long' * 60}.tri": ("x", "too long a name"),
    "<img src=x onerror=alert(1)>.tri": ("x", "cannot be kept"),
}


def test_what_cannot_be_used_is_refused_and_not_kept(tab, folder):
    before = files_around(folder)
    for name, (text, reason) in BROKEN.items():
        send(tab, name, text)
        assert reason in refusal(tab), name
        assert files_around(folder) == before, name


def test_what_is_too_large_is_refused(tab, folder, monkeypatch):
    monkeypatch.setattr(projects, "LARGEST_UPLOAD", 2_000_000)
    before = files_around(folder)
    send(tab, "large.tri", "x" * 3_000_000)
    assert "3 MB are too many to upload" in refusal(tab)
    assert files_around(folder) == before


def test_the_page_goes_on_after_all_of_them(tab):
    tab.tab("Board")
    tab.choose("Workpiece", "two-sided")
    tab.page.get_by_text("43 (24 top, 19 bottom)").first.wait_for()
    tab.wait_until_planned()
