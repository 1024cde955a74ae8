// Dragging a part of the mechanism: the server says where all of it goes, one place after the
// other, the latest first; when it is let go, it runs from there.
//
//   const drag = planarc.createDrag(page, { show: (poses) => ..., release: (start) => ... });
//   drag.take({ components, time, x, y });  drag.move({ x, y });  drag.leave();
//
// With Shift a length is dragged: `stretch(order)` gives what each place of the pointer is told to.

planarc.createDrag = function (page, { show, release, stretch = () => null }) {
  let taken = null; // where it was taken hold of, until it is moved
  let hold = null; // the same, to be told first
  let place = null; // the next place to be told
  let busy = false;
  let held = false;
  let start = null; // start values of the last poses
  let pull = null; // of a length
  const delays = []; // ms from a place to its poses; for tests and measuring

  async function tell(order) {
    const since = performance.now();
    const response = await fetch("drag", {
      method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ page, ...order }),
    });
    const answer = response.ok ? await response.json() : {};
    if (!answer.poses) return;
    start = answer.start;
    show(answer.poses);
    delays.push(performance.now() - since);
  }

  async function send() {
    busy = true;
    try {
      while (hold || place) {
        const order = hold ?? place;
        if (hold) hold = null;
        else place = null;
        await tell(order);
      }
    } catch {
      hold = place = null; // that the server is gone the page tells by itself
    }
    busy = false;
    if (!held) end();
  }

  function end() {
    if (start) release(start);
    start = null;
  }

  return {
    delays,
    take({ shift, item, ...order }) {
      pull = shift ? stretch(order) : null;
      taken = order;
      held = true;
      start = null;
    },
    move(to) {
      if (!held) return;
      if (pull) {
        pull(to);
        return;
      }
      hold = taken ?? hold;
      taken = null;
      place = to;
      if (!busy) send();
    },
    leave() {
      held = false;
      taken = pull = null;
      if (!busy) end();
    },
  };
};
