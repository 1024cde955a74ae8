// The tree: it opens at the class that is shown, and a search finds classes by name and by what
// they say of themselves. The class that is shown moves where a model of it is known, and its
// source text is unpacked.
(() => {
  const tree = document.querySelector("nav .tree");
  const search = document.querySelector("nav input");
  const found = document.querySelector("nav .found");
  const links = [...tree.querySelectorAll("a")].map((link) => ({
    link, name: decodeURIComponent(link.hash.slice(1)), about: link.title.toLowerCase(),
  }));
  const MOST = 60;

  function open() {
    const here = decodeURIComponent(location.hash.slice(1));
    for (const { link, name } of links) {
      if (name !== here) {
        link.removeAttribute("aria-current");
        continue;
      }
      link.setAttribute("aria-current", "page");
      for (let box = link.closest("details"); box; box = box.parentElement.closest("details")) box.open = true;
      link.scrollIntoView({ block: "nearest" });
    }
  }

  function reach() {
    // What scrolls sideways is reached by keys, too.
    for (const text of document.querySelectorAll("main pre")) {
      if (text.scrollWidth > text.clientWidth) text.tabIndex = 0;
    }
  }

  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  const unpacked = {};

  function texts(kind) {
    return (unpacked[kind] ??= unpack(kind));
  }

  async function unpack(kind) {
    const packed = atob(document.querySelector(`template.${kind}`).content.textContent);
    const bytes = Uint8Array.from(packed, (letter) => letter.charCodeAt(0));
    const whole = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Response(whole).json();
  }

  function shown(what) {
    // By name: while the page is loaded, nothing is the target yet.
    const named = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    return (named ?? document.querySelector("section.start"))?.querySelector(what);
  }

  async function write() {
    // The source text of the class that is shown; its colours are elements that planarc wrote.
    const place = shown("[data-source]");
    if (!place || place.firstChild) return;
    place.innerHTML = (await texts("sources"))[place.dataset.source];
    reach();
  }

  async function move() {
    // The class that is shown moves; a click holds it.
    const button = shown("[data-motion]");
    const place = button?.firstElementChild;
    if (!place || place.shadowRoot) return;
    const root = place.attachShadow({ mode: "open" });
    const text = (await texts("pictures"))[button.dataset.motion];
    const svg = new DOMParser().parseFromString(text, "image/svg+xml").documentElement;
    root.append(svg);
    if (still) svg.pauseAnimations();
    button.addEventListener("click", () => {
      if (svg.animationsPaused()) svg.unpauseAnimations();
      else svg.pauseAnimations();
    });
    button.parentElement.hidden = false;
  }

  // Contents show the icons of their classes, small.
  for (const link of document.querySelectorAll("table.contents a")) {
    const icon = document.getElementById(decodeURIComponent(link.hash.slice(1)))?.querySelector(".head svg.icon");
    if (icon) link.closest("tr").firstElementChild.append(icon.cloneNode(true));
  }

  // A link tells the full name of its class.
  for (const link of document.querySelectorAll('main a[href^="#"]')) link.title = decodeURIComponent(link.hash.slice(1));

  function rank({ name, about }, words) {
    // Lower is nearer: the last name begins so, holds it, the full name does, the description does.
    const full = name.toLowerCase();
    const last = full.slice(full.lastIndexOf(".") + 1);
    const ranks = words.map((word) => (last.startsWith(word) ? 0 : last.includes(word) ? 1
      : full.includes(word) ? 2 : about.includes(word) ? 3 : Infinity));
    return Math.max(...ranks);
  }

  function look() {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    tree.hidden = words.length > 0;
    found.hidden = !words.length;
    if (!words.length) return;
    const hits = links.map((entry) => [rank(entry, words), entry])
      .filter(([order]) => order < Infinity)
      .sort((a, b) => a[0] - b[0] || a[1].name.length - b[1].name.length);
    found.replaceChildren(...hits.slice(0, MOST).map(([, { link, name }]) => {
      const row = document.createElement("div");
      const copy = document.createElement("a");
      copy.href = link.hash;
      copy.textContent = name.slice(name.lastIndexOf(".") + 1);
      copy.title = link.title;
      const where = document.createElement("small");
      where.textContent = name.slice(0, Math.max(0, name.lastIndexOf(".")));
      row.append(copy, where);
      return row;
    }));
    if (!hits.length) found.textContent = "nothing found";
  }

  search.addEventListener("input", look);
  search.addEventListener("keydown", (event) => {
    if (event.key === "Escape") search.value = "";
    else if (event.key === "Enter") found.querySelector("a")?.click();
    else return;
    look();
  });
  addEventListener("hashchange", () => {
    open();
    reach();
    write();
    move();
  });
  addEventListener("resize", reach);
  open();
  reach();
  write();
  move();
})();
