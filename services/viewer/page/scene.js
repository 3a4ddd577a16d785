// Keeps the frames of a run and draws a moment of them on a canvas. The format is described in
// README.md beside this file. No network, no clock, and no global but this one.
// long: one file, so that a report can hold it as one script
const ZeronavScene = (() => {
  "use strict";

  const TILE = 32;
  const EVENTS_MAX = 500; // that are kept where old frames are dropped
  const FLAG = { static: 1, sensed: 2, virtual: 4, regularised: 8, unknown: 16 };

  // ---------------------------------------------------------------- frames

  /** Bytes of base64 of PackBits; `null` for a layer that was not recorded. */
  function unpack(text) {
    if (!text) return null;
    const from = atob(text);
    const to = new Uint8Array(TILE * TILE);
    let at = 0;
    for (let i = 0; i < from.length && at < to.length; ) {
      const n = from.charCodeAt(i);
      if (n < 128) {
        for (let k = 1; k <= n + 1 && at < to.length; k++) to[at++] = from.charCodeAt(i + k);
        i += n + 2;
      } else {
        const value = from.charCodeAt(i + 1);
        for (let k = 257 - n; k > 0 && at < to.length; k--) to[at++] = value;
        i += 2;
      }
    }
    return to;
  }

  /** The tiles of one grid, with all versions that the kept frames need. */
  class TileLog {
    constructor(grid, since) {
      [this.x, this.y, this.resolution, this.width, this.height] = grid;
      this.columns = Math.ceil(this.width / TILE);
      this.rows = Math.ceil(this.height / TILE);
      this.since = since;
      this.versions = new Map(); // key -> [[frame, flags, cost, clearance], ...], packed
      this.newest = since;
    }
    push(frame, tiles) {
      for (const [column, row, ...layers] of tiles) {
        if (!(column >= 0 && column < this.columns && row >= 0 && row < this.rows)) continue;
        const key = row * this.columns + column;
        if (!this.versions.has(key)) this.versions.set(key, []);
        this.versions.get(key).push([frame, ...layers]);
      }
      this.newest = frame;
    }
    /** The version of a tile that frame `frame` shows. */
    at(key, frame) {
      const all = this.versions.get(key) || [];
      for (let i = all.length - 1; i >= 0; i--) if (all[i][0] <= frame) return all[i];
      return null;
    }
    forget(first) {
      for (const all of this.versions.values()) {
        while (all.length > 1 && all[1][0] <= first) all.shift();
      }
    }
  }

  /** Frames of a run in order of time. */
  class Scene {
    /** Longer than `unseen_s` between two frames, what was driven in between was not seen. */
    constructor(fixed, { keep_s = Infinity, unseen_s = Infinity } = {}) {
      this.fixed = fixed;
      this.keep_s = keep_s;
      this.unseen_s = unseen_s;
      this.states = []; // whole moments; what did not change is shared
      this.first = 0; // number of the first kept frame
      this.logs = [];
      this.events = []; // of the kept frames and before
    }
    get start_s() { return this.states.length ? this.states[0].time_s : 0; }
    get end_s() { return this.states.length ? this.states[this.states.length - 1].time_s : 0; }

    push(frame) {
      const before = this.states[this.states.length - 1];
      const number = this.first + this.states.length;
      const { map, events, ...rest } = frame;
      const state = Object.assign({ before_path: null, path_since_s: 0 }, before, rest);
      if (frame.path && (!before || !before.path || before.path.id !== frame.path.id)) {
        state.before_path = before ? before.path : null;
        state.path_since_s = frame.time_s;
      }
      // The driven line is drawn within a part, and never across what nobody saw.
      const is_seen = before && frame.time_s - before.time_s <= this.unseen_s && frame.time_s >= before.time_s;
      state.part = before ? before.part + (is_seen ? 0 : 1) : 0;
      if (map && map.grid) this.logs.push(new TileLog(map.grid, number));
      if (map && this.logs.length) this.logs[this.logs.length - 1].push(number, map.tiles || []);
      for (const event of events || []) this.events.push(event);
      this.states.push(state);
      if (this.keep_s !== Infinity && number % 64 === 0) this.forget();
      return state;
    }
    forget() {
      const oldest = this.end_s - this.keep_s;
      const drop = Math.max(0, this.indexAt(oldest));
      if (drop === 0) return;
      this.states.splice(0, drop);
      this.first += drop;
      while (this.logs.length > 1 && this.logs[1].since <= this.first) this.logs.shift();
      for (const log of this.logs) log.forget(this.first);
      if (this.events.length > EVENTS_MAX) this.events.splice(0, this.events.length - EVENTS_MAX);
    }
    /** Place in `states` of the last frame that is not after `time_s`; -1 before the first. */
    indexAt(time_s) {
      let [low, high] = [0, this.states.length];
      while (low < high) {
        const middle = (low + high) >> 1;
        if (this.states[middle].time_s <= time_s) low = middle + 1;
        else high = middle;
      }
      return low - 1;
    }
    /** The moment at `time_s`, with the robot between two frames where it was then. */
    at(time_s) {
      if (!this.states.length) return null;
      const index = Math.max(0, this.indexAt(time_s));
      const state = this.states[index];
      const next = this.states[index + 1];
      const moment = { ...state, index, number: this.first + index, now_s: state.time_s };
      if (next && time_s > state.time_s && next.time_s > state.time_s) {
        const part = (time_s - state.time_s) / (next.time_s - state.time_s);
        moment.now_s = time_s;
        moment.robot = between(state.robot, next.robot, part);
        if (state.truth && next.truth) moment.truth = between(state.truth, next.truth, part);
      }
      return moment;
    }
    log(number) {
      let found = null;
      for (const log of this.logs) if (log.since <= number) found = log;
      return found;
    }
  }

  function between(a, b, part) {
    const mixed = a.map((value, i) => value + (b[i] - value) * part);
    const turn = Math.atan2(Math.sin(b[2] - a[2]), Math.cos(b[2] - a[2]));
    mixed[2] = a[2] + turn * part;
    return mixed;
  }

  // ---------------------------------------------------------------- colours

  const THEMES = {
    light: {
      outside: "#e9ebee", unknown: "#dfe2e6", free: "#ffffff", static: "#39424e", sensed: "#d4552f",
      virtual: "#8a63c7", regularised: "#c9952a", cost: "#3f6fd8", clearance: "#159a8c",
      scan: "#e03131", obstacle: "#b7791f", path: "#1c62d6", before: "#1c62d6", track: "#7b8794",
      robot: "#0b8f6a", robotFill: "#0b8f6a33", truth: "#6b7280", goal: "#a3319f", body: "#9aa3ad",
      free_arc: "#0b8f6a", slowed: "#d08700", stopped: "#d62f2f", text: "#3b434d", halo: "#ffffffcc",
      keepout: "#c2255c", speed_limit: "#c77700", avoid: "#7048e8", lane: "#2b8a3e",
      chosen: "#e6007e", costlier: "#8b95a1", collision: "#e07b00", moving_collision: "#7a4fd0", no_stop: "#d62f2f",
    },
    dark: {
      outside: "#0f1215", unknown: "#181c21", free: "#21262c", static: "#aab4c0", sensed: "#ff8157",
      virtual: "#b395ec", regularised: "#e0b454", cost: "#5d8bf4", clearance: "#2fb8a8",
      scan: "#ff6b6b", obstacle: "#e5b567", path: "#6aa5ff", before: "#6aa5ff", track: "#7d8894",
      robot: "#3ddbac", robotFill: "#3ddbac33", truth: "#8f98a3", goal: "#e17fdc", body: "#58616b",
      free_arc: "#3ddbac", slowed: "#f0b429", stopped: "#ff5c5c", text: "#c3cad2", halo: "#14181ccc",
      keepout: "#ff6f9c", speed_limit: "#f5b14a", avoid: "#a58bff", lane: "#69db7c",
      chosen: "#ff4fb0", costlier: "#77828e", collision: "#ffa62b", moving_collision: "#b395ec", no_stop: "#ff5c5c",
    },
  };

  const LAYERS = [
    { key: "static", name: "static", on: true, map: true },
    { key: "sensed", name: "sensed", on: true, map: true },
    { key: "virtual", name: "virtual", on: true, map: true },
    { key: "regularised", name: "regularised", on: true, map: true },
    { key: "cost", name: "cost", on: false, map: true },
    { key: "clearance", name: "clearance", on: false, map: true },
    { key: "zone", name: "zones", colour: "keepout", on: true },
    { key: "scan", name: "scan", on: true },
    { key: "obstacle", name: "tracked", on: true },
    { key: "path", name: "path", on: true },
    { key: "rollouts", name: "rollouts", colour: "chosen", on: true },
    { key: "track", name: "driven", on: true },
    { key: "goal", name: "goals", on: true },
    { key: "arc", name: "braking", colour: "free_arc", on: true },
    { key: "truth", name: "ground truth", on: true },
  ];

  // Why a rollout was not chosen, by the word of the contract, which is that of its colour, too.
  const ROLLOUTS = [
    { key: "chosen", name: "chosen" },
    { key: "costlier", name: "costs more" },
    { key: "collision", name: "leads into an obstacle" },
    { key: "moving_collision", name: "leads into a moving obstacle" },
    { key: "no_stop", name: "no room to stop" },
  ];

  // How the kinds of zones look: the colour, and what stands behind the name.
  const ZONES = {
    keepout: { colour: "keepout", says: () => "keepout" },
    speed_limit: { colour: "speed_limit", says: (value) => `${value} m/s` },
    speed_percent: { colour: "speed_limit", says: (value) => `${value} %` },
    cost: { colour: "avoid", says: (value) => `cost ${value}` },
    lane: { colour: "lane", says: () => "lane" },
  };

  const channels = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));

  // ---------------------------------------------------------------- the map as an image

  /** The map of one moment, a pixel per cell, kept up to date tile by tile. */
  class MapImage {
    constructor() {
      this.canvas = document.createElement("canvas");
      this.log = null;
      this.shown = new Map(); // key -> version
      this.look = "";
    }
    /** Shows frame `number` of `log` with these layers and colours. */
    show(log, number, layers, theme) {
      const look = LAYERS.filter((layer) => layer.map && layers[layer.key]).map((layer) => layer.key).join() + theme.free;
      if (log !== this.log || look !== this.look) {
        if (log !== this.log) [this.canvas.width, this.canvas.height] = [log.width, log.height];
        this.context = this.canvas.getContext("2d");
        this.context.fillStyle = theme.unknown;
        this.context.fillRect(0, 0, log.width, log.height);
        [this.log, this.look, this.number] = [log, look, -1];
        this.shown.clear();
        this.colours = Object.fromEntries(Object.entries(theme).map(([key, hex]) => [key, channels(hex)]));
      }
      if (this.number === number) return;
      this.number = number;
      for (const key of log.versions.keys()) {
        const version = log.at(key, number);
        if (this.shown.get(key) === version) continue;
        this.shown.set(key, version);
        this.paint(key, version, layers);
      }
    }
    paint(key, version, layers) {
      const { log, colours } = this;
      const [column, row] = [key % log.columns, Math.floor(key / log.columns)];
      const image = this.context.createImageData(TILE, TILE);
      const flags = version && unpack(version[1]);
      const cost = version && layers.cost && unpack(version[2]);
      const clearance = version && layers.clearance && unpack(version[3]);
      for (let i = 0; i < TILE * TILE; i++) {
        const colour = cellColour(colours, layers, flags ? flags[i] : FLAG.unknown, cost && cost[i], clearance && clearance[i]);
        // The first row of cells is the lowest one, that of an image the highest.
        const to = ((TILE - 1 - Math.floor(i / TILE)) * TILE + (i % TILE)) * 4;
        [image.data[to], image.data[to + 1], image.data[to + 2], image.data[to + 3]] = [...colour, 255];
      }
      this.context.putImageData(image, column * TILE, log.height - (row + 1) * TILE);
    }
  }

  function cellColour(colours, layers, flags, cost, clearance) {
    if (flags & FLAG.static && layers.static) return colours.static;
    if (flags & FLAG.sensed && layers.sensed) return colours.sensed;
    if (flags & FLAG.virtual && layers.virtual) return colours.virtual;
    if (flags & FLAG.regularised && layers.regularised) return colours.regularised;
    let colour = flags & FLAG.unknown ? colours.unknown : colours.free;
    if (typeof clearance === "number") {
      // Bands of 10 cm, so that distances can be counted.
      const band = Math.min(1, Math.floor(clearance / 10) / 12);
      colour = mixed(colour, colours.clearance, 0.6 * (1 - band));
    }
    if (typeof cost === "number" && cost > 0 && cost < 255) {
      colour = mixed(colour, colours.cost, cost >= 253 ? 0.72 : 0.08 + 0.5 * (cost / 252));
    }
    return colour;
  }

  const mixed = (a, b, part) => a.map((value, i) => Math.round(value + (b[i] - value) * part));

  // ---------------------------------------------------------------- the view

  const SCALE = { least: 2, most: 2000 }; // pixels per metre
  const CLICK_PX = 5; // a pointer that moved less has clicked
  const TOUCH_PX = 12; // a finger
  const UNSEEN_S = 0.3; // after which a tracked obstacle is only an outline
  const ZONE_CORNERS_MAX = 16;

  /** Draws a moment of a scene, and moves over it. */
  class View {
    constructor(canvas) {
      this.canvas = canvas;
      this.layers = Object.fromEntries(LAYERS.map((layer) => [layer.key, layer.on]));
      this.follow = false;
      this.theme = "auto";
      this.time_s = Infinity;
      this.scene = null;
      this.image = new MapImage();
      this.scale = 0; // pixels per metre; 0 = fit at the next drawing
      this.centre = [0, 0];
      this.tool = "move"; // what a drag of the main button does; any other word goes to `onpose`
      this.draft = null; // what is being drawn: {is_box, from: [x, y], to: [x, y]}
      this.corners = []; // of a zone that is being drawn
      this.onzone = null; // ([[x, y], ...]) of a closed polygon
      this.onpose = null; // ({tool, at: [x, y], yaw, is_added}); yaw is null after a click
      this.ondraft = null; // ([[x, y], [x, y]]) of a rectangle
      this.pointers = new Map();
      this.pinched = false; // two fingers move the map until both are gone
      this.asked = false;
      this.listen();
      new ResizeObserver(() => this.redraw()).observe(canvas);
      matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.redraw());
    }

    show(scene) { this.scene = scene; this.scale = 0; this.redraw(); }
    seek(time_s) { this.time_s = time_s; this.redraw(); }
    fit() { this.scale = 0; this.follow = false; this.redraw(); }
    get colours() {
      const dark = this.theme === "dark" || (this.theme === "auto" && matchMedia("(prefers-color-scheme: dark)").matches);
      return THEMES[dark ? "dark" : "light"];
    }
    /** Draws at the next frame of the screen. */
    redraw() {
      if (this.asked) return;
      this.asked = true;
      requestAnimationFrame(() => { this.asked = false; this.draw(); });
    }

    toMap(px, py) {
      const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
      return [this.centre[0] + (px - width / 2) / this.scale, this.centre[1] - (py - height / 2) / this.scale];
    }
    toScreen([x, y]) {
      const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
      return [width / 2 + (x - this.centre[0]) * this.scale, height / 2 - (y - this.centre[1]) * this.scale];
    }
    zoom(by, px, py) {
      if (!this.scale) return;
      const [x, y] = this.toMap(px, py);
      this.scale = Math.min(SCALE.most, Math.max(SCALE.least, this.scale * by));
      const [nx, ny] = this.toMap(px, py);
      if (!this.follow) this.centre = [this.centre[0] + x - nx, this.centre[1] + y - ny];
      this.redraw();
    }

    listen() {
      const canvas = this.canvas;
      const at = (event) => {
        const box = canvas.getBoundingClientRect();
        return [event.clientX - box.left, event.clientY - box.top];
      };
      canvas.style.touchAction = "none";
      canvas.addEventListener("wheel", (event) => {
        event.preventDefault();
        this.zoom(Math.exp(-event.deltaY * (event.ctrlKey ? 0.01 : 0.0015)), ...at(event));
      }, { passive: false });
      canvas.addEventListener("contextmenu", (event) => { if (this.onpose) event.preventDefault(); });
      canvas.addEventListener("pointerdown", (event) => {
        if (event.button > 2) return;
        canvas.setPointerCapture(event.pointerId);
        const from = at(event);
        this.pointers.set(event.pointerId, { from, last: from, moved: false, is_touch: event.pointerType === "touch" });
        this.pinched = this.pinched || this.pointers.size > 1;
        this.draft = null;
        if (event.button !== 0 || this.pinched || !this.scale) return;
        if (this.tool === "zone") return;
        const to = this.toMap(...from);
        const is_box = this.tool === "obstacle" || (this.tool === "goal" && event.shiftKey);
        if (is_box ? this.ondraft : this.onpose && this.tool !== "move") this.draft = { is_box, from: to, to, is_added: event.shiftKey };
      });
      canvas.addEventListener("pointermove", (event) => {
        const pointer = this.pointers.get(event.pointerId);
        if (pointer) this.move(pointer, at(event));
      });
      const end = (event, is_done) => {
        const pointer = this.pointers.get(event.pointerId);
        this.pointers.delete(event.pointerId);
        if (!this.pointers.size) this.pinched = false;
        const draft = this.draft;
        this.draft = null;
        if (pointer && is_done && draft) this.finish(draft, pointer.moved);
        else if (pointer && is_done && event.button === 0 && this.tool === "zone" && !pointer.moved && !this.pinched) this.corner(at(event));
        this.redraw();
      };
      canvas.addEventListener("pointerup", (event) => end(event, true));
      canvas.addEventListener("pointercancel", (event) => end(event, false));
    }
    /** One more corner of a zone; on the first one, or twice on the last, the zone is closed. */
    corner([px, py]) {
      if (!this.onzone || !this.scale) return;
      const is_on = (corner) => {
        const [x, y] = this.toScreen(corner);
        return Math.hypot(x - px, y - py) <= 2 * CLICK_PX;
      };
      const { corners } = this;
      const closes = corners.length >= 3 && (is_on(corners[0]) || is_on(corners[corners.length - 1]));
      if (closes) {
        // What is rejected stays, to be drawn on or given another name.
        this.onzone(corners).then((is_added) => {
          if (is_added && this.corners === corners) this.corners = [];
          this.redraw();
        });
      } else if (corners.length < ZONE_CORNERS_MAX && !(corners.length && is_on(corners[corners.length - 1]))) {
        corners.push(this.toMap(px, py));
      }
      this.redraw();
    }
    /** Hands over what was drawn. */
    finish({ is_box, from, to, is_added }, moved) {
      if (is_box && moved) return this.ondraft([from, to]);
      if (this.tool === "obstacle" || !this.onpose) return null;
      const yaw = moved ? Math.atan2(to[1] - from[1], to[0] - from[0]) : null;
      return this.onpose({ tool: this.tool, at: from, yaw, is_added });
    }
    move(pointer, [px, py]) {
      const [fx, fy] = pointer.from;
      pointer.moved = pointer.moved || Math.hypot(px - fx, py - fy) > (pointer.is_touch ? TOUCH_PX : CLICK_PX);
      const before = pointer.last;
      const spread = () => {
        const [a, b] = [...this.pointers.values()].map((each) => each.last);
        return Math.hypot(a[0] - b[0], a[1] - b[1]);
      };
      const was = this.pointers.size === 2 ? spread() : 0;
      pointer.last = [px, py];
      const share = this.pointers.size === 2 ? 0.5 : 1; // two fingers move it together
      if (this.draft) this.draft.to = this.toMap(px, py);
      else if (pointer.moved && this.scale) {
        this.follow = false;
        this.centre = [this.centre[0] - share * (px - before[0]) / this.scale, this.centre[1] + share * (py - before[1]) / this.scale];
      }
      if (was > 0) this.zoom(spread() / was, px, py);
      this.redraw();
    }

    // -------------------------------------------------------------- drawing

    draw() {
      const { canvas } = this;
      const ratio = window.devicePixelRatio || 1;
      const [width, height] = [canvas.clientWidth, canvas.clientHeight];
      if (!width || !height) return;
      const [pw, ph] = [Math.round(width * ratio), Math.round(height * ratio)];
      if (canvas.width !== pw || canvas.height !== ph) [canvas.width, canvas.height] = [pw, ph];
      const to = canvas.getContext("2d");
      const theme = this.colours;
      to.setTransform(1, 0, 0, 1, 0, 0);
      to.fillStyle = theme.outside;
      to.fillRect(0, 0, pw, ph);
      const moment = this.scene && this.scene.at(this.time_s);
      if (!moment) return;
      const log = this.scene.log(moment.number);
      if (!this.scale) this.frame(log, moment, width, height);
      if (this.follow) this.centre = [moment.robot[0], moment.robot[1]];
      const scale = this.scale * ratio;
      to.setTransform(scale, 0, 0, -scale, pw / 2 - this.centre[0] * scale, ph / 2 + this.centre[1] * scale);
      const px = 1 / this.scale; // a pixel of the screen in metres
      to.lineJoin = to.lineCap = "round";
      if (log) this.drawMap(to, log, moment, theme);
      if (this.layers.zone) this.drawZones(to, moment, theme, px);
      this.drawBodies(to, moment, theme, px);
      if (this.layers.track) this.drawTrack(to, moment, theme, px);
      if (this.layers.path) this.drawPaths(to, moment, theme, px);
      if (this.layers.goal) this.drawGoals(to, moment, theme, px);
      if (this.layers.scan) this.drawScan(to, moment, theme, px);
      if (this.layers.obstacle) this.drawObstacles(to, moment, theme, px);
      if (this.layers.truth && moment.truth) this.drawTruth(to, moment, theme, px);
      if (this.layers.rollouts) this.drawRollouts(to, moment, theme, px);
      if (this.layers.arc) this.drawArc(to, moment, theme, px);
      this.drawRobot(to, moment, theme, px);
      if (this.draft) this.drawDraft(to, theme, px);
      if (this.corners.length) this.drawCorners(to, theme, px);
      to.setTransform(ratio, 0, 0, ratio, 0, 0);
      if (this.layers.zone) this.nameZones(to, moment, theme);
      this.drawScaleBar(to, theme, width, height);
    }

    /** Fits the map, or without one where the robot has been and 5 m around it, into the canvas. */
    frame(log, moment, width, height) {
      const [x, y, w, h] = log
        ? [log.x, log.y, log.width * log.resolution, log.height * log.resolution]
        : this.driven(moment);
      this.scale = Math.min(SCALE.most, Math.max(SCALE.least, 0.96 * Math.min(width / w, height / h)));
      this.centre = [x + w / 2, y + h / 2];
    }

    /** A box around everywhere where the robot has been: x, y, width and height. [m] */
    driven(moment) {
      let [x, y, to_x, to_y] = [Infinity, Infinity, -Infinity, -Infinity];
      for (const { robot, truth } of [moment, ...this.scene.states]) {
        for (const [at_x, at_y] of truth ? [robot, truth] : [robot]) {
          [x, y, to_x, to_y] = [Math.min(x, at_x), Math.min(y, at_y), Math.max(to_x, at_x), Math.max(to_y, at_y)];
        }
      }
      return [x - 5, y - 5, to_x - x + 10, to_y - y + 10];
    }

    drawMap(to, log, moment, theme) {
      this.image.show(log, moment.number, this.layers, theme);
      to.save();
      to.imageSmoothingEnabled = this.scale * log.resolution < 1;
      to.translate(log.x, log.y + log.height * log.resolution);
      to.scale(log.resolution, -log.resolution);
      to.drawImage(this.image.canvas, 0, 0);
      to.restore();
    }

    drawBodies(to, moment, theme, px) {
      for (const outline of moment.bodies || []) {
        polygon(to, outline);
        to.fillStyle = theme.body + "55";
        to.fill();
        to.setLineDash([4 * px, 3 * px]);
        stroke(to, theme.body, 1.5 * px);
        to.setLineDash([]);
      }
    }

    drawZones(to, moment, theme, px) {
      for (const [, kind, , corners] of moment.zones || []) {
        const colour = theme[(ZONES[kind] || ZONES.keepout).colour];
        polygon(to, corners);
        to.fillStyle = colour + (kind === "keepout" ? "4d" : "22");
        to.fill();
        to.setLineDash(kind === "lane" ? [6 * px, 4 * px] : []);
        stroke(to, colour, 1.5 * px);
        to.setLineDash([]);
      }
    }

    /** The name of each zone once, in the middle of its first part, and what it asks for. */
    nameZones(to, moment, theme) {
      const named = new Set();
      to.font = "12px system-ui, sans-serif";
      to.textAlign = "center";
      to.lineJoin = "round";
      for (const [name, kind, value, corners] of moment.zones || []) {
        if (named.has(name)) continue;
        named.add(name);
        const looks = ZONES[kind] || ZONES.keepout;
        const middle = corners.reduce(([x, y], corner) => [x + corner[0] / corners.length, y + corner[1] / corners.length], [0, 0]);
        const [px, py] = this.toScreen(middle);
        const text = `${name} · ${looks.says(value)}`;
        to.strokeStyle = theme.halo;
        to.lineWidth = 3;
        to.strokeText(text, px, py + 4);
        to.fillStyle = theme[looks.colour];
        to.fillText(text, px, py + 4);
      }
      to.textAlign = "start";
    }

    /** A zone that is being drawn. */
    drawCorners(to, theme, px) {
      line(to, this.corners);
      stroke(to, theme.keepout, 2 * px);
      for (const [x, y] of this.corners) {
        to.beginPath();
        to.arc(x, y, 4 * px, 0, 2 * Math.PI);
        to.fillStyle = theme.keepout;
        to.fill();
      }
    }

    drawTrack(to, moment, theme, px) {
      const { states } = this.scene;
      const step = Math.max(1, Math.floor((moment.index + 1) / 2000));
      let part = -1;
      const point = (state, [x, y]) => {
        if (state.part !== part) to.moveTo(x, y);
        to.lineTo(x, y);
        part = state.part;
      };
      to.beginPath();
      for (let i = 0; i <= moment.index; i += step) point(states[i], states[i].robot);
      point(moment, moment.robot);
      stroke(to, theme.track, 1.5 * px);
    }

    drawPaths(to, moment, theme, px) {
      const age_s = moment.now_s - moment.path_since_s;
      const fading = Math.max(0, 1 - age_s / 4);
      const { before_path: before, path } = moment;
      if (before && before.points_m.length && fading > 0) {
        to.globalAlpha = 0.55 * fading;
        to.setLineDash([5 * px, 4 * px]);
        line(to, before.points_m);
        stroke(to, theme.before, 1.5 * px);
        to.setLineDash([]);
        to.globalAlpha = 1;
      }
      if (path && path.points_m.length) {
        line(to, path.points_m);
        stroke(to, theme.path, 2.25 * px);
      }
    }

    drawGoals(to, moment, theme, px) {
      for (const [x, y, yaw, tolerance, state] of moment.goals || []) {
        to.globalAlpha = state === "active" ? 1 : 0.45;
        if (tolerance < 5) {
          to.beginPath();
          to.arc(x, y, tolerance, 0, 2 * Math.PI);
          stroke(to, theme.goal, px);
        }
        const size = Math.max(7 * px, 0.12);
        to.beginPath();
        to.arc(x, y, 0.45 * size, 0, 2 * Math.PI);
        to.fillStyle = theme.goal;
        to.fill();
        arrow(to, [x, y], [x + 2 * size * Math.cos(yaw), y + 2 * size * Math.sin(yaw)], 0.6 * size);
        stroke(to, theme.goal, 1.75 * px);
        to.globalAlpha = 1;
      }
    }

    drawScan(to, moment, theme, px) {
      const { scan } = moment;
      if (!scan) return;
      const [x, y, yaw] = scan.laser;
      const size = Math.max(2.2 * px, 0.015);
      to.fillStyle = theme.scan;
      scan.ranges_mm.forEach((range, i) => {
        if (range < 0) return;
        const angle = yaw + scan.angle_min_rad + i * scan.angle_increment_rad;
        const [hx, hy] = [x + (range / 1000) * Math.cos(angle), y + (range / 1000) * Math.sin(angle)];
        to.fillRect(hx - size / 2, hy - size / 2, size, size);
      });
    }

    /** Discs with their velocity, and where they are in the next two seconds if it stays. */
    drawObstacles(to, moment, theme, px) {
      for (const [, x, y, vx, vy, radius, unseen_s] of moment.obstacles || []) {
        const speed = Math.hypot(vx, vy);
        for (let ahead_s = 0.5; speed > 0.05 && ahead_s <= 2; ahead_s += 0.5) {
          to.globalAlpha = 0.45 * (1 - ahead_s / 2.5);
          to.beginPath();
          to.arc(x + vx * ahead_s, y + vy * ahead_s, radius, 0, 2 * Math.PI);
          stroke(to, theme.obstacle, px);
        }
        to.globalAlpha = 1;
        to.beginPath();
        to.arc(x, y, radius, 0, 2 * Math.PI);
        // Older recordings do not say.
        if (!(unseen_s > UNSEEN_S)) {
          to.fillStyle = theme.obstacle + "40";
          to.fill();
        }
        stroke(to, theme.obstacle, 1.5 * px);
        if (speed > 0.05) {
          arrow(to, [x, y], [x + vx, y + vy], 6 * px);
          stroke(to, theme.obstacle, 1.5 * px);
        }
      }
    }

    /** What the local planner looked at; the chosen one is the last of them. */
    drawRollouts(to, moment, theme, px) {
      for (const [outcome, , , , points] of moment.rollouts || []) {
        const colour = theme[outcome] || theme.costlier;
        const is_chosen = outcome === "chosen";
        const is_free = is_chosen || outcome === "costlier";
        to.globalAlpha = is_chosen ? 1 : 0.6;
        line(to, points);
        stroke(to, colour, (is_chosen ? 3 : 1) * px);
        // Where it touches what is in its way.
        const [x, y] = points[points.length - 1];
        to.fillStyle = colour;
        if (!is_free) to.fillRect(x - 1.5 * px, y - 1.5 * px, 3 * px, 3 * px);
      }
      to.globalAlpha = 1;
    }

    outline(to, [x, y, yaw]) {
      const { footprint_m: corners, radius_m: radius } = this.scene.fixed.robot;
      if (corners.length) polygon(to, corners.map((corner) => placed([x, y, yaw], corner)));
      else { to.beginPath(); to.arc(x, y, radius, 0, 2 * Math.PI); }
    }

    drawTruth(to, moment, theme, px) {
      this.outline(to, moment.truth);
      to.setLineDash([3 * px, 3 * px]);
      stroke(to, theme.truth, 1.25 * px);
      to.setLineDash([]);
    }

    /** The band that the robot sweeps until it stands, in the colour of what the guard does. */
    drawArc(to, moment, theme, px) {
      const { control } = moment;
      const [, , , v, w] = moment.robot;
      if (!control || !(control.braking_m > 0.005) || Math.abs(v) < 0.01) return;
      const colour = GUARD[control.intervention] === undefined ? theme.free_arc : theme[GUARD[control.intervention]];
      const steps = 16;
      let pose = moment.robot.slice(0, 3);
      const centres = [pose];
      const ds = (control.braking_m / steps) * Math.sign(v);
      for (let i = 0; i < steps; i++) {
        const turn = (w / v) * ds;
        pose = [pose[0] + ds * Math.cos(pose[2] + turn / 2), pose[1] + ds * Math.sin(pose[2] + turn / 2), pose[2] + turn];
        centres.push(pose);
      }
      to.globalAlpha = 0.22;
      line(to, centres);
      to.lineCap = "butt";
      stroke(to, colour, 2 * this.scene.fixed.robot.inscribed_m);
      to.lineCap = "round";
      to.globalAlpha = 1;
      line(to, centres);
      stroke(to, colour, 2 * px);
      this.outline(to, pose);
      stroke(to, colour, px);
    }

    drawRobot(to, moment, theme, px) {
      const { robot } = moment;
      this.outline(to, robot);
      to.fillStyle = theme.robotFill;
      to.fill();
      stroke(to, theme.robot, 2 * px);
      const nose = placed(robot, [this.scene.fixed.robot.inscribed_m, 0]);
      to.beginPath();
      to.moveTo(robot[0], robot[1]);
      to.lineTo(...nose);
      stroke(to, theme.robot, 2 * px);
    }

    drawDraft(to, theme, px) {
      const { is_box, from: [ax, ay], to: [bx, by] } = this.draft;
      if (is_box) {
        to.fillStyle = theme.sensed + "55";
        to.fillRect(Math.min(ax, bx), Math.min(ay, by), Math.abs(bx - ax), Math.abs(by - ay));
        polygon(to, [[ax, ay], [bx, ay], [bx, by], [ax, by]]);
        stroke(to, theme.sensed, 1.5 * px);
        return;
      }
      this.outline(to, [ax, ay, Math.atan2(by - ay, bx - ax)]);
      stroke(to, theme.goal, px);
      arrow(to, [ax, ay], [bx, by], 9 * px);
      stroke(to, theme.goal, 2.5 * px);
    }

    drawScaleBar(to, theme, width, height) {
      const length_m = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100].find((length) => length * this.scale >= 50) || 200;
      const [x, y, w] = [14, height - 14, length_m * this.scale];
      to.strokeStyle = to.fillStyle = theme.text;
      to.lineWidth = 1.25;
      to.beginPath();
      to.moveTo(x, y - 4); to.lineTo(x, y); to.lineTo(x + w, y); to.lineTo(x + w, y - 4);
      to.stroke();
      to.font = "11px system-ui, sans-serif";
      to.fillText(`${length_m} m`, x + 5, y - 4);
    }
  }

  // What the guard does, by the word of the contract: the colour of the braking arc.
  const GUARD = {
    clamped: "slowed", slowed: "slowed", refused: "stopped", stopped_short: "stopped",
    request_stale: "stopped", scan_stale: "stopped", odometry_stale: "stopped",
    zone_slowed: "slowed", zone_stopped: "stopped", zones_missing: "stopped",
  };

  function placed([x, y, yaw], [px, py]) {
    const [sin, cos] = [Math.sin(yaw), Math.cos(yaw)];
    return [x + cos * px - sin * py, y + sin * px + cos * py];
  }
  function stroke(to, colour, width) {
    to.strokeStyle = colour;
    to.lineWidth = width;
    to.stroke();
  }
  function line(to, points) {
    to.beginPath();
    for (const [x, y] of points) to.lineTo(x, y);
  }
  function polygon(to, points) {
    line(to, points);
    to.closePath();
  }
  function arrow(to, [ax, ay], [bx, by], head) {
    const angle = Math.atan2(by - ay, bx - ax);
    to.beginPath();
    to.moveTo(ax, ay);
    to.lineTo(bx, by);
    for (const side of [-1, 1]) {
      to.moveTo(bx, by);
      to.lineTo(bx - head * Math.cos(angle + side * 0.45), by - head * Math.sin(angle + side * 0.45));
    }
  }

  return { Scene, View, LAYERS, ROLLOUTS, THEMES };
})();
