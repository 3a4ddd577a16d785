// Moves through the time of a scene, and holds the buttons and keys for that. Drawing is ZeronavScene's.
const ZeronavPlayer = (() => {
  "use strict";
  const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8, 16, 32, 64];
  const pressed = (button, is_on) => button.setAttribute("aria-pressed", String(is_on));

  class Player {
    /** Moves between the two moments of `range()` [s], with stops at those of `stops()`. `shown(time_s)` shows one, and `changed()`
        is called when `playing` or `speed` has changed. */
    constructor({ range, stops, shown, changed, speeds = SPEEDS }) {
      Object.assign(this, { range, stops, shown, changed, speeds, speed: 1, playing: false, now_s: range()[0], before_ms: 0, next: 0 });
    }

    seek(time_s) {
      const [from_s, to_s] = this.range();
      this.now_s = Math.min(to_s, Math.max(from_s, time_s));
      this.shown(this.now_s);
    }

    stopAt(time_s) {
      this.play(false);
      this.seek(time_s);
    }

    play(is_on) {
      const [from_s, to_s] = this.range();
      if (is_on && this.now_s >= to_s) this.seek(from_s);
      Object.assign(this, { playing: is_on, before_ms: 0 });
      cancelAnimationFrame(this.next);
      this.changed();
      if (is_on) this.next = requestAnimationFrame((at_ms) => this.step(at_ms));
    }

    step(at_ms) {
      if (!this.playing) return;
      if (this.before_ms) this.seek(this.now_s + ((at_ms - this.before_ms) / 1000) * this.speed);
      this.before_ms = at_ms;
      if (this.now_s >= this.range()[1]) this.play(false);
      else this.next = requestAnimationFrame((next_ms) => this.step(next_ms));
    }

    /** To the next stop in this direction, 1 or -1. */
    toStop(direction) {
      const [from_s, to_s] = this.range();
      const stops = [from_s, ...this.stops(), to_s].filter((time) => direction * (time - this.now_s) > 0.005);
      if (stops.length) this.seek(direction > 0 ? Math.min(...stops) : Math.max(...stops));
    }

    setSpeed(speed) {
      if (this.speeds.includes(speed)) this.speed = speed;
      this.changed();
    }

    faster(by) {
      this.setSpeed(this.speeds[this.speeds.indexOf(this.speed) + by]);
    }
  }

  /** Gives the player its buttons, its choice of speeds, and keys, `more` of which are those of the page. */
  function controls(player, { play, before, next, speed }, more) {
    const toggle = more[" "] || (() => player.play(!player.playing));
    play.onclick = toggle;
    before.onclick = () => player.toStop(-1);
    next.onclick = () => player.toStop(1);
    speed.replaceChildren(...player.speeds.map((each) => new Option(`${each} ×`, each, each === 1, each === 1)));
    speed.onchange = () => player.setSpeed(Number(speed.value));
    const by = (direction) => (event) => player.seek(player.now_s + direction * (event.shiftKey ? 10 : 1));
    const keys = {
      " ": toggle, ArrowLeft: by(-1), ArrowRight: by(1),
      "[": () => player.toStop(-1), "]": () => player.toStop(1),
      Home: () => player.seek(-Infinity), End: () => player.seek(Infinity),
      "<": () => player.faster(-1), ">": () => player.faster(1), ...more,
    };
    document.addEventListener("keydown", (event) => {
      const act = keys[event.key];
      if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
      const within = (names) => event.target instanceof Element && event.target.closest(names);
      // What is written, chosen or pressed belongs to the field that has the focus.
      if (within("select, textarea, input:not([type=range])") || (event.key === " " && within("button, a"))) return;
      event.preventDefault();
      act(event);
    });
  }

  /** A button for each layer that is `wanted`. */
  function layers(into, view, { wanted = () => true, changed = () => {} }) {
    into.replaceChildren(...ZeronavScene.LAYERS.filter(wanted).map((layer) => {
      const button = document.createElement("button");
      const swatch = document.createElement("i");
      swatch.style.background = view.colours[layer.colour || layer.key];
      button.append(swatch, layer.name);
      button.dataset.layer = layer.key;
      pressed(button, view.layers[layer.key]);
      button.onclick = () => {
        view.layers[layer.key] = !view.layers[layer.key];
        pressed(button, view.layers[layer.key]);
        changed();
        view.redraw();
      };
      return button;
    }));
  }

  /** The buttons that follow the robot, at least at `scale`, and that show the whole map; what they do, for keys. */
  function framing(view, { canvas, follow, fit, scale = 0 }) {
    const set = (is_on) => {
      view.follow = is_on;
      pressed(follow, is_on);
      if (is_on && view.scale) view.scale = Math.max(view.scale, scale);
      view.redraw();
    };
    const acts = { follow: () => set(!view.follow), fit: () => { set(false); view.fit(); } };
    follow.onclick = acts.follow;
    fit.onclick = acts.fit;
    // A drag on the map ends it, too.
    canvas.addEventListener("pointerup", () => pressed(follow, view.follow));
    return acts;
  }

  return { Player, SPEEDS, controls, layers, framing };
})();
