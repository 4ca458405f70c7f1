"use strict";
// Sliders for parameters, initial values and the length of the run, and the control of a page that computes its motion.

// A number to five digits; with an exponent if it is longer than a box.
const short = (x) => (String((x = Number(x.toPrecision(5)))).length <= 10 ? String(x) : x.toExponential());

// Makes sliders, whose names are set as ``symbols``. ``state`` holds the values that the user chose, ``moved`` is called when one changes.
function sliders(root, list, length, symbols, moved) {
  const state = { values: {}, initial: {}, until: length }, places = {}, resets = [];
  root.replaceChildren();
  const run = { group: "", name: "until", value: length, low: length / 10, high: 4 * length, unit: "s", about: "length of the run", follows: [] };
  const folds = {};
  for (const { group, name, value, low, high, unit, about, follows, fold } of [...list, run]) {
    if (fold && !folds[fold]) element("summary", {}, (folds[fold] = element("details", {}, root)), fold);
    const row = element("label", { class: "slider", title: about }, fold ? folds[fold] : root);
    symbol(element("span", { class: "name" }, row), symbols, name);
    const step = ticks(0, high - low, 250)[1], least = low > 0 ? Math.max(1, Math.round(low / step)) : Math.floor(low / step);
    const range = element("input", { type: "range", min: least * step, max: Math.ceil(high / step) * step, step, name }, row);
    const box = element("input", { type: "number", step: "any", "aria-label": `${name}, number` }, row);
    const tail = element("span", { class: "unit" }, row, unit);
    const show = (x) => {
      range.min = Math.min(range.min, x);
      range.max = Math.max(range.max, x);
      range.value = x;
      box.value = short(x);
    };
    show(value);
    if (group === "initial") places[name] = { show, follows, tail };
    const set = (x) => {
      if (!Number.isFinite(x) || (!group && !(x > 0))) return;
      if (group) state[group][name] = x;
      else state.until = x;
      // initial values that the model gives as expressions of this parameter follow it again
      if (group === "values")
        for (const start in places) if (places[start].follows.includes(name)) delete state.initial[start];
      moved();
    };
    // a step of a range that is zero is read as the round-off of its sum
    const chosen = () => (Math.abs(range.value) < 1e-12 * (range.max - range.min) ? 0 : Number(range.value));
    range.addEventListener("input", () => {
      box.value = short(chosen());
      set(chosen());
    });
    box.addEventListener("change", () => {
      show(Number(box.value));
      set(Number(box.value));
    });
    resets.push(() => show(value));
  }
  return {
    state,
    // Shows the values of the model's expressions at the sliders of initial values that the user has not moved.
    follow(start) {
      for (const name in start)
        if (places[name] && places[name].follows.length && !(name in state.initial)) places[name].show(start[name]);
    },
    // Shows the forces that would hold the machine at rest in the position of the start, beside its coordinates; none
    // where it stays by itself.
    hold(units, forces) {
      const least = 1e-9 * Math.max(...forces.map(Math.abs), 0);
      Object.entries(units).forEach(([name, unit], k) => {
        const place = places[name];
        if (!place) return;
        place.unit ??= place.tail.textContent;
        const force = least && `${written(Math.abs(forces[k]) <= least ? 0 : Number(forces[k].toPrecision(3)))} ${unit}`;
        if (force === place.force) return; // what is written again is laid out again
        place.force = force;
        place.tail.title = "";
        if (!least) return place.tail.replaceChildren(place.unit);
        place.tail.replaceChildren(place.unit, " ");
        element("small", {}, place.tail, force);
        place.tail.title = `${force} holds the machine at rest with this ${name}`;
      });
    },
    reset() {
      Object.assign(state, { values: {}, initial: {}, until: length });
      for (const reset of resets) reset();
      moved();
    },
  };
}

const write = (place, text) => place.textContent === text || (place.textContent = text);

// Shows a text beside the sliders, or none.
function say(text) {
  const place = document.getElementById("problem");
  place.hidden = !text;
  place.textContent = text;
}

// Lets the sliders of a page change its motion. Until one moves, the page shows the motion that was recorded. Returns
// whether the page may compute (WebAssembly may be forbidden).
async function control(scene, shown, redraw) {
  const at = (id) => document.getElementById(id), live = scene.live, data = document.documentElement.dataset;
  let machine = null, busy = false, moved = false;
  try {
    machine = await simulator(live, scene);
  } catch (error) {
    return false;
  }
  const cells = [...document.querySelectorAll("[data-answer]")].map((cell) => [cell, live.answers.indexOf(cell.dataset.answer)]);
  const panel = sliders(at("sliders"), live.sliders, live.length, scene.symbols, move);
  at("reset").hidden = false;
  at("reset").onclick = () => panel.reset();
  if (Object.keys(live.holding).length) panel.hold(live.holding, machine.run(panel.state).answers.slice(live.answers.length));
  // Computes at once, not first when the next frame begins, and once more in a frame if a slider has moved meanwhile.
  function move() {
    moved = true;
    if (busy) return;
    busy = true;
    update();
    requestAnimationFrame(() => {
      busy = false;
      if (moved) move();
    });
  }
  function update() {
    const begun = performance.now();
    moved = false;
    const { problem, steps, start, answers, scene: next, shaped } = machine.run(panel.state);
    say(problem + (problem && !next ? " The picture is that of the setting before." : ""));
    if (next) {
      shown.take(next, shaped);
      redraw(next);
      panel.follow(start);
      panel.hold(live.holding, answers.slice(live.answers.length));
      for (const [cell, place] of cells) {
        if (place >= 0) write(cell, written(Number(answers[place].toPrecision(8))));
        else cell.classList.add("fixed"), (cell.title = "of the recorded motion");
      }
    }
    const time = performance.now() - begun;
    at("work").textContent = next ? `${steps} steps, ${time.toFixed(1)} ms` : "";
    data.motions = Number(data.motions || 0) + 1;
    data.milliseconds = time;
  }
  return true;
}
