// What is told of a run made here: how it ended, what it warns of, its events. The words are
// planarc's (`told.py`), the numbers those of the run's rows.
//
//   const teller = planarc.createTeller(told);
//   teller.end(run, ends, now);  teller.warnings(time, warned);  teller.events(run, time, happens, column)
//
// A value is a number, or an array with one for each row.

const FELT = 1e-12; // of the largest impulse: less is rounding

const at = (value, row) => (typeof value === "number" || value === null ? value : value[row]);

function general(value, digits = 6) {
  // As C's %g: the exponent has two digits.
  if (!Number.isFinite(value)) return Number.isNaN(value) ? "nan" : value < 0 ? "-inf" : "inf";
  const [, power] = value.toExponential(digits - 1).split("e");
  if (Number(power) >= -4 && Number(power) < digits) return String(Number(value.toPrecision(digits)));
  const [short, , sign, size] = String(Number(value.toPrecision(digits)).toExponential()).split(/(e)([+-])/);
  return `${short}e${sign}${size.padStart(2, "0")}`;
}

planarc.general = general;

function formatted(value, form, texts) {
  // As `runtime/texts.py` has it.
  if (typeof value !== "number") return "...";
  if (form === '"') return texts[value] ?? "";
  const [, flags, width, places, kind] = /^%?([-+ 0]*)(\d*)(?:\.(\d+))?([dieEfFgG])$/.exec(form) ?? [];
  if (!kind || !Number.isFinite(value)) return general(value);
  const count = places === undefined ? 6 : Number(places);
  const low = kind.toLowerCase();
  let digits = general(Math.abs(value), Math.max(1, count));
  if (low === "d" || low === "i") digits = String(Math.trunc(Math.abs(value)));
  if (low === "f") digits = Math.abs(value).toFixed(count);
  if (low === "e") digits = Math.abs(value).toExponential(count).replace(/([+-])(\d)$/, "$10$2");
  if (kind !== low) digits = digits.toUpperCase();
  const sign = value < 0 ? "-" : flags.includes("+") ? "+" : flags.includes(" ") ? " " : "";
  if (flags.includes("-")) return (sign + digits).padEnd(Number(width));
  if (flags.includes("0")) return sign + digits.padStart(Number(width) - sign.length, "0");
  return (sign + digits).padStart(Number(width));
}

planarc.createTeller = function (told) {
  const owners = new Set(told.touches.map(([, owner]) => owner));

  function filled({ message, forms }, values, row, now) {
    // The instant, and a number for each mark.
    const texts = forms.map((form, i) => formatted(at(values[i], row), form, told.texts));
    return message.replace("@", general(now)).replace(/\x01/g, () => texts.shift());
  }

  function end(number, ends, row, now) {
    const { hint, text, severity } = told.ends[number];
    return { message: filled(told.ends[number], ends[number], row, now), hint, text, severity };
  }

  function warnings(time, warned) {
    // Each assertion that did not hold: since when, how often and how long in all.
    const found = [];
    warned.forEach(([holds, ...values], i) => {
      if (holds === null) return;
      const broken = Array.from(time, (_, row) => !at(holds, row));
      const first = broken.indexOf(true);
      if (first < 0) return;
      let stretches = 0;
      let seconds = 0;
      broken.forEach((bad, row) => {
        if (bad && broken[row - 1]) seconds += time[row] - time[row - 1];
        else if (bad) stretches += 1;
      });
      const times = stretches === 1 ? "once" : `${stretches} times`;
      const whole = filled(told.warnings[i], values, first, time[first]) + (seconds ? ` (${times}, ${general(seconds, 3)} s in all)` : "");
      const { hint } = told.warnings[i];
      found.push(hint ? `${whole}\n${hint}` : whole);
    });
    return found;
  }

  function touched(column, before, behind) {
    // What happened at touches, as `solve/contact/messages.py` tells it.
    const largest = Math.max(0, ...told.touches.map(([, , , , impulse]) => column(impulse)[behind]));
    return told.touches.flatMap(([name, , held, way, impulse]) => {
      const [was, closed] = [before, behind].map((row) => column(held)[row]);
      const [old, now] = [before, behind].map((row) => column(way)[row]);
      const size = column(impulse)[behind];
      const strikes = size > FELT * largest && size !== column(impulse)[before]; // else it is the last one
      const texts = strikes ? [`impact of ${planarc.typeset(general(size, 4))} N·s`] : [];
      if (closed && (!was || old !== now) && now !== 2) texts.push(now === 0 ? "sticks" : "slides");
      else if (closed && !was) texts.push("rests");
      if (was && !closed) texts.push("lets go");
      return texts.length ? [`${name}: ${texts.join(", ")}`] : [];
    });
  }

  function named(happens, before, behind) {
    // What components say that happened: component -> texts.
    const found = new Map();
    for (const [component, own] of Object.entries(happens)) {
      const begins = (name) => at(own[name], behind) && !at(own[name], before)
        && !name.endsWith(".from") && (!(`${name}.from` in own) || at(own[`${name}.from`], before));
      found.set(component, before < behind ? Object.keys(own).filter(begins) : []);
    }
    return found;
  }

  function events(run, happens, column) {
    // Pairs of a time and its text, as `insight/happenings.py` names them.
    const found = [];
    let row = 0;
    for (const { time, relations, samples } of run.events) {
      while (row < run.rows && run.time[row] < time) row += 1;
      let behind = row;
      while (behind + 1 < run.rows && run.time[behind + 1] === time) behind += 1;
      const known = row < run.rows && run.time[row] === time;
      const said = known ? named(happens, row, behind) : new Map();
      const switched = relations.map((i) => told.relations[i]).filter(([, owner]) => !owners.has(owner));
      const ticks = samples.map(([start, interval]) => `sample(${general(start)}, ${general(interval)})`);
      const meets = known && row < behind ? touched(column, row, behind) : [];
      if (!meets.length && !switched.length && !ticks.length) continue;
      const texts = [...said].flatMap(([owner, names]) => names.map((name) => `\`${owner}\` ${name}`));
      if (!said.get("")?.length) texts.push(...meets);
      for (const [text, owner] of switched) {
        if (!said.get(owner)?.length) texts.push(said.has(owner) ? `\`${owner}\`: ${text}` : text);
      }
      found.push([time, [...new Set([...texts, ...ticks])].join(", ")]);
    }
    return found;
  }

  return { end, warnings, events };
};
