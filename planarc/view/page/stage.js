// The drawing: the view (what of the world is seen, and how large), the grid, the items of an
// instant, and the layers over them.

const GHOST = 0.22; // of other runs behind the one that plays
const LIMIT = 1e12; // of the zoom, in pixels a metre

planarc.createStage = function (canvas) {
  const context = canvas.getContext("2d");
  const view = { x: 0, y: 0, scale: 100 }; // centre in metres, pixels a metre
  let ratio = 1;
  let width = 1;
  let height = 1;
  let colors = {};

  function measure() {
    ratio = window.devicePixelRatio || 1;
    const box = canvas.getBoundingClientRect();
    width = Math.max(1, box.width);
    height = Math.max(1, box.height);
    const columns = Math.round(width * ratio);
    const rows = Math.round(height * ratio);
    if (canvas.width !== columns) canvas.width = columns;
    if (canvas.height !== rows) canvas.height = rows;
  }

  function dress() {
    colors = Object.fromEntries(
      ["grid", "grid-strong", "faint", "ink", "stage", "accent"].map((n) => [n, planarc.theme.color(n)]),
    );
    colors.dark = planarc.theme.isDark();
  }

  const bounded = (scale) => Math.min(LIMIT, Math.max(1 / LIMIT, scale));

  function fit(box, inset = 0) {
    // The inset is kept free at the right, for buttons that lie over the picture.
    const [left, bottom, right, top] = box || [-1, -1, 1, 1];
    const w = Math.max(right - left, 1e-9);
    const h = Math.max(top - bottom, 1e-9);
    // Room for the scale at the lower edge and a margin all round.
    const margin = Math.min(28, 0.08 * Math.min(width, height));
    const lower = margin + 16;
    const room = width - 2 * margin - inset;
    view.scale = bounded(Math.min(room / w, (height - margin - lower) / h));
    view.x = (left + right) / 2 + inset / 2 / view.scale;
    view.y = (bottom + top) / 2 - (lower - margin) / 2 / view.scale;
  }

  function zoom(factor, x = 0, y = 0) {
    // Keeps the point of the world under (x, y), in pixels from the canvas's middle.
    const wx = view.x + x / view.scale;
    const wy = view.y - y / view.scale;
    view.scale = bounded(view.scale * factor);
    view.x = wx - x / view.scale;
    view.y = wy + y / view.scale;
  }

  function move(dx, dy) {
    view.x -= dx / view.scale;
    view.y += dy / view.scale;
  }

  function grid() {
    const target = 84 / view.scale;
    const power = 10 ** Math.floor(Math.log10(target));
    const step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= target * 0.999);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.lineWidth = 1;
    for (const zero of [false, true]) {
      context.strokeStyle = zero ? colors["grid-strong"] : colors.grid;
      context.beginPath();
      const first = Math.ceil((view.x - width / 2 / view.scale) / step);
      const last = Math.floor((view.x + width / 2 / view.scale) / step);
      for (let i = first; i <= last; i++) {
        if ((i === 0) !== zero) continue;
        const x = Math.round(width / 2 + (i * step - view.x) * view.scale) + 0.5;
        context.moveTo(x, 0);
        context.lineTo(x, height);
      }
      const lowest = Math.ceil((view.y - height / 2 / view.scale) / step);
      const highest = Math.floor((view.y + height / 2 / view.scale) / step);
      for (let i = lowest; i <= highest; i++) {
        if ((i === 0) !== zero) continue;
        const y = Math.round(height / 2 - (i * step - view.y) * view.scale) + 0.5;
        context.moveTo(0, y);
        context.lineTo(width, y);
      }
      context.stroke();
    }
    return step;
  }

  function ruler(step) {
    const bar = step * view.scale;
    const [x, y] = [16, height - 14];
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.strokeStyle = colors.faint;
    context.fillStyle = colors.faint;
    context.lineWidth = 1.5;
    context.lineCap = "butt";
    context.beginPath();
    context.moveTo(x, y - 4);
    context.lineTo(x, y);
    context.lineTo(x + bar, y);
    context.lineTo(x + bar, y - 4);
    context.stroke();
    context.font = "12px system-ui, sans-serif";
    context.textAlign = "left";
    context.textBaseline = "bottom";
    context.fillText(planarc.length(step), x + 5, y - 2);
  }

  function world() {
    const k = view.scale * ratio;
    context.setTransform(
      k, 0, 0, -k,
      (width / 2 - view.x * view.scale) * ratio, (height / 2 + view.y * view.scale) * ratio,
    );
  }

  function paint(target, pose, px) {
    target.translate(pose.x, pose.y);
    target.rotate(pose.angle);
    planarc.paint(target, pose, px, colors.dark);
  }

  function draw(items, layers, reader, lit = "", ghosts = []) {
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = colors.stage;
    context.fillRect(0, 0, canvas.width, canvas.height);
    const step = grid();
    const px = 1 / view.scale;
    const under = layers.filter((layer) => layer.under);
    const over = layers.filter((layer) => !layer.under);
    for (const layer of under) {
      world();
      layer.paint(context, reader, px, colors);
    }
    const pose = {};
    context.globalAlpha = GHOST;
    for (const ghost of ghosts) {
      for (const item of ghost.items) {
        if (!planarc.posed(item, ghost.reader, pose)) continue;
        world();
        paint(context, pose, px);
      }
    }
    context.globalAlpha = 1;
    for (const item of items) {
      if (!planarc.posed(item, reader, pose)) continue;
      world();
      if (lit && planarc.shows(item, lit)) {
        context.shadowColor = colors.accent;
        context.shadowBlur = 18 * ratio;
      }
      paint(context, pose, px);
      context.shadowBlur = 0;
    }
    for (const layer of over) {
      world();
      layer.paint(context, reader, px, colors);
    }
    ruler(step);
  }

  function place(x, y) {
    // The point of the world at a point of the canvas.
    return { x: view.x + (x - width / 2) / view.scale, y: view.y - (y - height / 2) / view.scale };
  }

  function pick(items, reader, x, y) {
    // The topmost item under a point of the canvas, or else close to it; null where none is.
    return touched(items, reader, x, y, 1) ?? touched(items, reader, x, y, 9);
  }

  function touched(items, reader, x, y, size) {
    // The topmost item that covers something of a square around a point, sizes in pixels.
    const glass = document.createElement("canvas");
    glass.width = size;
    glass.height = size;
    const target = glass.getContext("2d", { willReadFrequently: true });
    const pose = {};
    for (const item of [...items].reverse()) {
      if (!planarc.posed(item, reader, pose)) continue;
      const k = view.scale;
      target.setTransform(
        k, 0, 0, -k, width / 2 - view.x * k - x + size / 2, height / 2 + view.y * k - y + size / 2,
      );
      paint(target, pose, 1 / k);
      if (target.getImageData(0, 0, size, size).data.some((byte) => byte > 0)) return item;
    }
    return null;
  }

  dress();
  measure();
  return { view, fit, zoom, move, draw, pick, place, measure, dress };
};

planarc.within = function (name, component) {
  // True for a component itself, what is in it, and its elements.
  return name.startsWith(component) && ["", ".", "["].includes(name.charAt(component.length));
};

planarc.shows = function (item, component) {
  // True where an item is a component, or a part of it, or one shape for it and others.
  return planarc.within(item.component, component) || (item.parts || []).some((p) => planarc.within(p, component));
};

planarc.length = function (metres) {
  // A length as people say it: 5 cm, 200 mm, 2 km.
  const units = [["km", 1e3], ["m", 1], ["cm", 1e-2], ["mm", 1e-3], ["µm", 1e-6]];
  const [unit, size] = units.find((u) => metres >= u[1] * (1 - 1e-9)) ?? ["nm", 1e-9];
  return `${Number((metres / size).toPrecision(3))} ${unit}`;
};

planarc.posed = function (item, reader, pose) {
  // The item at the reader's instant, or where it is dragged; false where it has no finite place.
  if (item.dragged) {
    [pose.x, pose.y, pose.angle, pose.length, pose.width] = item.dragged;
    if (item.dragged.some((v) => v === null)) return false;
    return dressed(item, reader, pose);
  }
  pose.x = reader.at(item.x);
  pose.y = reader.at(item.y);
  pose.angle = reader.at(item.angle);
  pose.length = reader.at(item.length);
  pose.width = reader.at(item.width);
  if (!Number.isFinite(pose.x + pose.y + pose.angle + pose.length + pose.width)) return false;
  return dressed(item, reader, pose);
};

function dressed(item, reader, pose) {
  pose.extra = item.extra === undefined ? 0 : reader.at(item.extra);
  pose.color = item.color.map((c) => reader.at(c));
  pose.shape = item.shape;
  return true;
}
