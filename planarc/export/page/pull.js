// Dragging a part of the mechanism: start values follow the pointer, and the run begins there.
//
//   const drag = planarc.createPull({ names, start }, {
//     show, value, given, give, least, grip, dropped, stretch });
//   drag.take({ item, x, y, shift });  drag.move({ x, y });  drag.leave();  drag.again();
//
// `names` are the fields that may follow; `start(values)` gives the pose of each item there, or null
// where there is no start. `value(name)` is where it stands in the picture, `given(name)` what its
// field says, `give(values)` sets fields. A point that each of them moves by `least(name)` at most, for
// 1 rad or 1 m, cannot be taken. With Shift a length is dragged: `stretch(order)` gives what each
// place of the pointer is told to.

const STEP = 1e-5; // rad or m, by which slopes are found
const FELT = 1e-7; // less is rounding
const LONGEST = 0.5; // rad or m of a step
const ROUNDS = 20; // steps for a place of the pointer
const PATIENCE = 25; // ms for them, while it moves
const WORTH = 1e-4; // of the way that is left: a step that gains less is none

planarc.createPull = function ({ names, start }, { shown, grip, dropped, stretch = () => null, show, value, given, give, least }) {
  const reach = new Map(); // name -> the items that it moves, looked at once
  let hold = null; // what is held: {item, moving, at, local}
  let pull = null; // of a length
  let latest = null; // the poses that are shown
  let begun = false; // whether anything has moved
  let target = null; // where the pointer is

  function pointOf(poses, { item, local: [u, v] }) {
    const [x, y, angle] = poses[item];
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    return [x + c * u - s * v, y + s * u + c * v];
  }

  function slopes(held, at, here) {
    // How the point moves by each name.
    return held.moving.map((name) => {
      const poses = start({ ...at, [name]: at[name] + STEP });
      if (!poses) return [0, 0];
      const there = pointOf(poses, held);
      return [(there[0] - here[0]) / STEP, (there[1] - here[1]) / STEP];
    });
  }

  function stepOf(ways, [dx, dy]) {
    // The least step that leads there, a little damped where the ways are nearly one.
    let [a, b, d] = [0, 0, 0];
    for (const [x, y] of ways) [a, b, d] = [a + x * x, b + x * y, d + y * y];
    const cost = 1e-4 * (a + d);
    const det = (a + cost) * (d + cost) - b * b;
    const [p, q] = [((d + cost) * dx - b * dy) / det, ((a + cost) * dy - b * dx) / det];
    const step = ways.map(([x, y]) => x * p + y * q);
    const size = Math.max(...step.map(Math.abs));
    return step.map((s) => (size > LONGEST ? (s * LONGEST) / size : s));
  }

  function follow(held, target, patience) {
    // Start values at which the point is as near to the pointer as they bring it.
    const since = performance.now();
    let { at } = held;
    let poses = start(at);
    if (!poses) return null;
    for (let round = 0; round < ROUNDS && performance.now() - since < patience; round++) {
      const here = pointOf(poses, held);
      const gap = [target[0] - here[0], target[1] - here[1]];
      const step = stepOf(slopes(held, at, here), gap);
      let better = null;
      for (const part of [1, 0.5, 0.2, 0.05]) {
        const tried = { ...at };
        held.moving.forEach((name, i) => { tried[name] += part * step[i]; });
        const there = start(tried);
        if (!there) continue;
        const [x, y] = pointOf(there, held);
        if (Math.hypot(target[0] - x, target[1] - y) >= Math.hypot(...gap) * (1 - WORTH)) continue;
        better = { at: tried, poses: there };
        break;
      }
      if (!better) break;
      ({ at, poses } = better);
    }
    return { at, poses };
  }

  function held({ item, x, y }) {
    // A hold on an item at a point; null where no name moves it.
    const all = Object.fromEntries(names.map((name) => [name, value(name)]).filter(([, v]) => Number.isFinite(v)));
    const first = start(all);
    if (!first || !first[item]?.slice(0, 3).every(Number.isFinite)) return null;
    for (const [name, v] of Object.entries(all)) {
      if (!reach.has(name)) reach.set(name, moved(first, start({ ...all, [name]: v + STEP })));
    }
    const at = Object.fromEntries(Object.entries(all).filter(([name]) => reach.get(name).size));
    const [px, py, angle] = first[item];
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const found = { item, at, local: [c * (x - px) + s * (y - py), c * (y - py) - s * (x - px)], moving: [] };
    found.moving = Object.keys(at).filter((name) => reach.get(name).has(item));
    const ways = slopes(found, at, pointOf(first, found));
    found.moving = found.moving.filter((name, i) => Math.hypot(...ways[i]) > least(name));
    return found.moving.length ? found : null;
  }

  function moved(first, other) {
    // The items that are elsewhere.
    const parts = first.map((_, i) => i);
    return new Set(parts.filter((i) => other && [0, 1, 2].some((k) => Math.abs(other[i][k] - first[i][k]) > FELT * STEP)));
  }

  function told({ at }) {
    // The values that are others than those of the fields, with as many digits as one can aim at.
    const pairs = Object.entries(at).map(([name, v]) => [name, Number(v.toPrecision(5))]);
    return Object.fromEntries(pairs.filter(([name, v]) => Math.abs(v - given(name)) > 1e-6 * Math.max(1, Math.abs(v))));
  }

  function go(patience) {
    const found = follow(hold, target, patience);
    if (!found) return;
    hold.at = found.at;
    latest = found.poses;
    show(latest);
    give(told(hold));
  }

  return {
    take(order) {
      // Whether there is anything to drag there.
      pull = order.shift ? stretch(order) : null;
      hold = pull ? null : held(order);
      begun = false;
      return Boolean(pull || hold);
    },
    move({ x, y }) {
      if (pull) return pull({ x, y });
      if (!hold) return undefined;
      if (!begun) grip();
      begun = true;
      target = [x, y];
      go(PATIENCE);
      return undefined;
    },
    leave() {
      if (begun) go(8 * PATIENCE);
      hold = pull = latest = null;
      if (begun) dropped();
      begun = false;
    },
    again() {
      // A run under way has drawn an older place.
      if (latest) show(latest);
    },
  };
};
