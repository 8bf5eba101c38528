"""Foreign web pages in a real browser, against the real server."""

import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest
import viser
from driven_page import CHROMIUM, NO_CHROMIUM, WAIT_MS, DrivenPage, open_chromium, with_query
from playwright.sync_api import expect

from webui.page.project import open_project
from webui.server import server as servers
from webui.server.server import open_session, serve

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM),
]
EVIL = "evil.example"
CONNECT = """([url, protocol]) => new Promise(done => {
  const socket = new WebSocket(url, protocol);
  socket.onopen = () => done('open');
  socket.onerror = () => done('refused');
})"""


class ForeignPage(BaseHTTPRequestHandler):
    """A page that does nothing; tests run their scripts in it."""

    def do_GET(self):
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(b"<title>foreign</title><body>")

    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def foreign_port():
    server = ThreadingHTTPServer(("127.0.0.1", 0), ForeignPage)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield server.server_address[1]
    server.shutdown()
    server.server_close()


@pytest.fixture(scope="module")
def browser():
    with open_chromium(f"--host-resolver-rules=MAP *.example 127.0.0.1, MAP {EVIL} 127.0.0.1") as browser:
        yield browser


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    server = serve(open_session("tiny", "rinse-only"), open_project(tmp_path_factory.mktemp("project")), "127.0.0.1", 0)
    yield server
    server.stop()


@pytest.fixture
def page(browser):
    page = browser.new_page()
    yield page
    page.close()


def connect(page, url):
    return page.evaluate(CONNECT, [url, f"viser-v{viser.__version__}"])


def test_the_page_works_whole_with_the_headers(browser, server):
    tab = DrivenPage(browser, server.address)
    tab.dismiss_notice()
    for name in ("Board", "Components", "Recipe", "YAML", "Paths", "Program"):
        tab.tab(name)
    assert tab.errors == []
    assert tab.strangers == []
    assert [line for line in tab.said if "Content Security Policy" in line] == []
    tab.page.close()


def test_its_own_page_may_connect(page, server):
    for name in ("127.0.0.1", "localhost"):
        page.goto(server.address.replace("127.0.0.1", name), wait_until="commit")
        assert connect(page, f"ws://{name}:{server.port}") == "open"


XSS = r"""() => new Promise(done => {
  const box = document.createElement('div'), run = [];
  window.hit = name => run.push(name);
  box.innerHTML = "<img src=x onerror=\"hit('handler')\"><a href=\"javascript:hit('address')\">x</a>";
  document.body.append(box);
  document.body.insertAdjacentHTML('beforeend', `<iframe srcdoc="<script>parent.hit('frame')</script>"></iframe>`);
  box.querySelector('a').click();
  setTimeout(() => (0, eval)("hit('text')"), 1);  // later: a debugger's own call may compile text
  setTimeout("hit('timer')", 1);
  const made = document.createElement('p');
  made.setAttribute('onclick', "hit('attribute')");
  made.click();
  setTimeout(() => done(run), 1000);
})"""


def test_script_that_came_in_as_text_does_not_run(page, server):
    page.goto(server.address, wait_until="domcontentloaded")
    page.locator("[data-total]").wait_for(timeout=WAIT_MS)
    assert page.evaluate(XSS) == []


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost", EVIL, "localhost.evil.example"])
@pytest.mark.parametrize("target", ["127.0.0.1", "localhost"])
def test_a_foreign_page_is_refused(page, server, foreign_port, name, target):
    pages = dict(server.viser.get_clients())
    page.goto(f"http://{name}:{foreign_port}/")
    assert connect(page, f"ws://{target}:{server.port}") == "refused"
    assert server.viser.get_clients() == pages


def test_a_page_without_origin_is_refused(page, server, foreign_port):
    page.goto(f"http://127.0.0.1:{foreign_port}/")
    page.evaluate("""html => new Promise(done => {
      const frame = document.createElement('iframe');
      frame.sandbox = 'allow-scripts';
      frame.srcdoc = html;
      addEventListener('message', event => { window.result = event.data; done(); });
      document.body.append(frame);
    })""", f"""<script>
      const socket = new WebSocket('ws://127.0.0.1:{server.port}', 'viser-v{viser.__version__}');
      socket.onopen = () => parent.postMessage(origin + ' open', '*');
      socket.onerror = () => parent.postMessage(origin + ' refused', '*');
    </script>""")  # fmt: skip
    assert page.evaluate("window.result") == "null refused"


def test_a_name_that_was_pointed_at_this_machine_is_refused(page, server):
    answer = page.goto(f"http://{EVIL}:{server.port}/")
    assert answer.status == 403
    assert "another name" in page.inner_text("body")
    assert connect(page, f"ws://{EVIL}:{server.port}") == "refused"


def test_the_page_cannot_be_framed(page, server, foreign_port):
    page.goto(f"http://127.0.0.1:{foreign_port}/")
    with page.expect_console_message(lambda message: "frame-ancestors" in message.text):
        page.evaluate(
            "url => { const frame = document.createElement('iframe'); frame.src = url; document.body.append(frame); }",
            server.address,
        )


@pytest.mark.parametrize("query", ["websocket=ws://127.0.0.1:{port}", "playbackPath=http://127.0.0.1:{port}/a.viser"])
def test_a_link_cannot_have_the_page_show_what_another_server_sends(page, server, foreign_port, query):
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    answer = page.goto(with_query(server.address, query.format(port=foreign_port)))
    assert answer.status == 403
    page.goto(server.address, wait_until="commit")  # the policy refuses by itself too
    assert connect(page, f"ws://127.0.0.1:{foreign_port}") == "refused"
    assert not [url for url in asked if f":{foreign_port}/" in url and "?" not in url]


@pytest.mark.parametrize("host", ["127.0.0.1", "0.0.0.0"])
def test_a_token_opens_the_page_and_a_cookie_keeps_it(browser, foreign_port, tmp_path, host):
    server = serve(open_session("tiny", "rinse-only"), open_project(tmp_path), host, 0)
    try:
        context = browser.new_context()
        page = context.new_page()
        bare = f"http://127.0.0.1:{server.port}/"
        assert page.goto(bare).status == 403
        assert "open the address that was printed" in page.inner_text("body")
        assert page.goto(f"{bare}?token=wrong").status == 403
        assert connect(page, f"ws://127.0.0.1:{server.port}") == "refused"
        page.goto(f"http://foreign.example:{foreign_port}/")  # a link there is followed without strict cookies
        page.evaluate("url => { location.href = url; }", f"{server.address}&fixedDpr=0.25")
        page.locator("[data-total]").wait_for(timeout=WAIT_MS)
        assert page.url == f"{bare}?fixedDpr=0.25"
        assert page.reload(wait_until="commit").status == 200
        page.locator("[data-total]").wait_for(timeout=WAIT_MS)
        second = context.new_page()
        assert second.goto(bare, wait_until="commit").status == 200
        assert connect(second, f"ws://127.0.0.1:{server.port}") == "open"
        cookie = context.cookies()[0]
        assert (cookie["httpOnly"], cookie["sameSite"]) == (True, "Strict")
        assert page.evaluate("document.cookie") == ""
    finally:
        server.stop()


SEND = """([name, size]) => {
  const files = new DataTransfer();
  files.items.add(new File([new Uint8Array(size)], name));
  const input = document.querySelector('input[type=file]');
  input.files = files.files;
  input.dispatchEvent(new Event('change', {bubbles: true}));
}"""


def test_a_file_that_is_too_large_is_refused_before_it_arrives(browser, tmp_path, monkeypatch):
    monkeypatch.setattr(servers, "LARGEST_UPLOAD", 1_000_000)
    server = serve(open_session("tiny", "rinse-only"), open_project(tmp_path), "127.0.0.1", 0)
    try:
        tab = DrivenPage(browser, server.address)
        tab.dismiss_notice()
        tab.tab("Board")
        for name in ("large.tri", "again.tri"):
            tab.page.evaluate(SEND, [name, 3_000_000])
            tab.see(f"'{name}': 3 MB are too many to upload")
        assert tab.page.get_by_role("button", name="Import CAD").is_enabled()
        expect(tab.page.get_by_text("Uploading")).to_have_count(0)
        assert list(tmp_path.iterdir()) == []
        assert tab.errors == []
        tab.page.close()
    finally:
        server.stop()
