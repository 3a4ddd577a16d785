// Plays the frames in #data: ZeronavScene draws, ZeronavPlayer moves the time, this shows what happened when.
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
  const view = new ZeronavScene.View($("view"));
  const player = new ZeronavPlayer.Player({
    range: () => [start_s, last_s],
    stops: () => events.map((event) => event.time_s),
    speeds: ZeronavPlayer.SPEEDS.filter((speed) => speed <= 4 || last_s / speed > 2),
    shown: (now_s) => {
      $("time").value = now_s;
      $("clock").textContent = `${now_s.toFixed(1)} of ${last_s.toFixed(1)} s`;
      view.seek(now_s);
      drawPlayhead();
      say();
    },
    changed: () => {
      $("play").textContent = player.playing ? "Pause" : "Play";
      $("speed").value = player.speed;
    },
  });
  [$("time").min, $("time").max] = [start_s, last_s];

  /** The newest event stays on the picture for a moment, and its row is marked. */
  const rows = [...document.querySelectorAll("#events a[data-t]")].map((link) => [Number(link.dataset.t), link.closest("tr")]);
  let marked = null;
  function say() {
    const { now_s, speed } = player;
    const past = events.filter((event) => event.time_s <= now_s + 0.005);
    const newest = past[past.length - 1];
    const is_fresh = newest && now_s - newest.time_s < Math.max(2, 1.5 * speed);
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
    const at = ((player.now_s - start_s) / (last_s - start_s)) * canvas.width;
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
    ZeronavPlayer.layers($("layers"), view, { wanted: has });
  }

  // -------------------------------------------------------------- what a person does

  const stage = $("stage");
  // The page scrolls under the wheel; with Ctrl the map is zoomed.
  stage.addEventListener("wheel", (event) => { if (!event.ctrlKey) event.stopPropagation(); }, { capture: true });
  $("view").style.touchAction = "pan-y";
  const zoom = (by) => view.zoom(by, $("view").clientWidth / 2, $("view").clientHeight / 2);
  const framing = ZeronavPlayer.framing(view, { canvas: $("view"), follow: $("follow"), fit: $("fit"), scale: 45 });
  $("time").oninput = () => player.seek(Number($("time").value));
  $("in").onclick = () => zoom(1.4);
  $("out").onclick = () => zoom(1 / 1.4);
  document.addEventListener("click", (event) => {
    const link = event.target instanceof Element && event.target.closest("a[data-t]");
    if (!link) return;
    event.preventDefault();
    player.stopAt(Number(link.dataset.t));
    $("player").scrollIntoView({ block: "nearest" });
  });
  const buttons = { play: $("play"), before: $("before"), next: $("next"), speed: $("speed") };
  ZeronavPlayer.controls(player, buttons, {
    f: framing.follow, 0: framing.fit, "+": () => zoom(1.4), "-": () => zoom(1 / 1.4),
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
  player.seek(start_s);
})();
