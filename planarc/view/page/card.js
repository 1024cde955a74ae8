// The card of a part under the pointer: name, class, and what it weighs, how fast it is, what
// forces act on it. A click shows its curves.
//
//   const card = planarc.createCard(player, { variables: () => plots.variables, classes, picked });
//
// `variables` are those of the page by name; `picked(component, curves)` is called for a click.

const ROWS = [ // label, names after the component's, and whether they are two parts of a vector
  ["mass", ["m"]],
  ["inertia", ["I"]],
  ["speed", ["v_CM[1]", "v_CM[2]"]],
  ["speed", ["v"]],
  ["angle", ["phi"]],
  ["turns at", ["w"]],
  ["slide", ["s"]],
  ["torque", ["tau"]],
  ["force", ["f"]],
  ["force at frame_a", ["frame_a.f[1]", "frame_a.f[2]"]],
  ["force at frame_b", ["frame_b.f[1]", "frame_b.f[2]"]],
];
const MOST = 6; // rows, and curves of a click
const REST = 60; // ms between two looks at what is under the pointer

planarc.createCard = function (player, { variables, classes = () => ({}), picked = () => {} }) {
  const { element: make } = planarc;
  const canvas = player.picture();
  const card = make("div", { class: "part", role: "status", hidden: true });
  canvas.parentElement.append(card);
  let shown = null; // {component, owners}
  let last = 0;
  let pressed = null;

  function ownersOf({ component, parts }) {
    // The components that a shape stands for: those that have variables, or what they are in.
    const names = [...variables().keys()];
    const known = (owner) => names.some((name) => name.startsWith(`${owner}.`));
    const all = [component, ...parts].map((name) => {
      let owner = name;
      while (owner && !known(owner)) owner = owner.replace(/\.?[^.]*$/, "");
      return owner;
    });
    return [...new Set(all)].filter(Boolean);
  }

  function found(owners) {
    // What is known of the parts: {label, of: [variables]}, each label once.
    const rows = [];
    for (const [label, names] of ROWS) {
      for (const owner of owners) {
        const of = names.map((name) => variables().get(`${owner}.${name}`));
        if (of.some((v) => !v) || rows.some((row) => row.label === label)) continue;
        rows.push({ label, of });
      }
    }
    return rows.slice(0, MOST);
  }

  function value({ of }, reader) {
    const parts = of.map((v) => v.value(reader));
    const size = parts.length > 1 ? Math.hypot(...parts) : parts[0];
    const tiny = Math.abs(size) < 1e-13; // round-off
    return `${planarc.digits(tiny ? 0 : size)} ${planarc.unit(of[0].unit)}`.trim();
  }

  function tell() {
    if (!shown) return;
    const told = found(shown.owners);
    const rows = told.flatMap((row) => [make("dt", {}, row.label), make("dd", {}, value(row, player.reader))]);
    const name = shown.owners[0] ?? shown.component;
    const kind = classes()?.[name] ?? "";
    card.replaceChildren(make("b", {}, planarc.shortened(name)), make("span", {}, kind), make("dl", {}, ...rows));
  }

  function hide() {
    shown = null;
    card.hidden = true;
    canvas.style.cursor = "";
  }

  function look(event) {
    const part = player.part(event.clientX, event.clientY);
    if (!part) return hide();
    shown = { component: part.component, owners: ownersOf(part) };
    card.hidden = false;
    canvas.style.cursor = "pointer";
    player.reader.seek(player.time);
    tell();
    const box = canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    card.style.left = `${Math.max(4, Math.min(x + 16, box.width - card.offsetWidth - 8))}px`;
    card.style.top = `${y + 20 + card.offsetHeight < box.height ? y + 20 : Math.max(4, y - card.offsetHeight - 12)}px`;
    return undefined;
  }

  canvas.addEventListener("pointerdown", (event) => {
    pressed = event;
    hide();
  });
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons || event.timeStamp - last < REST) return;
    last = event.timeStamp;
    look(event);
  });
  canvas.addEventListener("pointerleave", hide);
  canvas.addEventListener("pointerup", (event) => {
    // A picture that was moved was not touched.
    if (!pressed || Math.hypot(event.clientX - pressed.clientX, event.clientY - pressed.clientY) > 4) return;
    look(event);
    if (!shown) return;
    const curves = found(shown.owners).flatMap((row) => row.of).filter((v) => !v.constant);
    picked(shown.owners[0] ?? shown.component, curves.map((v) => v.name).slice(0, MOST));
  });
  player.onTime(tell);
  return { hide };
};
