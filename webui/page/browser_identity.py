"""Identity of a browser and its tab."""

import secrets
import time
from dataclasses import dataclass

import viser

_BROWSER = "browser"
_TAB_S = 2.0
_POLL_S = 0.03
_TAB_HTML = (
    '<img alt="" style="display:none" src="data:image/gif;base64,R0lGODlhAQABAAAAACwAAAAAAQABAAA=" onload="'
    "try {{ const name = sessionStorage.getItem('washboard-tab') || '{name}';"
    " sessionStorage.setItem('washboard-tab', name);"
    " localStorage.setItem('viser-user:tab-{name}', name); }} catch {{}}\">"
)
"""A browser has a session storage for each tab, which outlives a reload; viser reads only the shared one."""


@dataclass(frozen=True, slots=True)
class BrowserIdentity:
    """A browser and its tab; empty names where the browser stores nothing."""

    browser: str
    tab: str


def identify(client: viser.ClientHandle) -> BrowserIdentity:
    """Identity of a browser and its tab by the names that were stored in them the first time.

    A tab in the background responds once it is in the foreground: that is waited for, unless it disconnects.
    """
    try:
        browser = client.local_storage.get_item(_BROWSER)
    except RuntimeError:  # storage is blocked, or the browser has disconnected
        return BrowserIdentity("", "")
    if browser is None:
        browser = secrets.token_urlsafe(12)
        client.local_storage.set_item(_BROWSER, browser)
    return BrowserIdentity(browser, _tab_of(client) if browser else "")


def _tab_of(client: viser.ClientHandle) -> str:
    new = secrets.token_hex(8)
    probe = client.gui.add_html(_TAB_HTML.format(name=new))
    name, end = None, time.monotonic() + _TAB_S
    try:
        while name is None and time.monotonic() < end:
            time.sleep(_POLL_S)
            name = client.local_storage.get_item(f"tab-{new}")
        client.local_storage.remove_item(f"tab-{new}")
    except RuntimeError:
        return ""
    finally:
        probe.remove()
    return name or ""
