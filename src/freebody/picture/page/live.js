"use strict";
// The live page: a slider that moves asks for a new motion, a text that is applied for a new machine. The server is the
// one that the page came from, on this computer.

(function () {
  const machine = JSON.parse(document.getElementById("scene").textContent);
  const at = (id) => document.getElementById(id);
  let shown = null, state = { values: {}, initial: {}, until: machine.until }, busy = false, waiting = false, starts = {};

  async function ask(what, data) {
    const answer = await fetch(what, {
      method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(data),
    });
    return answer.json();
  }
  function say(text) {
    at("problem").hidden = !text;
    at("problem").textContent = text;
  }
  // The new motion in the place of the old one, seen from where that was seen, at the time that it was at.
  function put({ scene, charts }, keep) {
    const old = shown && shown.state;
    const kept = shown && shown.dispose();
    at("player").replaceChildren();
    shown = player(at("player"), scene, { kept });
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
  // One request at a time; what moved meanwhile goes with the next.
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
        // what the model gives as an expression of this parameter follows it again
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
  // Sliders of the start that were not moved themselves show what the model's expressions give.
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
  function number(wrong = null) {
    const count = at("text").value.split("\n").length;
    at("lines").replaceChildren();
    for (let i = 1; i <= count; i++) element("span", i === wrong ? { class: "wrong" } : {}, at("lines"), `${i}\n`);
    at("lines").scrollTop = at("text").scrollTop;
  }
  function all(given) {
    document.title = at("name").textContent = given.name;
    at("equations").innerHTML = given.equations;
    at("text").value = given.text;
    state = { values: {}, initial: {}, until: given.until };
    sliders(given.sliders, given.until);
    number();
    put(given, false);
  }
  at("text").addEventListener("input", () => number());
  at("text").addEventListener("scroll", () => (at("lines").scrollTop = at("text").scrollTop));
  at("apply").addEventListener("click", async () => {
    const answer = await ask("model", { text: at("text").value });
    say(answer.error || "");
    if (answer.error) number(answer.line);
    else all(answer);
  });
  at("close").addEventListener("click", async () => {
    await ask("close", {});
    say("Closed. This page can be closed, too.");
  });
  all(machine);
})();
