// Where the page has its answers from: the model in it, run here. `live.js` knows it as
// `planarc.source`; an answer is as `session.py` gives it.

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
    return { ...drawing, engine: await planarc.createEngine(bytes.subarray(behind), drawing.slots, counts) };
  }

  const unpacked = unpack();
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
    if (failed) return problem("", order, { ...teller.end(failed - 1, shown.ends, row, now), field: "" });
    if (!run.begun) return problem(told.start, order);
    return now < end ? problem(`the run ends at t = ${planarc.general(now)} s: ${told.step}`, order, { field: "" }) : null;
  }

  async function run(order, signal) {
    const drawing = await unpacked;
    const since = performance.now();
    const answer = { problems: [], notes: told.notes, key: "" };
    const begin = model.start;
    const end = order.stop ?? model.stop;
    const times = Float64Array.from({ length: rows }, (_, i) => begin + ((end - begin) * i) / (rows - 1));
    const given = { ...order.values };
    for (const [name, value] of Object.entries(order.starts)) given[`${name}.start`] = value;
    const values = Object.entries(given).map(([name, value]) => [places[name][0], places[name][1] * value]);
    const found = await drawing.engine.run(values, times, { wanted: () => !signal.aborted, events: true });
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

  return { run, model, lost: "" };
})();
