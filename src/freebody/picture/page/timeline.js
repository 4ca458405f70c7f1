"use strict";
// The contact modes as strips under the time bar, and marks of the events.

const MODE_COLORS = { open: "#e3e6ea", stick: "#0072B2", slip: "#E69F00" };
const ROWS = 6, ROW = 13;

// Draws the timeline of the contacts that touch, under the time bar as it was ``measured``; returns a function that moves its cursor to the time of the motion. Without events and contacts it
// draws nothing.
function timeline(root, measured, scene, motion, seek) {
  const { modes, events } = scene, first = motion.first, span = motion.last - motion.first || 1;
  if (!modes.length && !events.length) return () => {};
  const touching = modes.filter(({ spans }) => spans.some(([mode]) => mode !== "open"));
  const rows = (touching.length ? touching : modes).slice(0, ROWS), width = 1000, x = (t) => (width * (t - first)) / span;
  const box = element("div", { class: "timeline" }, root), names = element("div", { class: "names" }, box);
  const high = ROW * rows.length + 10;
  const svg = drawing("svg", { viewBox: `0 0 ${width} ${high}`, preserveAspectRatio: "none", style: `height:${high}px` }, box);
  const time = ({ clientX }) => {
    const r = svg.getBoundingClientRect();
    return first + (span * (clientX - r.left)) / r.width;
  };
  element("span", { style: "height:10px" }, names, "");
  rows.forEach(({ contact, spans }, i) => {
    element("span", { title: contact }, names, contact);
    for (const [mode, from, to, text] of spans) {
      const kind = mode.replace(/[+-]$/, ""), y = 10 + ROW * i;
      const bar = drawing("rect", { x: x(from), y: y + 2, width: Math.max(0.5, x(to) - x(from)), height: ROW - 4, fill: MODE_COLORS[kind] || "#999", class: `mode ${kind}` }, svg);
      drawing("title", {}, bar, text);
      // a white line along slip tells it from stick in print without colour
      if (kind === "slip") drawing("line", { x1: x(from), x2: x(to), y1: y + ROW / 2, y2: y + ROW / 2, stroke: "#fff", "stroke-dasharray": "6 4" }, svg);
    }
  });
  // one path for all events, which takes less time than many; the title is that of the nearest to the pointer
  const marks = events.slice(0, 400);
  if (marks.length) {
    const mark = drawing("path", { d: marks.map(([t]) => `M${x(t) - 4},0h8l-4,8z`).join(""), class: "mark" }, svg);
    const title = drawing("title", {}, mark, [...new Set(marks.map(([, text]) => text))].slice(0, 8).join("; "));
    mark.addEventListener("pointermove", (event) => {
      const at = time(event), [t, text] = marks.reduce((a, b) => (Math.abs(b[0] - at) < Math.abs(a[0] - at) ? b : a));
      title.textContent = text.startsWith("t =") ? text : `t = ${digits(t)} s: ${text}`;
    });
  }
  const cursor = drawing("line", { y1: 0, y2: high, class: "cursor" }, svg);
  if (rows.length) {
    const legend = element("div", { class: "key" }, root);
    const used = new Set(rows.flatMap(({ spans }) => spans.map(([mode]) => mode.replace(/[+-]$/, ""))));
    for (const [kind, color] of Object.entries(MODE_COLORS)) {
      if (!used.has(kind)) continue;
      const entry = element("span", {}, legend);
      const swatch = drawing("svg", { viewBox: "0 0 20 9", class: "swatch" }, entry);
      drawing("rect", { x: 0, y: 0, width: 20, height: 9, fill: color }, swatch);
      if (kind === "slip") drawing("line", { x1: 0, x2: 20, y1: 4.5, y2: 4.5, stroke: "#fff", "stroke-dasharray": "6 4" }, swatch);
      entry.append(` ${kind}`);
    }
    const more = modes.length - rows.length, stay = more > 1 ? "stay" : "stays";
    if (more) element("span", {}, legend, touching.length > ROWS ? `and ${more} more contacts` : `and ${more} that ${stay} open`);
  }
  const pick = (event) => seek(time(event));
  svg.addEventListener("pointerdown", (event) => (svg.setPointerCapture(event.pointerId), pick(event)));
  svg.addEventListener("pointermove", (event) => event.buttons & 1 && pick(event));
  let wide = 0;
  return () => {
    if (measured.slider && measured.slider !== wide) { // the strips stand under the time bar, the names to their left
      wide = measured.slider;
      names.style.width = `${Math.max(0, measured.left - 8)}px`;
      svg.style.width = `${wide}px`;
    }
    const at = x(motion.now);
    cursor.setAttribute("x1", at);
    cursor.setAttribute("x2", at);
  };
}

// Time and place of the first 100 impacts, for each contact that the text of an event names.
function impacts(motion, scene) {
  const struck = [], names = scene.touching.map(({ name }) => name);
  for (const [time, text] of scene.events) {
    const at = text.indexOf(": impact");
    const i = at < 0 ? -1 : names.indexOf(text.slice(0, at));
    if (i < 0 || struck.length >= 100) continue;
    let k = 0;
    while (k + 1 < motion.t.length && motion.t[k + 1] <= Math.fround(time)) k++;
    struck.push([time, Array.from(scene.touching[i].path.subarray(3 * k, 3 * k + 3))]);
  }
  return struck;
}
