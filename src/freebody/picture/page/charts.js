"use strict";
// Quantities over time as SVG, with a cursor at the time of the animation; a click or a drag moves the time.

const COLORS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#8a6d00", "#3b8ea5"];
const DASHES = ["", "7 3", "2 3", "9 3 2 3", "12 4", "4 2"];
const WRITTEN = ["#0072B2", "#b34f00", "#00735a", "#a0447a", "#7a6000", "#2a6f84"]; // the same, dark enough to be read
const TELEPHONE = matchMedia("(max-width: 580px)"); // to ask for the width of an element would lay out the page
const HEIGHT = 230, LEFT = 62, TOP = 26, BOTTOM = 34;

// Draws a chart; returns a function that moves its cursor to the time of the motion.
function chart(root, motion, spec, units, { events, symbols, breaks = [] }, seek) {
  // on a narrow screen a chart is narrower, not smaller, and its curves have their names below it only
  const narrow = TELEPHONE.matches, WIDTH = narrow ? 400 : 720, RIGHT = narrow ? 14 : 100;
  const area = element("div", { class: "plot" }, root);
  const svg = drawing("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "chart", role: "img" }, area);
  drawing("title", {}, svg, spec.title);
  const curves = spec.curves.map(([key, component, label]) => ({ ...motion.channels[key], component, label, unit: units[key] }));
  let low = Infinity, high = -Infinity;
  for (const { values, width, component } of curves)
    for (let i = component; i < values.length; i += width) {
      if (!Number.isFinite(values[i])) continue; // no distance
      low = Math.min(low, values[i]);
      high = Math.max(high, values[i]);
    }
  if (low > high) [low, high] = [0, 0];
  if (!(high - low > Math.max(1e-6 * Math.max(Math.abs(low), Math.abs(high)), spec.least || 0))) {
    const room = Math.max(0.5 * Math.max(Math.abs(low), Math.abs(high)), spec.least || 0) || 1;
    [low, high] = [low - room, high + room];
  }
  const margin = 0.05 * (high - low);
  [low, high] = [low - margin, high + margin];
  const first = motion.first, span = motion.last - motion.first || 1;
  const x = (t) => LEFT + ((WIDTH - LEFT - RIGHT) * (t - first)) / span;
  const y = (v) => HEIGHT - BOTTOM - ((HEIGHT - TOP - BOTTOM) * (v - low)) / (high - low);
  const rungs = ticks(low, high, 5), power = common(rungs), times = ticks(first, motion.last, 8), pace = common(times);
  for (const v of rungs) {
    drawing("line", { x1: LEFT, x2: WIDTH - RIGHT, y1: y(v), y2: y(v), class: "grid" }, svg);
    drawing("text", { x: LEFT - 7, y: y(v) + 4, "text-anchor": "end" }, svg, number(v, power));
  }
  for (const t of times) {
    drawing("line", { x1: x(t), x2: x(t), y1: HEIGHT - BOTTOM, y2: HEIGHT - BOTTOM + 4, class: "axis" }, svg);
    drawing("text", { x: x(t), y: HEIGHT - BOTTOM + 16, "text-anchor": "middle" }, svg, number(t, pace));
  }
  drawing("line", { x1: LEFT, x2: WIDTH - RIGHT, y1: HEIGHT - BOTTOM, y2: HEIGHT - BOTTOM, class: "axis" }, svg);
  drawing("text", { x: (LEFT + WIDTH - RIGHT) / 2, y: HEIGHT - 4, "text-anchor": "middle" }, svg, `time ${measure("s", pace)}`);
  if (events.length) { // ticks above the time axis; the timeline tells them apart
    const places = [];
    for (const [t] of events) // thinned: not closer than three pixels
      if (!(x(t) - places[places.length - 1] < 3)) places.push(Math.round(10 * x(t)) / 10);
    const mark = drawing("path", { d: places.map((at) => `M${at},${HEIGHT - BOTTOM}v-6`).join(""), class: "event" }, svg);
    drawing("title", {}, mark, [...new Set(events.map(([, name]) => name))].slice(0, 8).join("; "));
  }
  const unit = curves.every((curve) => curve.unit === curves[0].unit) && curves[0].unit;
  if (power || (unit && unit !== "1")) drawing("text", { x: 4, y: 15 }, svg, measure(unit && unit !== "1" ? unit : "", power));
  const labels = curves.map((curve, i) => {
    const finite = (k) => Number.isFinite(curve.values[k * curve.width + curve.component]), all = motion.t.length;
    const missing = Array.from({ length: all - 1 }, (_, k) => k + 1).filter((k) => finite(k) !== finite(k - 1));
    const ends = [...new Set([0, ...breaks, ...missing, all])].sort((a, b) => a - b); // no line runs through a jump
    for (let n = 0; n + 1 < ends.length; n++) {
      if (!finite(ends[n])) continue;
      const points = thinned(ends[n], ends[n + 1], (k) => x(motion.t[k]), (k) => y(curve.values[k * curve.width + curve.component]));
      drawing("polyline", { points, stroke: COLORS[i], "stroke-dasharray": DASHES[i], class: "curve" }, svg);
    }
    return curve.label;
  });
  // each curve has its name at its end; names that would meet are moved apart
  const final = ({ values, width, component }) => values.filter((x, k) => k % width === component && Number.isFinite(x)).at(-1) ?? low;
  const ends = curves.map((curve, i) => [i, y(final(curve))]).sort((a, b) => a[1] - b[1]);
  const apart = 15, least = TOP, most = HEIGHT - BOTTOM;
  for (let k = 0; k < ends.length; k++) ends[k][1] = Math.max(ends[k][1], k ? ends[k - 1][1] + apart : least);
  for (let k = ends.length - 1; k >= 0; k--) ends[k][1] = Math.min(ends[k][1], k + 1 < ends.length ? ends[k + 1][1] - apart : most);
  for (const [i, height] of narrow || curves.length < 2 ? [] : ends) {
    const place = `left:${(100 * (WIDTH - RIGHT + 5)) / WIDTH}%;top:${(100 * height) / HEIGHT}%;color:${WRITTEN[i]};font-size:${1200 / WIDTH}cqw`;
    symbol(element("span", { class: "end", style: place, "aria-hidden": "true" }, area), symbols, labels[i]);
  }
  const cursor = drawing("line", { y1: TOP, y2: HEIGHT - BOTTOM, class: "cursor" }, svg);
  const dots = curves.map((_, i) => drawing("circle", { r: 3.2, fill: COLORS[i] }, svg));
  const legend = element("div", { class: "legend" }, root);
  const readings = labels.map((label, i) => {
    const entry = element("span", {}, legend);
    const swatch = drawing("svg", { viewBox: "0 0 28 8", class: "swatch" }, entry);
    drawing("line", { x1: 0, x2: 28, y1: 4, y2: 4, stroke: COLORS[i], "stroke-dasharray": DASHES[i], class: "curve" }, swatch);
    entry.append(" ");
    symbol(entry, symbols, label);
    entry.append(" = ");
    return element("output", {}, entry);
  });
  const pick = (event) => {
    const box = svg.getBoundingClientRect();
    const at = ((event.clientX - box.left) / box.width) * WIDTH;
    seek(first + (span * (at - LEFT)) / (WIDTH - LEFT - RIGHT));
  };
  svg.addEventListener("pointerdown", (event) => {
    svg.setPointerCapture(event.pointerId);
    pick(event);
  });
  svg.addEventListener("pointermove", (event) => event.buttons & 1 && pick(event));
  return () => {
    const at = x(motion.now);
    cursor.setAttribute("x1", at);
    cursor.setAttribute("x2", at);
    curves.forEach((curve, i) => {
      const value = motion.vector(curve.values, curve.width)[curve.component];
      dots[i].setAttribute("visibility", Number.isFinite(value) ? "visible" : "hidden");
      if (!Number.isFinite(value)) return (readings[i].textContent = "none");
      dots[i].setAttribute("cx", at);
      dots[i].setAttribute("cy", y(value));
      readings[i].textContent = `${written(value.toPrecision(5))} ${curve.unit === "1" ? "" : curve.unit}`;
    });
  };
}

// Points of a curve as text, without those that a line between others passes within a quarter of a pixel: each new point narrows the
// directions that a line from the last one kept may have (Reumann and Witkam, 1974).
function thinned(from, to, x, y) {
  const kept = [], keep = (u, v) => kept.push(`${Math.round(10 * u) / 10},${Math.round(10 * v) / 10}`);
  let u = x(from), v = y(from), least = -Infinity, most = Infinity, lastU = u, lastV = v;
  keep(u, v);
  for (let k = from + 1; k < to; k++) {
    const nextU = x(k), nextV = y(k);
    let slope = (nextV - v) / (nextU - u);
    if (!(nextU - u > 0) || slope < least || slope > most) {
      keep(lastU, lastV);
      [u, v, least, most] = [lastU, lastV, -Infinity, Infinity];
      slope = (nextV - v) / (nextU - u);
    }
    const room = 0.25 / Math.max(nextU - u, 1e-3);
    [least, most] = [Math.max(least, slope - room), Math.min(most, slope + room)];
    [lastU, lastV] = [nextU, nextV];
  }
  keep(lastU, lastV);
  return kept.join(" ");
}

// Draws each chart of a page when it is opened, with its cursor at the time of the player. Returns a function that draws
// the open ones again for another motion; those out of sight wait until they come into sight, or are printed.
function plots(root, scene, shown) {
  const units = Object.fromEntries(Object.entries(scene.channels).map(([key, { unit }]) => [key, unit]));
  const seek = (time) => {
    shown.pause();
    shown.seek(time);
  };
  const charts = [...root.querySelectorAll("[data-chart]")].map((place) => ({ place, fold: place.closest("details"), update: null, seen: true }));
  const open = (one) => {
    if (!one.fold.open) return;
    if (!one.update) {
      one.place.replaceChildren();
      one.update = chart(one.place, shown.motion, scene.charts[Number(one.place.dataset.chart)], units, scene, seek);
    }
    one.update();
  };
  const sight = new IntersectionObserver((changes) => {
    for (const { target, isIntersecting } of changes) {
      const one = charts.find(({ fold }) => fold === target);
      one.seen = isIntersecting;
      if (one.seen) open(one);
    }
  }, { rootMargin: "300px" });
  for (const one of charts) {
    shown.listen(() => one.update && open(one));
    one.fold.addEventListener("toggle", () => open(one));
    open(one);
    sight.observe(one.fold);
  }
  window.addEventListener("beforeprint", () => charts.forEach(open), { signal: shown.signal });
  return (next) => {
    scene = next;
    for (const one of charts) {
      one.update = null;
      if (one.seen) open(one);
    }
  };
}

function drawing(tag, attributes, parent, text = "") {
  const result = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) if (value !== "") result.setAttribute(name, value);
  if (text) result.textContent = text;
  parent.append(result);
  return result;
}

// About ``count`` round numbers between two numbers.
function ticks(low, high, count) {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((k) => k * power >= rough), result = [];
  for (let i = Math.ceil(low / step); i * step <= high + 1e-9 * step; i++) result.push(i * step);
  return result;
}

// The power of ten that the numbers at an axis leave to its unit: of the largest if it is above 10^5 or below 10^-3, else 0.
function common(list) {
  const size = Math.max(...list.map(Math.abs));
  return size !== 0 && (size < 1e-3 || size >= 1e5) ? Math.floor(Math.log10(size) + 1e-9) : 0;
}

// Text of a tick, without round-off in its last digits and without the common power of ten.
const number = (x, power) => String(Number((power ? x / 10 ** power : x).toPrecision(6))).replace("-", "−");

// What the numbers at an axis are to be multiplied with.
const measure = (unit, power) => `[${[power ? written(`1e${power}`) : "", unit].filter(Boolean).join(" ")}]`;
