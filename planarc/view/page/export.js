// A figure as a file: the numbers that are shown (.csv), or the curves (.svg).
//
//   planarc.figureCsv(panels);  planarc.figureSvg(title, panels);
//
// Both hold what is on the screen: the chosen curves, the zoomed stretch of time, all runs. A
// panel is {chart, unit, looks}, where `looks` are {name, label, color, dash} of its columns.

planarc.download = function (name, content, type) {
  const blob = content instanceof Blob ? content : new Blob([content], { type });
  const link = planarc.element("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
};

const field = (text) => `"${text.replace(/"/g, '""')}"`;
const cell = (value) => (value === null || value === undefined ? "" : String(Number(value.toPrecision(7))));

function within({ chart }) {
  // The rows between the ends of the time that is shown.
  const { min, max } = chart.scales.x;
  return chart.data[0].map((_, row) => row).filter((row) => chart.data[0][row] >= min && chart.data[0][row] <= max);
}

planarc.figureCsv = function (panels) {
  const heads = panels.flatMap(({ looks, unit }) => looks.map(({ name, label }) => (
    `${name}${unit && unit !== "1" ? ` [${unit}]` : ""}${label ? ` (${label})` : ""}`)));
  const columns = panels.flatMap(({ chart }) => chart.data.slice(1));
  const [time] = panels[0].chart.data;
  const lines = within(panels[0]).map((row) => [cell(time[row]), ...columns.map((c) => cell(c[row]))].join(","));
  return `${[["time [s]", ...heads].map(field).join(","), ...lines].join("\r\n")}\r\n`;
};

const WIDTH = 720;
const HEIGHT = 230;
const SIDES = { left: 72, right: 24, top: 26, bottom: 30 };

const escaped = (text) => text.replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);
const label = (x, y, text, more = "") => `<text x="${x}" y="${y}" ${more}>${escaped(text)}</text>`;

planarc.figureSvg = function (title, panels) {
  const color = planarc.theme.color;
  let top = 28;
  const parts = [label(SIDES.left, 20, title, `font-weight="600" font-size="14" fill="${color("ink")}"`)];
  for (const panel of panels) {
    const [drawn, height] = drawPanel(panel, top);
    parts.push(drawn);
    top += height;
  }
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${WIDTH} ${top}" width="${WIDTH}" height="${top}" `
    + `font-family="system-ui, sans-serif" font-size="12" fill="${color("faint")}">`
    + `<rect width="100%" height="100%" fill="${color("panel")}"/>${parts.join("")}</svg>\n`;
};

function drawPanel(panel, above) {
  const { chart, unit, looks, plain } = panel;
  const { x, y } = chart.scales;
  const [left, right] = [SIDES.left, WIDTH - SIDES.right];
  const [top, bottom] = [above + SIDES.top, above + HEIGHT - SIDES.bottom];
  const across = (value) => left + ((value - x.min) / (x.max - x.min)) * (right - left);
  const up = (value) => bottom - ((value - y.min) / (y.max - y.min)) * (bottom - top);
  const short = (value) => value.toFixed(2).replace(/\.?0+$/, "");
  const grid = planarc.theme.color("grid-strong");
  const inside = (value, { min, max }) => value >= min && value <= max;
  const parts = [label(left, top - 8, planarc.unit(unit), 'text-anchor="end" dx="-8"')];
  for (const value of chart.axes[0]._splits.filter((v) => inside(v, x))) {
    parts.push(`<path d="M${short(across(value))} ${top}V${bottom}" stroke="${grid}"/>`);
    parts.push(label(short(across(value)), bottom + 17, plain(value), 'text-anchor="middle"'));
  }
  for (const value of chart.axes[1]._splits.filter((v) => inside(v, y))) {
    parts.push(`<path d="M${left} ${short(up(value))}H${right}" stroke="${grid}"/>`);
    parts.push(label(left - 8, short(up(value) + 4), plain(value), 'text-anchor="end"'));
  }
  parts.push(label(right, bottom + 29, "t / s", 'text-anchor="end"'));
  const rows = within(panel);
  looks.forEach(({ color, dash }, i) => {
    let pen = "M";
    let line = "";
    for (const row of rows) {
      const value = chart.data[i + 1][row];
      if (value === undefined) continue;
      if (value === null) pen = "M";
      else {
        line += `${pen}${short(across(chart.data[0][row]))} ${short(up(value))}`;
        pen = "L";
      }
    }
    const dashed = dash ? ` stroke-dasharray="${dash.join(" ")}"` : "";
    parts.push(`<path d="${line}" fill="none" stroke="${color}" stroke-width="1.6" stroke-linejoin="round"${dashed}/>`);
  });
  let under = bottom + 44;
  for (const { name, label: run, color, dash } of looks) {
    const dashed = dash ? ` stroke-dasharray="${dash.join(" ")}"` : "";
    parts.push(`<path d="M${left} ${under - 4}h22" stroke="${color}" stroke-width="2.5"${dashed}/>`);
    parts.push(label(left + 30, under, run ? `${name}, ${run}` : name, `fill="${planarc.theme.color("ink")}"`));
    under += 17;
  }
  return [parts.join(""), under - above + 6];
}
