// What the live page asks of the stack, and what became of it: goals, poses, obstacles, faults, swaps.
const ZeronavActs = (() => {
  "use strict";

  const by = (id) => document.getElementById(id);
  const CONFIRM_MS = 4000; // for which a second click on the same button counts
  const SWAP_LOOK_MS = 400;
  const STAND = { mps: 0.01, radps: 0.01, limit_ms: 10000 };
  const TOOLS = [
    { key: "move", name: "Move", hint: "drag: move the map" },
    { key: "goal", name: "Goal", hint: "click: goal · drag: goal with yaw · shift-click: queue · shift-drag: obstacle · right-drag: move the map" },
    { key: "queue", name: "Queue", hint: "click or drag: a goal after the others" },
    { key: "pose", name: "Pose estimate", hint: "drag: the robot is here and looks this way" },
    { key: "obstacle", name: "Obstacle", hint: "drag: put a box into the simulated world" },
    { key: "zone", name: "Zone", hint: "click: a corner · click the first corner: done · drag: move the map · Esc: forget it" },
  ];
  const ENDED = new Set(["swapped", "compared", "rejected", "rolled_back", "cancelled"]);

  const millimetres = (value) => Math.round(value * 1000) / 1000;
  function make(tag, text, kind) {
    const element = document.createElement(tag);
    if (text !== undefined) element.textContent = text;
    if (kind) element.className = kind;
    return element;
  }

  let said_timer = 0;
  /** Says something for a while; what went wrong stays longer. */
  function say(text, is_bad) {
    const said = by("said");
    said.textContent = text;
    said.className = is_bad ? "bad" : "";
    said.hidden = false;
    clearTimeout(said_timer);
    said_timer = setTimeout(() => { said.hidden = true; }, is_bad ? 10000 : 3500);
  }

  /** What became of a swap, in one line. */
  function swapLine({ id, role, state, why }) {
    const words = { rolled_back: "rolled back", swapped: "done, the newcomer has the seat", compared: "compared, nothing changed" };
    const what = ENDED.has(state) ? words[state] || state : `accepted, ${state}`;
    return `swap ${id ? `${id} ` : ""}of ${role.replaceAll("_", " ")}: ${what}${why ? `: ${why}` : ""}`;
  }

  /** The acts of a page: {token, view, scene(), run(), is_held(), may_act(), note(kind, text), refresh()}. */
  function acts(page) {
    const { token, view } = page;
    const placed = []; // names of obstacles from this page
    let with_faults = false;
    let seen_swap = null; // "id state" of what was said last; null before the first report
    let following = 0; // number of the swap whose end is awaited

    /** Asks the stack; its answer, with `error` where it did not do it. */
    async function ask(request) {
      try {
        const response = await fetch("act", { method: "POST", headers: { "X-Zeronav-Token": token }, body: JSON.stringify(request) });
        const text = await response.text();
        if (!response.ok) return { error: text.trim() };
        const answer = JSON.parse(text);
        return answer === "done" ? {} : answer;
      } catch (error) {
        return { error: `the page's server does not answer (${error.message})` };
      }
    }
    /** Asks, and says what came of it; `null` when it was not done. */
    async function act(request, done) {
      const answer = await ask(request);
      if (answer.error !== undefined) { say(answer.error, true); return null; }
      if (done) say(typeof done === "function" ? done(answer) : done);
      return answer;
    }

    // -------------------------------------------------------------- goals, poses, obstacles

    function goal(at, yaw, is_added) {
      const pose = [...at.map(millimetres), millimetres(yaw ?? 0)];
      const goals = [{ pose, tolerance_m: 0.15, yaw_tolerance_rad: yaw === null ? 3.1416 : 0.2 }];
      return act({ command: "goal", now: !is_added, goals }, ({ goal: it }) => (
        it && it.before ? `goal queued, ${it.before} before it` : "goal accepted"
      ));
    }
    function estimate(at, yaw) {
      const newest = page.scene() && page.scene().at(Infinity);
      const pose = [...at.map(millimetres), millimetres(yaw ?? (newest ? newest.robot[2] : 0))];
      return act({ command: "pose", pose }, "pose estimate sent");
    }
    async function obstacle([[ax, ay], [bx, by_]]) {
      const name = `page_${Date.now().toString(36)}`;
      const size_m = [Math.abs(bx - ax), Math.abs(by_ - ay)].map((side) => Math.max(0.05, millimetres(side)));
      const pose = [millimetres((ax + bx) / 2), millimetres((ay + by_) / 2), 0];
      if (await act({ command: "obstacle", name, change: { add: { pose, size_m } } }, "obstacle put in")) placed.push(name);
      by("clear").hidden = placed.length === 0;
    }

    /** Asks for the zone that was drawn, of the kind and name in the form; whether it was added. */
    async function zone(polygon) {
      const kind = by("zone-kind").value;
      const value = Number(by("zone-value").value);
      const newest = page.scene() && page.scene().at(Infinity);
      const taken = new Set(((newest && newest.zones) || []).map(([name]) => name));
      let name = by("zone-name").value.trim();
      for (let n = 1; !name; n++) if (!taken.has(`zone ${n}`)) name = `zone ${n}`;
      const more = { speed_limit: { limit_mps: value }, lane: { cost: value }, cost: { cost: value } }[kind] || {};
      const asked = { name, kind, polygon: polygon.map((corner) => corner.map(millimetres)), ...more };
      const is_added = await act({ command: "zone_add", zone: asked }, `zone ${name} added`);
      if (is_added) by("zone-name").value = "";
      return is_added;
    }
    /** The zones that can be taken away, and what else the form shows. */
    function showZones() {
      const newest = page.scene() && page.scene().at(Infinity);
      const names = [...new Set(((newest && newest.zones) || []).map(([name]) => name))];
      const list = by("zone-list");
      by("zone-form").hidden = view.tool !== "zone";
      if (list.dataset.names !== names.join("\n")) {
        list.dataset.names = names.join("\n");
        list.replaceChildren(...names.map((name) => Object.assign(make("option", name), { value: name })));
      }
      list.hidden = by("zone-remove").hidden = names.length === 0;
      const defaults = { keepout: null, speed_limit: "0.3", lane: "100", cost: "100" };
      const value = by("zone-value");
      const kind = by("zone-kind").value;
      if (value.dataset.kind !== kind) {
        value.dataset.kind = kind;
        value.hidden = defaults[kind] === null;
        value.value = defaults[kind] || "";
        value.title = kind === "speed_limit" ? "fastest speed [m/s]" : "cost, 1 to 252";
      }
    }

    function setTool(key) {
      view.tool = key;
      view.corners = [];
      const tool = TOOLS.find((each) => each.key === key);
      by("hint").textContent = tool.hint;
      for (const button of by("modes").children) button.setAttribute("aria-pressed", String(button.dataset.tool === key));
      by("view").dataset.tool = key;
      showZones();
      view.redraw();
    }

    // -------------------------------------------------------------- stop

    const moves = () => {
      const newest = page.scene() && page.scene().at(Infinity);
      return Boolean(newest) && (Math.abs(newest.robot[3]) > STAND.mps || Math.abs(newest.robot[4]) > STAND.radps);
    };
    async function stop() {
      const answer = await ask({ command: "cancel" });
      const had_none = /no goal to cancel/.test(answer.error || "");
      if (answer.error !== undefined && !had_none) {
        // What cannot be cancelled can still be held.
        const held = await ask({ command: "pause" });
        say(`goals are not cancelled: ${answer.error}${held.error === undefined ? "; run time is held instead" : `; nor is run time held: ${held.error}`}`, true);
        return;
      }
      const what = had_none ? "there was no goal" : "every goal is cancelled";
      say(`${what}; the robot brakes`);
      const began = performance.now();
      const look = () => {
        if (!moves()) say(`${what}; the robot stands`);
        else if (performance.now() - began < STAND.limit_ms) setTimeout(look, 100);
        else say(`${what}, but the robot still moves after ${STAND.limit_ms / 1000} s`, true);
      };
      setTimeout(look, 300);
    }

    // -------------------------------------------------------------- seats

    function button(key, text, title, act_on, sure) {
      const element = make("button", text);
      element.title = title;
      element.dataset.act = key;
      let until = 0;
      element.addEventListener("click", () => {
        if (sure && performance.now() > until) {
          until = performance.now() + CONFIRM_MS;
          element.textContent = sure;
          element.classList.add("sure");
          setTimeout(() => { element.textContent = text; element.classList.remove("sure"); }, CONFIRM_MS);
          return;
        }
        until = 0;
        element.textContent = text;
        element.classList.remove("sure");
        try { act_on(); } catch (error) { say(error.message, true); }
      });
      return element;
    }
    function field(placeholder, title) {
      const element = make("input");
      Object.assign(element, { placeholder, title, spellcheck: false });
      return element;
    }

    /** What can be done with a seat: faults behind their switch, and a swap. */
    function seatActs(role) {
      const name = role.replaceAll("_", " ");
      const [first, second] = [make("div"), make("div")];
      const fault = (kind, more) => () => act({ command: "fault", fault: { kind, service: role, ...more } }, `${kind} of ${name}: done`);
      if (with_faults) {
        first.append(
          button("kill", "Kill (SIGKILL)", "It crashes and is restarted", fault("kill"), `Kill ${name}: click again`),
          button("hang", "Hang (SIGSTOP)", "It hangs until it is restarted", fault("stop"), `Hang ${name}: click again`),
          button("slow", "Slow (20 ms, 5 s)", "Each answer is 20 ms late, for 5 s", fault("slow", { by_ms: 20, lasts_s: 5 })),
          button("heal", "End faults", "End the faults of this seat", () => act({ command: "heal", target: role }, `faults of ${name} ended`)),
        );
      }
      const binary = field("binary (the same)", "Another program that the scenario lists, or any by name or path; empty = the one in the seat");
      binary.setAttribute("list", "binaries");
      const run = page.run();
      const listed = (run && run.binaries && run.binaries[role]) || [];
      by("binaries").replaceChildren(...listed.map((each) => Object.assign(make("option"), { value: each })));
      const keys = field("key=value, ...", "Parameters of the newcomer, such as controller=dwa");
      second.append(binary, keys, button("swap", "Swap", "Exchange the process while the robot drives", () => swap({
        role, binary: binary.value.trim() || null, config: configOf(keys.value), shadow_s: 2, keep_s: 2,
      })));
      return [first, second];
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

    // -------------------------------------------------------------- swaps

    async function swap(order) {
      const answer = await ask({ command: "swap", order });
      if (answer.error !== undefined) return tellSwap({ role: order.role, state: "rejected", why: answer.error });
      following = answer.swap.id;
      tellSwap(answer.swap);
      return follow(answer.swap.id);
    }
    /** Looks until a swap of this page is over: two that end within a second would look like one. */
    async function follow(id) {
      const { swap: result, error } = await ask({ command: "swap_status", id });
      if (error === undefined && !ENDED.has(result.state)) { setTimeout(() => follow(id), SWAP_LOOK_MS); return; }
      if (following === id) following = 0;
      if (error === undefined) tellSwap(result);
    }
    function tellSwap(result) {
      const line = swapLine(result);
      say(line, result.state === "rejected" || result.state === "rolled_back");
      page.note("swap", line);
      // One that was not begun has no number.
      if (result.id) seen_swap = `${result.id} ${result.state}`;
    }
    /** A report of the run: swaps that others asked for, each of their outcomes once. */
    function report(run) {
      const { swap: result } = run;
      const now = result ? `${result.id} ${result.state}` : "";
      const is_first = seen_swap === null;
      if (now === seen_swap || (result && result.id === following)) return;
      seen_swap = now;
      if (!result) return;
      // What was over before the page came is told in the list only.
      if (!is_first) tellSwap(result);
      else page.note("swap", swapLine(result));
    }

    // -------------------------------------------------------------- the page's controls

    function enable() {
      by("modes").replaceChildren(...TOOLS.map(({ key, name, hint }) => {
        const element = make("button", name);
        Object.assign(element, { title: hint });
        element.dataset.tool = key;
        element.addEventListener("click", () => setTool(key));
        return element;
      }));
      // A finger that scrolls must not send the robot away.
      setTool(matchMedia("(pointer: coarse)").matches ? "move" : "goal");
      view.onpose = ({ tool, at, yaw, is_added }) => {
        if (tool === "pose") estimate(at, yaw);
        else goal(at, yaw, is_added || tool === "queue");
      };
      view.ondraft = obstacle;
      view.onzone = zone;
      by("zone-kind").addEventListener("change", showZones);
      by("zone-remove").addEventListener("click", () => {
        const name = by("zone-list").value;
        act({ command: "zone_remove", name }, `zone ${name} removed`);
      });
      addEventListener("keydown", (event) => {
        if (event.key !== "Escape" || !view.corners.length) return;
        view.corners = [];
        view.redraw();
      });
      by("stop").addEventListener("click", stop);
      by("faults").addEventListener("click", () => {
        with_faults = !with_faults;
        by("faults").setAttribute("aria-pressed", String(with_faults));
        page.refresh();
      });
      by("pause").addEventListener("click", () => {
        const is_held = page.is_held();
        act({ command: is_held ? "resume" : "pause" }, is_held ? "run time goes on" : "run time is held");
      });
      by("step").addEventListener("click", () => act({ command: "step", ticks: Number(by("ticks").value) || 1 }, "stepped"));
      by("pace").addEventListener("change", () => act({ command: "speed", factor: Number(by("pace").value) || null }, "speed set"));
      by("clear").addEventListener("click", async () => {
        for (const name of placed.splice(0)) await act({ command: "obstacle", name, change: "remove" }, "obstacle removed");
        by("clear").hidden = true;
      });
    }
    function disable() {
      view.onpose = view.ondraft = view.onzone = null;
      view.tool = "move";
      view.corners = [];
      showZones();
    }
    return { enable, disable, report, seatActs, showZones };
  }

  return { acts, say };
})();
