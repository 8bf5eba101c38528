"""An engineer's way from a program to what it cleans, in a real browser."""

import io

import numpy as np
import pytest
from driven_page import CHROMIUM, NO_CHROMIUM, DrivenPage, open_chromium
from PIL import Image

from webui.layers.surface.heat_scale import FAILS, PASSES

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)]


def scene_pixels(tab):
    """(n, 3) of the picture, without what is laid over it."""
    tab.page.evaluate("document.querySelectorAll('canvas').forEach(each => { each.style.opacity = '1'; })")
    shot = Image.open(io.BytesIO(tab.page.locator("canvas").first.screenshot())).convert("RGB")
    return np.asarray(shot).reshape(-1, 3).astype(int)


def count_of(pixels, colour):
    return int((np.abs(pixels - np.array(colour)).max(axis=1) <= 3).sum())


def wait_for_colour(tab, colour, least, most=np.inf):
    for _ in range(180):
        if least <= count_of(scene_pixels(tab), colour) <= most:
            return
        tab.page.wait_for_timeout(500)
    raise AssertionError(f"{colour} is not seen")


def test_from_a_program_to_its_worst_part(start_server, tmp_path):
    steps = "".join(f"  - {{function: {name}, nozzle: ring60, paths: [sweep]}}\n" for name in ("clean", "rinse"))
    recipe = tmp_path / "hurried.yaml"
    recipe.write_text(f"recipe: hurried\nextends: smt-aqueous\nsequence:\n{steps}", "utf-8")
    server = start_server("tiny", str(recipe))
    with open_chromium() as browser:
        tab = DrivenPage(browser, server.address, sharpness=0.5)
        tab.tab("Cleaning")
        tab.see("Not analysed yet")
        tab.choose("Effort", "Sketch")
        tab.press("Analyse")
        tab.see("no proof of cleanliness")
        report = server.sessions.pages()[0].session.analysis.report
        worst = report.worst_first()[0]
        tab.press("Worst")
        tab.see(worst.judgements[0].because)
        page = server.sessions.pages()[0]
        assert page.session.selection.component == worst.component
        rows = tab.page.locator("tr[data-row]").filter(visible=True)
        names = rows.evaluate_all("rows => rows.map(row => row.dataset.row)")
        other = next(name for name in names if name != worst.component)
        rows.nth(names.index(other)).click()
        tab.wait_until(lambda: page.session.selection.component == other)
        tab.press("Worst")
        tab.wait_until(lambda: page.session.selection.component == worst.component)
        assert tab.input("Show").input_value() == "Verdict"  # the first analysis shows it
        tab.see("What limits it")
        tab.see("Gap from above")
        tab.page.get_by_role("img", name=f"Gap under {worst.component} from above").wait_for()
        tab.choose("In the gap", "Pressure")
        tab.tab("Board")
        tab.press("Top side")
        tab.tab("Cleaning")
        tab.choose("Show", "Volume")
        tab.choose("Colours", "Pass or fail")
        tab.type("Limit (mm)", "1")
        wait_for_colour(tab, PASSES, 1000)
        tab.type("Limit (mm)", "1000000")
        wait_for_colour(tab, FAILS, 1000)
        wait_for_colour(tab, PASSES, 0, most=0)
        tab.choose("Show", "Residue under parts")
        tab.see("of the parts' surface")
        tab.choose("Show", "Nothing")
        assert tab.errors == []
        assert tab.strangers == []


def test_what_was_analysed_outlives_a_reload_and_not_an_edit(start_server):
    server = start_server("tiny", "rinse-only")
    with open_chromium() as browser:
        tab = DrivenPage(browser, server.address)
        tab.tab("Cleaning")
        tab.choose("Effort", "Sketch")
        tab.press("Analyse")
        tab.see("no proof of cleanliness")
        tab.reload()
        tab.tab("Cleaning")
        tab.see("no proof of cleanliness")
        tab.choose("Show", "Volume")
        tab.page.get_by_label("As it grows").first.click()
        tab.see("nothing landed: 100 %")
        tab.press("Play")
        tab.page.wait_for_function("() => !document.body.innerText.includes('nothing landed: 100 %')")
        tab.tab("Files")
        tab.choose("File", "Cleaning report (JSON)")
        with tab.page.expect_download() as waiting:
            tab.press("Download")
        assert b"washboard_cleaning_report" in waiting.value.path().read_bytes()
        before = tab.time_text
        template = server.sessions.pages()[0].session.recipe.sequence[0].paths[0]
        tab.edit(template, "Speed (mm/s)", "20")
        tab.wait_for_another_time(before)
        tab.tab("Cleaning")
        tab.see("changed since it was analysed")
        assert tab.errors == []
