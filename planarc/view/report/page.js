// Joins canvas, curves and controls: one time for all of them.

(() => {
  const get = (id) => document.getElementById(id);
  const data = JSON.parse(get("data").textContent);
  const root = document.documentElement;
  const start = data.time[0];
  const stop = data.time[data.time.length - 1];
  const prefersDark = window.matchMedia("(prefers-color-scheme: dark)");
  const isDark = () => root.dataset.theme === "dark";
  root.dataset.theme = prefersDark.matches ? "dark" : "light";

  const reader = makeTrackReader(data);
  const stage = makeStage(get("canvas"), data, reader, isDark);
  const plots = makePlots(get("plots"), data, isDark, seek);
  const slider = get("slider");
  const digits = Math.max(0, Math.min(15, 3 - Math.floor(Math.log10(stop - start || 1))));
  let time = start;
  let playing = false;
  let last = 0;
  let asked = false;
  let fitted = true; // until the user moves or zooms, a new size fits anew

  slider.min = start;
  slider.max = stop;
  slider.value = start;

  // Speeds around one second a second; a run of milliseconds or hours gets its own.
  const natural = stop - start > 60 || stop - start < 1 ? (stop - start) / 10 || 1 : 1;
  for (const factor of [0.1, 0.25, 0.5, 1, 2, 5, 10]) {
    const speed = Number((factor * natural).toPrecision(2));
    get("speed").append(new Option(`${speed}×`, speed, factor === 1, factor === 1));
  }

  function show() {
    asked = false;
    stage.draw(time);
    plots.mark(time, reader);
    slider.value = time;
    get("clock").textContent = `${time.toFixed(digits)} s`;
  }

  function ask() {
    if (!asked) requestAnimationFrame(show);
    asked = true;
  }

  function seek(t) {
    time = Math.min(stop, Math.max(start, t));
    ask();
  }

  function play(on) {
    playing = on && stop > start;
    get("play").textContent = playing ? "Pause" : "Play";
    get("play").setAttribute("aria-pressed", String(playing));
    if (!playing) return;
    if (time >= stop) time = start;
    last = performance.now();
    requestAnimationFrame(tick);
  }

  function tick(moment) {
    if (!playing) return;
    time += (Math.max(0, moment - last) / 1000) * Number(get("speed").value);
    last = moment;
    if (time > stop) {
      if (get("loop").checked) time = start;
      else {
        time = stop;
        play(false);
      }
    }
    show();
    if (playing) requestAnimationFrame(tick);
  }

  function step(direction, far) {
    play(false);
    seek(time + (direction * (stop - start)) / (far ? 20 : 200));
  }

  function zoomMiddle(factor) {
    fitted = false;
    stage.zoom(factor, 0, 0);
    ask();
  }

  function fit() {
    fitted = true;
    stage.fit();
    ask();
  }

  function faster(direction) {
    const list = get("speed");
    const next = list.selectedIndex + direction;
    list.selectedIndex = Math.min(list.length - 1, Math.max(0, next));
  }

  const KEYS = {
    " ": () => play(!playing),
    ArrowLeft: (e) => step(-1, e.shiftKey),
    ArrowRight: (e) => step(1, e.shiftKey),
    Home: () => seek(start),
    End: () => seek(stop),
    f: fit,
    F: fit,
    "+": () => zoomMiddle(1.25),
    "-": () => zoomMiddle(0.8),
    ",": () => faster(-1),
    ".": () => faster(1),
  };

  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const inside = event.target.closest("button, input, select, summary");
    if (inside && (event.key === " " || inside === slider || inside.tagName === "SELECT")) return;
    const action = KEYS[event.key];
    if (!action) return;
    event.preventDefault();
    action(event);
  });

  get("play").addEventListener("click", () => play(!playing));
  get("fit").addEventListener("click", fit);
  get("larger").addEventListener("click", () => zoomMiddle(1.25));
  get("smaller").addEventListener("click", () => zoomMiddle(0.8));
  slider.addEventListener("input", () => {
    play(false);
    seek(Number(slider.value));
  });

  const canvas = get("canvas");
  let grabbed = null;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    grabbed = [event.clientX, event.clientY];
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!grabbed) return;
    fitted = false;
    stage.move(event.clientX - grabbed[0], event.clientY - grabbed[1]);
    grabbed = [event.clientX, event.clientY];
    ask();
  });
  for (const end of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(end, () => { grabbed = null; });
  }
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const box = canvas.getBoundingClientRect();
    const x = event.clientX - box.left - box.width / 2;
    const y = event.clientY - box.top - box.height / 2;
    fitted = false;
    stage.zoom(Math.exp(-event.deltaY * 0.0015), x, y);
    ask();
  }, { passive: false });

  function choose() {
    for (const curve of data.curves) {
      const label = document.createElement("label");
      const box = document.createElement("input");
      box.type = "checkbox";
      box.checked = curve.shown;
      box.addEventListener("change", () => {
        curve.shown = box.checked;
        plots.build();
        ask();
      });
      label.title = curve.description;
      label.append(box, ` ${curve.name}`);
      get("choice").append(label);
    }
    get("more").hidden = data.curves.length === 0;
  }

  function setTheme(dark) {
    root.dataset.theme = dark ? "dark" : "light";
    plots.build();
    ask();
  }
  get("theme").addEventListener("click", () => setTheme(!isDark()));
  prefersDark.addEventListener("change", (event) => setTheme(event.matches));

  new ResizeObserver(() => (fitted ? fit() : ask())).observe(canvas);
  new ResizeObserver(() => { plots.resize(); ask(); }).observe(get("plots"));

  choose();
  plots.build();
  stage.fit();
  show();
})();
