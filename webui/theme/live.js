"use strict";
/* One operation, looked at ten times a second and drawn into whatever has its marks: the live view's own page, and the page of
 * `washboard ui`. Requests go from the browser to the operating process itself, whatever the server of the page does. */
window.watchOperation = ({ address = "", token = "", drawn = () => {} }) => {
  const OLD_MS = 200, EVERY_MS = 60, DRAWN_MS = 50, PATIENCE_MS = 1000, TRIES = 50, AGAIN_MS = 100;
  const url = word => `${address}/${word}` + (token ? `?token=${encodeURIComponent(token)}` : "");
  const each = (name, act) => document.querySelectorAll(`[data-live="${name}"]`).forEach(act);
  const write = (name, text) => each(name, one => { if (one.textContent !== text) one.textContent = text; });
  const now = () => performance.timeOrigin + performance.now();  // the same in a worker
  const begunAt = now();
  let shown = null, sentAt = 0, stopping = false, missed = false, closed = false;

  const rows = (name, entries) => each(name, table => {
    while (table.rows.length > entries.length) table.deleteRow(-1);
    entries.forEach(([key, value, unmet], index) => {
      const row = table.rows[index] ?? table.insertRow();
      while (row.cells.length < 2) row.insertCell();
      [key, value].forEach((text, cell) => {
        if (row.cells[cell].textContent !== text) row.cells[cell].textContent = text;
      });
      row.cells[1].className = unmet ? "unmet" : "";
    });
  });
  const isOver = () => shown !== null
    && (["end", "faulted"].includes(shown.state) || (shown.state === "idle" && shown.seconds > 0.5));
  /* Before the first answer as old as the looking for one. */
  const ageMs = () => shown === null ? now() - begunAt : shown.age_ms + now() - sentAt;

  const draw = () => {
    if (closed) return;
    const over = isOver(), age = ageMs(), stale = !over && age > OLD_MS;
    document.documentElement.dataset.liveIs = over ? "over" : stale ? "stale" : "fresh";
    const words = age < 1000 ? `${Math.round(age)} ms` : `${(age / 1000).toFixed(1)} s`;
    write("age", over ? "" : shown === null ? `no answer for ${words}` : stale ? `not live: ${words} old` : `${words} old`);
    write("reason", missed ? "The stop did not arrive. Press the emergency stop of the machine." : shown?.reason ?? "");
    each("stop", one => { one.disabled = over; });
    write("stop", over ? "Stopped" : stopping ? "Stopping\u2026" : "STOP");
    each("pause", one => { one.disabled = shown?.state !== "running"; });
    each("resume", one => { one.disabled = shown?.state !== "paused"; });
    if (shown !== null) {
      write("state", shown.state);
      write("node", `node ${shown.node} of ${shown.nodes}`);
      each("done", one => { one.value = shown.nodes ? shown.node / shown.nodes : 0; });
      rows("joints", Object.entries(shown.joints).map(([name, value]) => {
        const unit = name.endsWith("_deg") ? "\u00b0" : " mm";
        return [name.replace(/_(deg|mm)$/, ""), value.toFixed(2) + unit];
      }));
      rows("conditions", Object.entries(shown.conditions).map(([name, met]) => [name, met ? "met" : "not met", !met]));
      rows("others", [["valves open", shown.jets.join(", ") || "none"],
        ...Object.entries(shown.quantities).map(([name, value]) => [name, String(value)])]);
    }
    drawn({ over, stale, age, seconds: shown === null ? null : shown.seconds + (now() - sentAt) / 1000 });
  };

  /* In a thread of its own: without a graphics card the page is busy drawing its scene for a tenth of a second at a time. */
  const look = (from, everyMs, patienceMs) => {
    const now = () => performance.timeOrigin + performance.now();
    const poll = async () => {
      const begun = now();
      try {
        const answer = await fetch(from, { signal: AbortSignal.timeout(patienceMs), credentials: "same-origin" });
        if (answer.ok) postMessage({ state: await answer.json(), sentAt: begun });
      } catch { /* the age of what there is shows it */ }
      setTimeout(poll, Math.max(0, everyMs - (now() - begun)));
    };
    poll();
  };
  const given = JSON.stringify([new URL(url("state"), location.href).href, EVERY_MS, PATIENCE_MS]).slice(1, -1);
  const source = URL.createObjectURL(new Blob([`(${look})(${given})`], { type: "text/javascript" }));
  const looker = new Worker(source);
  looker.onmessage = ({ data }) => {
    if (data.sentAt < sentAt) return;
    shown = data.state;
    sentAt = data.sentAt;
    draw();
  };
  const send = async word => {
    const how = { method: "POST", keepalive: true, credentials: "same-origin", signal: AbortSignal.timeout(PATIENCE_MS) };
    try { return (await fetch(url(word), how)).ok; } catch { return false; }
  };
  const pause = ms => new Promise(done => { setTimeout(done, ms); });
  const act = async event => {
    const word = event.target.closest?.("button[data-live]")?.dataset.live;
    if (word !== "stop") { if (word) send(word); return; }
    stopping = true;
    missed = false;
    draw();
    for (let tries = 0; tries < TRIES && !isOver(); tries++) {
      if (await send("stop")) return;
      await pause(AGAIN_MS);
    }
    stopping = false;
    missed = !isOver();
    draw();
  };
  document.addEventListener("click", act);
  const drawing = setInterval(draw, DRAWN_MS);
  draw();
  return () => {
    closed = true;
    looker.terminate();
    URL.revokeObjectURL(source);
    clearInterval(drawing);
    document.removeEventListener("click", act);
    delete document.documentElement.dataset.liveIs;
  };
};
