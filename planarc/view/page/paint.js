// Draws one item in its own axes: metres, x along the item's length, y to its left.
// `px` is the size of a screen pixel in metres, so that lines stay thin at any zoom.

function rgb(color, dark) {
  // Dark colours are lightened on a dark ground.
  const bright = 0.3 * color[0] + 0.59 * color[1] + 0.11 * color[2];
  const mix = dark && bright < 150 ? (155 - bright) / 255 : 0;
  return color.map((c) => Math.round(c + (255 - c) * mix));
}

function css(c, alpha = 1) {
  return `rgba(${c[0]},${c[1]},${c[2]},${alpha})`;
}

planarc.paint = function (ctx, item, px, dark) {
  const c = rgb(item.color, dark);
  const edge = c.map((v) => Math.round(v * 0.6));
  ctx.fillStyle = css(c, item.kind === "shape" ? 0.92 : 1);
  ctx.strokeStyle = css(edge);
  ctx.lineWidth = 1.2 * px;
  ctx.lineJoin = "round";
  ctx.lineCap = "round";
  const draw = { shape: paintShape, arrow: paintArrow, doubleArrow: paintArrow, frame: paintFrame,
    curve: paintCurve, text: paintText }[item.kind];
  if (draw) draw(ctx, item, px, c, edge, dark);
};

function both(ctx) {
  ctx.fill();
  ctx.stroke();
}

function paintShape(ctx, item, px, c, edge, dark) {
  const { length: l, width: w } = item;
  const solid = SOLIDS[item.shape] || SOLIDS.box;
  if (item.shape === "ground") return paintGround(ctx, l, w, px, dark ? c : edge);
  if (item.upright) return (ENDS[item.shape] || ENDS.box)(ctx, w, item.extra, c, px);
  if (!l || !w) return undefined;
  return solid(ctx, l, w, item.extra, px, c);
}

const SOLIDS = {
  box(ctx, l, w) {
    ctx.beginPath();
    ctx.rect(Math.min(0, l), -w / 2, Math.abs(l), w);
    both(ctx);
  },
  beam(ctx, l, w) {
    ctx.beginPath();
    ctx.roundRect(Math.min(0, l) - w / 2, -w / 2, Math.abs(l) + w, w, w / 2);
    both(ctx);
  },
  cylinder(ctx, l, w, extra, px, c) {
    const shade = ctx.createLinearGradient(0, -w / 2, 0, w / 2);
    const dark = c.map((v) => v * 0.72);
    const light = c.map((v) => v + (255 - v) * 0.35);
    shade.addColorStop(0, css(dark));
    shade.addColorStop(0.62, css(light));
    shade.addColorStop(1, css(c));
    ctx.fillStyle = shade;
    SOLIDS.box(ctx, l, w);
  },
  pipe(ctx, l, w, extra, px, c) {
    SOLIDS.cylinder(ctx, l, w, extra, px, c);
  },
  sphere(ctx, l, w) {
    ctx.beginPath();
    ctx.ellipse(l / 2, 0, Math.abs(l / 2), Math.abs(w / 2), 0, 0, 2 * Math.PI);
    both(ctx);
  },
  cone(ctx, l, w, extra) {
    const top = (w / 2) * Math.min(1, Math.max(0, extra));
    ctx.beginPath();
    ctx.moveTo(0, -w / 2);
    ctx.lineTo(l, -top);
    ctx.lineTo(l, top);
    ctx.lineTo(0, w / 2);
    ctx.closePath();
    both(ctx);
  },
  gearwheel(ctx, l, w) {
    SOLIDS.box(ctx, l, w);
    ctx.beginPath();
    for (let i = 1; i < 8; i++) {
      const y = (w / 2) * Math.cos((i * Math.PI) / 8);
      ctx.moveTo(0, y);
      ctx.lineTo(l, y);
    }
    ctx.stroke();
  },
  spring(ctx, l, w, extra, px, c) {
    // A coil seen from the side: a wave between two straight ends.
    const turns = Math.max(1, Math.round(extra || 5));
    const steps = 16 * turns;
    ctx.strokeStyle = css(c);
    ctx.lineWidth = Math.max(1.8 * px, w / 14);
    ctx.beginPath();
    ctx.moveTo(0, 0);
    for (let i = 0; i <= steps; i++) {
      ctx.lineTo(l * (0.1 + (0.8 * i) / steps), (w / 2) * Math.sin((2 * Math.PI * turns * i) / steps));
    }
    ctx.lineTo(l, 0);
    ctx.stroke();
  },
};

const ENDS = {
  box(ctx, w) {
    ctx.beginPath();
    ctx.rect(-w / 2, -w / 2, w, w);
    both(ctx);
  },
  cylinder(ctx, w, extra, c) {
    ctx.beginPath();
    ctx.arc(0, 0, Math.abs(w / 2), 0, 2 * Math.PI);
    both(ctx);
    ctx.beginPath();
    ctx.arc(0, 0, Math.abs(w / 6), 0, 2 * Math.PI);
    ctx.fillStyle = css(c.map((v) => v + (255 - v) * 0.75));
    ctx.fill();
  },
  sphere(ctx, w) {
    ctx.beginPath();
    ctx.arc(0, 0, Math.abs(w / 2), 0, 2 * Math.PI);
    both(ctx);
  },
  pipe(ctx, w, extra) {
    const inner = Math.min(0.98, Math.max(0.02, extra || 0.7));
    ctx.beginPath();
    ctx.arc(0, 0, Math.abs(w / 2), 0, 2 * Math.PI);
    ctx.arc(0, 0, Math.abs((w / 2) * inner), 0, 2 * Math.PI, true);
    both(ctx);
  },
  gearwheel(ctx, w, extra) {
    const teeth = Math.max(6, Math.round(extra || 20));
    const outer = w / 2;
    const inner = outer * (1 - 3 / (teeth + 6));
    ctx.beginPath();
    for (let i = 0; i < teeth; i++) {
      for (const [part, r] of [[0, inner], [0.2, inner], [0.35, outer], [0.65, outer], [0.8, inner]]) {
        const a = ((i + part) * 2 * Math.PI) / teeth;
        ctx.lineTo(r * Math.cos(a), r * Math.sin(a));
      }
    }
    ctx.closePath();
    both(ctx);
    ctx.beginPath();
    ctx.moveTo(0, 0);
    ctx.lineTo(inner, 0);
    ctx.stroke();
  },
};
ENDS.beam = ENDS.cylinder;
ENDS.cone = ENDS.sphere;
ENDS.spring = (ctx, w, extra, c, px) => ENDS.pipe(ctx, w, 0.8, c, px);

function paintGround(ctx, l, w, px, line) {
  // A bearing: a triangle under its point, on hatched ground.
  const base = -0.62 * l;
  ctx.beginPath();
  ctx.moveTo(0, 0);
  ctx.lineTo(0.36 * w, base);
  ctx.lineTo(-0.36 * w, base);
  ctx.closePath();
  both(ctx);
  ctx.strokeStyle = css(line);
  ctx.lineWidth = 1.6 * px;
  ctx.beginPath();
  ctx.moveTo(-0.55 * w, base);
  ctx.lineTo(0.55 * w, base);
  ctx.stroke();
  ctx.lineWidth = 1.1 * px;
  ctx.beginPath();
  for (let i = 0; i <= 5; i++) {
    const x = w * (-0.5 + i * 0.2);
    ctx.moveTo(x, base);
    ctx.lineTo(x - 0.13 * w, base - 0.25 * l);
  }
  ctx.stroke();
}

function arrow(ctx, l, w, px, heads) {
  if (!l) return;
  const shaft = Math.max(w, 1.6 * px);
  const head = Math.min(Math.abs(l), 4.5 * shaft);
  ctx.lineWidth = shaft;
  ctx.lineCap = "butt";
  ctx.beginPath();
  ctx.moveTo(0, 0);
  ctx.lineTo(l - Math.sign(l) * head * 0.8, 0);
  ctx.stroke();
  for (let i = 0; i < heads; i++) {
    const tip = l - Math.sign(l) * head * 0.8 * i;
    ctx.beginPath();
    ctx.moveTo(tip, 0);
    ctx.lineTo(tip - Math.sign(l) * head, 0.36 * head);
    ctx.lineTo(tip - Math.sign(l) * head, -0.36 * head);
    ctx.closePath();
    ctx.fill();
  }
}

function paintArrow(ctx, item, px, c) {
  ctx.strokeStyle = css(c);
  arrow(ctx, item.length, item.width, px, item.kind === "doubleArrow" ? 2 : 1);
}

function paintFrame(ctx, item, px, c) {
  ctx.strokeStyle = css(c);
  arrow(ctx, item.length, item.width, px, 1);
  label(ctx, item.labels[0], item.length + 10 * px, 0, px, c);
  ctx.save();
  ctx.rotate(Math.PI / 2);
  arrow(ctx, item.length, item.width, px, 1);
  ctx.restore();
  label(ctx, item.labels[1], 0, item.length + 10 * px, px, c);
}

function paintCurve(ctx, item, px, c) {
  ctx.strokeStyle = css(c);
  ctx.lineWidth = Math.max(item.width, 1.5 * px);
  ctx.beginPath();
  for (const [x, y] of item.points) ctx.lineTo(x, y);
  ctx.stroke();
}

function paintText(ctx, item, px, c) {
  label(ctx, item.labels[0], 0, 0, px, c, item.width);
}

function label(ctx, text, x, y, px, c, height = 13 * px) {
  planarc.label(ctx, text, x, y, px, css(c), { height });
}

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
