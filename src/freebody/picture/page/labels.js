"use strict";
// Places of texts over the picture: each beside its point, on no other text and on no head of an arrow; of those places the cheapest by its
// distance, its direction, and the lines and bodies that it covers. A text keeps the place that it had where another is hardly better, so that it does not jump
// while the machine moves. A text without such a place is not
// written, nor is one whose point is outside the picture.

const AROUND = Array.from({ length: 16 }, (_, k) => [Math.cos((Math.PI * k) / 8), Math.sin((Math.PI * k) / 8)]);
const AWAY = [3, 8, 15, 24, 36, 50, 68, 90, 116]; // from the point to the text [pixels]
const LEADING = 24; // distance from which a line leads to the text [pixels]
const KEPT = 12, ACROSS = 25, OVER = 90; // gain of the place before; costs of a line and of a body below the text [pixels of distance]

const meet = (a, b, gap = 0) => a[0] < b[2] + gap && b[0] < a[2] + gap && a[1] < b[3] + gap && b[1] < a[3] + gap;

// Whether the segment from p to q goes through a box [left, top, right, bottom].
function crosses([x, y], [u, v], box) {
  let from = 0, to = 1;
  for (const [at, way, low, high] of [[x, u - x, box[0], box[2]], [y, v - y, box[1], box[3]]]) {
    if (way === 0 && (at < low || at > high)) return false;
    if (way === 0) continue;
    const a = (low - at) / way, b = (high - at) / way;
    from = Math.max(from, Math.min(a, b));
    to = Math.min(to, Math.max(a, b));
  }
  return from < to;
}

// The corners of the convex hull of points on paper, in order (Andrew, 1979).
function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]), left = (o, a, b) => (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
  const half = (list) => list.reduce((chain, p) => {
    while (chain.length > 1 && left(chain[chain.length - 2], chain[chain.length - 1], p) <= 0) chain.pop();
    return [...chain, p];
  }, []).slice(0, -1);
  return [...half(sorted), ...half(sorted.reverse())];
}

// Whether a convex polygon and a box have a point in common: no side of one of them lies between them.
function covers(polygon, box) {
  if (polygon.length < 3) return false;
  const corners = [[box[0], box[1]], [box[2], box[1]], [box[2], box[3]], [box[0], box[3]]];
  const beyond = (axis) => polygon.every((p) => p[axis] < box[axis]) || polygon.every((p) => p[axis] > box[axis + 2]);
  if (beyond(0) || beyond(1)) return false;
  return polygon.every((p, i) => {
    const q = polygon[(i + 1) % polygon.length];
    return corners.some((c) => (q[0] - p[0]) * (c[1] - p[1]) - (q[1] - p[1]) * (c[0] - p[0]) > 0);
  });
}

// Places for texts {key, at, wide, high, toward} on a sheet [wide, high]: for each its box and whether a line leads to it, or null. ``full`` are
// boxes that no text covers, ``lines`` and ``bodies`` segments and polygons that texts avoid, ``before`` the numbers of the places that texts had, by key.
function placeTexts(texts, [wide, high], full, lines, bodies, before, ratio) {
  const taken = [...full];
  return texts.map(({ key, at: [x, y], wide: w, high: h, toward }) => {
    const side = (k) => (Math.abs(k) < 0.2 ? 0 : Math.sign(k)), count = (list, lies) => list.reduce((n, one) => n + (lies(one) ? 1 : 0), 0);
    let best = null, least = Infinity;
    for (let i = 0; i < AWAY.length && AWAY[i] - KEPT < least; i++) { // without any line below it, a further place costs more
      for (let k = 0; k < AROUND.length; k++) {
        const [c, s] = AROUND[k], number = AROUND.length * i + k, r = AWAY[i] * ratio;
        const base = AWAY[i] + 7 * (1 - (toward ? c * toward[0] + s * toward[1] : c)) - (before[key] === number ? KEPT : 0);
        if (base >= least) continue;
        // the box touches a circle about the point
        const left = x + r * c + (w * (side(c) - 1)) / 2, top = y + r * s + (h * (side(s) - 1)) / 2, box = [left, top, left + w, top + h];
        if (left < 0 || top < 0 || box[2] > wide || box[3] > high || taken.some((other) => meet(box, other, 1))) continue;
        const cost = base + ACROSS * count(lines, ([p, q]) => crosses(p, q, box)) + OVER * count(bodies, (one) => covers(one, box));
        if (cost < least) [least, best] = [cost, { box, number, led: AWAY[i] >= LEADING }];
      }
    }
    before[key] = best ? best.number : undefined;
    if (!best) return null;
    taken.push(best.box);
    if (best.led) lines.push([[x, y], nearest(best.box, [x, y])]);
    return best;
  });
}

const nearest = (box, [x, y]) => [Math.min(box[2], Math.max(box[0], x)), Math.min(box[3], Math.max(box[1], y))];

// Returns the pieces of a text with subscripts after "_", each with its place, its height and its font, and the width of all.
const widths = new Map(); // of pieces in their fonts: to measure one takes long
function pieces(pen, text, ratio) {
  let x = 0;
  const result = text.split(/_(\([^()]*\)|[^\s_]+)/u).map((part, k) => {
    const piece = k % 2 ? part.replace(/^\((.*)\)$/u, "$1") : part;
    const font = `${(k % 2 ? 9 : 12) * ratio}px system-ui, sans-serif`, key = font + piece, placed = [piece, x, k % 2 ? 3.5 * ratio : 0, font];
    if (!widths.has(key)) {
      if (widths.size > 2000) widths.clear();
      pen.font = font;
      widths.set(key, pen.measureText(piece).width);
    }
    x += widths.get(key);
    return placed;
  });
  return [result, x];
}

// Writes texts [point, text, colour, tail] over the picture, beside the arrows [tail, tip, length and half width of the head] and off the ``bodies`` (points of
// each); returns the boxes of texts and of heads.
function writeTexts(pen, texts, arrows, bodies, camera, ratio, angle, before) {
  const { width, height } = pen.canvas, m = camera.matrix, deep = (p) => m[3] * p[0] + m[7] * p[1] + m[11] * p[2] + m[15];
  const onPaper = (p) => {
    const [x, y] = point(m, p), w = deep(p);
    return [((1 + x / w) * width) / 2, ((1 - y / w) * height) / 2];
  };
  const metre = (p) => height / (2 * Math.tan(angle / 2) * deep(p)), lines = [], heads = [];
  for (const [tail, tip, long, half] of arrows) {
    if (!(deep(tail) > 0 && deep(tip) > 0)) continue;
    const [p, q] = [onPaper(tail), onPaper(tip)], base = onPaper(add(tip, scale(-long, unit(subtract(tip, tail))))), r = half * metre(tip);
    lines.push([p, q]);
    heads.push([Math.min(base[0] - r, q[0]), Math.min(base[1] - r, q[1]), Math.max(base[0] + r, q[0]), Math.max(base[1] + r, q[1])]);
  }
  pen.textBaseline = "middle";
  pen.lineJoin = "round";
  const inside = ([x, y]) => x >= 0 && y >= 0 && x <= width && y <= height;
  const seen = texts.filter(([p, text]) => text && deep(p) > 0 && inside(onPaper(p))).map(([p, text, color, tail]) => {
    const [parts, wide] = pieces(pen, text, ratio), at = onPaper(p), from = tail && onPaper(tail);
    const long = from && Math.hypot(at[0] - from[0], at[1] - from[1]);
    return { key: text.replace(/ \S+ N( m)?$/, ""), at, wide, high: 15 * ratio, parts, color, toward: long > 4 * ratio ? [(at[0] - from[0]) / long, (at[1] - from[1]) / long] : null };
  });
  const shapes = bodies.map((points) => hull(points.filter((p) => deep(p) > 0).map(onPaper)));
  const corner = [0, height - 92 * ratio, 110 * ratio, height]; // of the axes of the ground
  const boxes = placeTexts(seen, [width, height], [...heads, corner], lines, shapes, before, ratio);
  seen.forEach(({ parts, color, at }, i) => {
    if (!boxes[i]) return;
    const { box, led } = boxes[i], css = `rgb(${color.map((c) => Math.round(200 * c)).join()})`, y = (box[1] + box[3]) / 2;
    if (led) {
      pen.strokeStyle = css;
      pen.lineWidth = 0.8 * ratio;
      pen.beginPath();
      pen.moveTo(...at);
      pen.lineTo(...nearest(box, at));
      pen.stroke();
    }
    pen.strokeStyle = "rgba(255,255,255,0.85)";
    pen.lineWidth = 3 * ratio;
    pen.fillStyle = css;
    for (const draw of [pen.strokeText, pen.fillText])
      for (const [piece, dx, dy, font] of parts) {
        pen.font = font;
        draw.call(pen, piece, box[0] + dx, y + dy);
      }
  });
  return { texts: boxes.filter((one) => one).map(({ box }) => box), heads, left: boxes.filter((one) => !one).length };
}
