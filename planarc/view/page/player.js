// The player: the mechanism on a canvas with everything that moves it.
//
//   const player = planarc.createPlayer(element, scene, { keys: document });
//   player.setTime(1.5);  player.play();  player.pause();  player.fit();
//   player.setScene(other);            keeps time, view, layers and whether it plays
//   player.onTime((t, reader) => ...)  after every picture; reader.at(column) is a value then
//
// With { bare: true } there is the picture alone, without controls, keys and grabbing.
//
// A scene is {time, tracks, shapes, items, box, layers, scales, events}; see `data.py`.

const SPEEDS = [0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10];

planarc.createPlayer = function (element, scene, options = {}) {
  const { element: make, button } = planarc;
  const canvas = make("canvas", {
    class: "stage", tabindex: 0, role: "img",
    "aria-label": "The moving mechanism. Space plays and pauses, arrow keys step, plus and minus zoom, F fits.",
  });
  const slider = make("input", { type: "range", step: "any", "aria-label": "Time", class: "time" });
  const clock = make("output", { class: "clock" });
  const playing = button("play", "Play (Space)", () => play(!state.playing), { class: "play" });
  const repeat = button("repeat", "Repeat (L)", () => setRepeat(!state.repeat));
  const speed = make("select", { "aria-label": "Speed", title: "Speed" });
  const marks = make("div", { class: "marks", "aria-hidden": "true" });
  const chips = make("div", { class: "chips", role: "group", "aria-label": "Layers" });
  const zoomers = make(
    "div", { class: "zoomers" },
    button("plus", "Zoom in (+)", () => zoomMiddle(1.3)),
    button("minus", "Zoom out (−)", () => zoomMiddle(1 / 1.3)),
    button("fit", "Show all (F)", fit),
  );
  const root = options.bare ? make("div", { class: "player" }, make("div", { class: "frame" }, canvas)) : make(
    "div", { class: "player" },
    make("div", { class: "frame" }, canvas, zoomers),
    make(
      "div", { class: "transport" },
      button("back", "Step back (←)", () => step(-1, false)), playing,
      button("forward", "Step on (→)", () => step(1, false)),
      make("div", { class: "track" }, slider, marks), clock, speed, repeat,
    ),
    chips,
  );
  element.append(root);

  const stage = planarc.createStage(canvas);
  const inset = options.bare ? 0 : 30; // the zoom buttons lie there
  const listeners = new Set();
  const state = { time: 0, playing: false, repeat: true, fitted: true, asked: false, last: 0, natural: 1 };
  let reader = null;
  let items = [];
  let layers = [];
  let scales = []; // keys of arrows that components draw
  let box = null;
  let ghosts = []; // of other runs: {items, reader, box}
  let digits = 2;
  let lit = ""; // the component that is lit up
  let alive = true;

  function setScene(next, { keepTime = true, keepView = true } = {}) {
    const first = reader === null;
    const shown = new Map(layers.map((l) => [l.id, l]));
    reader = planarc.createReader(planarc.times(next.time));
    const tracks = next.tracks.map(planarc.column);
    items = readItems(next, tracks);
    box = next.box;
    layers = (next.layers || []).map((source) => planarc.createLayer(source, tracks, box, next.shapes));
    scales = (next.scales || []).map(planarc.createKey);
    if (!options.bare) layers.push(planarc.createNames(items, next.classes || {}));
    for (const layer of layers) {
      if (options.bare) layer.on = false; // a card is small
      const before = shown.get(layer.id);
      if (!before) continue;
      layer.on = before.on;
      const chosen = new Map(before.members.map((m) => [m.name, m.on]));
      for (const m of layer.members) m.on = chosen.get(m.name) ?? m.on;
    }
    const span = reader.stop - reader.start;
    digits = Math.max(0, Math.min(9, 3 - Math.floor(Math.log10(span || 1))));
    slider.min = reader.start;
    slider.max = reader.stop;
    slider.disabled = !(span > 0);
    if (first) listSpeeds(span);
    listMarks(next.events || [], span);
    listLayers();
    state.time = keepTime && !first ? Math.min(reader.stop, Math.max(reader.start, state.time)) : reader.start;
    if (first || !keepView) fit();
    ask();
  }

  function readItems(source, tracks) {
    const at = (quantity) => (Array.isArray(quantity) ? tracks[quantity[0]] : quantity);
    return source.items.map((item) => ({
      ...item, x: at(item.x), y: at(item.y), angle: at(item.angle), length: at(item.length),
      width: at(item.width), extra: at(item.extra), color: item.color.map(at),
      shape: source.shapes[item.shape],
    }));
  }

  function setGhosts(runs) {
    ghosts = runs.map(({ scene: source }) => ({
      items: readItems(source, source.tracks.map(planarc.column)),
      reader: planarc.createReader(planarc.times(source.time)), box: source.box,
    }));
    if (state.fitted) fit();
    ask();
  }

  function around() {
    // The box of all runs.
    const all = [box, ...ghosts.map((ghost) => ghost.box)].filter(Boolean);
    return all.length ? [0, 1, 2, 3].map((i) => Math[i < 2 ? "min" : "max"](...all.map((b) => b[i]))) : null;
  }

  function listSpeeds(span) {
    // Around one second a second; a run of milliseconds or hours gets its own.
    const long = options.bare ? 12 : 90;
    state.natural = span > long || (span > 0 && span < 1) ? span / (options.bare ? 6 : 10) : 1;
    speed.replaceChildren(...SPEEDS.map((factor) => {
      const value = Number((factor * state.natural).toPrecision(2));
      return new Option(`${value}×`, value, factor === 1, factor === 1);
    }));
  }

  function listMarks(events, span) {
    marks.replaceChildren(...events.slice(0, 400).map((t) => {
      const mark = make("i");
      mark.style.left = `${span > 0 ? (100 * (t - reader.start)) / span : 0}%`;
      return mark;
    }));
  }

  function listLayers() {
    chips.replaceChildren(...layers.map(chip), ...scales.map((key) => key.element));
    chips.hidden = layers.length === 0;
  }

  function dressLayers() {
    for (const layer of layers) layer.dress();
    for (const key of scales) key.dress(stage.view.scale);
  }

  function chip(layer) {
    const scale = make("span", { class: "key" });
    const toggle = make(
      "button",
      { type: "button", class: "chip", "aria-pressed": String(layer.on), onclick: () => setLayer(layer.id, !layer.on) },
      make("i", { class: "dot" }), layer.title, scale,
    );
    const dot = toggle.querySelector(".dot");
    layer.dress = () => {
      toggle.setAttribute("aria-pressed", String(layer.on));
      dot.style.background = planarc.layerColor(layer.id);
      const pixels = layer.key ? layer.key * layer.reach.scale * stage.view.scale : 0;
      scale.hidden = !layer.on || !(pixels > 2 && pixels < 200);
      if (scale.hidden || scale.dataset.pixels === String(Math.round(pixels))) return;
      scale.dataset.pixels = String(Math.round(pixels));
      const bar = make("b");
      bar.style.width = `${pixels}px`;
      bar.style.background = planarc.layerColor(layer.id);
      scale.replaceChildren(bar, `${Number(layer.key.toPrecision(1))} ${planarc.unit(layer.unit)}`);
    };
    layer.dress();
    if (layer.members.length < 2) return make("span", { class: "layer" }, toggle);
    const list = make("div", { class: "members" }, ...layer.members.map((member) => {
      const input = make("input", {
        type: "checkbox", checked: member.on,
        onchange: () => {
          member.on = input.checked;
          if (member.on && !layer.on) setLayer(layer.id, true);
          ask();
        },
      });
      return make("label", {}, input, member.name);
    }));
    const more = make(
      "details", { class: "choose" },
      make("summary", { title: `Choose: ${layer.title}`, "aria-label": `Choose: ${layer.title}` }), list,
    );
    more.addEventListener("keydown", (event) => {
      if (event.key !== "Escape") return;
      more.open = false;
      more.querySelector("summary").focus();
    });
    return make("span", { class: "layer" }, toggle, more);
  }

  function setLayer(id, on) {
    const layer = layers.find((l) => l.id === id);
    if (!layer) return;
    layer.on = on;
    layer.dress();
    ask();
  }

  function show() {
    state.asked = false;
    if (!alive) return;
    reader.seek(state.time);
    for (const ghost of ghosts) ghost.reader.seek(state.time);
    const dragged = items.some((item) => item.dragged); // then only what needs no run is laid over
    stage.draw(items, layers.filter((l) => l.on && (!dragged || !l.members.length)), reader, lit, ghosts);
    dressLayers();
    slider.value = state.time;
    slider.style.setProperty("--done", `${(100 * (state.time - reader.start)) / (reader.stop - reader.start || 1)}%`);
    clock.textContent = `${state.time.toFixed(digits)} s`;
    for (const listener of listeners) listener(state.time, reader);
  }

  function ask() {
    if (!state.asked) requestAnimationFrame(show);
    state.asked = true;
  }

  function setTime(t) {
    state.time = Math.min(reader.stop, Math.max(reader.start, t));
    ask();
  }

  function play(on = true) {
    const before = state.playing;
    state.playing = on && reader.stop > reader.start;
    playing.replaceChildren(planarc.icon(state.playing ? "pause" : "play"));
    const title = state.playing ? "Pause (Space)" : "Play (Space)";
    playing.title = title;
    playing.setAttribute("aria-label", title);
    if (!state.playing || before) return;
    if (state.time >= reader.stop) state.time = reader.start;
    state.last = performance.now();
    requestAnimationFrame(tick);
  }

  function tick(moment) {
    if (!state.playing || !alive) return;
    state.time += (Math.max(0, moment - state.last) / 1000) * Number(speed.value);
    state.last = moment;
    if (state.time > reader.stop) {
      if (state.repeat) state.time = reader.start;
      else {
        state.time = reader.stop;
        play(false);
      }
    }
    show();
    if (state.playing) requestAnimationFrame(tick);
  }

  function step(direction, far) {
    play(false);
    setTime(state.time + (direction * (reader.stop - reader.start)) / (far ? 20 : 200));
  }

  function setRepeat(on) {
    state.repeat = on;
    repeat.setAttribute("aria-pressed", String(on));
  }

  function zoomMiddle(factor, x = 0, y = 0) {
    state.fitted = false;
    stage.zoom(factor, x, y);
    ask();
  }

  function fit() {
    state.fitted = true;
    stage.fit(around(), inset);
    ask();
  }

  function touched(x, y) {
    reader.seek(state.time);
    const place = canvas.getBoundingClientRect();
    return stage.pick(items, reader, x - place.left, y - place.top);
  }

  function faster(direction) {
    speed.selectedIndex = Math.min(speed.length - 1, Math.max(0, speed.selectedIndex + direction));
  }

  const KEYS = {
    " ": () => play(!state.playing),
    ArrowLeft: (e) => step(-1, e.shiftKey),
    ArrowRight: (e) => step(1, e.shiftKey),
    Home: () => setTime(reader.start),
    End: () => setTime(reader.stop),
    f: fit,
    l: () => setRepeat(!state.repeat),
    "+": () => zoomMiddle(1.3),
    "=": () => zoomMiddle(1.3),
    "-": () => zoomMiddle(1 / 1.3),
    ",": () => faster(-1),
    ".": () => faster(1),
  };

  function onKey(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || event.defaultPrevented) return;
    const inside = event.target.closest ? event.target.closest("input, select, textarea, button, summary, a") : null;
    if (inside && inside !== slider) {
      if (inside.matches("select, textarea, input:not([type=checkbox])")) return;
      if (event.key === " ") return;
    }
    const action = KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!action) return;
    event.preventDefault();
    action(event);
  }

  const keys = options.keys || root;
  if (!options.bare) keys.addEventListener("keydown", onKey);
  slider.addEventListener("input", () => {
    play(false);
    setTime(Number(slider.value));
  });

  let held = null; // the pointer that drags a part
  function there(event) {
    const place = canvas.getBoundingClientRect();
    return stage.place(event.clientX - place.left, event.clientY - place.top);
  }

  const touches = new Map(); // pointers that hold the picture
  function spread() {
    const [a, b] = [...touches.values()];
    return b ? { x: (a[0] + b[0]) / 2, y: (a[1] + b[1]) / 2, size: Math.hypot(a[0] - b[0], a[1] - b[1]) }
      : { x: a[0], y: a[1], size: 0 };
  }
  canvas.addEventListener("pointerdown", (event) => {
    if (options.bare) return;
    canvas.setPointerCapture(event.pointerId);
    const part = options.drag && touches.size === 0 && touched(event.clientX, event.clientY);
    const order = part && {
      components: [part.component, ...(part.parts || [])], item: items.indexOf(part), time: state.time, shift: event.shiftKey, ...there(event),
    };
    if (order && options.drag.take(order) !== false) {
      held = { pointer: event.pointerId, x: event.clientX, y: event.clientY, moved: false };
      return;
    }
    touches.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (held?.pointer === event.pointerId) {
      held.moved = held.moved || Math.hypot(event.clientX - held.x, event.clientY - held.y) > 4;
      if (!held.moved) return;
      play(false);
      options.drag.move(there(event));
    }
    if (!touches.has(event.pointerId)) return;
    const before = spread();
    touches.set(event.pointerId, [event.clientX, event.clientY]);
    const after = spread();
    state.fitted = false;
    stage.move(after.x - before.x, after.y - before.y);
    if (before.size > 0 && after.size > 0) {
      const place = canvas.getBoundingClientRect();
      stage.zoom(after.size / before.size, after.x - place.left - place.width / 2, after.y - place.top - place.height / 2);
    }
    ask();
  });
  // A finger that holds a part does not scroll the page.
  canvas.addEventListener("touchstart", (event) => { if (held) event.preventDefault(); }, { passive: false });
  for (const end of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(end, (event) => {
      touches.delete(event.pointerId);
      if (held?.pointer !== event.pointerId) return;
      held = null;
      options.drag.leave();
    });
  }
  canvas.addEventListener("dblclick", fit);
  canvas.addEventListener("wheel", (event) => {
    if (options.bare) return;
    event.preventDefault();
    const place = canvas.getBoundingClientRect();
    zoomMiddle(
      Math.exp(-event.deltaY * 0.0015),
      event.clientX - place.left - place.width / 2, event.clientY - place.top - place.height / 2,
    );
  }, { passive: false });

  const watch = new ResizeObserver(() => {
    stage.measure();
    if (state.fitted) stage.fit(around(), inset);
    ask();
  });
  watch.observe(canvas);
  addEventListener("beforeprint", () => show());
  planarc.theme.onChange(() => {
    stage.dress();
    dressLayers();
    ask();
  });

  setScene(scene);
  setRepeat(options.loop !== false);
  if (options.playing) play(true);

  return {
    setScene, setGhosts, setTime, play, pause: () => play(false), fit, setLayer, redraw: ask,
    get time() { return state.time; },
    get playing() { return state.playing; },
    get reader() { return reader; },
    get view() { return stage.view; },
    get layers() { return layers; },
    pose(component) {
      // Where the first item of a component is now; for tests and for people at the console.
      const item = items.find((i) => i.component === component)
        || items.find((i) => (i.parts || []).some((part) => planarc.within(component, part)));
      const pose = {};
      reader.seek(state.time);
      return item && planarc.posed(item, reader, pose) ? { ...pose } : null;
    },
    light(component) {
      // Of a part that is not drawn, what it is in.
      lit = component;
      while (lit && !items.some((item) => planarc.shows(item, lit))) lit = lit.replace(/\.?[^.]*$/, "");
      ask();
    },
    drag(poses) {
      // Shows the items elsewhere than the run says, or, without poses, where it says.
      items.forEach((item, i) => { item.dragged = poses ? poses[i] : undefined; });
      ask();
    },
    pick(x, y) {
      // The component of the topmost item at a point of the window, or null.
      return touched(x, y)?.component ?? null;
    },
    part(x, y) {
      // The same with all components that the shape stands for.
      const item = touched(x, y);
      return item && { component: item.component, parts: item.parts || [] };
    },
    picture: () => canvas,
    onTime: (listener) => listeners.add(listener),
    destroy() {
      alive = false;
      watch.disconnect();
      keys.removeEventListener("keydown", onKey);
      root.remove();
    },
  };
};
