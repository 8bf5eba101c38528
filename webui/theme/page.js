"use strict";
/* The part of the page that viser has no words for. It adds to what viser draws and replaces none of it: modes over its
 * tabs, names and keys for its controls, words while it loads or the server is gone. `washboard.given` is from the server. */
(() => {
  /* viser's page unpacks itself into the text of a script, which the policy cannot name; from an address it may run,
   * since a script that may run made it. */
  const text = Object.getOwnPropertyDescriptor(Node.prototype, "textContent");
  const load = function (code) { this.src = URL.createObjectURL(new Blob([code], { type: "text/javascript" })); };
  Object.defineProperty(HTMLScriptElement.prototype, "textContent", { ...text, set: load });
  /* It compiles text for Gaussian splats at the start, and to draw Plotly; here are neither. The policy would refuse that
   * with an error: the text becomes a function that does nothing. */
  const compile = () => () => () => {};
  window.Function = new Proxy(Function, { apply: compile, construct: compile });

  /* A browser has a session storage for each tab, which outlives a reload; viser reads only the shared one. */
  document.addEventListener("load", ({ target }) => {  // of a picture, which does not reach the window
    const fresh = target.dataset?.tab;
    if (!fresh) return;
    try {
      const name = sessionStorage.getItem("washboard-tab") || fresh;
      sessionStorage.setItem("washboard-tab", name);
      localStorage.setItem(`viser-user:tab-${fresh}`, name);
    } catch { /* it stores nothing, and each reload is another tab */ }
  }, true);

  const { modes, keys, most } = window.washboard.given;
  const root = document.documentElement;
  const NAMED = { "tabler-icon-list-search": "All commands (Ctrl+K)", "tabler-icon-adjustments": "Settings of the view",
    "tabler-icon-arrow-back": "Back to the panels", "tabler-icon-x": "Close" };
  const CLOSING = ["Cancel", "Close", "Keep this text"];
  const COLOURS = "washboard-colours", MODE = "washboard-mode";
  const AFTER_MS = 60, LOST_MS = 1200, LATE_MS = 20000, LONG_LINES = 500;

  /* viser takes its colours from the address; they are chosen before it starts. */
  const stored = () => { try { return localStorage.getItem(COLOURS); } catch { return null; } };
  const dark = (stored() ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light")) === "dark";
  const address = new URL(location.href);
  if (dark !== address.searchParams.has("darkMode")) {
    dark ? address.searchParams.set("darkMode", "") : address.searchParams.delete("darkMode");
    history.replaceState(history.state, "", address);
  }
  root.dataset.mantineColorScheme = dark ? "dark" : "light";

  /* Tabs and modes. */
  const tabs = () => [...document.querySelectorAll("[role=tab]")];
  const tabNamed = name => tabs().find(each => each.title === name || each.textContent.trim() === name);
  const activate = tab => {
    if (!tab.dataset.dockTab) { tab.click(); return; }
    for (const kind of ["pointerdown", "pointerup"])
      tab.dispatchEvent(new PointerEvent(kind, { bubbles: true, isPrimary: true, pointerId: 1 }));
  };
  const chosen = {};  // tabs that are open, by mode and side
  const sideOf = tab => tab.closest("[role=tablist]");
  const remember = () => {
    const open = tabs().filter(each => each.getAttribute("aria-selected") === "true" && each.offsetParent);
    for (const each of open) (chosen[root.dataset.mode] ??= {})[each.title] = true;
  };
  const setMode = (mode, wanted) => {
    if (root.dataset.mode !== mode) remember();
    const last = chosen[mode] ?? {};
    delete chosen[mode];
    root.dataset.mode = mode;
    try { sessionStorage.setItem(MODE, mode); } catch { /* it is then Plan after a reload */ }
    for (const each of document.querySelectorAll("#wb-bar [data-to]"))
      each.setAttribute("aria-pressed", String(each.dataset.to === mode));
    for (const side of new Set(tabs().map(sideOf))) {
      const own = tabs().filter(each => sideOf(each) === side && modes[mode].includes(each.title));
      own.sort((one, two) => modes[mode].indexOf(one.title) - modes[mode].indexOf(two.title));
      const next = own.find(each => each.title === wanted) ?? own.find(each => last[each.title]) ?? own[0];
      if (next && next.getAttribute("aria-selected") !== "true") activate(next);
    }
  };
  const modeOf = name => modes[root.dataset.mode]?.includes(name) ? root.dataset.mode
    : Object.keys(modes).find(each => modes[each].includes(name));
  const open = name => {
    const mode = modeOf(name), tab = tabNamed(name);
    if (mode && mode !== root.dataset.mode) setMode(mode, name);
    if (tab && tab.getAttribute("aria-selected") !== "true") activate(tab);
  };
  root.dataset.mode = Object.keys(modes)[0];
  Object.assign(window.washboard, { modeOf, setMode });
  addEventListener("click", event => {
    const opener = event.target.closest?.("[data-opens]");
    if (opener) open(opener.dataset.opens);
  });

  /* A row of a listing, or a finding, that is clicked is written into the text of the stepper before it, which nobody sees. */
  const write = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  let clicks = 0;
  addEventListener("click", event => {
    const row = event.target.closest?.("[data-row]");
    if (!row) return;
    const before = [...document.querySelectorAll(".wb-pick")]
      .filter(each => each.compareDocumentPosition(row) & Node.DOCUMENT_POSITION_FOLLOWING).pop();
    const input = before?.parentElement.nextElementSibling?.querySelector("input");
    if (!input) return;
    write.call(input, `${++clicks} ${row.dataset.row}`);
    input.dispatchEvent(new Event("input", { bubbles: true }));
  });

  /* Keys. */
  const press = (key, more) => root.dispatchEvent(new KeyboardEvent("keydown", { key, code: `Key${key.toUpperCase()}`, ...more }));
  root.addEventListener("keydown", event => {
    // With these viser flies through the scene, two metres a second, until they are released: Ctrl+S too would lose the board.
    if (/^Key[WASDQE]$/.test(event.code)) event.stopPropagation();
  });
  const pressButton = (...names) => [...document.querySelectorAll("button")]
    .find(each => names.includes(each.textContent.trim()) && each.offsetParent)?.click();
  const showKeys = () => {
    const list = document.getElementById("wb-keys");
    if (!list.open) list.showModal();
  };
  const ACTS = { " ": () => pressButton("Play", "Pause"), ArrowLeft: () => pressButton("Previous event"),
    ArrowRight: () => pressButton("Next event"), "?": showKeys };
  Object.keys(modes).forEach((mode, at) => { ACTS[String(at + 1)] = () => setMode(mode); });
  const OWN = "input, textarea, select, button, summary, [role=tab], [role=slider], [role=button], [role=dialog], dialog";
  addEventListener("keydown", event => {
    const act = ACTS[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey || document.querySelector("[aria-modal=true], dialog[open]"))
      return;
    const typing = event.target.closest?.("input, textarea, select, [contenteditable=true]");
    if (typing || (event.key !== "?" && !/[0-9]/.test(event.key) && event.target.closest?.(OWN))) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    act();
  }, true);
  addEventListener("keydown", event => {  // arrows would choose tabs of other modes, which are not seen
    const at = event.target.closest?.("[role=tab]");
    if (!at || event.ctrlKey || event.metaKey || event.altKey) return;
    const own = tabs().filter(each => sideOf(each) === sideOf(at) && each.getClientRects().length), place = own.indexOf(at);
    const to = { ArrowLeft: place - 1, ArrowRight: place + 1, Home: 0, End: own.length - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    const next = own[(to + own.length) % own.length];
    activate(next);
    next.focus();
  }, true);
  addEventListener("keydown", event => {  // what viser draws as a button for the mouse alone
    if ((event.key === "Enter" || event.key === " ") && event.target.dataset?.wbPressed !== undefined) {
      event.preventDefault();
      event.target.click();
    }
  });

  addEventListener("keydown", event => {  // viser's windows do not close by themselves: what stands for "no" closes them
    const window_ = [...document.querySelectorAll(".mantine-Modal-content")].pop();
    if (event.key !== "Escape" || !window_) return;
    [...window_.querySelectorAll("button")].reverse().find(each => CLOSING.includes(each.textContent.trim()))?.click();
  });

  /* A browser edits a pasted text line by line, and stands still for minutes over ten thousand of them: a long one is set
   * at once, and one that is longer than any recipe is not taken. */
  const setText = (area, text) => {
    const value = area.value.slice(0, area.selectionStart) + text + area.value.slice(area.selectionEnd);
    Object.getOwnPropertyDescriptor(HTMLTextAreaElement.prototype, "value").set.call(area, value);
    area.dispatchEvent(new Event("input", { bubbles: true }));
  };
  addEventListener("paste", event => {
    const text = event.clipboardData?.getData("text") ?? "", area = event.target;
    const lines = text.split("\n").length;
    const tooLong = text.length > most[0] || lines > most[1];
    if (!tooLong && (lines < LONG_LINES || area.tagName !== "TEXTAREA")) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (!tooLong) { setText(area, text); return; }
    say(`Not pasted: the text has ${lines.toLocaleString("en")} lines and ${text.length.toLocaleString("en")} characters; ` +
      `at most ${most[1].toLocaleString("en")} and ${most[0].toLocaleString("en")} can be pasted. ` +
      "Save it as a file in the project folder, and open that.", 12000);
  }, true);

  /* Names of controls for assistive technology. */
  const labelOf = each => {
    let row = each.closest(".mantine-Flex-root");
    while (row && !row.querySelector("label")) row = row.parentElement?.closest(".mantine-Flex-root");
    return row?.querySelector("label")?.textContent ?? "";
  };
  const setName = (each, name) => {
    if (name && each.getAttribute("aria-label") !== name) each.setAttribute("aria-label", name);
  };
  const nameControls = () => {
    for (const each of document.querySelectorAll("body :is(input:not([type=hidden]), textarea, [role=slider])")) {
      const own = each.id && document.querySelector(`label[for="${CSS.escape(each.id)}"]`);
      const among = [...(each.closest(".mantine-Flex-root")?.querySelectorAll("input:not([type=hidden])") ?? [])];
      const label = labelOf(each) || each.placeholder;
      const part = among.length > 1 && !each.closest("[role=slider]") && among.every(one => one.closest(".mantine-NumberInput-root"))
        && !document.querySelector(`.mantine-Slider-root:has(~ * #${CSS.escape(each.id)})`) ? ` ${"xyz"[among.indexOf(each)]}` : "";
      if (!own || part || each.role === "slider") setName(each, label + (labelOf(each) && part ? part : ""));
    }
    for (const [icon, name] of Object.entries(NAMED))
      for (const each of document.querySelectorAll(`button:has(svg.${icon})`))
        if (!each.textContent.trim()) setName(each, name);
    for (const each of document.querySelectorAll(".mantine-CloseButton-root, .mantine-Notification-closeButton"))
      setName(each, "Close");
    for (const each of document.querySelectorAll(".mantine-Paper-root > .mantine-Paper-root:has(> .tabler-icon)")) {
      each.dataset.wbPressed = "";
      each.setAttribute("role", "button");
      each.tabIndex = 0;
      each.setAttribute("aria-expanded", String(!!each.querySelector(".tabler-icon-chevron-up")));
    }
    for (const each of tabs()) if (!each.title) each.title = each.textContent.trim();
    for (const each of document.querySelectorAll("#root canvas")) each.setAttribute("aria-hidden", "true");
  };

  /* State of the connection. */
  let lostSince = null, told = 0;
  const say = (words, forMs) => {
    const box = document.getElementById("wb-gone");
    if (box && box.textContent !== words) box.textContent = words;
    clearTimeout(told);
    if (forMs) told = setTimeout(() => say(""), forMs);
  };
  const LOST = "The server does not answer. Your edits are kept; reconnecting…";
  const watch = () => {
    const connected = !!document.querySelector(".tabler-icon-cloud-check");
    const ready = !!document.querySelector("[data-job]");
    if (!root.hasAttribute("data-ready")) {
      if (!ready || !connected) return;
      root.setAttribute("data-ready", "");
      const kept = (() => { try { return sessionStorage.getItem(MODE); } catch { return null; } })();
      setMode(modes[kept] ? kept : root.dataset.mode);
    }
    if (connected) {
      if (lostSince !== null && document.getElementById("wb-gone")?.textContent === LOST) { say(""); setMode(root.dataset.mode); }
      lostSince = null;
    } else {
      lostSince ??= performance.now();
      if (performance.now() - lostSince > LOST_MS) say(LOST);
    }
    followMark(connected);
  };

  /* A running operation: a band with its state and its STOP, tables in the tab Live. The server puts the mark that names it;
   * while the server does not answer the mark stays, and what it began goes on. */
  const LEFT_MS = 3000, OLD_SCENE_MS = 200, LOST_SCENE_MS = 1000;
  let watched = null, unmarkedSince = null;
  const liveTables = [["Joints", "joints"], ["Interlocks and sensors", "conditions"], ["Valves and quantities", "others"]];
  const drawScene = ({ over, seconds }) => {
    for (const box of document.querySelectorAll("[data-live-tables]:empty")) {
      box.append(element("p", {}, part("b", "state", {}), part("span", "node", {}), part("span", "age", {})));
      for (const [title, name] of liveTables) {
        box.append(element("h2", {}, title), part("table", name, {}));
      }
    }
    const stamp = document.querySelector("[data-live-scene]")?.dataset.liveScene;
    const age = stamp === undefined || seconds === null || over ? null : 1000 * (seconds - Number(stamp));
    root.dataset.liveSceneIs = over ? "over" : age === null ? "none" : age > LOST_SCENE_MS ? "lost" : "fresh";
    const late = age !== null && age > OLD_SCENE_MS;
    const old = age > LOST_SCENE_MS ? `${(age / 1000).toFixed(1)} s old, the server of the page does not answer`
      : `${Math.round(age)} ms old`;
    const words = age === null ? "" : late ? `scene not live: ${old}` : `scene ${old}`;
    const box = document.getElementById("wb-live-scene");
    if (box.textContent !== words) box.textContent = words;
    box.classList.toggle("late", late);
  };
  const leaveLive = () => {
    watched?.end();
    watched = unmarkedSince = null;
    delete root.dataset.watching;
    delete root.dataset.liveSceneIs;
  };
  const followMark = connected => {
    const mark = document.querySelector("[data-live-of]")?.dataset;
    if (mark) {
      unmarkedSince = null;
      if (watched?.token === mark.liveToken) return;
      leaveLive();
      root.dataset.watching = "";
      document.getElementById("wb-live-what").textContent = mark.liveWhat;
      watched = { token: mark.liveToken,
        end: window.watchOperation({ address: mark.liveOf, token: mark.liveToken, drawn: drawScene }) };
    } else if (watched && connected) {
      unmarkedSince ??= performance.now();
      if (performance.now() - unmarkedSince > LEFT_MS || !root.hasAttribute("data-live-is")) leaveLive();
    }
  };

  const element = (tag, more, ...inside) => {
    const made = Object.assign(document.createElement(tag), more);
    made.append(...inside);
    return made;
  };
  const part = (tag, name, more, ...inside) => {
    const made = element(tag, more, ...inside);
    made.dataset.live = name;
    return made;
  };
  const button = (text, label, act, more = {}) => {
    const made = element("button", { type: "button", onclick: act, title: label, ...more }, text);
    if (text !== label) made.setAttribute("aria-label", label);
    return made;
  };
  const build = () => {
    const ofModes = element("nav", { ariaLabel: "Modes" }, ...Object.keys(modes).map((mode, at) => {
      const made = button(mode, mode, () => setMode(mode));
      made.title = `${modes[mode].join(", ")} (${at + 1})`;
      made.dataset.to = mode;
      return made;
    }));
    const acts = element("div", {},
      button("↶", "Undo (Ctrl+Z)", () => press("z", { ctrlKey: true })),
      button("↷", "Redo (Ctrl+Shift+Z)", () => press("z", { ctrlKey: true, shiftKey: true })),
      button("Save", "Save (Ctrl+S)", () => press("s", { ctrlKey: true })),
      button("◐", dark ? "Light colours" : "Dark colours", () => {
        try { localStorage.setItem(COLOURS, dark ? "light" : "dark"); } catch { /* chosen by the system then */ }
        location.reload();
      }),
      button("?", "Keys (?)", showKeys));
    const list = element("dialog", { id: "wb-keys" }, element("h2", {}, "Keys"), element("table", {}, element("tbody", {},
      ...keys.map(([key, what]) => element("tr", {}, element("td", {}, element("kbd", {}, key)), element("td", {}, what))))),
      button("Close", "Close", () => list.close()));
    list.setAttribute("aria-label", "Keys");
    const veil = element("div", { id: "wb-veil", role: "status" }, "Washboard is loading…");
    const gone = element("div", { id: "wb-gone", role: "alert" });
    document.body.prepend(element("header", { id: "wb-bar" }, element("h1", {}, "Washboard"), ofModes, acts));
    const live = element("section", { id: "wb-live", ariaLabel: "Live operation" },
      element("span", { id: "wb-live-what" }), part("b", "state", { role: "status" }), part("span", "node", {}),
      part("progress", "done", { max: 1, value: 0, ariaLabel: "Nodes reached" }), part("span", "age", {}),
      element("span", { id: "wb-live-scene" }), part("span", "reason", { role: "alert" }),
      part("button", "pause", { type: "button", title: "Stands on the path, valves shut" }, "Pause"),
      part("button", "resume", { type: "button", title: "Goes on from where it stands" }, "Resume"),
      part("button", "stop", { type: "button", title: "Stops the operation. No emergency stop: that is the machine's" }, "STOP"));
    document.body.append(list, veil, gone, live);
    document.getElementById("root")?.setAttribute("role", "main");
    setTimeout(() => { veil.textContent = "Washboard is loading; the server takes long to answer. Is it still running?"; }, LATE_MS);
    let waiting = 0;
    new MutationObserver(() => {
      waiting ||= setTimeout(() => { waiting = 0; nameControls(); watch(); }, AFTER_MS);
    }).observe(document.body, { childList: true, subtree: true });
    setInterval(watch, 500);
  };
  document.readyState === "loading" ? addEventListener("DOMContentLoaded", build) : build();
})();
