"""A real page in a real browser: what somebody does with it, and what the browser complained about meanwhile."""

import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
from playwright.sync_api import Browser, Locator, Page, sync_playwright
from playwright.sync_api import TimeoutError as NotInTime

from webui.forms.spec_form import NOT_APPLIED
from webui.scene.camera import first_hit, strokes_at, target_of

# The shell without windows takes two thirds of the processor time: the whole browser draws its own bars in each window.
PROGRAMS = ("chromium-headless-shell", "chromium", "chromium-browser")
CHROMIUM = next((path for path in map(Path("/usr/bin").joinpath, PROGRAMS) if path.exists()), None)
NO_CHROMIUM = "no chromium in /usr/bin: apt-get install chromium-headless-shell"
FLAGS = [
    "--no-sandbox",
    "--disable-dev-shm-usage",
    "--use-gl=angle",  # WebGL without a graphics card
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-background-networking",  # the browser's own calls home would be taken for ours
    "--disable-component-update",
    "--no-first-run",
    # Without a graphics card only the scene itself is drawn by what stands in for one; the page is quicker without.
    "--disable-gpu-rasterization",
    "--disable-gpu-compositing",
]
WAIT_MS = 90_000
LIST_MS = 10_000
AGAIN_MS = 30_000
FEWER_FRAMES = """
window.requestAnimationFrame = draw => setTimeout(() => draw(performance.now()), 500);
window.cancelAnimationFrame = clearTimeout;
"""
"""Two a second: without a graphics card the drawing of sixty takes the processor from the page and its server."""
TYPED_MS = 200
"""The page tells of what is typed every 50 ms."""
WINDOW = (1400, 900)


@contextmanager
def open_chromium(*flags: str) -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=[*FLAGS, *flags])
        try:
            yield browser
        finally:
            browser.close()


def with_query(url: str, query: str) -> str:
    """Address of a page, as its server states it, with another query beside the token."""
    return f"{url}&{query}" if "?" in url else f"{url}/?{query}"


class DrivenPage:
    """One tab; each has a browser profile of its own unless a page of one is given.

    A scene of few pixels is drawn quickly without a graphics card; pictures need a sharpness of 1.
    """

    def __init__(
        self,
        browser: Browser,
        url: str,
        page: Page | None = None,
        sharpness: float = 0.25,
        wait_ms: int = WAIT_MS,
        *,
        all_frames: bool = False,
    ) -> None:
        width, height = WINDOW
        self._wait_ms = wait_ms
        self.page = page or browser.new_page(viewport={"width": width, "height": height}, accept_downloads=True)
        self.page.set_default_timeout(wait_ms)
        if not all_frames:
            self.page.add_init_script(FEWER_FRAMES)
        self.said: list[str] = []
        self.asked: list[str] = []
        self.page.on("console", lambda message: self.said.append(f"{message.type}: {message.text}"))
        self.page.on("pageerror", lambda error: self.said.append(f"error: {error}"))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(with_query(url, f"fixedDpr={sharpness}"), wait_until="domcontentloaded")
        self.wait_until_planned()

    @property
    def errors(self) -> list[str]:
        return [line for line in self.said if line.startswith("error")]

    @property
    def strangers(self) -> list[str]:
        """What was asked of anybody but this machine."""
        own = ("http://127.0.0.1:", "ws://127.0.0.1:", "data:", "blob:")
        return [url for url in self.asked if not url.startswith(own)]

    @property
    def time_text(self) -> str:
        """How long the program takes, as the page says."""
        return self.page.locator("[data-total]").inner_text()

    def wait_until_planned(self) -> None:
        planned = re.compile(r"^Planned( in|\.)")  # "The program is not planned yet." is on the page too
        self.page.get_by_text(planned).first.wait_for(timeout=2 * WAIT_MS)  # parts are planned for longest

    def wait_for_another_time(self, than: str) -> str:
        """Wait for the result of an edit, and return the new time."""
        self.page.wait_for_function(
            "than => (document.querySelector('[data-total]')?.innerText ?? than) !== than", arg=than
        )
        return self.time_text

    def wait_for_time(self, text: str) -> None:
        self.page.wait_for_function("text => document.querySelector('[data-total]')?.innerText === text", arg=text)

    def wait_for_input(self, label: str, check: str, wanted: str = "") -> None:
        """Wait until the value of an input satisfies a JavaScript function of it and of what is wanted."""
        self.page.wait_for_function(
            f"([label, wanted]) => [...document.querySelectorAll('label')].some(each => each.innerText === label && "
            f"[...(each.closest('.mantine-Flex-root')?.querySelectorAll('input') ?? [])].some("
            f"input => ({check})(input.value, wanted)))",
            arg=[label, wanted],
        )

    def wait_for_log(self, text: str) -> None:
        """Wait until the browser's console has a line with a text."""
        end = time.monotonic() + self._wait_ms / 1000
        while not any(text in line for line in self.said):
            assert time.monotonic() < end, f"no {text!r} in {self.said}"
            self.page.wait_for_timeout(50)

    def wait_until(self, holds: Callable[[], bool]) -> None:
        """Wait until something holds on the server."""
        end = time.monotonic() + self._wait_ms / 1000
        while not holds():
            assert time.monotonic() < end
            self.page.wait_for_timeout(50)

    def edit(self, template: str, label: str, value: str) -> None:
        """Write a value of a template in the form."""
        self.tab("Recipe")
        self.choose("Entry", template)
        self.page.locator(f"[data-entry='templates.{template}']").wait_for()
        self.input(label).fill(value)
        self.page.get_by_text(NOT_APPLIED).wait_for()  # the server has heard what was typed
        self.input(label).press("Enter")

    def reload(self) -> None:
        self.page.reload(wait_until="domcontentloaded")
        self.wait_until_planned()

    def tab(self, name: str) -> None:
        """Open a tab as somebody does: its mode first, where it belongs to another one."""
        tab = self.page.get_by_role("tab", name=name, exact=True)
        self.page.locator(f"[role=tab][title='{name}']").first.wait_for(state="attached")
        if not tab.is_visible():
            mode = self.page.evaluate("name => washboard.modeOf(name)", name)
            self.page.locator(f"#wb-bar [data-to='{mode}']").click()
        tab.click()

    def choose(self, label: str, option: str) -> None:
        shown, end = self.page.get_by_role("option", name=option, exact=True), time.monotonic() + self._wait_ms / 1000
        while True:  # a list that opens while its panel is drawn anew closes again; it is opened once more
            self.page.get_by_label(label, exact=True).first.click()
            try:
                shown.click(timeout=LIST_MS)
            except NotInTime:
                if time.monotonic() > end:
                    raise
            else:
                return

    def choices(self, label: str) -> list[str]:
        self.page.get_by_label(label, exact=True).first.click()
        found = self.page.get_by_role("option").all_inner_texts()
        self.page.keyboard.press("Escape")
        return found

    def input(self, label: str) -> Locator:
        return self.page.locator(f"xpath=//label[normalize-space(.)='{label}']/../../..//input").first

    def type(self, label: str, value: str) -> None:
        self.input(label).fill(value)
        self.page.wait_for_timeout(TYPED_MS)
        self.input(label).press("Enter")

    def press(self, name: str) -> None:
        self.page.get_by_role("button", name=name, exact=True).filter(visible=True).last.click()

    def insist(self, name: str, appears: Locator) -> None:
        """Press a button again and again until something appears: a panel drawn anew loses what is sent to it."""
        for _ in range(WAIT_MS // AGAIN_MS):
            self.press(name)
            with suppress(NotInTime):
                return appears.wait_for(timeout=AGAIN_MS)
        raise AssertionError(f"{name} was pressed, and nothing appeared")

    def see(self, text: str) -> None:
        self.page.get_by_text(text).first.wait_for()

    def click_scene(self, camera, place) -> None:
        """Click where a place of the board, mm, is seen by a viser camera."""
        self.page.mouse.click(*self.pixel_of(camera, place))

    def pixel_of(self, camera, place) -> tuple[float, float]:
        room = self.page.locator("canvas").first.bounding_box()
        forward = unit(np.array(camera.look_at) - np.array(camera.position))
        right = unit(np.cross(forward, np.array(camera.up_direction)))
        away = np.array(place) * 0.001 - np.array(camera.position)
        scale = room["height"] / 2 / np.tan(camera.fov / 2) / float(away @ forward)
        across, down = float(away @ right) * scale, -float(away @ np.cross(right, forward)) * scale
        return room["x"] + room["width"] / 2 + across, room["y"] + room["height"] / 2 + down

    def dismiss_notice(self) -> None:
        """Close what the browser says about software rendering."""
        notice = self.page.locator(".mantine-Notification-closeButton").first
        if notice.count():
            notice.click()
            self.page.wait_for_timeout(400)

    def picture(self, file: Path) -> None:
        """Take a picture as it is when the scene has faded in, which takes minutes without a graphics card."""
        self.page.evaluate("document.querySelectorAll('canvas').forEach(each => { each.style.opacity = '1'; })")
        self.page.mouse.move(WINDOW[0] / 2, 10)  # away from fields that would show their hints
        self.page.wait_for_timeout(500)
        self.page.screenshot(path=file)


def unit(vector):
    return vector / np.linalg.norm(vector)


def camera_of(server):
    return next(iter(server.viser.get_clients().values())).camera


def ray_to(camera, place):
    origin = np.array(camera.position) * 1000
    return origin, (place - origin) / np.linalg.norm(place - origin)


def visible_component(board, lines, camera):
    """A component whose top can be clicked: nothing stands or is drawn in front of it."""
    target = target_of(board)
    for component in sorted(board.components, key=lambda each: -each.area_mm2):
        middle = component.outline.centroid
        place = np.array([middle.x, middle.y, board.top_z_mm + component.height_mm])
        origin, direction = ray_to(camera, place)
        hit = first_hit(target, origin, direction)
        if hit is not None and hit.body == component.name and not strokes_at(lines, origin, direction, np.inf):
            return component.name, place
    raise AssertionError
