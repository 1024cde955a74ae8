// The mechanism on the canvas: the poses of an instant, the view, the grid.

function makeTrackReader(data) {
  // Values of moving quantities between rows, by linear interpolation.
  const { time, tracks } = data;
  let row = 0;
  let part = 0;
  return {
    seek(t) {
      let low = 0;
      let high = time.length - 1;
      while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (time[middle] <= t) low = middle;
        else high = middle;
      }
      row = low;
      const span = time.length > 1 ? time[high] - time[low] : 0;
      part = span > 0 ? Math.min(1, Math.max(0, (t - time[low]) / span)) : 0;
    },
    value(quantity) {
      if (!Array.isArray(quantity)) return quantity;
      return this.between(tracks[quantity[0]]);
    },
    between(values) {
      const a = values[row];
      const b = values[Math.min(row + 1, values.length - 1)];
      return a === null || b === null ? NaN : a + (b - a) * part;
    },
  };
}

function makeStage(canvas, data, reader, isDark) {
  const ctx = canvas.getContext("2d");
  const view = { x: 0, y: 0, scale: 100 };

  function size() {
    const ratio = window.devicePixelRatio || 1;
    const { width, height } = canvas.getBoundingClientRect();
    canvas.width = Math.max(1, Math.round(width * ratio));
    canvas.height = Math.max(1, Math.round(height * ratio));
    return { ratio, width, height };
  }

  function fit() {
    const { width, height } = canvas.getBoundingClientRect();
    const [left, bottom, right, top] = data.box || [-1, -1, 1, 1];
    const w = Math.max(right - left, 1e-9);
    const h = Math.max(top - bottom, 1e-9);
    view.x = (left + right) / 2;
    view.y = (bottom + top) / 2;
    view.scale = Math.min(1e12, Math.max(1e-12, 0.88 * Math.min(width / w, height / h)));
  }

  function zoom(factor, x, y) {
    // Keeps the point of the world under (x, y), in pixels from the canvas's middle.
    const wx = view.x + x / view.scale;
    const wy = view.y - y / view.scale;
    view.scale = Math.min(1e12, Math.max(1e-12, view.scale * factor));
    view.x = wx - x / view.scale;
    view.y = wy + y / view.scale;
  }

  function move(dx, dy) {
    view.x -= dx / view.scale;
    view.y += dy / view.scale;
  }

  function grid(width, height, ratio) {
    const styles = getComputedStyle(document.documentElement);
    const target = 90 / view.scale;
    const power = 10 ** Math.floor(Math.log10(target));
    const step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= target);
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.strokeStyle = styles.getPropertyValue("--grid");
    ctx.lineWidth = 1;
    ctx.beginPath();
    const first = Math.ceil((view.x - width / 2 / view.scale) / step) * step;
    for (let x = first; x < view.x + width / 2 / view.scale; x += step) {
      const sx = Math.round(width / 2 + (x - view.x) * view.scale) + 0.5;
      ctx.moveTo(sx, 0);
      ctx.lineTo(sx, height);
    }
    const lowest = Math.ceil((view.y - height / 2 / view.scale) / step) * step;
    for (let y = lowest; y < view.y + height / 2 / view.scale; y += step) {
      const sy = Math.round(height / 2 - (y - view.y) * view.scale) + 0.5;
      ctx.moveTo(0, sy);
      ctx.lineTo(width, sy);
    }
    ctx.stroke();
    // The scale: one step of the grid.
    ctx.fillStyle = styles.getPropertyValue("--faint");
    ctx.strokeStyle = ctx.fillStyle;
    ctx.lineWidth = 2;
    const bar = step * view.scale;
    ctx.beginPath();
    ctx.moveTo(14, height - 14);
    ctx.lineTo(14 + bar, height - 14);
    ctx.stroke();
    ctx.font = "12px system-ui, sans-serif";
    ctx.textAlign = "left";
    ctx.textBaseline = "bottom";
    ctx.fillText(`${Number(step.toPrecision(3))} m`, 14, height - 18);
  }

  function draw(t) {
    const { ratio, width, height } = size();
    reader.seek(t);
    grid(width, height, ratio);
    const k = view.scale * ratio;
    for (const item of data.items) {
      const pose = {
        ...item,
        x: reader.value(item.x),
        y: reader.value(item.y),
        angle: reader.value(item.angle),
        length: reader.value(item.length),
        width: reader.value(item.width),
        extra: reader.value(item.extra),
        color: item.color.map((c) => reader.value(c)),
      };
      if (![pose.x, pose.y, pose.angle, pose.length, pose.width].every(Number.isFinite)) continue;
      ctx.setTransform(
        k, 0, 0, -k,
        (width / 2 - view.x * view.scale) * ratio, (height / 2 + view.y * view.scale) * ratio,
      );
      ctx.translate(pose.x, pose.y);
      ctx.rotate(pose.angle);
      paint(ctx, pose, 1 / view.scale, isDark());
    }
  }

  return { fit, zoom, move, draw };
}
