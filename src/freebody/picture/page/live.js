"use strict";
// The live page: moving a slider requests a new motion, applying the text requests a new machine. The requests go to the
// server that the page came from, on this computer.

(function () {
  const machine = JSON.parse(document.getElementById("scene").textContent);
  const at = (id) => document.getElementById(id);
  let shown = null, state = { values: {}, initial: {}, until: machine.until }, busy = false, waiting = false, starts = {};

  async function ask(address, data) {
    const answer = await fetch(address, {
      method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(data),
    });
    return answer.json();
  }
  function say(text) {
    at("problem").hidden = !text;
    at("problem").textContent = text;
  }
  // Shows a new motion in place of the old one; with ``keep``, from the same eye and at the same time.
  function put({ scene, charts }, keep) {
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
    plots(at("charts"), scene, shown);
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
      const answer = await ask("motion", state);
      say(answer.error || "");
      if (!answer.error) {
        follow(answer.start);
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
  function sliders(list, until) {
    at("sliders").replaceChildren();
    const places = {};
    const all = [...list, { group: "", name: "until", value: until, low: until / 10, high: 4 * until, unit: "s", about: "length of the run", follows: [] }];
    for (const { group, name, value, low, high, unit, about, follows } of all) {
      const row = element("label", { class: "slider", title: about }, at("sliders"));
      element("span", {}, row, name);
      const range = element("input", { type: "range", min: low, max: high, step: "any", name }, row);
      const box = element("input", { type: "number", step: "any", "aria-label": name }, row);
      element("span", { class: "unit" }, row, unit);
      range.value = box.value = value;
      if (group === "initial") places[name] = { range, box, follows };
      const moved = (x) => {
        if (!Number.isFinite(x)) return;
        if (group) state[group][name] = x;
        else state.until = x;
        // initial values that the model gives as expressions of this parameter follow it again
        if (group === "values")
          for (const start in places) if (places[start].follows.includes(name)) delete state.initial[start];
        move();
      };
      range.addEventListener("input", () => {
        box.value = Number(Number(range.value).toPrecision(5));
        moved(Number(range.value));
      });
      box.addEventListener("change", () => {
        range.value = box.value;
        moved(Number(box.value));
      });
    }
    starts = places;
  }
  // Shows the values of the model's expressions at the sliders of initial values that the user has not moved.
  function follow(start) {
    for (const name in starts)
      if (starts[name].follows.length && !(name in state.initial)) {
        const { range, box } = starts[name];
        const x = Number(start[name].toPrecision(5));
        range.min = Math.min(range.min, x);
        range.max = Math.max(range.max, x);
        range.value = box.value = x;
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
  function showMachine(data) {
    document.title = at("name").textContent = data.name;
    at("equations").innerHTML = data.equations;
    at("text").value = data.text;
    state = { values: {}, initial: {}, until: data.until };
    sliders(data.sliders, data.until);
    number();
    put(data, false);
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
  showMachine(machine);
})();
