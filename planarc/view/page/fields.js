// The controls: a slider with a number for what is real, menus for the rest, in groups.
//
//   const fields = planarc.createFields(element, { changed: (name) => ..., opened: 10 });
//   fields.show(model);  fields.values();  fields.blame(problems);  fields.reset();
//
// A model is {groups, choices, stop}; see `controls.py`. Values are kept by name while models
// come and go: what a model does not have waits until one has it again.

const LONGEST = 1000; // so many times as long as its experiment a run may be made: pages do not answer meanwhile

const key = (field) => (field.start ? `${field.name}.start` : field.name);

const text = (value) => String(Number(value.toPrecision(6)));

function nice(size) {
  // A step of 1, 2 or 5 times a power of ten.
  const power = 10 ** Math.floor(Math.log10(size));
  return [1, 2, 5, 10].map((f) => f * power).find((s) => s >= size * 0.999);
}

planarc.createFields = function (element, { changed, refused = () => {}, opened = 10 }) {
  const { element: make } = planarc;
  const set = new Map(); // what the user changed: key -> number in SI units, or class
  const rows = new Map(); // key -> {row, field, put, original}
  const folded = new Map(); // title -> whether the user left it open
  let model = null;

  function change(name, value) {
    const { original } = rows.get(name);
    if (value === original) set.delete(name);
    else set.set(name, value);
    dress(name);
    changed(name);
  }

  function dress(name) {
    const { row } = rows.get(name);
    row.classList.toggle("changed", set.has(name));
  }

  function frame(name, label, description, original, control, put, wide = false) {
    const back = () => {
      put(original);
      tell(name, "");
      set.delete(name);
      dress(name);
      changed(name);
    };
    const again = make("button", { type: "button", class: "again", title: "Reset", "aria-label": `Reset ${label}`, onclick: back }, "↺");
    const wrong = make("p", { class: "error", hidden: true, role: "alert" });
    const id = `field-${rows.size}`;
    const head = make("label", { for: id, title: description || label }, label);
    const line = wide ? make("div", { class: "line" }, head, again, control.main) : make("div", { class: "line" }, head, control.main, again);
    (control.input || control.main).id = id;
    const row = make("div", { class: wide ? "field wide" : "field" }, line, ...(control.slider ? [control.slider] : []), wrong);
    row.dataset.name = name;
    row.dataset.search = `${name} ${description}`.toLowerCase();
    rows.set(name, { row, wrong, put, original, check: control.check });
    if (set.has(name)) put(set.get(name));
    dress(name);
    return row;
  }

  function tell(name, message) {
    const { row, wrong } = rows.get(name);
    row.classList.toggle("wrong", Boolean(message));
    wrong.hidden = !message;
    wrong.replaceChildren(...planarc.spoken(message));
  }

  function outside(field, value) {
    // What the model's own bounds say against a value in SI units.
    const shown = (v) => `${text(v * field.factor)} ${planarc.unit(field.unit)}`.trim();
    if (!Number.isFinite(value)) return "not a number";
    if (field.minimum !== null && value < field.minimum) return `at least ${shown(field.minimum)}`;
    if (field.maximum !== null && value > field.maximum) return `at most ${shown(field.maximum)}`;
    if (field.kind === "Integer" && !Number.isInteger(value)) return "a whole number";
    return "";
  }

  function numberField(field, label) {
    const name = key(field);
    const shown = (value) => value * field.factor;
    const input = make("input", { type: "text", inputmode: "decimal", autocomplete: "off", spellcheck: "false", "aria-label": label });
    const slider = field.structural ? null : make("input", { type: "range", class: "slide", step: "any", tabindex: -1, "aria-hidden": "true" });
    const grain = nice((shown(field.high) - shown(field.low)) / 400);

    function place(value) {
      if (!slider) return;
      slider.min = Math.min(shown(field.low), shown(value));
      slider.max = Math.max(shown(field.high), shown(value));
      slider.value = shown(value);
      const part = (100 * (slider.value - slider.min)) / (slider.max - slider.min);
      slider.style.setProperty("--done", `${part}%`);
    }
    function put(value) {
      input.value = text(shown(value));
      place(value);
    }
    function take(value) {
      const problem = outside(field, value);
      tell(name, problem);
      if (problem) return refused(label, problem);
      place(value);
      change(name, value);
    }
    if (slider) {
      slider.addEventListener("input", () => {
        const value = field.kind === "Integer" ? Math.round(Number(slider.value))
          : Math.round(Number(slider.value) / grain) * grain;
        input.value = text(value);
        const part = (100 * (slider.value - slider.min)) / (slider.max - slider.min);
        slider.style.setProperty("--done", `${part}%`);
        const problem = outside(field, Number(text(value)) / field.factor);
        tell(name, problem);
        if (problem) refused(label, problem);
        else change(name, Number(text(value)) / field.factor);
      });
      slider.addEventListener("dblclick", () => { put(rows.get(name).original); take(rows.get(name).original); });
    }
    input.addEventListener("input", () => {
      // A comma is what many keyboards have for a point.
      const typed = input.value.trim().replace("−", "-").replace(",", ".");
      take(typed === "" ? NaN : Number(typed) / field.factor);
    });
    input.addEventListener("keydown", (event) => {
      const direction = { ArrowUp: 1, ArrowDown: -1 }[event.key];
      if (!direction) return;
      event.preventDefault();
      const step = (field.kind === "Integer" ? 1 : grain) * (event.shiftKey ? 10 : 1);
      const value = Number(text(Number(input.value) + direction * step)) / field.factor;
      put(value);
      take(value);
    });
    put(field.value);
    const main = make("span", { class: "number" }, input, make("span", {}, planarc.unit(field.unit)));
    return frame(name, label, field.description, field.value, { main, input, slider, check: (value) => outside(field, value) }, put);
  }

  function menu(name, label, description, original, options, wide) {
    const input = make("select", { "aria-label": label }, ...options.map(([value, shown, title]) => make("option", { value, title }, shown)));
    const put = (value) => { input.value = value; };
    const isText = typeof original === "string";
    input.addEventListener("change", () => {
      tell(name, "");
      change(name, isText ? input.value : Number(input.value));
    });
    put(original);
    const check = (value) => (options.some(([known]) => known === value) ? "" : "none of its values");
    return frame(name, label, description, original, { main: input, check }, put, wide);
  }

  function single(field) {
    if (field.kind === "Boolean") return menu(key(field), field.label, field.description, field.value, [[0, "false"], [1, "true"]]);
    if (field.literals.length) return menu(key(field), field.label, field.description, field.value, field.literals.map((l, i) => [i + 1, l]));
    return numberField(field, field.label + (field.start ? " at the start" : ""));
  }

  function fold(title, about, children, open) {
    const box = make(
      "details", { class: "group", open: folded.get(title) ?? open },
      make("summary", {}, make("b", {}, title), make("span", { class: "faint" }, about)),
      make("div", { class: "inside" }, ...children),
    );
    box.querySelector("summary").addEventListener("click", () => folded.set(title, !box.open));
    return box;
  }

  function group(source, count) {
    const free = source.fields.filter((f) => !f.structural);
    const structural = source.fields.filter((f) => f.structural);
    const children = free.map(single);
    if (structural.length) {
      const more = fold(`${source.title} structure`, "", structural.map(single), false);
      more.querySelector("b").textContent = "structure";
      more.querySelector(".faint").textContent = "compiles again";
      children.push(more);
    }
    const open = free.length > 0 && count < opened && source.last !== true;
    return [fold(source.title || model.name, source.description, children, open), open ? free.length : 0];
  }

  function show(next) {
    model = next;
    rows.clear();
    const boxes = [];
    if (model.choices.length) {
      boxes.push(fold("Parts", "replaceable", model.choices.map((c) => menu(
        `=${c.component}`, c.component, c.description, c.current,
        c.options.map((o) => [o.name, o.name.split(".").pop(), o.description]), true,
      )), true));
    }
    let count = 0;
    model.groups.forEach((source, i) => {
      const last = i === model.groups.length - 1 && source.title.includes(" ");
      const [box, more] = group({ ...source, last }, count);
      count += more;
      boxes.push(box);
    });
    const span = model.stop - model.start;
    const stop = {
      name: "$stop", label: "stop time", kind: "Real", value: model.stop, unit: "s", factor: 1, minimum: model.start,
      maximum: model.start + LONGEST * span, low: model.start + 0.1 * span, high: model.start + 3 * span, literals: [], structural: false,
      start: false, description: "Where the run ends",
    };
    boxes.push(fold("Run", "", [numberField(stop, "stop time")], false));
    element.replaceChildren(...boxes);
    return [...set.keys()].filter((name) => !rows.has(name));
  }

  function search(words) {
    const wanted = words.toLowerCase().split(/\s+/).filter(Boolean);
    for (const { row } of rows.values()) {
      row.hidden = !wanted.every((word) => row.dataset.search.includes(word));
    }
    for (const box of element.querySelectorAll("details.group")) {
      const any = [...box.querySelectorAll(".field")].some((row) => !row.hidden);
      box.hidden = !any;
      if (wanted.length && any) box.open = true;
    }
  }

  function values() {
    const found = { values: {}, starts: {}, choices: {}, stop: null };
    for (const [name, value] of set) {
      if (name === "$stop") found.stop = value;
      else if (name.startsWith("=")) found.choices[name.slice(1)] = value;
      else if (rows.has(name) && name.endsWith(".start")) found.starts[name.slice(0, -6)] = value;
      else if (rows.has(name)) found.values[name] = value;
    }
    return found;
  }

  function blame(problems) {
    // Beside its field where there is one; the others are given back.
    for (const name of rows.keys()) tell(name, "");
    const left = [];
    for (const problem of problems) {
      const name = rows.has(problem.field) ? problem.field : null;
      const message = problem.hint ? `${problem.message}\n${problem.hint}` : problem.message;
      if (name) tell(name, message);
      else left.push(problem);
      for (let box = name && rows.get(name).row.closest("details"); box; box = box.parentElement.closest("details")) box.open = true;
    }
    return left;
  }

  function reset() {
    for (const name of [...set.keys()]) {
      set.delete(name);
      if (!rows.has(name)) continue;
      rows.get(name).put(rows.get(name).original);
      tell(name, "");
      dress(name);
    }
    changed("");
  }

  function told() {
    // What the user changed, as the fields show it.
    return [...set.keys()].filter((name) => rows.has(name)).map((name) => {
      const { row } = rows.get(name);
      const input = row.querySelector("[id^=field-]");
      const unit = row.querySelector(".number span");
      const value = input.matches("select") ? input.selectedOptions[0].text : input.value;
      return `${name.replace(/^[=$]/, "")} = ${value} ${unit ? unit.textContent : ""}`.trim();
    });
  }

  function put(name, value) {
    // A value that was not typed here, such as of a length that is dragged; false without field.
    if (!rows.has(name)) return false;
    rows.get(name).put(value);
    tell(name, "");
    change(name, value);
    return true;
  }

  function give(values) {
    // Several at once, told as one change.
    for (const [name, value] of Object.entries(values)) {
      rows.get(name).put(value);
      set.set(name, value);
      dress(name);
    }
    changed(Object.keys(values).pop());
  }

  function offer(name, value) {
    // The same for a value that may be wrong; gives the reason why it is not taken, or "".
    const problem = rows.has(name) ? rows.get(name).check(value) : "not in this model";
    if (!problem) put(name, value);
    return problem;
  }

  return { show, search, values, blame, reset, told, put, give, offer, has: (name) => rows.has(name), get changes() { return set.size; } };
};
