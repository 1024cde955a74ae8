// The curves: one plot for each unit of a figure, with a line at the time that is shown.
//
//   const plots = planarc.createPlots(element, curves, { seek: (t) => player.setTime(t) });
//   plots.mark(t, reader);  plots.toggle("crank.w", true);  plots.setData(other);

const PALETTE = {
  light: ["#1d63c4", "#c2410c", "#15803d", "#a21caf", "#0e7490", "#b91c1c", "#7a6200", "#4d4d9b"],
  dark: ["#7fb0ff", "#ffa366", "#7ddc9a", "#e59af0", "#6fd3e6", "#ff9a94", "#e0cc6a", "#b7b6ff"],
};
const CHOSEN = "Chosen";
const PAPER = 620; // pixels that a sheet of paper surely has for a plot
const DASHES = [[6, 4], [2, 3], [10, 4, 2, 4], [12, 6]]; // of runs that lie beside the first one

const colorsNow = () => PALETTE[planarc.theme.isDark() ? "dark" : "light"];
planarc.runColor = (number) => colorsNow()[number % colorsNow().length];

planarc.readCurves = function (source) {
  // Curves as the page carries them: columns are decoded when they are first looked at.
  const decoded = new Map();
  const column = (index) => {
    if (!decoded.has(index)) decoded.set(index, planarc.column(source.columns[index]));
    return decoded.get(index);
  };
  const variables = new Map(source.variables.map(([name, index, factor, unit, description]) => [
    name,
    {
      name, unit, description,
      constant: typeof source.columns[index] === "number" || source.columns[index] === null,
      value: (reader) => factor * reader.at(column(index)),
      values(count) {
        const own = column(index);
        if (own === null || typeof own === "number") return new Array(count).fill(own === null ? null : own * factor);
        return Array.from(own, (v) => (Number.isFinite(v) ? v * factor : null));
      },
    },
  ]));
  return { time: Array.from(planarc.times(source.time)), variables, figures: source.figures };
};

planarc.createPlots = function (element, source, { seek = () => {}, changed = () => {} } = {}) {
  const { element: make } = planarc;
  const chips = make("div", { class: "chips", role: "group", "aria-label": "Figures" });
  const place = make("div", { class: "figures" });
  const empty = make("p", { class: "faint" }, "No curve is shown: choose a figure above, or variables below.");
  element.append(chips, place, empty);
  let data = planarc.readCurves(source);
  let own = planarc.createReader(data.time); // where the pointer is
  let figures = open(data.figures);
  let panels = [];
  let phases = []; // curves over each other: {phase, curves}
  let runs = []; // beside the first one: {number, label, data, reader}
  let here = ""; // what the run that plays is called among several
  let woven = null; // the rows of all runs by time: [time, number of the run, row]
  let now = null; // time and reader of the last mark

  function open(list) {
    return list
      .map((f) => ({ title: f.title, on: Boolean(f.on), curves: f.curves.filter((n) => data.variables.has(n)) }))
      .concat({ title: CHOSEN, on: true, curves: [] });
  }

  const chosen = () => figures[figures.length - 1];

  function build() {
    for (const panel of panels) panel.chart.destroy();
    panels = [];
    phases = [];
    place.replaceChildren();
    for (const figure of figures) {
      if (figure.on && figure.curves.length) place.append(drawFigure(figure));
    }
    empty.hidden = panels.length > 0;
    chips.replaceChildren(...figures.filter((f) => f !== chosen() || f.curves.length).map((figure) => make(
      "button",
      {
        type: "button", class: "chip", "aria-pressed": String(figure.on),
        onclick: () => { figure.on = !figure.on; build(); },
      },
      figure.title,
    )));
    chips.hidden = chips.childElementCount < 2 && figures[0].on;
    if (now) mark(...now);
    changed(new Set(chosen().curves));
  }

  function drawFigure(figure) {
    const box = make("section", { class: "figure", "aria-label": figure.title });
    const saved = (ending, write) => make(
      "button",
      {
        type: "button", class: "link save", title: `Save what is shown as .${ending}`,
        "aria-label": `Save ${figure.title} as .${ending}`,
        onclick: () => planarc.download(`${figure.title}.${ending}`, write(), ending === "csv" ? "text/csv" : "image/svg+xml"),
      },
      ending.toUpperCase(),
    );
    const own = () => panels.filter((panel) => panel.figure === figure);
    const alike = new Set(figure.curves.map((n) => data.variables.get(n).unit)).size < figure.curves.length;
    const over = make(
      "button",
      {
        type: "button", class: "link save", title: "Curves of one unit over the first of them, too",
        "aria-label": `x–y: ${figure.title}, curves over each other`, "aria-pressed": String(Boolean(figure.over)),
        onclick: () => { figure.over = !figure.over; build(); },
      },
      "x–y",
    );
    box.append(make(
      "div", { class: "title" }, make("h3", {}, figure.title), ...(alike ? [over] : []),
      saved("csv", () => planarc.figureCsv(own())), saved("svg", () => planarc.figureSvg(figure.title, own())),
    ));
    place.append(box); // before the plots, which ask for their width
    const units = new Map();
    for (const name of figure.curves) {
      const variable = data.variables.get(name);
      if (!units.has(variable.unit)) units.set(variable.unit, []);
      units.get(variable.unit).push(variable);
    }
    for (const [unit, curves] of units) {
      const turning = unit === "deg" ? curves.filter(turns) : [];
      const others = curves.filter((curve) => !turning.includes(curve));
      for (const part of [turning, others]) {
        if (part.length) panels.push(drawPanel(box, figure, unit, part, units.size));
      }
      if (figure.over && curves.length > 1) phases.push(drawPhase(box, unit, curves));
    }
    return box;
  }

  function turns(curve) {
    // Beside an angle that goes round and round others would look still.
    const values = curve.values(data.time.length).filter((v) => v !== null);
    return values.reduce((high, v) => Math.max(high, v), -Infinity) - values.reduce((low, v) => Math.min(low, v), Infinity) > 360;
  }

  function drawPhase(box, unit, curves) {
    // The first curve lies along x; of each run beside this one, too, where it has them.
    const holder = make("div", { class: "plot" });
    box.append(holder);
    const [first, ...others] = curves;
    const colors = colorsNow();
    const lines = [{ data, dash: undefined }, ...runs.map((run) => ({ data: run.data, dash: DASHES[(run.number - 1) % DASHES.length] }))]
      .flatMap(({ data: source, dash }) => others.map((curve, i) => {
        const [x, y] = [first, curve].map((c) => source.variables.get(c.name)?.values(source.time.length));
        return x && y ? { x, y, dash, color: colors[(i + 1) % colors.length] } : null;
      })).filter(Boolean);
    return { phase: planarc.createPhase(holder, { lines, unit, across: first.name, plain }), first, others };
  }

  function drawPanel(box, figure, unit, curves, count) {
    const colors = colorsNow();
    const holder = make("div", { class: "plot" });
    const legend = make("div", { class: "legend" });
    box.append(holder, legend);
    const axis = {
      stroke: planarc.theme.color("faint"), font: "12px system-ui, sans-serif", gap: 4,
      grid: { stroke: planarc.theme.color("grid"), width: 1 },
      ticks: { stroke: planarc.theme.color("line"), width: 1, size: 4 },
    };
    const values = curves.map((curve, i) => entry(legend, figure, curve, colors[i % colors.length], i >= colors.length));
    const looks = curves.map((c, i) => ({
      name: c.name, label: runs.length ? here : "", color: colors[i % colors.length], width: 1.6,
      dash: i >= colors.length ? [6, 4] : undefined,
    }));
    for (const run of runs) {
      looks.push(...curves.map((c, i) => ({
        name: c.name, label: run.label, color: colors[(curves.length > 1 ? i : run.number) % colors.length],
        width: 1.4, dash: DASHES[(run.number - 1) % DASHES.length],
      })));
    }
    const chart = new uPlot(
      {
        width: Math.max(200, holder.clientWidth),
        height: count > 1 || figures.filter((f) => f.on && f.curves.length).length > 1 ? 178 : 236,
        padding: [20, 24, 0, 0],
        scales: { x: { time: false }, y: { range: span } },
        legend: { show: false },
        cursor: { sync: { key: "planarc" }, points: { size: 6 } },
        axes: [
          { ...axis, size: 28, values: (u, ticks) => ticks.map((v, i) => (i === ticks.length - 1 ? `${plain(v)} s` : plain(v))) },
          { ...axis, size: room, values: (u, ticks) => ticks.map(plain) },
        ],
        series: [{}, ...looks.map(({ color, width, dash }) => ({
          stroke: color, width, dash, points: { show: false }, pxAlign: 0,
        }))],
        hooks: { setCursor: [(u) => tell(u.cursor.idx)] },
      },
      numbers(curves),
      holder,
    );
    holder.append(make("span", { class: "axis-unit" }, planarc.unit(unit)));
    const line = make("div", { class: "now" });
    chart.over.append(line);
    grabbable(line, chart);
    holder.addEventListener("dblclick", showAll);
    chart.over.addEventListener("click", () => {
      if (chart.select.width < 3 && chart.cursor.left >= 0) seek(chart.posToVal(chart.cursor.left, "x"));
    });

    function tell(row) {
      // While the pointer is in the plot the legend tells the values there.
      panel.hovered = row !== null && row !== undefined;
      if (panel.hovered) tellValues(panel, chart.data[0][row]);
      else if (now) markPanel(panel, ...now);
    }
    const panel = { chart, line, holder, curves, values, unit, figure, looks, plain, hovered: false };
    return panel;
  }

  function tellValues({ curves, values, unit }, time, reader = own) {
    // Of the run that plays, and of those beside it at that time.
    if (reader === own) own.seek(time);
    for (const run of runs) run.reader.seek(time);
    curves.forEach((curve, i) => {
      const all = [planarc.digits(curve.value(reader))];
      for (const run of runs.slice(0, 3)) {
        const same = run.data.variables.get(curve.name);
        all.push(same ? planarc.digits(same.value(run.reader)) : "–");
      }
      values[i].textContent = `${all.join(" | ")} ${planarc.unit(unit)}`.trim();
    });
  }

  function numbers(curves) {
    // The columns of a plot: each run has rows of its own, between which the others are joined.
    const columns = [data, ...runs.map((run) => run.data)].map((source) => curves.map((c) => {
      const found = source.variables.get(c.name);
      return found ? found.values(source.time.length) : null;
    }));
    if (!runs.length) return [data.time, ...columns[0]];
    woven = woven || weave([data.time, ...runs.map((run) => run.data.time)]);
    const spread = (values, set) => {
      const line = new Array(woven.length).fill(undefined);
      if (values) woven.forEach(([, which, row], i) => { if (which === set) line[i] = values[row]; });
      return line;
    };
    return [woven.map(([time]) => time), ...columns.flatMap((own, set) => own.map((values) => spread(values, set)))];
  }

  function weave(times) {
    const rows = times.flatMap((time, set) => time.map((t, row) => [t, set, row]));
    return rows.sort((a, b) => a[0] - b[0] || a[1] - b[1] || a[2] - b[2]);
  }

  function setRuns(list, name = "") {
    here = name;
    runs = list.map((run) => {
      const read = planarc.readCurves(run.curves);
      return { number: run.number, label: run.label, data: read, reader: planarc.createReader(read.time) };
    });
    woven = null;
    build();
  }

  const plain = (value) => {
    const short = Number(value.toPrecision(6));
    const size = Math.abs(short);
    return planarc.typeset(size >= 1e6 || (size > 0 && size < 1e-4) ? short.toExponential() : String(short));
  };

  function room(u, texts) {
    // As wide as the longest number needs, alike for most, so that plots stand in line.
    const longest = Math.max(0, ...(texts || []).map((t) => t.length));
    return Math.max(56, 16 + 7 * longest);
  }

  function span(u, low, high) {
    // A constant gets room above and below; noise around it is not blown up to a curve.
    if (low === null || high === null) return [0, 1];
    const size = Math.max(Math.abs(low), Math.abs(high));
    if (high - low <= 1e-9 * size) {
      const room = size > 0 ? 0.1 * size : 1;
      return [low - room, high + room];
    }
    return uPlot.rangeNum(low, high, 0.08, true);
  }

  function showAll() {
    // All of the time, in every plot: they are zoomed together.
    const times = [data, ...runs.map((run) => run.data)].map((source) => source.time);
    const ends = { min: Math.min(...times.map((t) => t[0])), max: Math.max(...times.map((t) => t[t.length - 1])) };
    for (const { chart } of panels) chart.setScale("x", ends);
  }

  function entry(legend, figure, curve, color, dashed) {
    const value = make("b");
    const swatch = make("i", { class: dashed ? "dashed" : "" });
    swatch.style.color = color;
    const remove = planarc.button("close", `Take ${curve.name} away`, () => {
      figure.curves = figure.curves.filter((n) => n !== curve.name);
      build();
    }, { class: "remove" });
    legend.append(make("span", { title: curve.description }, swatch, make("span", { class: "name" }, curve.name), value, remove));
    return value;
  }

  function grabbable(line, chart) {
    const go = (event) => {
      const place = chart.over.getBoundingClientRect();
      seek(chart.posToVal(event.clientX - place.left, "x"));
    };
    for (const name of ["mousedown", "click"]) line.addEventListener(name, (event) => event.stopPropagation());
    line.addEventListener("pointerdown", (event) => {
      event.stopPropagation();
      line.setPointerCapture(event.pointerId);
    });
    line.addEventListener("pointermove", (event) => {
      if (line.hasPointerCapture(event.pointerId)) go(event);
    });
  }

  function markPanel({ chart, line, curves, values, unit, hovered }, t, reader) {
    const left = chart.valToPos(t, "x");
    line.style.transform = `translateX(${left}px)`;
    line.hidden = !(left >= -1 && left <= chart.over.clientWidth + 1);
    if (!hovered && reader) tellValues({ curves, values, unit }, t, reader);
  }

  function mark(t, reader) {
    now = [t, reader];
    for (const panel of panels) markPanel(panel, t, reader);
    for (const { phase, first, others } of reader ? phases : []) {
      phase.mark(others.map((curve) => [first.value(reader), curve.value(reader)]));
    }
  }

  function toggle(name, on) {
    const figure = chosen();
    figure.curves = figure.curves.filter((n) => n !== name);
    if (on) {
      figure.curves.push(name);
      figure.on = true;
    }
    build();
  }

  function setData(next) {
    // Other numbers of the same model: what is shown stays, where it still exists.
    const before = figures;
    data = planarc.readCurves(next);
    own = planarc.createReader(data.time);
    woven = null;
    figures = open(data.figures);
    for (const figure of figures) {
      const old = before.find((f) => f.title === figure.title);
      if (!old) continue;
      figure.on = old.on;
      figure.over = old.over;
      figure.curves = old.curves.filter((n) => data.variables.has(n));
    }
    if (!refill(before)) build();
  }

  function refill(before) {
    // The quick way: equal figures keep their plots and only get new numbers.
    const same = before.length === figures.length
      && !phases.length && figures.every((f, i) => f.curves.join() === before[i].curves.join() && f.on === before[i].on);
    if (!same) return false;
    for (const panel of panels) {
      panel.curves = panel.curves.map((c) => data.variables.get(c.name));
      panel.chart.setData(numbers(panel.curves));
    }
    if (now) mark(...now);
    return true;
  }

  function resize(most = Infinity) {
    for (const { chart, holder } of panels) {
      const width = Math.min(most, Math.max(200, holder.clientWidth));
      if (Math.abs(width - chart.width) > 1) chart.setSize({ width, height: chart.height });
    }
    for (const { phase } of phases) phase.draw();
    if (now) mark(...now);
  }

  new ResizeObserver(() => resize()).observe(place);
  addEventListener("beforeprint", () => resize(PAPER));
  addEventListener("afterprint", () => resize());
  planarc.theme.onChange(build);
  build();

  return {
    mark, toggle, setData, setRuns,
    get variables() { return data.variables; },
    get chosen() { return new Set(chosen().curves); },
    get panels() { return panels; },
  };
};
