// A model as WebAssembly: started with other values, and run.
//
//   const engine = await planarc.createEngine(bytes, slots, { relations, samplers });
//   const run = await engine.run(values, times, { wanted: () => true });
//
// `values` are pairs [slot, number] in SI units; of a run are kept the `slots` of its workspace.
//
//   run    { refused: slot that cannot be set, or -1;  begun: whether a start was found;
//            rows: count;  failed: number of the message that ended it, also its start, or 0;
//            time, column: (number of a slot) => Float64Array, first: (the same) => its first value;
//            (of what has no start one row, where its parameters stand);
//            events: [{ time, relations: [numbers], samples: [[start, interval]] }] }
//
// With { events: true } there are rows before and behind each event, too.
//
// `engine.start(values, time)` gives the row of a start alone.
//
// It gives null where the run was no longer wanted: so often it lets go of the page.

const PATIENCE = 30; // ms of a run at one stretch
const STRETCH = 16; // rows, of models that are quick
const MOST = 2000; // events with rows of their own

planarc.createEngine = async function (bytes, slots, counts = {}) {
  let heap = 0;
  const taken = []; // where rooms begin
  let model = null;

  function room(count) {
    // That many words of 8 bytes, all zero; the whole heap is given back before each run, and what
    // was asked for last as soon as it is free.
    const at = heap;
    taken.push(at);
    heap += 8 * count;
    const lacking = heap - model.memory.buffer.byteLength;
    if (lacking > 0) model.memory.grow(Math.ceil(lacking / 65536));
    new Float64Array(model.memory.buffer, at, count).fill(0);
    return at;
  }

  let note = () => {}; // what is told of an event

  const bytesAt = (at, count) => new Uint8Array(model.memory.buffer, at, count);
  const others = {
    calloc: (count, size) => room(Math.ceil(Number(count * size) / 8)),
    free: (at) => { if (at && at === taken.at(-1)) heap = taken.pop(); },
    fmod: (a, b) => a % b,
    fabs: Math.abs,
    memset: (to, byte, count) => { bytesAt(to, count).fill(byte); return to; },
    memcpy: (to, from, count) => { bytesAt(to, count).set(bytesAt(from, count)); return to; },
    memmove: (to, from, count) => { bytesAt(to, count).set(bytesAt(from, count).slice()); return to; },
    page_event: (...told) => note(...told),
  };
  const code = await WebAssembly.compile(bytes);
  const env = {};
  const { relations = 0, samplers = 0 } = counts;
  for (const { name } of WebAssembly.Module.imports(code)) env[name] = others[name] ?? Math[name];
  model = (await WebAssembly.instantiate(code, { env })).exports;

  const numbers = (at, count) => new Float64Array(model.memory.buffer, at, count);

  let last = Promise.resolve(); // the memory belongs to one run at a time

  function run(values, times, options = {}) {
    last = last.then(() => only(values, times, options));
    return last;
  }

  function listener(events, own) {
    // Keeps what switches at events, and the rows before and behind them.
    return (time, behind, w, crossing, fired, samples) => {
      const inside = new Float64Array(model.memory.buffer);
      const flags = new Int32Array(model.memory.buffer); // the low halves of 64 bits
      const which = (at, count) => Array.from({ length: count }, (_, i) => i).filter((i) => flags[at / 4 + 2 * i]);
      if (!behind) {
        const ticks = which(fired, samplers).map((k) => [inside[samples / 8 + k], inside[samples / 8 + samplers + k]]);
        events.push({ time, relations: which(crossing, relations), samples: ticks });
      }
      if (events.length <= MOST) own.push([time, Float64Array.from(slots, (slot) => inside[w / 8 + slot])]);
    };
  }

  function merged(times, rows, kept, own) {
    // The rows in the order of their times; of an instant with an event its own ones alone.
    const width = slots.length;
    const found = { time: [], rows: [] };
    let next = 0;
    const put = (time, row) => { found.time.push(time); found.rows.push(row); };
    for (let i = 0; i <= rows; i++) {
      while (next < own.length && (i === rows || own[next][0] <= times[i])) put(...own[next++]);
      if (i < rows && !(next > 0 && own[next - 1][0] === times[i])) put(times[i], kept.subarray(i * width, (i + 1) * width));
    }
    return found;
  }

  async function only(values, times, { wanted = () => true, events: withEvents = false }) {
    if (!wanted()) return null;
    const events = [];
    const own = [];
    note = listener(events, own);
    heap = model.heap.value;
    taken.length = 0;
    const block = model.page_new();
    const count = times.length;
    const width = slots.length;
    const found = {
      refused: -1, begun: false, rows: 0, failed: 0, events, time: new Float64Array(0), column: () => new Float64Array(0),
    };
    for (const [slot, value] of values) {
      if (model.page_set(block, slot, value) !== 0) return { ...found, refused: slot };
    }
    const flag = model.page_begin(block);
    if (flag !== 0) {
      const w = numbers(model.page_place(block), 1 + Math.max(...slots)).slice();
      return { ...found, failed: Math.max(0, -flag), time: Float64Array.from(times.slice(0, 1)), first: (k) => w[slots[k]], column: (k) => w.subarray(slots[k], slots[k] + 1) };
    }
    own.length = 0; // the first row is that behind all events of the start
    const at = room(count);
    const places = room(width);
    const out = room(count * width + 1);
    numbers(at, count).set(times);
    new BigInt64Array(model.memory.buffer, places, width).set(slots.map(BigInt));
    let rows = 0;
    let failed = 0;
    let since = performance.now();
    let stretch = 1;
    while (rows < count) {
      const end = Math.min(count, rows + stretch);
      const begin = performance.now();
      rows = model.page_rows(block, at, rows, end, places, width, out);
      failed = Number(new BigInt64Array(model.memory.buffer, out + 8 * end * width, 1)[0]);
      if (rows < end || failed) break;
      stretch = performance.now() - begin < PATIENCE / 4 ? Math.min(STRETCH, 2 * stretch) : Math.ceil(stretch / 2);
      if (performance.now() - since < PATIENCE) continue;
      await new Promise((done) => setTimeout(done));
      if (!wanted()) return null;
      since = performance.now();
    }
    const all = merged(times, rows, numbers(out, rows * width).slice(), withEvents ? own : []);
    function column(k) {
      const values = new Float64Array(all.rows.length);
      for (let i = 0; i < values.length; i++) values[i] = all.rows[i][k];
      return values;
    }
    const first = (k) => all.rows[0][k];
    return { ...found, begun: true, rows: all.rows.length, failed, time: Float64Array.from(all.time), first, column };
  }
  function start(values, time) {
    // The row of a start, at once; null where there is none. Not while a run is under way.
    note = () => {};
    heap = model.heap.value;
    taken.length = 0;
    const block = model.page_new();
    if (values.some(([slot, value]) => model.page_set(block, slot, value) !== 0) || model.page_begin(block) !== 0) return null;
    const [at, places, out] = [1, slots.length, slots.length + 1].map(room);
    numbers(at, 1)[0] = time;
    new BigInt64Array(model.memory.buffer, places, slots.length).set(slots.map(BigInt));
    const rows = model.page_rows(block, at, 0, 1, places, slots.length, out);
    return rows === 1 ? numbers(out, slots.length).slice() : null;
  }

  return { run, start };
};
