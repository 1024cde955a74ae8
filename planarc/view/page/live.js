// The live page: what is moved is run and drawn at once; the latest wish counts.
//
// What it asks for it has from `planarc.source`: a server (`served.js`), or the model in the page
// itself.
//
//   source.run(order, signal) => answer      `order` and `answer` as in `session.py`
//   source.file(name, order) => response     where the page offers files
//   source.drag(options) => drag; it may have `again`, for what a run has drawn over
//    source.show(player), source.follow({ edited, ended })
//   source.model                             what an answer's `model` is, where it is known at once

(() => {
  const get = (id) => document.getElementById(id);
  const { element: make } = planarc;
  const { source } = planarc;
  const PATIENCE = 200; // ms that a newer wish waits for an answer before it overtakes it
  const LONG = 0.2; // s of a run before which the start is shown

  let player = null;
  let plots = null;
  let tree = null;
  let known = ""; // key of the model whose fields are shown
  let moved = 0; // when the field was moved that the next picture answers
  let wish = null; // name of the field of the next order
  let flight = null; // the order under way: {since, abort}
  let ended = false;
  let seconds = 0; // of the last run
  let still = false; // whether the next order is for the start alone
  let resumed = null; // what was looked at before that start: {time, playing}
  let runs = null;
  let dragging = false; // whether start values follow the pointer now
  let pose = {}; // start values of the position to which the mechanism was dragged
  let latest = null; // the answer that is shown, and what was set for it
  let looked = ""; // the view that this page chose last
  let strange = []; // remarks about the address
  const delays = []; // ms from each moved field to its picture; for tests and measuring

  get("theme").append(planarc.icon("theme"));
  get("theme").addEventListener("click", () => planarc.theme.set(planarc.theme.isDark() ? "light" : "dark"));
  get("keep")?.querySelector("summary").append(planarc.icon("picture"));

  const fields = planarc.createFields(get("fields"), {
    refused: (label, message) => fail(`${label}: ${message}`),
    changed: (name) => {
      moved = performance.now();
      get("reset").hidden = fields.changes === 0 && Object.keys(pose).length === 0;
      ask(name);
    },
  });
  function stretch({ components, x, y }) {
    // The rod whose end is nearest gets longer or shorter by the way of the pointer along it.
    const value = (name) => plots.variables.get(name)?.value(player.reader);
    player.reader.seek(player.time);
    const rods = components
      .filter((name) => fields.has(`${name}.r[1]`) && fields.has(`${name}.r[2]`))
      .map((name) => ({
        name, a: [1, 2].map((i) => value(`${name}.frame_a.r[${i}]`)), b: [1, 2].map((i) => value(`${name}.frame_b.r[${i}]`)),
        r: [1, 2].map((i) => value(`${name}.r[${i}]`)),
      }))
      .filter(({ a, b, r }) => [...a, ...b, ...r].every(Number.isFinite) && Math.hypot(...r) > 0)
      .sort((p, q) => Math.hypot(p.b[0] - x, p.b[1] - y) - Math.hypot(q.b[0] - x, q.b[1] - y));
    if (!rods.length) return null;
    const [{ name, a, b, r }] = rods;
    const length = Math.hypot(...r);
    return (to) => {
      const along = ((to.x - x) * (b[0] - a[0]) + (to.y - y) * (b[1] - a[1])) / length;
      const factor = Math.max(0.02, 1 + along / length);
      r.forEach((part, i) => { if (part) fields.put(`${name}.r[${i + 1}]`, Number((part * factor).toPrecision(3))); });
    };
  }

  const drag = source.drag?.({
    stretch,
    fields,
    show: (poses) => player.drag(poses),
    value: (name) => {
      player.reader.seek(player.time);
      return plots.variables.get(name)?.value(player.reader) ?? NaN;
    },
    pixel: () => 1 / player.view.scale,
    grip: () => {
      // What follows the pointer is where the run begins.
      dragging = true;
      player.setTime(-Infinity);
    },
    dropped: () => {
      dragging = false;
      player.drag(null);
      look(latest.scene.box);
      if (!window.matchMedia("(prefers-reduced-motion: reduce)").matches) player.play();
    },
    release: (start) => {
      pose = { ...pose, ...start };
      resumed = { time: -Infinity, playing: !window.matchMedia("(prefers-reduced-motion: reduce)").matches };
      moved = performance.now();
      get("reset").hidden = false;
      ask("");
    },
  });
  get("reset").addEventListener("click", () => {
    const dragged = Object.keys(pose).length > 0;
    pose = {};
    fields.reset();
    if (dragged) ask("");
    get("reset").hidden = true;
  });
  get("hold").addEventListener("click", () => {
    if (latest) runs.add({ label: latest.label, scene: latest.scene, curves: latest.curves }, { removable: true });
  });
  get("search").addEventListener("input", () => fields.search(get("search").value));

  // Orders

  function ask(name) {
    wish = name;
    if (ended) return;
    if (!flight) send();
    else if (performance.now() - flight.since > PATIENCE) {
      flight.abort.abort();
      send();
    }
  }

  const order = (more = {}) => ({ ...fields.values(), pose, known, changed: wish ?? "", ...more });

  async function send() {
    const mine = { since: performance.now(), abort: new AbortController(), still };
    flight = mine;
    const asked = moved;
    const body = order({ still });
    wish = null;
    still = false;
    const slow = setTimeout(() => say("working …", true), 150);
    try {
      const answer = await source.run(body, mine.abort.signal);
      if (answer.overtaken && !player) wish ??= ""; // the text was edited meanwhile
      if (flight === mine && !answer.overtaken) take(answer, asked, mine.still);
      if (mine.still && answer.scene) wish ??= "";
    } catch (problem) {
      if (problem.name !== "AbortError") lose();
    } finally {
      clearTimeout(slow);
      if (flight === mine) {
        flight = null;
        if (wish !== null) send();
      }
    }
  }

  // Answers

  function take(answer, asked, isStart) {
    const notes = [...strange, ...answer.notes, ...(answer.warnings || [])];
    if (answer.model) {
      known = answer.key;
      notes.push(...introduce(answer.model));
    }
    const left = fields.blame(answer.problems);
    // The text repeats the message in its first line.
    const told = left.map((p) => ["error", p.hint && !p.text ? `${p.message}\n${p.hint}` : p.message, excerpt(p.text)]);
    tell([...told, ...notes]);
    stale(!answer.scene);
    if (answer.scene) show(answer, asked, isStart);
    if (isStart && answer.scene) return say("working …", true);
    seconds = answer.seconds;
    const [problem] = answer.problems;
    if (problem) return fail(problem.message);
    const time = answer.seconds < 10 ? `${Math.round(1000 * answer.seconds)} ms` : `${answer.seconds.toFixed(0)} s`;
    say(`simulated in ${time}`);
  }

  function introduce(model) {
    const whole = model.name.split(".");
    get("name").textContent = whole.pop();
    get("package").textContent = whole.join(".");
    get("description").textContent = model.description;
    document.title = model.name;
    const waiting = fields.show(model).filter((n) => !n.startsWith("="));
    fields.search(get("search").value);
    return [...(waiting.length ? [["remark", `not in this model: ${waiting.join(", ")}`]] : []), ...model.warnings];
  }

  const excerpt = (text) => text.split("\n").slice(1).join("\n");

  function fail(message) {
    // The header tells in a line what the field or the notes tell whole.
    const [line] = message.split("\n");
    say("");
    get("state").append(...planarc.spoken(line));
    get("state").title = line;
    get("state").classList.add("wrong");
  }

  function show(answer, asked, isStart) {
    if (!player) start(answer);
    else if (isStart) {
      resumed ??= { time: player.time, playing: player.playing };
      player.setScene(answer.scene);
    } else {
      player.setScene(answer.scene);
      if (dragging) drag.again();
      if (resumed) player.setTime(resumed.time);
      if (resumed?.playing) player.play();
      resumed = null;
      plots.setData(answer.curves);
      tree.setVariables(plots.variables);
      look(answer.scene.box);
    }
    if (get("events")) list(answer.events);
    if (get("peaks") && answer.peaks) planarc.listPeaks(get("peaks"), answer.peaks);
    if (!isStart) latest = { ...answer, label: fields.told().join(", ") || "as the file says" };
    if (latest) runs.name(latest.label);
    if (asked) requestAnimationFrame(() => setTimeout(() => delays.push(performance.now() - asked)));
  }

  function list(events = []) {
    get("events").closest("section").hidden = !events.length;
    planarc.listEvents(get("events"), events, (t) => player.setTime(t));
  }

  function start(answer) {
    const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    player = planarc.createPlayer(get("player"), answer.scene, { keys: document, playing: !still, drag });
    plots = planarc.createPlots(get("plots"), answer.curves, {
      seek: (t) => player.setTime(t),
      changed: (names) => tree && tree.check(names),
    });
    runs = planarc.createRuns(get("runs"), {
      changed: (shown, name) => {
        player.setGhosts(shown);
        plots.setRuns(shown, name);
      },
    });
    tree = planarc.createTree(get("tree"), plots.variables, { toggle: plots.toggle });
    player.onTime((t, reader) => {
      plots.mark(t, reader);
      if (get("variables").open) tree.mark(reader);
    });
    planarc.createCard(player, {
      variables: () => plots.variables,
      classes: () => latest?.scene.classes,
      picked: (component, curves) => {
        curves.forEach((name) => plots.toggle(name, true));
        get("search").value = component;
        fields.search(component);
      },
    });
    source.show?.(player);
    window.planarcPlayer = player;
    window.planarcDrag = drag;
    requestAnimationFrame(() => look(answer.scene.box));
  }

  function look(box) {
    // The mechanism stays in view, and of a good size, unless the user looks at a detail.
    const { view } = player;
    const key = () => [view.x, view.y, view.scale].join();
    if (!box || dragging || (looked !== "" && looked !== key())) return;
    const stage = get("player").querySelector("canvas").getBoundingClientRect();
    const [w, h] = [stage.width / 2 / view.scale, stage.height / 2 / view.scale];
    const inside = box[0] >= view.x - w && box[2] <= view.x + w && box[1] >= view.y - h && box[3] <= view.y + h;
    const small = Math.max((box[2] - box[0]) / w, (box[3] - box[1]) / h) < 0.9;
    if (!inside || small) player.fit();
    looked = key();
  }

  function stale(on) {
    get("player").classList.toggle("stale", on);
    get("plots").classList.toggle("stale", on);
  }

  function tell(notes) {
    get("notes").replaceChildren(...notes.map(([kind, text, source]) => make(
      "p", { class: kind }, ...planarc.spoken(text), ...(source ? [make("pre", {}, source)] : []),
    )));
  }

  function say(text, busy = false) {
    get("state").textContent = text;
    get("state").title = "";
    get("state").classList.remove("wrong");
    get("state").classList.toggle("busy", busy);
  }

  function lose() {
    ended = true;
    stale(true);
    say("ended");
    tell([["error", source.lost]]);
  }

  // Files

  for (const button of get("keep")?.querySelectorAll("button") ?? []) {
    button.addEventListener("click", async () => {
      get("keep").open = false;
      const more = { time: player ? player.time : 0, dark: planarc.theme.isDark() };
      const response = await source.file(button.dataset.file, order(more));
      if (!response.ok) {
        tell([["error", await response.text()]]);
        return;
      }
      planarc.download(`${get("name").textContent}.${button.dataset.ending}`, await response.blob());
    });
  }

  // Values in the address: #crank.r[1]=0.3&revA.w.start=2&$stop=5, in SI units

  function readAddress() {
    const given = [...new URLSearchParams(location.hash.slice(1))];
    for (const [name, value] of given) {
      const problem = fields.offer(name, Number(value));
      if (problem) strange.push(["remark", `the address gives \`${name}\` a value that is not taken: ${problem}`]);
    }
  }

  get("link")?.addEventListener("click", async () => {
    const { values, starts, stop } = fields.values();
    const told = new URLSearchParams(Object.entries(values));
    for (const [name, value] of Object.entries(starts)) told.set(`${name}.start`, value);
    if (stop !== null) told.set("$stop", stop);
    location.hash = String(told);
    try {
      await navigator.clipboard.writeText(location.href);
      say("link copied");
    } catch {
      say("the address holds the values now");
    }
  });

  // The file, and the end

  source.follow?.({
    edited: () => {
      known = "";
      still = player !== null && seconds > LONG;
      ask("");
    },
    ended: lose,
  });

  window.planarcLive = { delays, get busy() { return flight !== null || wish !== null; }, fields };
  if (source.model) {
    strange = introduce(source.model);
    readAddress();
  }
  ask("");
})();
