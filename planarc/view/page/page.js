// The page of one run: joins player, curves, variables and events by one time.

(() => {
  const get = (id) => document.getElementById(id);
  const data = JSON.parse(get("data").textContent);

  const themes = get("theme");
  themes.append(planarc.icon("theme"));
  themes.addEventListener("click", () => planarc.theme.set(planarc.theme.isDark() ? "light" : "dark"));

  let tree = null;
  const player = planarc.createPlayer(get("player"), data.scene, { keys: document });
  window.planarcPlayer = player;
  const plots = planarc.createPlots(get("plots"), data.curves, {
    seek: (t) => player.setTime(t),
    changed: (names) => tree && tree.check(names),
  });
  const runs = planarc.createRuns(get("runs"), {
    changed: (shown, name) => {
      player.setGhosts(shown);
      plots.setRuns(shown, name);
    },
  });
  runs.name(data.label);
  for (const run of data.runs) runs.add(run);
  window.planarcPlots = plots;
  tree = planarc.createTree(get("tree"), plots.variables, { toggle: plots.toggle });
  player.onTime((t, reader) => {
    plots.mark(t, reader);
    if (get("variables").open) tree.mark(reader);
  });
  get("variables").addEventListener("toggle", () => {
    player.reader.seek(player.time);
    tree.mark(player.reader, true);
  });

  planarc.createCard(player, {
    variables: () => plots.variables,
    classes: () => data.scene.classes,
    picked: (component, curves) => curves.forEach((name) => plots.toggle(name, true)),
  });

  const picture = get("picture");
  picture.append(planarc.icon("picture"));
  picture.addEventListener("click", () => player.picture().toBlob((blob) => planarc.download(`${data.name}.png`, blob)));

  const events = get("events");
  if (events) planarc.listEvents(events, data.events, player.setTime);
})();
