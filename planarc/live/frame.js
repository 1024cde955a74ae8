// The editor around the page, where there is one: what is clicked is told to it, and what its
// cursor is on is lit up.
//
//   from the editor   {type: "planarc/lit", component, dark}   component "" for none
//   to the editor     {type: "planarc/picked", component}
//
// The editor speaks first, and only it is answered: the window around this one.

planarc.createFrame = function () {
  let origin = null;
  let lit = "";
  let player = null;

  if (window.parent !== window && document.body.classList.contains("framed")) {
    addEventListener("message", (event) => {
      if (event.source !== window.parent || event.data?.type !== "planarc/lit") return;
      origin = event.origin;
      if (typeof event.data.dark === "boolean") planarc.theme.set(event.data.dark ? "dark" : "light");
      if (typeof event.data.component !== "string") return;
      lit = event.data.component;
      player?.light(lit);
    });
  }

  function show(made) {
    player = made;
    player.light(lit);
    const canvas = player.picture();
    const under = (event) => origin !== null && player.pick(event.clientX, event.clientY);
    let pressed = null;
    canvas.addEventListener("pointerdown", (event) => { pressed = event; });
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons === 0) canvas.style.cursor = under(event) ? "pointer" : "";
    });
    canvas.addEventListener("pointerup", (event) => {
      // A picture that was moved was not clicked.
      const moved = !pressed || Math.hypot(event.clientX - pressed.clientX, event.clientY - pressed.clientY) > 4;
      const component = !moved && under(event);
      if (component) window.parent.postMessage({ type: "planarc/picked", component }, origin);
    });
  }

  return { show };
};
