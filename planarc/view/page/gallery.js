// Many small players: those in sight move, a click holds one.

(() => {
  const get = (id) => document.getElementById(id);
  const scenes = JSON.parse(get("data").textContent);
  const players = new Map();
  let moving = !window.matchMedia("(prefers-reduced-motion: reduce)").matches;

  const watch = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      const entry = players.get(target);
      entry.seen = isIntersecting;
      entry.player.play(moving && isIntersecting && !entry.held);
    }
  });
  for (const place of document.querySelectorAll("[data-scene]")) {
    const scene = scenes[Number(place.dataset.scene)];
    const entry = { player: planarc.createPlayer(place, scene, { bare: true }), seen: false, held: false };
    players.set(place, entry);
    place.addEventListener("click", () => {
      entry.held = entry.player.playing;
      entry.player.play(!entry.held);
    });
    watch.observe(place);
  }
  window.planarcPlayers = [...players.values()].map((entry) => entry.player);

  const pause = get("pause");
  function dress() {
    const title = moving ? "Hold all" : "Let all move";
    pause.title = title;
    pause.setAttribute("aria-label", title);
    pause.replaceChildren(planarc.icon(moving ? "pause" : "play"));
  }
  pause.addEventListener("click", () => {
    moving = !moving;
    dress();
    for (const entry of players.values()) {
      entry.held = false;
      entry.player.play(moving && entry.seen);
    }
  });
  dress();
  const themes = get("theme");
  themes.append(planarc.icon("theme"));
  themes.addEventListener("click", () => planarc.theme.set(planarc.theme.isDark() ? "light" : "dark"));
})();
