// What all modules share: elements, icons, numbers, light and dark.

planarc.element = function (tag, attributes = {}, ...children) {
  // Texts become text nodes, never markup.
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (value === true) node.setAttribute(name, "");
    else if (value !== false && value !== undefined) node.setAttribute(name, value);
  }
  node.append(...children);
  return node;
};

const ICONS = {
  play: "M7 4.5v15l12.5-7.5z",
  pause: "M6.5 4.5h4v15h-4zM13.5 4.5h4v15h-4z",
  back: "M17.5 5v14l-9-7zM5.5 5h2.5v14H5.5z",
  forward: "M6.5 5v14l9-7zM16 5h2.5v14H16z",
  repeat: "M17 2.5 21 6.5l-4 4V7.8H7.6A2.6 2.6 0 0 0 5 10.4V12H3v-1.6a4.6 4.6 0 0 1 4.6-4.6H17zM7 21.5 3 17.5l4-4v2.7h9.4a2.6 2.6 0 0 0 2.6-2.6V12h2v1.6a4.6 4.6 0 0 1-4.6 4.6H7z",
  plus: "M11 4.5h2V11h6.5v2H13v6.5h-2V13H4.5v-2H11z",
  minus: "M4.5 11h15v2h-15z",
  fit: "M4 4h6v2H6v4H4zM14 4h6v6h-2V6h-4zM4 14h2v4h4v2H4zM18 14h2v6h-6v-2h4z",
  theme: "M12 3a9 9 0 1 0 0 18zM12 3v2a7 7 0 0 1 0 14v2a9 9 0 0 0 0-18z",
  picture: "M12 3.5v9.1l3.3-3.3 1.4 1.4-5.7 5.7-5.7-5.7 1.4-1.4 3.3 3.3V3.5zM4 18.5h16v2H4z",
  close: "M6.4 5 12 10.6 17.6 5 19 6.4 13.4 12l5.6 5.6-1.4 1.4L12 13.4 6.4 19 5 17.6l5.6-5.6L5 6.4z",
};

planarc.icon = function (name) {
  const space = "http://www.w3.org/2000/svg";
  const svg = document.createElementNS(space, "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("class", "icon");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS(space, "path");
  path.setAttribute("d", ICONS[name]);
  svg.append(path);
  return svg;
};

planarc.button = function (icon, title, action, attributes = {}) {
  return planarc.element(
    "button",
    { type: "button", title, "aria-label": title, onclick: action, ...attributes },
    planarc.icon(icon),
  );
};

planarc.digits = function (value, count = 4) {
  if (value === null || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  const text = size !== 0 && (size < 1e-3 || size >= 1e6)
    ? value.toExponential(count - 1)
    : value.toPrecision(count);
  return planarc.typeset(text);
};

const raised = (digits) => [...digits].map((d) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[d] || "⁻").join("");

planarc.typeset = function (text) {
  // 1.5e-5 as print has it, and a minus that is as long as a plus.
  return text
    .replace(/(−|-)?(\d+(?:\.\d+)?)e([+-]?)(\d+)/, (_, sign, size, minus, power) => (
      `${sign ? "−" : ""}${size === "1" ? "" : `${size}×`}10${raised(String(Number(minus + power)))}`))
    .replace(/-/g, "−");
};

planarc.spoken = function (message) {
  // What stands in backticks is code.
  return message.split(/`([^`]*)`/).map((part, i) => (i % 2 ? planarc.element("code", {}, part) : part));
};

planarc.unit = (unit) => (unit && unit !== "1"
  ? unit.replace(/\./g, "·").replace(/-?\d+/g, raised)
  : "");

planarc.theme = (() => {
  const root = document.documentElement;
  const wish = window.matchMedia("(prefers-color-scheme: dark)");
  const listeners = new Set();
  const isDark = () => root.dataset.theme === "dark";
  function set(name) {
    const dark = name === "auto" ? wish.matches : name === "dark";
    root.dataset.theme = dark ? "dark" : "light";
    for (const listener of listeners) listener();
  }
  wish.addEventListener("change", () => set("auto"));
  set("auto");
  // Paper is light.
  let kept = "";
  addEventListener("beforeprint", () => {
    if (isDark()) kept = "dark";
    if (kept) set("light");
  });
  addEventListener("afterprint", () => {
    if (kept) set(kept);
    kept = "";
  });
  const color = (name) => getComputedStyle(root).getPropertyValue(`--${name}`).trim();
  return { isDark, set, color, onChange: (listener) => listeners.add(listener) };
})();
