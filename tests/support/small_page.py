"""A page without a browser: real inputs of a server that nobody is connected to, and somebody who presses them."""

from contextlib import contextmanager
from dataclasses import dataclass, field
from types import SimpleNamespace

import rich
import viser

from webui.page.page import Page


@dataclass
class Client:
    gui: viser.GuiApi
    scene: viser.SceneApi
    atomic: object
    said: list[str] = field(default_factory=list)

    def add_notification(self, title, body, **_):
        self.said.append(f"{title}: {body}")


class SmallPage(Page):
    """Edits are shown at once and never planned."""

    def plan(self):
        pass


@contextmanager
def small_page(session, project=None):
    console = rich.get_console()
    loud, console.quiet = console.quiet, True  # viser prints a box at the start and a line at the end
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        yield SmallPage(Client(server.gui, server.scene, server.atomic), project, session)
    finally:
        server.stop()
        console.quiet = loud


def find(page, label, at=-1):
    """The newest input of a label, or an earlier one."""
    found = [handle for handle in inputs(page) if getattr(handle, "label", None) == label]
    assert found, f"no input {label!r} among {[getattr(handle, 'label', None) for handle in inputs(page)]}"
    return found[at]


def inputs(page):
    return list(page.client.gui._gui_input_handle_from_uuid.values())


def folder_of(page, label):
    """The newest folder of a label."""
    return [
        each for each in page.client.gui._container_handle_from_uuid.values() if getattr(each, "label", 0) == label
    ][-1]


def html_in(page, label):
    """What the HTML elements of a folder show."""
    return "".join(each.content for each in folder_of(page, label)._children.values() if hasattr(each, "content"))


def press(page, label, value=True, at=-1):
    """Choose a value or press a button as somebody in a browser does."""
    click(page, find(page, label, at), value)


def click(page, handle, value=True):
    """Press one of several inputs that may have the same label."""
    handle._impl.value = value
    for callback in list(handle._impl.update_cb):
        callback(SimpleNamespace(client=page.client, target=handle))


def windows(page):
    return list(page.client.gui._modal_handle_from_uuid.values())
