// The events of a run, in words; a click goes there. And how much drives and joints carry.
//
//   planarc.listEvents(element, [[time, text]], (t) => player.setTime(t));
//   planarc.listPeaks(element, [[name, unit, value, time, rms]]);

const MOST = 1000; // that are listed

planarc.listEvents = function (element, events, seek) {
  const { element: make } = planarc;
  element.replaceChildren(...events.slice(0, MOST).map(([t, text]) => make(
    "li", {},
    make("button", { type: "button", class: "link", onclick: () => seek(t) }, `${Number(t.toPrecision(6))} s`),
    make("span", {}, ...planarc.spoken(text)),
  )));
};

planarc.listPeaks = function (element, peaks) {
  const { element: make, digits } = planarc;
  const heads = ["peak", "at s", "RMS"].map((text) => make("th", { scope: "col" }, text));
  element.replaceChildren(make("tr", {}, make("td"), ...heads, make("td")), ...peaks.map(([name, unit, value, time, rms]) => make(
    "tr", {}, make("th", { scope: "row" }, name),
    ...[digits(value), digits(time, 3), digits(rms), planarc.unit(unit)].map((text) => make("td", {}, text)),
  )));
};
