"""Who opens a page: a browser, and which of its tabs."""

import secrets
import time
from dataclasses import dataclass

import viser

_BROWSER = "browser"
_TAB_S = 2.0
_LOOK_AGAIN_S = 0.03
_TAB_HTML = (
    '<img alt="" style="display:none" src="data:image/gif;base64,R0lGODlhAQABAAAAACwAAAAAAQABAAA=" onload="'
    "try {{ const name = sessionStorage.getItem('washboard-tab') || '{name}';"
    " sessionStorage.setItem('washboard-tab', name);"
    " localStorage.setItem('viser-user:tab-{name}', name); }} catch {{}}\">"
)
"""A browser keeps the storage of a session for each tab, also over a reload; viser reads only what all tabs share."""


@dataclass(frozen=True, slots=True)
class Visitor:
    """Who opens a page; empty names where the browser keeps nothing."""

    browser: str
    tab: str


def recognise(client: viser.ClientHandle) -> Visitor:
    """Recognise a browser and its tab by what was written into their storage the first time.

    A tab that nobody sees answers when somebody looks at it: that is waited for, unless it leaves.
    """
    browser = _browser_of(client)
    return Visitor(browser, _tab_of(client) if browser else "")


def _browser_of(client: viser.ClientHandle) -> str:
    try:
        name = client.local_storage.get_item(_BROWSER)
    except RuntimeError:  # it blocks storage, or has left
        return ""
    if name is None:
        name = secrets.token_urlsafe(12)
        client.local_storage.set_item(_BROWSER, name)
    return name


def _tab_of(client: viser.ClientHandle) -> str:
    new = secrets.token_hex(8)
    asked = client.gui.add_html(_TAB_HTML.format(name=new))
    name, end = None, time.monotonic() + _TAB_S
    try:
        while name is None and time.monotonic() < end:
            time.sleep(_LOOK_AGAIN_S)
            name = client.local_storage.get_item(f"tab-{new}")
        client.local_storage.remove_item(f"tab-{new}")
    except RuntimeError:
        return ""
    finally:
        asked.remove()
    return name or ""
