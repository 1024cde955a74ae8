// The variables as a tree of components, with a search; a tick shows a curve.
//
//   const tree = planarc.createTree(element, plots.variables, { toggle: plots.toggle });
//   tree.check(names);  tree.mark(reader);  tree.setVariables(plots.variables);

const MOST = 200; // rows that a search shows

function pieces(name) {
  // `a.b[1].c` is c in b[1] in a; `der(a.c)` stands beside a.c.
  if (name.startsWith("der(") && name.endsWith(")")) {
    const inner = pieces(name.slice(4, -1));
    return [...inner.slice(0, -1), `der(${inner[inner.length - 1]})`];
  }
  const found = [""];
  let quoted = false;
  let depth = 0;
  for (const c of name) {
    if (c === "'") quoted = !quoted;
    else if (!quoted && c === "[") depth += 1;
    else if (!quoted && c === "]") depth -= 1;
    if (c === "." && !quoted && depth === 0) found.push("");
    else found[found.length - 1] += c;
  }
  return found;
}

planarc.createTree = function (element, variables, { toggle = () => {} } = {}) {
  const { element: make } = planarc;
  const search = make("input", {
    type: "search", placeholder: "Search names and descriptions", "aria-label": "Search variables",
    autocomplete: "off", spellcheck: "false",
  });
  const found = make("div", { class: "tree" });
  const count = make("p", { class: "faint", role: "status" });
  element.append(search, found, count);
  let root = null;
  let rows = []; // visible leaves: [input, value, variable]
  let checked = new Set();
  let last = 0;
  let reader = null;

  function grow() {
    root = { children: new Map(), leaves: [] };
    for (const variable of variables.values()) {
      const path = pieces(variable.name);
      let node = root;
      for (const piece of path.slice(0, -1)) {
        if (!node.children.has(piece)) node.children.set(piece, { children: new Map(), leaves: [] });
        node = node.children.get(piece);
      }
      node.leaves.push([path[path.length - 1], variable]);
    }
  }

  function leaf(label, variable) {
    const input = make("input", {
      type: "checkbox", checked: checked.has(variable.name),
      onchange: () => toggle(variable.name, input.checked),
    });
    input.checked = checked.has(variable.name);
    const value = make("span", { class: "value" });
    rows.push([input, value, variable]);
    return make(
      "label", { class: variable.constant ? "leaf constant" : "leaf", title: variable.description || variable.name },
      input, make("span", { class: "name" }, label), value,
    );
  }

  function branch(name, node) {
    const box = make("details", {}, make("summary", {}, name));
    let full = false;
    box.addEventListener("toggle", () => {
      if (!box.open || full) return;
      full = true;
      box.append(make("div", { class: "inside" }, ...fill(node)));
      mark(reader, true);
    });
    return box;
  }

  function fill(node) {
    return [
      ...[...node.children].map(([name, child]) => branch(name, child)),
      ...node.leaves.map(([label, variable]) => leaf(label, variable)),
    ];
  }

  function show() {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    rows = [];
    if (!words.length) {
      found.replaceChildren(...fill(root));
      count.textContent = `${variables.size} variables and parameters`;
    } else {
      const hits = [...variables.values()].filter((v) => {
        const text = `${v.name} ${v.description}`.toLowerCase();
        return words.every((word) => text.includes(word));
      });
      found.replaceChildren(...hits.slice(0, MOST).map((v) => leaf(v.name, v)));
      count.textContent = hits.length > MOST ? `${hits.length} found, the first ${MOST} are shown`
        : hits.length ? `${hits.length} found` : "nothing found";
    }
    mark(reader, true);
  }

  function mark(at, now = false) {
    reader = at;
    const moment = performance.now();
    if (!at || (!now && moment - last < 120)) return;
    last = moment;
    for (const [, value, variable] of rows) {
      value.textContent = `${planarc.digits(variable.value(at))} ${planarc.unit(variable.unit)}`;
    }
  }

  function check(names) {
    checked = names;
    for (const [input, , variable] of rows) input.checked = names.has(variable.name);
  }

  function setVariables(next) {
    const same = next.size === variables.size && [...next.keys()].every((name) => variables.has(name));
    variables = next;
    if (same) {
      rows = rows.map(([input, value, variable]) => [input, value, variables.get(variable.name)]);
      mark(reader, true);
      return;
    }
    grow();
    show();
  }

  search.addEventListener("input", show);
  search.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    search.value = "";
    show();
  });
  grow();
  show();
  return { mark, check, setVariables };
};
