// Labels that do not overlap: each at the nearest free place around its point, farther ones with
// a line that leads to it.
//
// A placer keeps where each label was, so that labels of a moving picture do not jump. What has
// no room is left out.

const RINGS = [12, 24, 42, 66, 96]; // px from the point to the label
const WAYS = [[1, -1], [1, 1], [-1, -1], [-1, 1], [0, -1], [0, 1], [1, 0], [-1, 0]];
const LONGEST = 28; // letters
const MOST = 150; // labels: more nobody reads

planarc.shortened = (text) => (text.length > LONGEST ? `${text.slice(0, LONGEST / 2)}…${text.slice(1 - LONGEST / 2)}` : text);

planarc.createPlacer = function () {
  const kept = new Map(); // text: the number of its place

  function place(points, size, width, height) {
    // Labels {text, x, y, left, top, wide, high} for points {text, x, y} in pixels.
    const taken = points.map(({ x, y }) => [x - 5, y - 5, x + 5, y + 5]);
    const found = [];
    for (const { text, x, y } of points.slice(0, MOST)) {
      const [wide, high] = [size(text), 16];
      const tries = RINGS.length * WAYS.length;
      const first = kept.get(text) ?? 0;
      for (let i = 0; i < tries + 1; i++) {
        const number = i === 0 ? first : i - 1;
        const ring = RINGS[Math.floor(number / WAYS.length)];
        const [a, b] = WAYS[number % WAYS.length];
        const across = a && b ? 0.75 * ring : ring;
        const left = x + a * across - (a > 0 ? 0 : a < 0 ? wide : wide / 2);
        const top = y + b * across - high / 2;
        const box = [left - 2, top - 1, left + wide + 2, top + high + 1];
        if (box[0] < 2 || box[1] < 2 || box[2] > width - 2 || box[3] > height - 2) continue;
        if (taken.some((t) => t[0] < box[2] && box[0] < t[2] && t[1] < box[3] && box[1] < t[3])) continue;
        taken.push(box);
        kept.set(text, number);
        found.push({ text, x, y, left, top, wide, high, far: ring > RINGS[0] });
        break;
      }
    }
    return found;
  }

  function paint(context, points, color, halo) {
    // Points are in metres, in the present axes of the context.
    const m = context.getTransform();
    const ratio = window.devicePixelRatio || 1;
    const shown = points.map(({ text, x, y }) => ({
      text: planarc.shortened(text), x: (m.a * x + m.c * y + m.e) / ratio, y: (m.b * x + m.d * y + m.f) / ratio,
    }));
    context.save();
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.font = "12px system-ui, sans-serif";
    context.textAlign = "left";
    context.textBaseline = "middle";
    context.lineJoin = "round";
    const [width, height] = [context.canvas.width / ratio, context.canvas.height / ratio];
    const size = (text) => context.measureText(text).width;
    const labels = place(shown, size, width, height);
    context.strokeStyle = color;
    context.lineWidth = 0.8;
    context.beginPath();
    for (const { x, y, left, top, wide, high, far } of labels) {
      if (!far) continue;
      context.moveTo(x, y);
      context.lineTo(Math.min(Math.max(x, left), left + wide), Math.min(Math.max(y, top), top + high));
    }
    context.stroke();
    context.strokeStyle = halo;
    context.lineWidth = 3.5;
    context.fillStyle = color;
    for (const { text, left, top, high } of labels) {
      context.strokeText(text, left, top + high / 2);
      context.fillText(text, left, top + high / 2);
    }
    context.restore();
  }

  return { place, paint };
};
