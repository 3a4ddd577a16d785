// Plays the frames in #data: the renderer draws, this moves the time.
(() => {
  "use strict";
  const $ = (id) => document.getElementById(id);
  const { scene: recorded, events, end_s } = JSON.parse($("data").textContent);
  const scene = new ZeronavScene.Scene(recorded.fixed);
  for (const frame of recorded.frames) scene.push(frame);
  if (!scene.states.length) return;
  document.body.classList.add("plays");

  const start_s = scene.start_s;
  const last_s = Math.max(scene.end_s, Number.isFinite(end_s) ? end_s : 0, start_s + 0.01);
  const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8, 16, 32, 64].filter((speed) => speed <= 4 || last_s / speed > 2);
  const view = new ZeronavScene.View($("view"));
  let [now_s, playing, before_ms] = [start_s, false, 0];

  for (const speed of SPEEDS) $("speed").append(new Option(`${speed} ×`, speed));
  $("speed").value = 1;
  [$("time").min, $("time").max] = [start_s, last_s];

  // -------------------------------------------------------------- time

  function seek(time_s) {
    now_s = Math.min(last_s, Math.max(start_s, time_s));
    $("time").value = now_s;
    $("clock").textContent = `${now_s.toFixed(1)} of ${last_s.toFixed(1)} s`;
    view.seek(now_s);
    drawPlayhead();
    say();
  }
  function play(on) {
    if (on && now_s >= last_s) seek(start_s);
    playing = on;
    before_ms = 0;
    $("play").textContent = on ? "Pause" : "Play";
    if (on) requestAnimationFrame(step);
  }
  function step(at_ms) {
    if (!playing) return;
    if (before_ms) seek(now_s + ((at_ms - before_ms) / 1000) * Number($("speed").value));
    before_ms = at_ms;
    if (now_s >= last_s) play(false);
    else requestAnimationFrame(step);
  }
  function toEvent(direction) {
    const times = [...new Set([start_s, ...events.map((event) => event.time_s), last_s])].sort((a, b) => a - b);
    const found = direction > 0 ? times.find((time) => time > now_s + 0.005) : times.reverse().find((time) => time < now_s - 0.005);
    if (found !== undefined) seek(found);
  }
  function faster(by) {
    const at = SPEEDS.indexOf(Number($("speed").value)) + by;
    if (SPEEDS[at]) $("speed").value = SPEEDS[at];
  }

  /** The newest event stays on the picture for a moment, and its row is marked. */
  const rows = [...document.querySelectorAll("#events a[data-t]")].map((link) => [Number(link.dataset.t), link.closest("tr")]);
  let marked = null;
  function say() {
    const past = events.filter((event) => event.time_s <= now_s + 0.005);
    const newest = past[past.length - 1];
    const is_fresh = newest && now_s - newest.time_s < Math.max(2, 1.5 * Number($("speed").value));
    const together = past.filter((event) => newest && newest.time_s - event.time_s < 0.05).slice(-3);
    $("said").textContent = is_fresh ? together.map((event) => event.text).join("; ") : "";
    let row = null;
    for (const [time_s, of] of rows) if (time_s <= now_s + 0.005) row = of;
    if (row === marked) return;
    if (marked) marked.classList.remove("now");
    if (row) {
      row.classList.add("now");
      const box = row.closest(".scroll");
      const [top, bottom] = [row.offsetTop - 40, row.offsetTop + row.offsetHeight];
      if (top < box.scrollTop || bottom > box.scrollTop + box.clientHeight) box.scrollTop = top;
    }
    marked = row;
  }

  // -------------------------------------------------------------- the line below: speed, guard, events

  const COLOURS = { path: "--h3", obstacle: "--h2", guard: "--h6", contact: "--h5", fault: "--h5", restart: "--h5", goal: "--h4", swap: "--h4", end: "--h1" };
  const GUARD = { slowed: "--h2", clamped: "--h6", stopped_short: "--h5", refused: "--h5", request_stale: "--h5", scan_stale: "--h5", odometry_stale: "--h5" };
  const strip = document.createElement("canvas");
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  function drawStrip() {
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [$("strip").clientWidth, $("strip").clientHeight];
    if (!width) return;
    for (const canvas of [$("strip"), strip]) [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    const to = strip.getContext("2d");
    to.setTransform(ratio, 0, 0, ratio, 0, 0);
    const x = (time_s) => ((time_s - start_s) / (last_s - start_s)) * width;
    const { states } = scene;
    const most = states.reduce((most, state) => Math.max(most, Math.abs(state.robot[3])), 0.1);
    const y = (v) => height - 4 - (Math.abs(v) / most) * (height - 18);
    states.forEach((state, i) => {
      const doing = state.control && GUARD[state.control.intervention];
      const until_s = i + 1 < states.length ? states[i + 1].time_s : state.time_s;
      if (!doing) return;
      to.fillStyle = colour(doing);
      to.globalAlpha = 0.45;
      to.fillRect(x(state.time_s), height - 4, Math.max(1, x(until_s) - x(state.time_s)), 4);
    });
    to.globalAlpha = 1;
    to.beginPath();
    to.moveTo(x(states[0].time_s), height - 4);
    for (const state of states) to.lineTo(x(state.time_s), y(state.robot[3]));
    to.lineTo(x(states[states.length - 1].time_s), height - 4);
    to.globalAlpha = 0.25;
    to.fillStyle = colour("--bar");
    to.fill();
    to.globalAlpha = 1;
    to.strokeStyle = colour("--bar");
    to.lineWidth = 1;
    to.stroke();
    for (const event of events) {
      to.fillStyle = colour(COLOURS[event.kind] || "--h0");
      const at = x(event.time_s);
      to.globalAlpha = event.kind === "guard" ? 0.6 : 1;
      to.fillRect(at - 0.75, 0, 1.5, event.kind === "guard" ? 6 : 12);
    }
    to.globalAlpha = 1;
    to.fillStyle = colour("--quiet");
    to.font = "11px system-ui, sans-serif";
    to.fillText(`speed, at most ${most.toFixed(1)} m/s`, 6, height - 8);
    drawPlayhead();
  }
  function drawPlayhead() {
    const canvas = $("strip");
    if (!canvas.width) return;
    const to = canvas.getContext("2d");
    to.clearRect(0, 0, canvas.width, canvas.height);
    to.drawImage(strip, 0, 0);
    const at = ((now_s - start_s) / (last_s - start_s)) * canvas.width;
    to.fillStyle = colour("--ink");
    to.fillRect(Math.min(canvas.width - 2, Math.max(0, at - 1)), 0, 2, canvas.height);
  }
  new ResizeObserver(drawStrip).observe($("strip"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { drawStrip(); layers(); });

  // -------------------------------------------------------------- layers

  function layers() {
    const seen = { scan: "scan", obstacle: "obstacles", path: "path", goal: "goals", arc: "control", truth: "truth", rollouts: "rollouts" };
    const has = (layer) => {
      if (layer.key === "cost" || layer.key === "clearance") return false;
      if (layer.map && !scene.logs.length) return false;
      const key = seen[layer.key];
      return !key || scene.states.some((state) => state[key] && (!Array.isArray(state[key]) || state[key].length));
    };
    $("layers").replaceChildren(...ZeronavScene.LAYERS.filter(has).map((layer) => {
      const button = document.createElement("button");
      const dot = document.createElement("i");
      dot.style.background = view.colours[layer.colour || layer.key];
      button.append(dot, layer.name);
      button.setAttribute("aria-pressed", view.layers[layer.key]);
      button.onclick = () => {
        view.layers[layer.key] = !view.layers[layer.key];
        button.setAttribute("aria-pressed", view.layers[layer.key]);
        view.redraw();
      };
      return button;
    }));
  }

  // -------------------------------------------------------------- what a person does

  const stage = $("stage");
  // The page scrolls under the wheel; with Ctrl the map is zoomed.
  stage.addEventListener("wheel", (event) => { if (!event.ctrlKey) event.stopPropagation(); }, { capture: true });
  $("view").style.touchAction = "pan-y";
  const zoom = (by) => view.zoom(by, $("view").clientWidth / 2, $("view").clientHeight / 2);
  const follow = (on) => {
    view.follow = on;
    $("follow").setAttribute("aria-pressed", on);
    if (on && view.scale) view.scale = Math.max(view.scale, 45);
    view.redraw();
  };
  $("view").addEventListener("pointerup", () => $("follow").setAttribute("aria-pressed", view.follow));
  $("play").onclick = () => play(!playing);
  $("before").onclick = () => toEvent(-1);
  $("next").onclick = () => toEvent(1);
  $("time").oninput = () => seek(Number($("time").value));
  $("follow").onclick = () => follow(!view.follow);
  $("in").onclick = () => zoom(1.4);
  $("out").onclick = () => zoom(1 / 1.4);
  $("fit").onclick = () => { follow(false); view.fit(); };
  document.addEventListener("click", (event) => {
    const link = event.target instanceof Element && event.target.closest("a[data-t]");
    if (!link) return;
    event.preventDefault();
    play(false);
    seek(Number(link.dataset.t));
    $("player").scrollIntoView({ block: "nearest" });
  });
  const KEYS = {
    " ": () => play(!playing),
    ArrowLeft: (event) => seek(now_s - (event.shiftKey ? 10 : 1)),
    ArrowRight: (event) => seek(now_s + (event.shiftKey ? 10 : 1)),
    "[": () => toEvent(-1), "]": () => toEvent(1),
    Home: () => seek(start_s), End: () => seek(last_s),
    "<": () => faster(-1), ">": () => faster(1),
    f: () => follow(!view.follow), "+": () => zoom(1.4), "-": () => zoom(1 / 1.4),
    0: () => { follow(false); view.fit(); },
  };
  document.addEventListener("keydown", (event) => {
    const act = KEYS[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    const within = (names) => event.target instanceof Element && event.target.closest(names);
    if (within("select") || (event.key === " " && within("button, a"))) return;
    event.preventDefault();
    act(event);
  });

  /** As high as the map needs, within what the window has. */
  function shape() {
    const log = scene.logs[0];
    const wide = $("stage").clientWidth;
    const high = log ? (wide * log.height) / log.width : 0.6 * wide;
    $("view").style.height = `${Math.round(Math.min(0.6 * window.innerHeight, 620, Math.max(180, high)))}px`;
  }
  window.addEventListener("resize", shape);

  shape();
  view.show(scene);
  layers();
  drawStrip();
  seek(start_s);
})();
