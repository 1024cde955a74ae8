// Other runs beside the one that plays: pale in the picture, and curves beside its curves.
//
//   const runs = planarc.createRuns(element, { changed: (shown) => ... });
//   runs.name("L = 0.5 m");  runs.add({ label, scene, curves });  runs.add(kept, { removable: true });
//
// `shown` are the runs that are switched on, each with the number by which it gets its colour; the
// run that plays is number 0.

planarc.createRuns = function (element, { changed }) {
  const { element: make } = planarc;
  let list = [];
  let own = "";
  let last = 0;

  const shown = () => list.filter((run) => run.on);

  function dot(number) {
    const mark = make("i", { class: "dot" });
    mark.style.background = planarc.runColor(number);
    return mark;
  }

  function chip(run) {
    const toggle = make(
      "button",
      {
        type: "button", class: "chip", "aria-pressed": String(run.on), title: run.label,
        onclick: () => { run.on = !run.on; draw(); },
      },
      dot(run.number), run.label,
    );
    if (!run.removable) return toggle;
    const remove = planarc.button("close", `Forget ${run.label}`, () => {
      list = list.filter((other) => other !== run);
      draw();
    }, { class: "remove" });
    return make("span", { class: "layer" }, toggle, remove);
  }

  function dress() {
    element.hidden = !list.length;
    const here = make("span", { class: "chip own", title: "plays in the picture" }, dot(0), own);
    element.replaceChildren(here, ...list.map(chip));
  }

  function draw() {
    dress();
    changed(shown(), own);
  }

  planarc.theme.onChange(dress);
  dress();
  return {
    add(run, { removable = false } = {}) {
      last += 1;
      list.push({ ...run, number: last, on: true, removable });
      draw();
    },
    name(text) {
      own = text;
      dress();
    },
    get count() { return list.length; },
  };
};
