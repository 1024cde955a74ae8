// Columns of numbers as the page carries them, and their values between two rows.
//
// A column is a number when it never changes, else base64 of little-endian numbers: 32 bits,
// or 64 bits for times. What is not finite is NaN.

function bytes(text) {
  const raw = atob(text);
  const found = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) found[i] = raw.charCodeAt(i);
  return found.buffer;
}

// What a page has computed itself is an array already.
planarc.column = (text) => (typeof text === "string" ? new Float32Array(bytes(text)) : text);
planarc.times = (text) => (typeof text === "string" ? new Float64Array(bytes(text)) : text);

planarc.createReader = function (time) {
  let row = 0;
  let part = 0;
  return {
    time,
    start: time[0],
    stop: time[time.length - 1],
    get row() { return row; },
    seek(t) {
      let low = 0;
      let high = time.length - 1;
      while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (time[middle] <= t) low = middle;
        else high = middle;
      }
      row = low;
      const span = time[high] - time[low];
      part = span > 0 ? Math.min(1, Math.max(0, (t - time[low]) / span)) : 0;
    },
    at(values) {
      // A number stands for itself; null is unknown.
      if (values === null) return NaN;
      if (typeof values === "number") return values;
      const a = values[row];
      if (part === 0) return a;
      return a + (values[row + 1] - a) * part;
    },
  };
};
