// What a served page asks of its server: runs, files, where a dragged part goes, and the news that
// the file of the model was edited. `live.js` knows it as `planarc.source`.

planarc.source = (() => {
  const page = Array.from(crypto.getRandomValues(new Uint8Array(8)), (b) => b.toString(16).padStart(2, "0")).join("");
  const frame = planarc.createFrame();

  function post(place, body, signal) {
    return fetch(place, {
      method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ page, ...body }), signal,
    });
  }

  function follow({ edited, ended }) {
    const events = new EventSource(`events?page=${page}`);
    events.addEventListener("edited", edited);
    events.addEventListener("end", () => {
      events.close();
      ended();
    });
    addEventListener("pagehide", () => navigator.sendBeacon("leave", page));
  }

  return {
    run: async (order, signal) => (await post("run", order, signal)).json(),
    file: (name, order) => post(name, { ...order, page: `${page}-file` }),
    drag: (options) => planarc.createDrag(page, options),
    show: (player) => frame.show(player),
    follow,
    lost: "planarc does not answer any more: start `planarc serve` again and open its new address",
  };
})();
