// The curves: one plot for each unit, with a line at the time that the mechanism shows.

const PALETTE = {
  light: ["#2563c9", "#c2410c", "#15803d", "#a21caf", "#0e7490", "#b91c1c", "#6d5a00", "#4d4d9b"],
  dark: ["#7fb0ff", "#ffa366", "#7ddc9a", "#e59af0", "#6fd3e6", "#ff9a94", "#e0cc6a", "#b7b6ff"],
};

function makePlots(place, data, isDark, seek) {
  let plots = [];
  let now = data.time[0];

  function build() {
    for (const plot of plots) plot.chart.destroy();
    place.replaceChildren();
    const groups = new Map();
    for (const curve of data.curves.filter((c) => c.shown)) {
      if (!groups.has(curve.unit)) groups.set(curve.unit, []);
      groups.get(curve.unit).push(curve);
    }
    plots = [...groups].map(([unit, curves]) => makePlot(unit, curves, groups.size));
    mark(now);
  }

  function makePlot(unit, curves, count) {
    const styles = getComputedStyle(document.documentElement);
    const colors = PALETTE[isDark() ? "dark" : "light"];
    const box = document.createElement("div");
    box.className = "plot";
    place.append(box);
    const axis = {
      stroke: styles.getPropertyValue("--faint").trim(),
      grid: { stroke: styles.getPropertyValue("--grid").trim(), width: 1 },
      ticks: { stroke: styles.getPropertyValue("--line").trim(), width: 1 },
      font: "12px system-ui, sans-serif",
    };
    const names = curves.length === 1 ? curves[0].name : "";
    const chart = new uPlot(
      {
        width: Math.max(200, box.clientWidth),
        height: Math.max(170, Math.min(360, Math.round(560 / count))),
        scales: { x: { time: false } },
        legend: { show: false },
        cursor: { sync: { key: "time" }, points: { size: 6 } },
        axes: [
          { ...axis, label: "time / s", labelSize: 20, labelFont: axis.font },
          {
            ...axis,
            label: [names, unit && unit !== "1" ? unit : ""].filter(Boolean).join(" / "),
            labelSize: 20,
            labelFont: axis.font,
            size: 62,
          },
        ],
        series: [
          {},
          ...curves.map((c, i) => ({
            label: c.name,
            stroke: colors[i % colors.length],
            width: 1.6,
            dash: i >= colors.length ? [6, 4] : undefined,
            points: { show: false },
          })),
        ],
      },
      [data.time, ...curves.map((c) => c.values)],
      box,
    );
    const line = document.createElement("div");
    line.className = "now";
    chart.over.append(line);
    chart.over.addEventListener("click", () => {
      if (chart.select.width < 3) seek(chart.posToVal(chart.cursor.left, "x"));
    });
    const legend = document.createElement("div");
    legend.className = "legend";
    const values = curves.map((curve, i) => {
      const entry = document.createElement("span");
      const swatch = document.createElement("i");
      swatch.style.background = colors[i % colors.length];
      const value = document.createElement("b");
      entry.title = curve.description;
      entry.append(swatch, `${curve.name} `, value);
      legend.append(entry);
      return value;
    });
    box.append(legend);
    return { chart, line, box, curves, values };
  }

  function mark(t, reader) {
    now = t;
    for (const { chart, line, curves, values } of plots) {
      const left = chart.valToPos(t, "x");
      line.style.left = `${left - 1}px`;
      line.hidden = !(left >= -1 && left <= chart.over.clientWidth + 1);
      if (!reader) continue;
      curves.forEach((curve, i) => {
        const value = reader.between(curve.values);
        values[i].textContent = Number.isFinite(value) ? value.toPrecision(4) : "";
      });
    }
  }

  function resize() {
    for (const { chart, box } of plots) {
      chart.setSize({ width: Math.max(200, box.clientWidth), height: chart.height });
    }
  }

  return { build, mark, resize };
}
