"use strict";
// The page of ``freebody view``. Moving a slider computes a new motion, in the page if it can, else by a request; applying
// the text requests a new machine. The requests go to the server that the page came from, on this computer.

(async function () {
  const machine = await unpacked(document.getElementById("scene").textContent);
  const at = (id) => document.getElementById(id);
  let shown = null, redraw = null, panel = null, busy = false, waiting = false;

  async function ask(address, data) {
    const answer = await fetch(address, {
      method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(data),
    });
    return unpacked(await answer.text());
  }
  // Shows a new motion in place of the old one; with ``keep``, from the same eye and at the same time.
  function put({ scene, charts, glyphs }, keep) {
    at("glyphs").innerHTML = glyphs;
    const old = shown && shown.state;
    const canvases = shown && shown.dispose();
    at("player").replaceChildren();
    shown = player(at("player"), scene, { canvases });
    if (old && keep) shown.restore(old);
    const open = new Set([...at("charts").querySelectorAll("details[open] summary")].map((x) => x.textContent));
    at("charts").innerHTML = charts;
    if (keep)
      for (const fold of at("charts").querySelectorAll("details"))
        fold.open = open.has(fold.querySelector("summary").textContent);
    redraw = plots(at("charts"), scene, shown);
    window.freebody = shown;
    document.documentElement.dataset.motions = Number(document.documentElement.dataset.motions || 0) + 1;
  }
  // Sends one request at a time; changes made meanwhile go with the next request.
  async function move() {
    if (busy) {
      waiting = true;
      return;
    }
    busy = true;
    try {
      const answer = await ask("motion", panel.state);
      say(answer.error || "");
      if (!answer.error) {
        panel.follow(answer.start);
        put(answer, true);
      }
    } catch (error) {
      say("The program that made this page has ended.");
    }
    busy = false;
    if (waiting) {
      waiting = false;
      move();
    }
  }
  // Numbers the lines of the text, and marks a wrong line.
  function number(wrong = null) {
    const count = at("text").value.split("\n").length;
    at("lines").replaceChildren();
    for (let i = 1; i <= count; i++) element("span", i === wrong ? { class: "wrong" } : {}, at("lines"), `${i}\n`);
    at("lines").scrollTop = at("text").scrollTop;
  }
  // Shows a machine.
  async function showMachine(data) {
    document.title = at("name").textContent = data.name;
    at("equations").innerHTML = data.equations;
    copyable(at("equations"));
    at("text").value = data.text;
    number();
    put(data, false);
    if (data.scene.live && (await control(data.scene, shown, redraw))) return;
    panel = sliders(at("sliders"), data.sliders, data.until, data.scene.symbols, move);
    at("reset").hidden = false;
    at("reset").onclick = () => panel.reset();
  }
  at("text").addEventListener("input", () => number());
  at("text").addEventListener("scroll", () => (at("lines").scrollTop = at("text").scrollTop));
  at("apply").addEventListener("click", async () => {
    const answer = await ask("model", { text: at("text").value });
    say(answer.error || "");
    if (answer.error) number(answer.line);
    else showMachine(answer);
  });
  at("close").addEventListener("click", async () => {
    await ask("close", {});
    say("Closed. You can close this page, too.");
  });
  await showMachine(machine);
})().finally(() => (document.documentElement.dataset.begun = 1));
