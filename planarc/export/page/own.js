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
    return { ...drawing, engine: await planarc.createEngine(bytes.subarray(behind), drawing.slots) };
  }

  const unpacked = unpack();

  function drawn({ data: empty, steps, holes, slots }, run, times) {
    const order = new Map(slots.map((slot, k) => [slot, k]));
    const columns = new Map();
    function column(slot) {
      if (!columns.has(slot)) columns.set(slot, run.column(order.get(slot)));
      return columns.get(slot);
    }
    const time = times.slice(0, run.rows);
    const values = planarc.replay(steps, { time, column });
    const answer = structuredClone(empty);
    for (const [path, step] of holes) {
      const last = path.length - 1;
      let inside = answer;
      for (let i = 0; i < last; i++) inside = inside[path[i]];
      inside[path[last]] = values[step];
    }
    answer.scene.time = answer.curves.time = time;
    return answer;
  }

  function problem(message, order, more = {}) {
    return { severity: "error", code: "", message, hint: "", text: "", field: order.changed, ...more };
  }

  function last(value) {
    // A number of a message, as it was at the last row.
    const number = value?.length ? value[value.length - 1] : value;
    return typeof number === "number" ? String(Number(number.toPrecision(6))) : "...";
  }

  function wrong(run, order, times, numbers) {
    if (run.refused >= 0) return problem(told.refused, order);
    if (!run.begun && !run.failed) return problem(told.start, order);
    const now = Number(times[Math.max(0, run.rows - 1)].toPrecision(6));
    if (run.failed) {
      const { message, text, severity } = told.assertions[run.failed - 1];
      const values = (numbers[run.failed - 1] ?? []).map(last);
      const whole = message.replace("@", now).replace(/\x01/g, () => values.shift());
      return problem(whole, order, { text, severity, field: "" });
    }
    return run.rows < times.length ? problem(`the run ends at t = ${now} s: ${told.step}`, order, { field: "" }) : null;
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
    const found = await drawing.engine.run(values, times, { wanted: () => !signal.aborted });
    if (found === null) return { overtaken: true };
    const shown = found.rows > 0 ? drawn(drawing, found, times) : { told: [] };
    const why = wrong(found, order, times, shown.told);
    if (why) answer.problems.push(why);
    answer.seconds = (performance.now() - since) / 1000;
    return found.rows > 1 ? { ...answer, scene: shown.scene, curves: shown.curves } : answer;
  }

  return { run, model, lost: "" };
})();
