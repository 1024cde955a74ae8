// A model as WebAssembly: started with other values, and run.
//
//   const engine = await planarc.createEngine(bytes, slots);
//   const run = await engine.run(values, times, { wanted: () => true });
//
// `values` are pairs [slot, number] in SI units; of a run are kept the `slots` of its workspace.
//
//   run    { refused: slot that cannot be set, or -1;  begun: whether a start was found;
//            rows: count;  failed: number of the message that ended it, also its start, or 0;
//            column: (number of a slot) => Float64Array }
//
// It gives null where the run was no longer wanted: so often it lets go of the page.

const PATIENCE = 30; // ms of a run at one stretch
const STRETCH = 16; // rows

planarc.createEngine = async function (bytes, slots) {
  let heap = 0;
  let model = null;

  function room(count) {
    // That many words of 8 bytes, all zero; the whole heap is given back before each run.
    const at = heap;
    heap += 8 * count;
    const lacking = heap - model.memory.buffer.byteLength;
    if (lacking > 0) model.memory.grow(Math.ceil(lacking / 65536));
    new Float64Array(model.memory.buffer, at, count).fill(0);
    return at;
  }

  const bytesAt = (at, count) => new Uint8Array(model.memory.buffer, at, count);
  const others = {
    calloc: (count, size) => room(Math.ceil(Number(count * size) / 8)),
    free: () => {},
    fmod: (a, b) => a % b,
    fabs: Math.abs,
    memset: (to, byte, count) => { bytesAt(to, count).fill(byte); return to; },
    memcpy: (to, from, count) => { bytesAt(to, count).set(bytesAt(from, count)); return to; },
    memmove: (to, from, count) => { bytesAt(to, count).set(bytesAt(from, count).slice()); return to; },
  };
  const code = await WebAssembly.compile(bytes);
  const env = {};
  for (const { name } of WebAssembly.Module.imports(code)) env[name] = others[name] ?? Math[name];
  model = (await WebAssembly.instantiate(code, { env })).exports;

  const numbers = (at, count) => new Float64Array(model.memory.buffer, at, count);

  let last = Promise.resolve(); // the memory belongs to one run at a time

  function run(values, times, options = {}) {
    last = last.then(() => only(values, times, options));
    return last;
  }

  async function only(values, times, { wanted = () => true }) {
    if (!wanted()) return null;
    heap = model.heap.value;
    const block = model.page_new();
    const count = times.length;
    const width = slots.length;
    const found = { refused: -1, begun: false, rows: 0, failed: 0, column: () => new Float64Array(0) };
    for (const [slot, value] of values) {
      if (model.page_set(block, slot, value) !== 0) return { ...found, refused: slot };
    }
    const flag = model.page_begin(block);
    if (flag !== 0) return { ...found, failed: Math.max(0, -flag) };
    const at = room(count);
    const own = room(width);
    const out = room(count * width + 1);
    numbers(at, count).set(times);
    new BigInt64Array(model.memory.buffer, own, width).set(slots.map(BigInt));
    let rows = 0;
    let failed = 0;
    let since = performance.now();
    while (rows < count) {
      const end = Math.min(count, rows + STRETCH);
      rows = model.page_rows(block, at, rows, end, own, width, out);
      failed = Number(new BigInt64Array(model.memory.buffer, out + 8 * end * width, 1)[0]);
      if (rows < end || failed) break;
      if (performance.now() - since < PATIENCE) continue;
      await new Promise((done) => setTimeout(done));
      if (!wanted()) return null;
      since = performance.now();
    }
    const kept = numbers(out, rows * width).slice();
    function column(k) {
      const values = new Float64Array(rows);
      for (let i = 0; i < rows; i++) values[i] = kept[i * width + k];
      return values;
    }
    return { ...found, begun: true, rows, failed, column };
  }
  return { run };
};
