// What is laid over the mechanism on demand: paths of points, vectors, instant centres.
//
// A layer of the scene is {id, title, kind, unit, members, on}. A member of `paths` and
// `centres` has x, y; one of `vectors` has x, y and the vector's components u, v, one
// of `masses` x, y and its mass u. The layer of kind `corner` has an `item`, which lies in a corner whatever the view.

const COLORS = {
  light: { paths: "#0d7a5f", forces: "#c0362c", contacts: "#c26a00", velocities: "#1d63c4", accelerations: "#a0389b", centres: "#8a5a00", masses: "#7a8494" },
  dark: { paths: "#5fd6b4", forces: "#ff8b7e", contacts: "#ffa657", velocities: "#7fb4ff", accelerations: "#e58be0", centres: "#f0c05a", masses: "#9aa4b4" },
};

planarc.layerColor = (id) => COLORS[planarc.theme.isDark() ? "dark" : "light"][id] || "#7a8494";

const PAINTERS = { paths: paintPaths, vectors: paintVectors, masses: paintMasses, centres: paintCentres, corner: paintCorner };

planarc.createLayer = function (source, tracks, box, shapes = []) {
  const at = (quantity) => (Array.isArray(quantity) ? tracks[quantity[0]] : quantity);
  const members = source.members.map((m) => ({
    name: m.name, on: m.on !== false, x: at(m.x), y: at(m.y), u: at(m.u), v: at(m.v), path: null,
  }));
  const layer = {
    id: source.id, title: source.title, unit: source.unit, on: Boolean(source.on), members,
    under: ["paths", "masses", "corner"].includes(source.kind), reach: reach(source.kind, members, box), key: null,
  };
  if (source.item) layer.item = { ...source.item, shape: shapes[source.item.shape] };
  if (source.kind === "vectors") layer.key = roundTo125(0.5 * layer.reach.largest);
  layer.paint = (...about) => PAINTERS[source.kind](layer, ...about);
  return layer;
};

function reach(kind, members, box) {
  // Vectors: the largest is a quarter of the mechanism's size; of masses, the radius of its disc a twelfth.
  if (kind !== "vectors" && kind !== "masses") return null;
  let largest = 0;
  for (const m of members) {
    const count = Math.max(m.u.length || 1, m.v?.length || 1);
    for (let i = 0; i < count; i++) {
      const size = Math.hypot(m.u.length ? m.u[i] : m.u, (m.v?.length ? m.v[i] : m.v) || 0);
      if (size > largest) largest = size;
    }
  }
  const [left, bottom, right, top] = box || [-1, -1, 1, 1];
  const span = Math.max(right - left, top - bottom, 1e-9);
  return { largest, span, scale: largest > 0 ? (0.28 * span) / largest : 0 };
}

function roundTo125(value) {
  if (!(value > 0)) return 0;
  const power = 10 ** Math.floor(Math.log10(value));
  return [5, 2, 1].map((f) => f * power).find((v) => v <= value * 1.0001);
}

planarc.createKey = function (source) {
  // How long arrows are that components draw: at any zoom a round value about 60 pixels long.
  const { element: make } = planarc;
  const bar = make("b");
  const text = document.createTextNode("");
  const key = make("span", { class: "key", title: "Arrows that components draw" }, bar, text);
  const dress = (scale) => {
    const value = roundTo125(60 / (source.metres * scale));
    bar.style.width = `${value * source.metres * scale}px`;
    bar.style.background = planarc.color(source.color, planarc.theme.isDark());
    text.data = `${Number(value.toPrecision(1))} ${planarc.unit(source.unit)}`;
  };
  return { element: make("span", { class: "layer" }, key), dress };
};

function pathOf(member, px) {
  // In pixels: a canvas draws no line of micrometres.
  const { x, y } = member;
  const path = new Path2D();
  const count = Math.max(x.length || 1, y.length || 1);
  let open = false;
  for (let i = 0; i < count; i++) {
    const [left, up] = [(x.length ? x[i] : x) / px, (y.length ? y[i] : y) / px];
    if (!Number.isFinite(left + up)) open = false;
    else if (open) path.lineTo(left, up);
    else {
      path.moveTo(left, up);
      open = true;
    }
  }
  return path;
}

function paintPaths(layer, context, reader, px) {
  const color = planarc.layerColor(layer.id);
  context.lineJoin = "round";
  for (const member of layer.members) {
    if (!member.on) continue;
    if (member.px !== px) Object.assign(member, { px, path: pathOf(member, px) });
    context.save();
    context.scale(px, px);
    context.strokeStyle = color;
    context.globalAlpha = 0.55;
    context.lineWidth = 1.5;
    context.stroke(member.path);
    context.restore();
    const [x, y] = [reader.at(member.x), reader.at(member.y)];
    if (!Number.isFinite(x + y)) continue;
    context.fillStyle = color;
    context.beginPath();
    context.arc(x, y, 3.5 * px, 0, 2 * Math.PI);
    context.fill();
  }
}

function paintVectors(layer, context, reader, px, colors) {
  const color = planarc.layerColor(layer.id);
  context.strokeStyle = color;
  context.fillStyle = color;
  for (const member of layer.members) {
    if (!member.on) continue;
    const [x, y] = [reader.at(member.x), reader.at(member.y)];
    const [u, v] = [reader.at(member.u), reader.at(member.v)];
    const length = (Math.hypot(u, v) * layer.reach.scale) / px;
    if (!Number.isFinite(x + y + length) || length < 3) continue;
    context.save();
    context.translate(x, y);
    context.rotate(Math.atan2(v, u));
    context.scale(px, px);
    const head = Math.min(length, 11);
    context.lineWidth = 2.2;
    context.lineCap = "butt";
    context.beginPath();
    context.moveTo(0, 0);
    context.lineTo(length - head * 0.8, 0);
    context.stroke();
    context.beginPath();
    context.moveTo(length, 0);
    context.lineTo(length - head, 0.4 * head);
    context.lineTo(length - head, -0.4 * head);
    context.closePath();
    context.fill();
    context.strokeStyle = colors.stage;
    context.lineWidth = 1;
    context.beginPath();
    context.arc(0, 0, 3, 0, 2 * Math.PI);
    context.stroke();
    context.fill();
    context.strokeStyle = color;
    context.restore();
  }
}

function paintMasses(layer, context, reader, px, colors) {
  // Discs whose areas are as the masses.
  context.fillStyle = planarc.layerColor(layer.id);
  context.globalAlpha = 0.4;
  for (const member of layer.members) {
    const [x, y] = [reader.at(member.x), reader.at(member.y)];
    const radius = 0.08 * layer.reach.span * Math.sqrt(reader.at(member.u) / layer.reach.largest);
    if (!member.on || !Number.isFinite(x + y + radius)) continue;
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fill();
  }
  context.globalAlpha = 1;
}

planarc.createNames = function (items, classes) {
  // The names of bodies and joints, each once.
  const placer = planarc.createPlacer();
  const named = new Map();
  for (const item of items) {
    let name = item.component; // or of a shape, what it is in
    while (!item.parts && name.includes(".") && !(name in classes)) name = name.replace(/\.[^.]*$/, "");
    const within = [...named.values()].some((other) => (other.parts || []).includes(name));
    if (!named.has(name) && !within) named.set(name, item);
  }
  const layer = { id: "names", title: "Names", unit: "", on: false, members: [], under: false, reach: null, key: null };
  layer.paint = (context, reader, px, colors) => {
    const points = [];
    const pose = {};
    for (const [text, item] of named) {
      if (!planarc.posed(item, reader, pose)) continue;
      const [u, v] = item.middle || [0, 0];
      const [c, s] = [Math.cos(pose.angle), Math.sin(pose.angle)];
      points.push({ text, x: pose.x + c * u - s * v, y: pose.y + s * u + c * v });
    }
    placer.paint(context, points, colors.ink, colors.stage);
  };
  return layer;
};

function paintCorner(layer, context, reader, px, colors) {
  // Near the lower left corner of the canvas, above the scale.
  const ratio = window.devicePixelRatio || 1;
  const [x, y] = [20 * ratio, context.canvas.height - 50 * ratio];
  context.setTransform(ratio / px, 0, 0, -ratio / px, x, y);
  planarc.paint(context, layer.item, px, colors.dark);
}

function paintCentres(layer, context, reader, px, colors) {
  const color = planarc.layerColor(layer.id);
  const points = [];
  for (const member of layer.members) {
    if (!member.on) continue;
    const [x, y] = [reader.at(member.x), reader.at(member.y)];
    if (!Number.isFinite(x + y)) continue;
    context.save();
    context.translate(x, y);
    context.scale(px, px);
    context.strokeStyle = color;
    context.lineWidth = 1.8;
    const r = 6;
    context.beginPath();
    context.arc(0, 0, r, 0, 2 * Math.PI);
    context.moveTo(-1.7 * r, 0);
    context.lineTo(1.7 * r, 0);
    context.moveTo(0, -1.7 * r);
    context.lineTo(0, 1.7 * r);
    context.stroke();
    context.restore();
    points.push({ text: member.name, x, y });
  }
  layer.placer = layer.placer || planarc.createPlacer();
  layer.placer.paint(context, points, color, colors.stage);
}
