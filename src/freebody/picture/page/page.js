"use strict";
// Puts the player and the charts into the page. A fragment such as #t=1.5&forces=1&play=1 sets them at the beginning.

(async function () {
  const scene = await unpacked(document.getElementById("scene").textContent);
  const options = new URLSearchParams(location.hash.slice(1));
  const shown = player(document.getElementById("player"), scene, { flat: options.get("flat") === "1" });
  const redraw = plots(document, scene, shown);
  for (const [name, value] of Object.entries(scene.shown || {})) shown.show(name, value);
  for (const [name, value] of options)
    if (name === "t") shown.seek(Number(value));
    else if (name === "speed") shown.pace(Number(value));
    else if (name === "view") shown.look(value);
    else if (name !== "play" && name !== "flat") shown.show(name, value === "1");
  if (options.get("play") === "1") shown.play();
  window.freebody = shown;
  if (scene.live)
    control(scene, shown, redraw).then((may) => may || say("WebAssembly is not allowed here, so that this page has no sliders. It shows the recorded motion."));
})().finally(() => (document.documentElement.dataset.begun = 1));
