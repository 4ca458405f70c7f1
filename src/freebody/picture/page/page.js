"use strict";
// Puts the player and the charts into the page. A fragment such as #t=1.5&forces=1&play=1 sets them at the start.

(function () {
  const scene = JSON.parse(document.getElementById("scene").textContent);
  const asked = new URLSearchParams(location.hash.slice(1));
  const shown = player(document.getElementById("player"), scene, { flat: asked.get("flat") === "1" });
  const units = Object.fromEntries(Object.entries(scene.channels).map(([key, { unit }]) => [key, unit]));
  const seek = (time) => {
    shown.pause();
    shown.seek(time);
  };
  // a chart is drawn when it is opened
  for (const place of document.querySelectorAll("[data-chart]")) {
    const spec = scene.charts[Number(place.dataset.chart)];
    const fold = place.closest("details");
    let update = null;
    const open = () => {
      if (update || !fold.open) return;
      update = chart(place, shown.motion, spec, units, scene.events, seek);
      shown.listen(() => fold.open && update());
      update();
    };
    fold.addEventListener("toggle", () => (open(), update && update()));
    open();
  }
  for (const [name, value] of Object.entries(scene.shown || {})) shown.show(name, value);
  for (const [name, value] of asked)
    if (name === "t") shown.seek(Number(value));
    else if (name === "speed") shown.pace(Number(value));
    else if (name === "view") shown.look(value);
    else if (name !== "play" && name !== "flat") shown.show(name, value === "1");
  if (asked.get("play") === "1") shown.play();
  window.freebody = shown;
})();
