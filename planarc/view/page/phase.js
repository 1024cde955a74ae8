// Curves over each other instead of over time, with equal axes: a circle is round.
//
//   const phase = planarc.createPhase(holder, { lines, unit, across, plain });
//   phase.mark([[x, y], ...]);  phase.draw();
//
// `lines` are {x, y, color, dash}, arrays of numbers or null; `across` says what lies along x.

const HEIGHT = 300;
const SIDES = { left: 64, right: 24, top: 22, bottom: 34 };

function ends(values) {
  const known = values.filter((v) => v !== null && v !== undefined);
  return known.length ? [Math.min(...known), Math.max(...known)] : [0, 1];
}

function ticks(low, high, room) {
  const least = ((high - low) * 64) / room;
  const power = 10 ** Math.floor(Math.log10(least));
  const step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= least * 0.999);
  const found = [];
  for (let i = Math.ceil(low / step); i * step <= high; i++) found.push(i * step);
  return found;
}

planarc.createPhase = function (holder, { lines, unit, across, plain }) {
  const { element: make } = planarc;
  const canvas = make("canvas", { class: "phase", role: "img", "aria-label": `Over ${across}` });
  holder.append(canvas);
  const [left, right] = ends(lines.flatMap((line) => ends(line.x)));
  const [low, high] = ends(lines.flatMap((line) => ends(line.y)));
  let points = [];

  function draw() {
    const width = Math.max(200, holder.clientWidth);
    const ratio = window.devicePixelRatio || 1;
    canvas.width = width * ratio;
    canvas.height = HEIGHT * ratio;
    canvas.style.width = `${width}px`;
    canvas.style.height = `${HEIGHT}px`;
    const [w, h] = [width - SIDES.left - SIDES.right, HEIGHT - SIDES.top - SIDES.bottom];
    const size = Math.max((right - left) / w, (high - low) / h) * 1.06 || 1 / w; // of a pixel
    const [x0, y0] = [(left + right) / 2, (low + high) / 2];
    const at = (x, y) => [SIDES.left + w / 2 + (x - x0) / size, SIDES.top + h / 2 - (y - y0) / size];
    const context = canvas.getContext("2d");
    context.scale(ratio, ratio);
    context.font = "12px system-ui, sans-serif";
    context.fillStyle = planarc.theme.color("faint");
    context.strokeStyle = planarc.theme.color("grid-strong");
    context.textAlign = "center";
    for (const x of ticks(x0 - (w * size) / 2, x0 + (w * size) / 2, w)) {
      line(context, [at(x, y0)[0], SIDES.top], [at(x, y0)[0], SIDES.top + h]);
      context.fillText(plain(x), at(x, y0)[0], SIDES.top + h + 15);
    }
    context.fillText(`${across} ${planarc.unit(unit)}`.trim(), SIDES.left + w / 2, HEIGHT - 4);
    context.textAlign = "right";
    for (const y of ticks(y0 - (h * size) / 2, y0 + (h * size) / 2, h)) {
      line(context, [SIDES.left, at(x0, y)[1]], [SIDES.left + w, at(x0, y)[1]]);
      context.fillText(plain(y), SIDES.left - 8, at(x0, y)[1] + 4);
    }
    context.fillText(planarc.unit(unit), SIDES.left - 8, 12);
    for (const one of lines) trace(context, one, at);
    points.forEach(([x, y], i) => {
      if (!Number.isFinite(x + y)) return;
      context.fillStyle = lines[i].color;
      context.beginPath();
      context.arc(...at(x, y), 4, 0, 2 * Math.PI);
      context.fill();
    });
  }

  function line(context, from, to) {
    context.beginPath();
    context.moveTo(...from);
    context.lineTo(...to);
    context.stroke();
  }

  function trace(context, { x, y, color, dash }, at) {
    context.save();
    context.strokeStyle = color;
    context.lineWidth = 1.6;
    context.lineJoin = "round";
    context.setLineDash(dash || []);
    context.beginPath();
    let open = false;
    for (let i = 0; i < x.length; i++) {
      if (x[i] === null || y[i] === null) open = false;
      else if (open) context.lineTo(...at(x[i], y[i]));
      else {
        context.moveTo(...at(x[i], y[i]));
        open = true;
      }
    }
    context.stroke();
    context.restore();
  }

  draw();
  return {
    draw,
    mark(next) {
      points = next;
      draw();
    },
  };
};
