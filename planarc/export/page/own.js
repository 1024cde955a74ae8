// Where the page has its answers from: the model in it, run here. `live.js` knows it as
// `planarc.source`; an answer is as `session.py` gives it.

const AXLE = 8; // pixels

planarc.source = (() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const { places, model, told, rows } = data;

  async function unpack() {
    // The length of the drawing, the drawing as JSON, the module.
    const packed = Uint8Array.from(atob(document.getElementById("model").textContent), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
    const behind = 4 + new DataView(bytes.buffer).getUint32(0, true);
    const drawing = JSON.parse(new TextDecoder().decode(bytes.subarray(4, behind)));
    const counts = { relations: told.relations.length, samplers: told.samplers };
    const create = () => planarc.createEngine(bytes.subarray(behind), drawing.slots, counts);
    return { ...drawing, engine: await create(), beside: await create() };
  }

  const unpacked = unpack();
  let starter = null; // what a drag needs
  unpacked.then((drawing) => { starter = posesOf(drawing); });
  const teller = planarc.createTeller(told);

  function drawn({ data: empty, steps, holes, slots }, run) {
    const { time } = run;
    const order = new Map(slots.map((slot, k) => [slot, k]));
    const columns = new Map();
    function column(slot) {
      if (!columns.has(slot)) columns.set(slot, run.column(order.get(slot)));
      return columns.get(slot);
    }
    const values = planarc.replay(steps, { time, column, first: (slot) => run.first(order.get(slot)) });
    const answer = structuredClone(empty);
    for (const [path, step] of holes) {
      const last = path.length - 1;
      let inside = answer;
      for (let i = 0; i < last; i++) inside = inside[path[i]];
      inside[path[last]] = values[step];
    }
    answer.scene.time = answer.curves.time = time;
    answer.events = teller.events(run, answer.happens, column);
    answer.scene.events = [...new Set(answer.events.map(([t]) => t))];
    answer.warnings = teller.warnings(time, answer.warned).map((text) => ["warning", text]);
    return answer;
  }

  function problem(message, order, more = {}) {
    return { severity: "error", code: "", message, hint: "", text: "", field: order.changed, ...more };
  }

  function wrong(run, order, end, shown) {
    if (run.refused >= 0) return problem(told.refused, order);
    const row = run.time.length - 1;
    const now = run.time[row];
    const broken = run.begun ? null : shown.impossible.find(([, holds]) => !(holds?.[0] ?? holds));
    const failed = run.failed || (broken ? broken[0] + 1 : 0);
    if (failed > 0) return problem("", order, { ...teller.end(failed - 1, shown.ends, row, now), field: "" });
    if (!run.begun) return problem(told.start, order);
    return now < end ? problem(`the run ends at t = ${planarc.general(now)} s: ${told[failed] ?? told.step}`, order, { field: "" }) : null;
  }

  function valuesOf({ values, starts }, more = {}) {
    // Pairs of a slot and what stands there.
    const given = { ...values };
    for (const [name, value] of Object.entries(starts)) given[`${name}.start`] = value;
    return Object.entries({ ...given, ...more }).map(([name, value]) => [places[name][0], places[name][1] * value]);
  }

  function posesOf({ data: empty, steps, holes, slots, beside }) {
    // What gives the place, angle, length and width of each item at a start.
    const step = new Map(holes.map(([path, number]) => [path.join(), number]));
    const wanted = empty.scene.items.map((item, i) => ["x", "y", "angle", "length", "width"].map((key) => {
      const [value, path] = Array.isArray(item[key])
        ? [empty.scene.tracks[item[key][0]], ["scene", "tracks", item[key][0]]] : [item[key], ["scene", "items", i, key]];
      return [step.get(path.join()), value];
    }));
    const { steps: few, place } = planarc.only(steps, wanted.flat().flatMap(([number]) => number ?? []));
    const order = new Map(slots.map((slot, k) => [slot, k]));
    return (values) => {
      const row = beside.start(values, model.start);
      if (!row) return null;
      const first = (slot) => row[order.get(slot)];
      const found = planarc.replay(few, { time: Float64Array.of(model.start), first, column: (slot) => Float64Array.of(first(slot)) });
      const number = (v) => (typeof v === "object" && v ? v[0] : v);
      return wanted.map((item) => item.map(([at, value]) => number(at === undefined ? value : found[place.get(at)])));
    };
  }

  function drag({ value, fields, pixel, ...options }) {
    const known = new Map(model.groups.flatMap((g) => g.fields).map((f) => [f.start ? `${f.name}.start` : f.name, f]));
    const start = (more) => (starter ? starter(valuesOf(fields.values(), more)) : null);
    const given = (name) => {
      const { name: own, start: isStart, value: original } = known.get(name);
      const { starts, values } = fields.values();
      return (isStart ? starts[own] : values[own]) ?? original;
    };
    // What is taken begins where it is shown.
    const shown = (name) => (known.get(name).start ? value(known.get(name).name) / known.get(name).factor : given(name));
    const give = (values) => { if (Object.keys(values).length) fields.give(values); };
    // A wheel is not turned by its axle.
    const least = (name) => (["deg", "rad"].includes(known.get(name).unit) ? AXLE * pixel() : 0.01);
    return planarc.createPull({ names: data.pulled, start }, { ...options, value: shown, given, give, least });
  }

  async function run(order, signal) {
    const drawing = await unpacked;
    const since = performance.now();
    const answer = { problems: [], notes: told.notes, key: "" };
    const begin = model.start;
    const end = order.stop ?? model.stop;
    const times = Float64Array.from({ length: rows }, (_, i) => begin + ((end - begin) * i) / (rows - 1));
    const found = await drawing.engine.run(valuesOf(order), times, { wanted: () => !signal.aborted, events: true });
    if (found === null) return { overtaken: true };
    const shown = found.time.length ? drawn(drawing, found) : null;
    const why = wrong(found, order, end, shown);
    if (why?.severity === "note") answer.notes = [...answer.notes, ["remark", why.message]];
    else if (why) answer.problems.push(why);
    answer.seconds = (performance.now() - since) / 1000;
    if (!(found.rows > 1)) return answer;
    const { scene, curves, events, peaks, warnings } = shown;
    return { ...answer, scene, curves, events, peaks, warnings };
  }

  return { run, model, drag: data.pulled.length ? drag : undefined, lost: "" };
})();
