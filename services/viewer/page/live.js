// The live page: what the server tells, tables, time line. Drawing is ZeronavScene's, moving through time is ZeronavPlayer's,
// acts are ZeronavActs'.
(() => {
  "use strict";

  const KEEP_S = 60; // of run time, for the time line
  const UNSEEN_S = 1; // between two frames: the driven line breaks
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
  let last_goal = ""; // what was said last about a goal
  let past = false; // true while the hops of an earlier replanning are shown
  const arrival = { from_s: 0, to_s: 0, at: 0, took: 100 };

  // ---------------------------------------------------------------- the stream

  let wait_ms = 250;
  function connect() {
    // The token stands in the list of protocols: a browser sets no header of its own here.
    const socket = new WebSocket(`ws://${location.host}/stream`, token ? ["zeronav", token] : ["zeronav"]);
    socket.onopen = () => { wait_ms = 250; };
    socket.onmessage = (event) => take(JSON.parse(event.data));
    socket.onclose = async () => {
      if (over) return;
      const why = await refusal();
      pill(by("link"), why ? "no access" : "not connected", "bad");
      by("why").textContent = why ? `${why}: open the link that zeronav printed` : "";
      setTimeout(connect, wait_ms);
      wait_ms = Math.min(4000, wait_ms * 2);
    };
  }

  /** Why the stream is refused, which a socket does not say; empty when it is not, or nobody answers. */
  async function refusal() {
    try {
      const response = await fetch("access", { headers: { "X-Zeronav-Token": token } });
      return response.status === 403 ? (await response.text()).trim() : "";
    } catch { return ""; }
  }

  function take(news) {
    if (news.fixed) {
      scene = new ZeronavScene.Scene(news.fixed, { keep_s: KEEP_S, unseen_s: UNSEEN_S });
      view.show(scene);
      by("events").replaceChildren();
      last_goal = "";
      by("scenario").textContent = news.fixed.scenario || "zeronav";
      document.title = `${news.fixed.scenario || "run"} · zeronav`;
      is_live = true;
      player.play(false);
    }
    if (news.frame && scene) takeFrame(news.frame);
    if (news.status) { status = news.status; showStatus(); }
    if (news.run) { run = news.run; showRun(); }
    if (news.over) {
      over = true;
      pill(by("link"), "the run is over", "warn");
      showActs();
      acts.disable();
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
    if (is_live) player.now_s = frame.time_s;
    for (const event of frame.events || []) addEvent(event);
    showLegend();
    if (frame.zones) acts.showZones();
    by("clock").textContent = `${frame.time_s.toFixed(2)} s`;
    const [v, w] = [state.robot[3], state.robot[4]];
    by("speed").textContent = `${v.toFixed(2)} m/s  ${w.toFixed(2)} rad/s`;
    const task = by("task");
    task.hidden = !state.task;
    const kinds = { active: "good", reached: "good", failed: "bad" };
    // The last event of a goal says why, too.
    const is_told = last_goal.startsWith(state.task);
    if (state.task) pill(task, is_told ? last_goal : state.task, kinds[state.task] || "");
    const certainty = by("certainty");
    const is_unsure = { unknown: "bad", unconfirmed: "warn" }[state.certainty];
    certainty.hidden = !is_unsure;
    if (is_unsure) pill(certainty, `pose ${state.certainty}`, is_unsure);
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
  /** Is run time held? In lockstep launch alone knows: it grants no further tick. */
  const is_held = () => Boolean((status && status.paused) || (run && run.paused));
  function showActs() {
    for (const id of ["acts", "stop", "hint", "modes", "faults"]) by(id).hidden = !may_act();
  }

  const acts = ZeronavActs.acts({
    token, view, may_act,
    is_held, scene: () => scene, run: () => run,
    note: (kind, text) => addEvent({ time_s: scene ? scene.end_s : 0, kind, text }),
    refresh: () => { by("services").tBodies[0].dataset.open = "?"; if (status) showStatus(); },
  });

  /** Whether nothing is heard of the process in a seat. */
  function is_silent(service) {
    return ["absent", "silent"].includes(service.state);
  }

  /** How the stack is as a whole, and what can be done about run time. */
  function showLink() {
    if (!status || over) return;
    const silent = status.services.filter((service) => is_silent(service)).map((service) => service.role);
    if (status.stopping) pill(by("link"), "stopping", "warn");
    else if (is_held()) pill(by("link"), "paused", "warn");
    else if (silent.length) pill(by("link"), `${silent.join(", ")} silent`, "bad");
    else pill(by("link"), "live", "good");
    by("pause").textContent = is_held() ? "Resume" : "Pause";
    by("steps").hidden = !(is_held() && scene && scene.fixed.mode === "lockstep");
  }

  function showStatus() {
    showLink();
    showActs();
    const body = by("services").tBodies[0];
    if (!body.rows.length || body.dataset.open !== String(seat_open)) buildServices(body);
    for (const service of status.services) {
      const row = by(`seat-${service.role}`);
      if (!row) continue;
      const words_of_state = [service.state, ...service.reasons].join(", ");
      const cells = [
        service.rate_hz.toFixed(0), service.cpu_percent.toFixed(1), (service.memory_bytes / 1e6).toFixed(1),
        short(service.superseded), short(service.restarts),
      ];
      const details = `${words_of_state}; pid ${service.pid}, epoch ${service.epoch}, ${service.rejected} messages rejected${binaryOf(service.role)}`;
      row.title = details;
      row.cells[0].textContent = nameOf(service.role);
      const state = row.cells[1].firstChild;
      state.textContent = words_of_state;
      state.className = `state ${service.state}`;
      cells.forEach((text, i) => { row.cells[i + 2].textContent = text; });
      if (seat_open === service.role) by("seat-details").textContent = details;
    }
    showLatency(status.latency);
    const viewer = status.viewer;
    by("viewer").textContent = `viewer ${viewer.cpu_percent.toFixed(1)} % CPU, ${(viewer.memory_bytes / 1e6).toFixed(0)} MB, ${viewer.clients} open`;
  }

  function binaryOf(role) {
    const found = run && run.services.find((service) => service.role === role);
    return found ? `, ${found.binary}` : "";
  }

  /** A seat, and the host that fills it in a stack of two. */
  function nameOf(role) {
    const found = run && run.services.find((service) => service.role === role);
    return role.replaceAll("_", " ") + (found && found.host ? ` on ${found.host}` : "");
  }

  /** A count in at most four characters. */
  function short(n) {
    if (n < 10000) return String(n);
    return n < 999500 ? `${Math.round(n / 1000)}k` : `${(n / 1e6).toFixed(n < 9.95e6 ? 1 : 0)}M`;
  }

  function buildServices(body) {
    body.dataset.open = String(seat_open);
    body.replaceChildren();
    for (const { role } of status.services) {
      const row = make("tr", undefined, "more");
      row.id = `seat-${role}`;
      row.append(make("td", role.replaceAll("_", " ")), make("td"));
      row.cells[1].append(make("span"));
      for (let i = 0; i < 5; i++) row.append(make("td"));
      body.append(row);
      row.tabIndex = 0;
      const toggle = () => { seat_open = seat_open === role ? null : role; showStatus(); };
      row.addEventListener("click", toggle);
      row.addEventListener("keydown", (event) => { if (event.key === "Enter") toggle(); });
      if (seat_open === role) body.append(seatDetails(role));
    }
  }

  function seatDetails(role) {
    const row = make("tr", undefined, "seat-acts");
    const cell = make("td");
    cell.colSpan = 7;
    const details = make("p");
    details.id = "seat-details";
    cell.append(details);
    // The robot is the clock of a run: it is neither broken nor swapped.
    if (role !== "robot" && may_act()) cell.append(...acts.seatActs(role));
    row.append(cell);
    return row;
  }

  const micros = (us) => (us >= 10000 ? `${(us / 1000).toFixed(1)} ms` : `${us.toFixed(us < 100 ? 1 : 0)} µs`);

  /** Percentiles of the reaction, or why there are none. */
  function reactionLine({ n, missed, p50_us, p99_us }, lost) {
    const lost_text = lost ? `, ${short(lost)} records lost` : "";
    if (p50_us !== null) return `p50 ${micros(p50_us)}  p99 ${micros(p99_us)}  n ${n}${missed ? `, ${missed} missed` : ""}${lost_text}`;
    if (n + missed === 0) return lost_text.slice(2);
    return `withheld: ${missed} of ${n + missed} missed${lost_text}`;
  }

  function showLatency({ reaction, replanning, direct, records_lost, scan_in_use }) {
    const line = by("reaction");
    const is_withheld = reaction.p50_us === null && reaction.n + reaction.missed > 0;
    line.textContent = reactionLine(reaction, records_lost);
    line.classList.toggle("bad", is_withheld);
    line.title = is_withheld || records_lost
      ? "This page was kept from reading by a busy machine. What rests on lost records is not measured, and percentiles of the rest would be those of its quiet part."
      : "From the capture of a scan to the first command whose author checked it";
    by("histogram").classList.toggle("withheld", is_withheld);
    by("scan-age").textContent = scan_in_use
      ? `The scan in use was ${micros(scan_in_use.age_us)} old when it was used${scan_in_use.uses > 1 ? `; ${scan_in_use.uses} commands rest on it` : ""}.` : "";
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
    showHops(by("direct"), by("direct-title"), "Last new scan to wheels", direct);
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
    by("why").textContent = run.why || "";
    showLink();
    acts.report(run);
  }

  function addEvent({ time_s, kind, text, hops_us }) {
    if (kind === "goal") last_goal = text;
    const line = make("li");
    const name = make("b", kind);
    name.style.setProperty("--kind", `var(${KINDS[kind] || "--soft"})`);
    line.append(make("time", `${time_s.toFixed(2)} s`), name, make("span", text));
    if (hops_us) line.title = "Show where its time went";
    line.addEventListener("click", () => { player.stopAt(time_s); if (hops_us && !is_live) showPast(time_s, hops_us); });
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
    player.changed();
  }

  // What is live moves by itself; a moment of the past stands, or plays behind it.
  const player = new ZeronavPlayer.Player({
    range: span,
    stops: () => (scene ? scene.events.map((event) => event.time_s) : []),
    shown: (time_s) => {
      const [, end] = span();
      is_live = time_s >= end - 0.05;
      if (is_live) past = false;
      if (is_live && player.playing) player.play(false);
      view.seek(is_live ? end : time_s);
      drawTimeline();
    },
    changed: () => {
      by("play").textContent = is_live || player.playing ? "Hold" : "Play";
      by("rate").value = player.speed;
    },
  });
  function toggle() {
    const holds = is_live;
    is_live = false;
    player.play(!holds && !player.playing);
    drawTimeline();
  }

  function drag(event) {
    const box = timeline.getBoundingClientRect();
    player.stopAt(scene ? scene.end_s - KEEP_S * (1 - (event.clientX - box.left) / box.width) : 0);
  }
  timeline.addEventListener("pointerdown", (event) => { timeline.setPointerCapture(event.pointerId); drag(event); });
  timeline.addEventListener("pointermove", (event) => { if (timeline.hasPointerCapture(event.pointerId)) drag(event); });
  by("live").addEventListener("click", () => player.stopAt(Infinity));

  // ---------------------------------------------------------------- the view

  function buildLayers() {
    ZeronavPlayer.layers(by("layers"), view, { changed: showLegend });
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
    by("theme").textContent = `Theme: ${theme}`;
    try { localStorage.setItem("theme", theme); } catch { /* not allowed: as it is */ }
    buildLayers();
    view.redraw();
    drawTimeline();
  }
  by("theme").addEventListener("click", () => setTheme(THEMES[(THEMES.indexOf(view.theme) + 1) % THEMES.length]));
  const framing = ZeronavPlayer.framing(view, { canvas: by("view"), follow: by("follow"), fit: by("fit") });
  const buttons = { play: by("play"), before: by("before"), next: by("next"), speed: by("rate") };
  ZeronavPlayer.controls(player, buttons, { " ": toggle, f: framing.follow, 0: framing.fit });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { buildLayers(); drawTimeline(); });
  new ResizeObserver(drawTimeline).observe(timeline);

  let stored = null;
  try { stored = localStorage.getItem("theme"); } catch { /* not allowed: the default */ }
  setTheme(THEMES.includes(stored) ? stored : "auto");
  if (token) acts.enable();
  const narrow = matchMedia("(max-width: 820px)");
  const layers = (is_on) => {
    by("layers").hidden = !is_on;
    by("layers-toggle").setAttribute("aria-pressed", String(is_on));
  };
  by("layers-toggle").addEventListener("click", () => layers(by("layers").hidden));
  layers(!narrow.matches);
  // For the console of the browser.
  window.zeronavPage = { view, get scene() { return scene; }, get status() { return status; } };
  connect();
})();
