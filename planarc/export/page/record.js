// Steps that lead from the columns of a run to what is drawn: see `evaluate/record.py`, which
// notes them down.
//
//   planarc.replay(steps, { time, column: (slot) => Float64Array }) => values of all steps
//
// A step is [name, ...arguments]: an argument is the number of an earlier step, or [constant]. A
// value is a number, or an array with one for each row.

const truth = (test) => (a, b) => (test(a, b) ? 1 : 0);

const ENTRIES = {
  add: (a, b) => a + b,
  subtract: (a, b) => a - b,
  multiply: (a, b) => a * b,
  divide: (a, b) => a / b,
  power: (a, b) => a ** b,
  negative: (a) => -a,
  absolute: Math.abs,
  sqrt: Math.sqrt,
  square: (a) => a * a,
  sign: Math.sign,
  sin: Math.sin,
  cos: Math.cos,
  tan: Math.tan,
  arcsin: Math.asin,
  arccos: Math.acos,
  arctan: Math.atan,
  arctan2: Math.atan2,
  hypot: (a, b) => Math.hypot(a, b),
  sinh: Math.sinh,
  cosh: Math.cosh,
  tanh: Math.tanh,
  exp: Math.exp,
  log: Math.log,
  log10: Math.log10,
  floor: Math.floor,
  ceil: Math.ceil,
  trunc: Math.trunc,
  remainder: (a, b) => {
    const rest = a % b;
    return rest !== 0 && rest < 0 !== b < 0 ? rest + b : rest;
  },
  fmod: (a, b) => a % b,
  minimum: (a, b) => Math.min(a, b),
  maximum: (a, b) => Math.max(a, b),
  less: truth((a, b) => a < b),
  less_equal: truth((a, b) => a <= b),
  greater: truth((a, b) => a > b),
  greater_equal: truth((a, b) => a >= b),
  equal: truth((a, b) => a === b),
  not_equal: truth((a, b) => a !== b),
  logical_and: truth((a, b) => a && b),
  logical_or: truth((a, b) => a || b),
  logical_not: truth((a) => !a),
  isfinite: truth(Number.isFinite),
  where: (c, a, b) => (c ? a : b),
  nan_to_num: (a) => (Number.isNaN(a) ? 0 : Math.max(-Number.MAX_VALUE, Math.min(Number.MAX_VALUE, a))),
};

// Most steps are these: a loop of its own is what an engine makes quick. Rows on both sides, at the
// left, at the right.
const QUICK = {
  add: [
    (to, a, b) => { for (let i = 0; i < to.length; i++) to[i] = a[i] + b[i]; },
    (to, a, b) => { for (let i = 0; i < to.length; i++) to[i] = a[i] + b; },
    (to, a, b) => { for (let i = 0; i < to.length; i++) to[i] = a + b[i]; },
  ],
  subtract: [
    (to, a, b) => { for (let i = 0; i < to.length; i++) to[i] = a[i] - b[i]; },
    (to, a, b) => { for (let i = 0; i < to.length; i++) to[i] = a[i] - b; },
    (to, a, b) => { for (let i = 0; i < to.length; i++) to[i] = a - b[i]; },
  ],
  multiply: [
    (to, a, b) => { for (let i = 0; i < to.length; i++) to[i] = a[i] * b[i]; },
    (to, a, b) => { for (let i = 0; i < to.length; i++) to[i] = a[i] * b; },
    (to, a, b) => { for (let i = 0; i < to.length; i++) to[i] = a * b[i]; },
  ],
  divide: [
    (to, a, b) => { for (let i = 0; i < to.length; i++) to[i] = a[i] / b[i]; },
    (to, a, b) => { for (let i = 0; i < to.length; i++) to[i] = a[i] / b; },
    (to, a, b) => { for (let i = 0; i < to.length; i++) to[i] = a / b[i]; },
  ],
};

const isRows = (value) => typeof value !== "number";

function entries(name, args) {
  // A function of the arguments, row by row where one of them has rows.
  const f = ENTRIES[name];
  const first = args.find(isRows);
  if (first === undefined) return f(...args);
  const count = first.length;
  const found = new Float64Array(count);
  const [a, b, c] = args;
  const [x, y, z] = args.map(isRows);
  if (QUICK[name]) QUICK[name][x && y ? 0 : x ? 1 : 2](found, a, b);
  else if (args.length === 1) for (let i = 0; i < count; i++) found[i] = f(a[i]);
  else if (args.length === 2 && x && y) for (let i = 0; i < count; i++) found[i] = f(a[i], b[i]);
  else if (args.length === 2 && x) for (let i = 0; i < count; i++) found[i] = f(a[i], b);
  else if (args.length === 2) for (let i = 0; i < count; i++) found[i] = f(a, b[i]);
  else for (let i = 0; i < count; i++) found[i] = f(x ? a[i] : a, y ? b[i] : b, z ? c[i] : c);
  return found;
}

function unwrap(angle) {
  // Without jumps of whole turns.
  const found = Float64Array.from(angle);
  let turns = 0;
  for (let i = 1; i < angle.length; i++) {
    const step = angle[i] - angle[i - 1];
    if (!(Math.abs(step) < Math.PI)) turns -= Math.round(step / (2 * Math.PI));
    found[i] = angle[i] + 2 * Math.PI * turns;
  }
  return found;
}

function slope(t, x, from, to, found) {
  // By differences of second order within rows that no event parts.
  const last = to - 1;
  if (to - from === 2) found[from] = found[last] = (x[last] - x[from]) / (t[last] - t[from]);
  if (to - from < 3) return;
  const three = (i, j, k, at) => {
    const [p, q, r] = [t[i], t[j], t[k]];
    return (x[i] * (2 * at - q - r)) / ((p - q) * (p - r)) + (x[j] * (2 * at - p - r)) / ((q - p) * (q - r))
      + (x[k] * (2 * at - p - q)) / ((r - p) * (r - q));
  };
  found[from] = three(from, from + 1, from + 2, t[from]);
  for (let i = from + 1; i < last; i++) found[i] = three(i - 1, i, i + 1, t[i]);
  found[last] = three(last - 2, last - 1, last, t[last]);
}

function rate(t, x) {
  const found = new Float64Array(t.length);
  let from = 0;
  for (let i = 1; i <= t.length; i++) {
    if (i < t.length && t[i] > t[i - 1]) continue;
    slope(t, x, from, i, found);
    from = i;
  }
  return found;
}

function integral(t, x) {
  // By cubics through values and slopes.
  const slopes = rate(t, x);
  const found = new Float64Array(t.length);
  for (let i = 1; i < t.length; i++) {
    const h = t[i] - t[i - 1];
    found[i] = found[i - 1] + (h / 2) * (x[i] + x[i - 1]) + ((h * h) / 12) * (slopes[i - 1] - slopes[i]);
  }
  return found;
}

function ends(args) {
  // The least and the largest of all finite numbers.
  let [low, high] = [Infinity, -Infinity];
  const take = (x) => {
    if (x - x !== 0) return;
    if (x < low) low = x;
    if (x > high) high = x;
  };
  for (const value of args) {
    if (isRows(value)) for (let i = 0; i < value.length; i++) take(value[i]);
    else take(value);
  }
  return low <= high ? [low, high] : [NaN, NaN];
}

const at = (x, row) => (isRows(x) ? x[row] : x);

function highest(x) {
  // The first row at which it is largest without its sign.
  let found = 0;
  let most = -1;
  for (let i = 0; i < (isRows(x) ? x.length : 0); i++) {
    if (Math.abs(x[i]) > most) [found, most] = [i, Math.abs(x[i])];
  }
  return found;
}

function rms(t, x) {
  const last = t.length - 1;
  const span = t[last] - t[0];
  const squares = x.map((v) => v * v);
  return Math.sqrt(Math.max(0, span > 0 ? integral(t, squares)[last] / span : squares[0]));
}

const spread = (x, time) => (isRows(x) ? x : new Float64Array(time.length).fill(x));

planarc.only = function (steps, wanted) {
  // The steps that lead to some of them, and where these stand.
  const needed = new Set();
  const waiting = [...wanted];
  while (waiting.length) {
    const number = waiting.pop();
    if (needed.has(number)) continue;
    needed.add(number);
    const [name, ...given] = steps[number];
    if (name !== "column" && name !== "fixed") waiting.push(...given.filter((a) => typeof a === "number"));
  }
  const place = new Map([...needed].sort((a, b) => a - b).map((number, i) => [number, i]));
  const few = [...place.keys()].map((number) => {
    const [name, ...given] = steps[number];
    return name === "column" || name === "fixed" ? steps[number] : [name, ...given.map((a) => (typeof a === "number" ? place.get(a) : a))];
  });
  return { steps: few, place };
};

planarc.replay = function (steps, { time, column, first = (slot) => column(slot)[0] }) {
  const wholes = {
    time: () => time,
    column: (slot) => column(slot),
    fixed: first,
    entry: (x, i) => x[i < 0 ? x.length + i : i],
    unwrap: (x) => (isRows(x) ? unwrap(x) : x),
    rate: (t, x) => rate(t, spread(x, time)),
    integral: (t, x) => integral(t, spread(x, time)),
    before: (x) => (isRows(x) ? x.map((_, i) => x[Math.max(0, i - 1)]) : x),
    finite: (x) => (isRows(x) ? x.map((v) => (Number.isFinite(v) ? v : 0)) : x),
    peak: (t, x) => at(x, highest(x)),
    instant: (t, x) => t[highest(x)],
    rms: (t, x) => rms(t, spread(x, time)),
    least: (...values) => ends(values)[0],
    largest: (...values) => ends(values)[1],
  };
  const values = [];
  for (const [name, ...given] of steps) {
    if (name === "column" || name === "fixed") values.push(wholes[name](given[0]));
    else {
      const args = given.map((a) => (typeof a === "number" ? values[a] : Number(a[0])));
      values.push(wholes[name] ? wholes[name](...args) : entries(name, args));
    }
  }
  return values;
};
