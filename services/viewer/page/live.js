// The live page: what the server tells, tables, time line, acts. Drawing is ZeronavScene's.
(() => {
  "use strict";

  const KEEP_S = 60; // of run time, for the time line
  const LAG_S = 0.3; // longest time over which the robot moves to where it was told
  const KINDS = {
    path: "--accent", restart: "--bad", fault: "--bad", guard: "--warn", recovery: "--warn",
    goal: "--good", swap: "--accent", pause: "--soft",
  };
  const SHOWN_EVENTS = 200;
  const by = (id) => document.getElementById(id);
  const token = location.hash.slice(1);
  const view = new ZeronavScene.View(by("view"));
  let scene = null;
  let status = null;
  let run = null;
  let is_live = true;
  let seat_open = null; // the seat whose acts are shown
  let over = false;
  let past = false; // true while the hops of an earlier replanning are shown
  const placed = []; // names of obstacles from this page
  const arrival = { from_s: 0, to_s: 0, at: 0, took: 100 };

  // ---------------------------------------------------------------- the stream

  let wait_ms = 250;
  function connect() {
    const socket = new WebSocket(`ws://${location.host}/stream`);
    socket.onopen = () => { wait_ms = 250; };
    socket.onmessage = (event) => take(JSON.parse(event.data));
    socket.onclose = () => {
      if (over) return;
      pill(by("link"), "not connected", "bad");
      setTimeout(connect, wait_ms);
      wait_ms = Math.min(4000, wait_ms * 2);
    };
  }

  function take(news) {
    if (news.fixed) {
      scene = new ZeronavScene.Scene(news.fixed, { keep_s: KEEP_S });
      view.show(scene);
      by("events").replaceChildren();
      by("scenario").textContent = news.fixed.scenario || "zeronav";
      document.title = `${news.fixed.scenario || "run"} · zeronav`;
      is_live = true;
    }
    if (news.frame && scene) takeFrame(news.frame);
    if (news.status) { status = news.status; showStatus(); }
    if (news.run) { run = news.run; showRun(); }
    if (news.over) {
      over = true;
      pill(by("link"), "the run is over", "warn");
      by("acts").hidden = by("hint").hidden = true;
      view.onclick = view.ondraft = null;
    }
  }

  function takeFrame(frame) {
    const before_s = scene.end_s;
    const state = scene.push(frame);
    const now = performance.now();
    if (frame.time_s > before_s) {
      arrival.took = Math.min(1000 * LAG_S, Math.max(20, now - arrival.at));
      Object.assign(arrival, { from_s: shown_s(now), to_s: frame.time_s, at: now });
    }
    for (const event of frame.events || []) addEvent(event);
    showLegend();
    by("clock").textContent = `${frame.time_s.toFixed(2)} s`;
    const [v, w] = [state.robot[3], state.robot[4]];
    by("speed").textContent = `${v.toFixed(2)} m/s  ${w.toFixed(2)} rad/s`;
    const task = by("task");
    task.hidden = !state.task;
    const kinds = { active: "good", reached: "good", failed: "bad" };
    if (state.task) pill(task, state.task, kinds[state.task] || "");
    animate();
  }

  /** The moment to show now: frames come ten times a second, the robot moves on between them. */
  function shown_s(now) {
    const part = Math.min(1, (now - arrival.at) / arrival.took);
    return arrival.from_s + (arrival.to_s - arrival.from_s) * part;
  }

  let animating = false;
  let drawn_at = 0;
  function animate() {
    if (animating) return;
    animating = true;
    const step = (now) => {
      const done = now - arrival.at >= arrival.took;
      // Thirty pictures a second are enough, and leave the processors to the stack.
      if (done || now - drawn_at > 30) {
        drawn_at = now;
        if (is_live) view.seek(shown_s(now));
        drawTimeline();
      }
      animating = !done;
      if (animating) requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  // ---------------------------------------------------------------- tables

  function pill(element, text, kind) {
    element.textContent = text;
    element.className = `pill ${kind}`;
  }

  function make(tag, text, kind) {
    const element = document.createElement(tag);
    if (text !== undefined) element.textContent = text;
    if (kind) element.className = kind;
    return element;
  }

  const may_act = () => Boolean(token) && !over;

  function showStatus() {
    const words = { silent: "silent", restarted: "restarted" };
    const silent = status.services.filter((service) => service.state === "silent").map((service) => service.role);
    if (status.stopping) pill(by("link"), "stopping", "warn");
    else if (status.paused) pill(by("link"), "paused", "warn");
    else if (silent.length) pill(by("link"), `${silent.join(", ")} silent`, "bad");
    else pill(by("link"), "live", "good");
    by("acts").hidden = by("hint").hidden = !may_act();
    by("pause").textContent = status.paused ? "Resume" : "Pause";
    by("steps").hidden = !(status.paused && scene && scene.fixed.mode === "lockstep");
    const body = by("services").tBodies[0];
    if (!body.rows.length || body.dataset.open !== String(seat_open)) buildServices(body);
    for (const service of status.services) {
      const row = by(`seat-${service.role}`);
      if (!row) continue;
      const words_of_state = [words[service.state] || service.state, ...service.reasons].join(", ");
      const cells = [
        service.rate_hz.toFixed(0), `${service.cpu_percent.toFixed(1)} %`, (service.memory_bytes / 1e6).toFixed(1),
        service.superseded, service.restarts,
      ];
      row.title = `pid ${service.pid}, epoch ${service.epoch}, ${service.rejected} messages rejected${binaryOf(service.role)}`;
      const state = row.cells[1].firstChild;
      state.textContent = words_of_state;
      state.className = `state ${service.state}`;
      state.title = words_of_state;
      cells.forEach((text, i) => { row.cells[i + 2].textContent = text; });
    }
    showLatency(status.latency);
    const viewer = status.viewer;
    by("viewer").textContent = `viewer ${viewer.cpu_percent.toFixed(1)} % CPU, ${(viewer.memory_bytes / 1e6).toFixed(0)} MB, ${viewer.clients} open`;
  }

  function binaryOf(role) {
    const found = run && run.services.find((service) => service.role === role);
    return found ? `, ${found.binary}` : "";
  }

  function buildServices(body) {
    body.dataset.open = String(seat_open);
    body.replaceChildren();
    for (const { role } of status.services) {
      const row = make("tr");
      row.id = `seat-${role}`;
      row.append(make("td", role.replaceAll("_", " ")), make("td"));
      row.cells[1].append(make("span"));
      for (let i = 0; i < 5; i++) row.append(make("td"));
      body.append(row);
      // The robot is the clock of a run: it is neither broken nor swapped.
      if (role === "robot" || !may_act()) continue;
      row.className = "more";
      row.tabIndex = 0;
      const toggle = () => { seat_open = seat_open === role ? null : role; showStatus(); };
      row.addEventListener("click", toggle);
      row.addEventListener("keydown", (event) => { if (event.key === "Enter") toggle(); });
      if (seat_open === role) body.append(seatActs(role));
    }
  }

  function seatActs(role) {
    const row = make("tr", undefined, "seat-acts");
    const cell = make("td");
    cell.colSpan = 7;
    const [first, second] = [make("div"), make("div")];
    const button = (text, title, request) => {
      const element = make("button", text);
      element.title = title;
      element.dataset.act = text.toLowerCase();
      element.addEventListener("click", () => {
        try { act(request()); } catch (error) { say(error.message, true); }
      });
      return element;
    };
    const field = (placeholder, title) => {
      const element = make("input");
      Object.assign(element, { placeholder, title, spellcheck: false });
      return element;
    };
    const fault = (kind, more) => () => ({ command: "fault", fault: { kind, service: role, ...more } });
    first.append(
      button("Kill", "SIGKILL: it crashes and is restarted", fault("kill")),
      button("Stop", "SIGSTOP: it hangs until it is restarted", fault("stop")),
      button("Slow", "Each answer is 20 ms late, for 5 s", fault("slow", { by_ms: 20, lasts_s: 5 })),
      button("Heal", "End the faults of this seat", () => ({ command: "heal", target: role })),
    );
    const binary = field("binary (the same)", "Another program that the scenario lists, or any by name or path; empty = the one in the seat");
    binary.setAttribute("list", "binaries");
    const listed = (run && run.binaries && run.binaries[role]) || [];
    by("binaries").replaceChildren(...listed.map((name) => Object.assign(make("option"), { value: name })));
    const keys = field("key=value, ...", "Parameters of the newcomer, such as controller=dwa");
    second.append(binary, keys, button("Swap", "Exchange the process while the robot drives", () => ({
      command: "swap",
      order: { role, binary: binary.value.trim() || null, config: configOf(keys.value), shadow_s: 2, keep_s: 2 },
    })));
    cell.append(first, second);
    row.append(cell);
    return row;
  }

  /** `a.b=1, c=x` as nested tables; numbers and booleans as such. */
  function configOf(text) {
    const config = {};
    for (const pair of text.split(",").map((part) => part.trim()).filter(Boolean)) {
      const at = pair.indexOf("=");
      if (at < 1) throw new Error(`${pair}: parameters read like key=value`);
      const [path, raw] = [pair.slice(0, at).trim().split("."), pair.slice(at + 1).trim()];
      let value = raw.replace(/^"(.*)"$/, "$1");
      if (raw === "true" || raw === "false") value = raw === "true";
      else if (raw !== "" && Number.isFinite(Number(raw))) value = Number(raw);
      const last = path.pop();
      let table = config;
      for (const key of path) table = table[key] ??= {};
      table[last] = value;
    }
    return config;
  }

  const micros = (us) => (us >= 10000 ? `${(us / 1000).toFixed(1)} ms` : `${us.toFixed(us < 100 ? 1 : 0)} µs`);

  function showLatency({ reaction, replanning, direct }) {
    by("reaction").textContent = reaction.n
      ? `reaction p50 ${micros(reaction.p50_us)}  p99 ${micros(reaction.p99_us)}  n ${reaction.n}` : "";
    const histogram = by("histogram");
    if (!histogram.children.length) {
      reaction.bins.forEach((_, i) => {
        const bar = make("i");
        const [from, to] = [reaction.ends_us[i - 1], reaction.ends_us[i]];
        bar.dataset.range = to === undefined ? `${micros(from)} or more` : `${from ? micros(from) : "0"} to ${micros(to)}`;
        histogram.append(bar);
      });
      const ends = make("div");
      ends.id = "histogram-ends";
      for (const i of [0, 4, 8, 12, 15]) ends.append(make("span", micros(reaction.ends_us[i])));
      histogram.after(ends);
    }
    const most = Math.max(1, ...reaction.bins);
    reaction.bins.forEach((n, i) => {
      const bar = histogram.children[i];
      bar.style.height = n ? `${Math.max(3, (100 * Math.log1p(n)) / Math.log1p(most))}%` : "0";
      bar.title = `${bar.dataset.range}: ${n}`;
    });
    if (!past) showHops(by("replanning"), by("replanning-title"), "Last replanning, scan to wheels", replanning);
    showHops(by("direct"), by("direct-title"), "Last scan to wheels", direct);
  }

  function showHops(into, title, text, way) {
    if (!way) return;
    const sum = way.hops_us.reduce((all, [, us]) => all + us, 0);
    title.textContent = `${text}: ${micros(sum)}`;
    const most = Math.max(...way.hops_us.map(([, us]) => us), 1);
    into.replaceChildren(...way.hops_us.map(([name, us]) => {
      const row = make("div", undefined, name.startsWith("to_") ? "" : "work");
      const bar = make("i");
      bar.style.width = `${(100 * us) / most}%`;
      row.append(make("b", name.replaceAll("_", " ")), bar, make("span", micros(us)));
      return row;
    }));
  }

  /** The hops of an earlier replanning, until the page is live again. */
  function showPast(time_s, hops_us) {
    past = true;
    showHops(by("replanning"), by("replanning-title"), `Replanning at ${time_s.toFixed(2)} s, scan to wheels`, { hops_us });
    by("replanning").scrollIntoView({ block: "nearest" });
  }

  function showRun() {
    by("pace").hidden = !(may_act() && run.mode === "lockstep");
    if (document.activeElement !== by("pace")) by("pace").value = run.speed ? String(run.speed) : "max";
    if (run.scenario && scene && !scene.fixed.scenario) by("scenario").textContent = run.scenario;
    const swap = run.swap;
    if (swap && swap.state !== showRun.swap) {
      if (showRun.swap !== undefined) say(`swap of ${swap.role}: ${swap.state}${swap.why ? `, ${swap.why}` : ""}`, swap.state === "rejected");
      showRun.swap = swap.state;
    }
  }

  function addEvent({ time_s, kind, text, hops_us }) {
    const line = make("li");
    const name = make("b", kind);
    name.style.setProperty("--kind", `var(${KINDS[kind] || "--soft"})`);
    line.append(make("time", `${time_s.toFixed(2)} s`), name, make("span", text));
    if (hops_us) line.title = "Show where its time went";
    line.addEventListener("click", () => { travel(time_s); if (hops_us && !is_live) showPast(time_s, hops_us); });
    const list = by("events");
    list.prepend(line);
    while (list.children.length > SHOWN_EVENTS) list.lastChild.remove();
  }

  // ---------------------------------------------------------------- time line

  const timeline = by("timeline");

  function span() {
    const end = scene ? scene.end_s : 0;
    return [Math.max(scene ? scene.start_s : 0, end - KEEP_S), end];
  }

  function drawTimeline() {
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [timeline.clientWidth, timeline.clientHeight];
    if (!scene || !width) return;
    if (timeline.width !== Math.round(width * ratio)) [timeline.width, timeline.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    const to = timeline.getContext("2d");
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(name).trim();
    to.setTransform(ratio, 0, 0, ratio, 0, 0);
    to.clearRect(0, 0, width, height);
    const [from, end] = span();
    const x = (time_s) => width * (1 - (end - time_s) / KEEP_S);
    const floor = height - 13;
    to.fillStyle = to.strokeStyle = colour("--soft");
    to.font = "10px system-ui, sans-serif";
    for (let s = Math.ceil(from / 10) * 10; s <= end; s += 10) {
      to.fillRect(x(s), floor, 1, 3);
      to.fillText(`${s} s`, Math.min(x(s) + 3, width - 24), height - 2);
    }
    // Speed, so that a stop is seen before its event is read.
    const { states } = scene;
    const most = Math.max(0.1, ...states.map((state) => Math.abs(state.robot[3])));
    to.beginPath();
    to.moveTo(x(from), floor);
    for (let i = Math.max(0, scene.indexAt(from)); i < states.length; i++) to.lineTo(x(states[i].time_s), floor - (floor - 8) * Math.abs(states[i].robot[3]) / most);
    to.lineTo(x(end), floor);
    to.globalAlpha = 0.18;
    to.fill();
    to.globalAlpha = 1;
    for (const event of scene.events) {
      if (event.time_s < from) continue;
      to.fillStyle = colour(KINDS[event.kind] || "--soft");
      to.fillRect(x(event.time_s) - 1, 0, 2, floor);
    }
    const at = is_live ? end : view.time_s;
    to.fillStyle = colour("--accent");
    to.fillRect(Math.min(width - 2, x(at) - 1), 0, 2, height);
    by("live").setAttribute("aria-pressed", String(is_live));
    by("live").textContent = is_live ? "Live" : `${(at - end).toFixed(1)} s`;
  }

  function travel(time_s) {
    const [from, end] = span();
    is_live = time_s >= end - 0.05;
    if (is_live) past = false;
    view.seek(is_live ? end : Math.max(from, time_s));
    drawTimeline();
  }

  function drag(event) {
    const box = timeline.getBoundingClientRect();
    travel(scene ? scene.end_s - KEEP_S * (1 - (event.clientX - box.left) / box.width) : 0);
  }
  timeline.addEventListener("pointerdown", (event) => { timeline.setPointerCapture(event.pointerId); drag(event); });
  timeline.addEventListener("pointermove", (event) => { if (timeline.hasPointerCapture(event.pointerId)) drag(event); });
  by("live").addEventListener("click", () => travel(Infinity));

  // ---------------------------------------------------------------- acts

  let said_timer = 0;
  function say(text, is_bad) {
    const said = by("said");
    said.textContent = text;
    said.className = is_bad ? "bad" : "";
    said.hidden = false;
    clearTimeout(said_timer);
    said_timer = setTimeout(() => { said.hidden = true; }, is_bad ? 8000 : 2500);
  }

  /** Asks the stack; what it answers, or `null` when it did not do it. */
  async function act(request) {
    let why;
    try {
      const response = await fetch("act", { method: "POST", headers: { "X-Zeronav-Token": token }, body: JSON.stringify(request) });
      const text = await response.text();
      if (response.ok) {
        const answer = JSON.parse(text);
        if (answer.error === undefined) { say(`${request.command.replaceAll("_", " ")}: done`); return answer; }
        why = answer.error;
      } else why = text.trim();
    } catch (error) {
      why = String(error);
    }
    say(why, true);
    return null;
  }

  const millimetres = (value) => Math.round(value * 1000) / 1000;
  function enableActs() {
    view.onclick = ([x, y]) => act({
      command: "goal", now: true, goals: [{ pose: [millimetres(x), millimetres(y), 0], tolerance_m: 0.15, yaw_tolerance_rad: 3.1416 }],
    });
    view.ondraft = async ([[ax, ay], [bx, by_]]) => {
      const name = `page_${Date.now().toString(36)}`;
      const size_m = [Math.abs(bx - ax), Math.abs(by_ - ay)].map((side) => Math.max(0.05, millimetres(side)));
      const pose = [millimetres((ax + bx) / 2), millimetres((ay + by_) / 2), 0];
      if (await act({ command: "obstacle", name, change: { add: { pose, size_m } } })) placed.push(name);
      by("clear").hidden = placed.length === 0;
    };
    by("pause").addEventListener("click", () => act({ command: status && status.paused ? "resume" : "pause" }));
    by("step").addEventListener("click", () => act({ command: "step", ticks: Number(by("ticks").value) || 1 }));
    by("pace").addEventListener("change", () => act({ command: "speed", factor: Number(by("pace").value) || null }));
    by("cancel").addEventListener("click", () => act({ command: "cancel" }));
    by("clear").addEventListener("click", async () => {
      for (const name of placed.splice(0)) await act({ command: "obstacle", name, change: "remove" });
      by("clear").hidden = true;
    });
  }

  // ---------------------------------------------------------------- the view

  function buildLayers() {
    by("layers").replaceChildren(...ZeronavScene.LAYERS.map((layer) => {
      const button = make("button");
      const swatch = make("i");
      button.append(swatch, layer.name);
      button.setAttribute("aria-pressed", String(view.layers[layer.key]));
      button.dataset.layer = layer.key;
      swatch.style.background = view.colours[layer.colour || layer.key];
      button.addEventListener("click", () => {
        view.layers[layer.key] = !view.layers[layer.key];
        button.setAttribute("aria-pressed", String(view.layers[layer.key]));
        showLegend();
        view.redraw();
      });
      return button;
    }));
    by("legend").replaceChildren(...ZeronavScene.ROLLOUTS.map(({ key, name }) => {
      const line = make("div", undefined, key);
      const swatch = make("i");
      swatch.style.background = view.colours[key];
      line.append(swatch, name);
      return line;
    }));
  }

  /** What the colours of rollouts say, while there are any. */
  function showLegend() {
    const newest = scene && scene.states[scene.states.length - 1];
    by("legend").hidden = !(view.layers.rollouts && newest && newest.rollouts && newest.rollouts.length);
  }

  const THEMES = ["auto", "light", "dark"];
  function setTheme(theme) {
    view.theme = theme;
    if (theme === "auto") delete document.documentElement.dataset.theme;
    else document.documentElement.dataset.theme = theme;
    by("theme").textContent = theme[0].toUpperCase() + theme.slice(1);
    try { localStorage.setItem("theme", theme); } catch { /* not allowed: as it is */ }
    buildLayers();
    view.redraw();
    drawTimeline();
  }
  by("theme").addEventListener("click", () => setTheme(THEMES[(THEMES.indexOf(view.theme) + 1) % THEMES.length]));
  const follow = (is_on) => {
    view.follow = is_on;
    by("follow").setAttribute("aria-pressed", String(is_on));
    view.redraw();
  };
  by("follow").addEventListener("click", () => follow(!view.follow));
  by("fit").addEventListener("click", () => { follow(false); view.fit(); });
  by("view").addEventListener("pointerup", () => by("follow").setAttribute("aria-pressed", String(view.follow)));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { buildLayers(); drawTimeline(); });
  new ResizeObserver(drawTimeline).observe(timeline);

  let stored = null;
  try { stored = localStorage.getItem("theme"); } catch { /* not allowed: the default */ }
  setTheme(THEMES.includes(stored) ? stored : "auto");
  if (token) enableActs();
  // For the console of the browser.
  window.zeronavPage = { view, get scene() { return scene; }, get status() { return status; } };
  connect();
})();
