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

const isRows = (value) => typeof value !== "number";

function entries(f, args) {
  // f of the arguments, row by row where one of them has rows.
  const first = args.find(isRows);
  if (first === undefined) return f(...args);
  const count = first.length;
  const found = new Float64Array(count);
  const [a, b, c] = args;
  const [x, y, z] = args.map(isRows);
  if (args.length === 1) for (let i = 0; i < count; i++) found[i] = f(a[i]);
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
    turns -= Math.round((angle[i] - angle[i - 1]) / (2 * Math.PI));
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

function extreme(choose, args) {
  let found = NaN;
  for (const value of args) {
    for (const x of isRows(value) ? value : [value]) {
      if (Number.isFinite(x)) found = Number.isNaN(found) ? x : choose(found, x);
    }
  }
  return found;
}

const spread = (x, time) => (isRows(x) ? x : new Float64Array(time.length).fill(x));

planarc.replay = function (steps, { time, column }) {
  const wholes = {
    time: () => time,
    column: (slot) => column(slot),
    fixed: (slot) => column(slot)[0],
    entry: (x, i) => x[i < 0 ? x.length + i : i],
    unwrap: (x) => (isRows(x) ? unwrap(x) : x),
    rate: (t, x) => rate(t, spread(x, time)),
    integral: (t, x) => integral(t, spread(x, time)),
    least: (...values) => extreme(Math.min, values),
    largest: (...values) => extreme(Math.max, values),
  };
  const values = [];
  for (const [name, ...given] of steps) {
    if (name === "column" || name === "fixed") values.push(wholes[name](given[0]));
    else {
      const args = given.map((a) => (typeof a === "number" ? values[a] : Number(a[0])));
      values.push(wholes[name] ? wholes[name](...args) : entries(ENTRIES[name], args));
    }
  }
  return values;
};
