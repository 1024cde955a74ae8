// Draws one item in its own axes: metres, x along the item's length, y to its left.
// `px` is the size of a screen pixel in metres, so that lines stay thin at any zoom.

function rgb(color, dark) {
  // Dark colours are lightened on a dark ground.
  const bright = 0.3 * color[0] + 0.59 * color[1] + 0.11 * color[2];
  const mix = dark && bright < 150 ? (155 - bright) / 255 : 0;
  return color.map((c) => Math.round(c + (255 - c) * mix));
}

function css(c) {
  return `rgb(${c[0]},${c[1]},${c[2]})`;
}

planarc.color = (color, dark) => css(rgb(color, dark));

planarc.paint = function (ctx, item, px, dark) {
  // The forms of the item's shape, which are data; see `marks/shapes.py`.
  const { shape } = item;
  if ((shape.needs[0] === "l" && !item.length) || (shape.needs[1] === "w" && !item.width)) return;
  const sizes = measure(item, px);
  ctx.scale(px, px); // thin lines of micrometres are none to a canvas
  const color = rgb(item.color, dark);
  ctx.lineJoin = "round";
  for (const form of shape.forms) paintForm(ctx, form, sizes, color, dark);
};

function measure(item, px) {
  // The sizes of `marks/measure.py`, in pixels.
  const shaft = Math.max(item.width, 1.6 * px);
  const head = Math.sign(item.length) * Math.min(Math.abs(item.length), 4.5 * shaft);
  return {
    l: item.length / px, w: item.width / px, p: 1, s: shaft / px, h: head / px, x: (item.width * item.extra) / px,
    i: 1 / px,
  };
}

function total(parts, from, basis, sizes) {
  let sum = 0;
  for (let i = 0; i < basis.length; i++) sum += parts[from + i] * sizes[basis[i]];
  return sum;
}

function tinted(color, tint, dark) {
  const share = tint[dark ? 1 : 0];
  return css(color.map((v) => Math.round(v + ((share > 0 ? 255 : 0) - v) * Math.abs(share))));
}

function paintForm(ctx, form, sizes, color, dark) {
  const basis = form.basis;
  const size = (parts) => (parts ? total(parts, 0, basis, sizes) : 0);
  const points = form.points.map((p) => [total(p, 0, basis, sizes), total(p, basis.length, basis, sizes)]);
  const radius = size(form.radius);
  if (form.kind === "label") {
    const [[x, y]] = points;
    planarc.label(ctx, form.text, x, y, sizes.p, tinted(color, form.fill, dark), { height: radius });
    return;
  }
  ctx.beginPath();
  TRACES[form.kind](ctx, points, Math.abs(radius), Math.abs(size(form.hole)));
  if (form.kind === "line" && !form.open) ctx.closePath();
  if (form.fill) {
    ctx.fillStyle = tinted(color, form.fill, dark);
    ctx.fill();
  }
  if (form.line) {
    ctx.strokeStyle = tinted(color, form.line, dark);
    ctx.lineWidth = Math.max(size(form.width), (form.least || 0) * sizes.p);
    ctx.lineCap = form.least ? "round" : "butt"; // the shaft of an arrow
    ctx.stroke();
  }
}

const TRACES = {
  line(ctx, points) {
    for (const [x, y] of points) ctx.lineTo(x, y);
  },
  bar(ctx, [[ax, ay], [bx, by]], radius) {
    const [x, y] = [Math.min(ax, bx) - radius, Math.min(ay, by)];
    ctx.roundRect(x, y, Math.abs(bx - ax) + 2 * radius, Math.abs(by - ay), radius);
  },
  oval(ctx, [[ax, ay], [bx, by]]) {
    const [x, y] = [(ax + bx) / 2, (ay + by) / 2];
    ctx.ellipse(x, y, Math.abs(bx - ax) / 2, Math.abs(by - ay) / 2, 0, 0, 2 * Math.PI);
  },
  disc(ctx, [[x, y]], radius, hole) {
    ctx.arc(x, y, radius, 0, 2 * Math.PI);
    if (!hole) return;
    ctx.moveTo(x + hole, y);
    ctx.arc(x, y, hole, 0, 2 * Math.PI, true);
  },
};
planarc.label = function (ctx, text, x, y, px, color, { height = 12.5 * px, dx = 0, dy = 0, halo } = {}) {
  // Text stays upright on the screen, whatever the axes do; dx and dy are in pixels.
  const m = ctx.getTransform();
  const scale = Math.hypot(m.a, m.b);
  ctx.save();
  ctx.setTransform(
    1, 0, 0, 1,
    m.a * x + m.c * y + m.e + dx * scale * px, m.b * x + m.d * y + m.f + dy * scale * px,
  );
  ctx.font = `${height * scale}px system-ui, sans-serif`;
  ctx.textAlign = dx > 0 ? "left" : "center";
  ctx.textBaseline = "middle";
  if (halo) {
    ctx.lineWidth = 3.5 * scale * px;
    ctx.lineJoin = "round";
    ctx.strokeStyle = halo;
    ctx.strokeText(text, 0, 0);
  }
  ctx.fillStyle = color;
  ctx.fillText(text, 0, 0);
  ctx.restore();
};
