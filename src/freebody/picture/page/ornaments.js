"use strict";
// Things beside the bodies: trails, grids of planes, springs, cones; and small tools of the page.

const plain = (x, i) => (i % STRIDE === STRIDE - 1 ? 1 : x);

function element(tag, attributes, parent, text = "") {
  const result = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) result.setAttribute(name, value);
  if (text) result.textContent = text;
  if (parent) parent.append(result);
  return result;
}

// Text of a number with three digits.
function digits(x) {
  const size = Math.abs(x);
  return written(size !== 0 && (size < 1e-3 || size >= 1e5) ? x.toExponential(2) : String(Number(x.toPrecision(3))));
}

// A number in the text of a program as a book prints it: 3 × 10⁵ for 3e+5.
function written(text) {
  const [digits, power] = String(text).split("e");
  const signed = digits.replace("-", "−");
  return power === undefined ? signed : `${signed === "1" ? "" : `${signed} × `}10${[...String(Number(power))].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c])).join("")}`;
}

// Path of a point of a body: points at least ``distance`` apart, and for every keyframe the number of the last point.
function trail(motion, body, local, distance, renderer, old) {
  const { position, quaternion } = motion.bodies[body], n = motion.t.length, [a, b, c] = local;
  const points = new Float32Array(3 * n), number = new Int32Array(n), least = distance * distance;
  let count = 0;
  for (let k = 0; k < n; k++) {
    const w = quaternion[4 * k], x = quaternion[4 * k + 1], y = quaternion[4 * k + 2], z = quaternion[4 * k + 3];
    const u = 2 * (y * c - z * b), v = 2 * (z * a - x * c), r = 2 * (x * b - y * a); // p + w t + q × t, t = 2 q × p
    const px = position[3 * k] + a + w * u + y * r - z * v;
    const py = position[3 * k + 1] + b + w * v + z * u - x * r;
    const pz = position[3 * k + 2] + c + w * r + x * v - y * u;
    const at = 3 * count, dx = px - points[at - 3], dy = py - points[at - 2], dz = pz - points[at - 1];
    if (!count || dx * dx + dy * dy + dz * dz > least) {
      [points[at], points[at + 1], points[at + 2]] = [px, py, pz];
      count++;
    }
    number[k] = count - 1;
  }
  const all = points.subarray(0, 3 * count);
  return { points: all, path: renderer.path(all, old), number };
}

// Points x, y, z, ... of all bodies at many times, from the ``far`` corners of each; the box that contains them; the greatest reach of the machine at
// one time. Parts on the ground are in ``points``, but not in the box or the reach.
function extent(motion, far, fixed) {
  const step = Math.max(1, Math.floor(motion.t.length / 120)), times = Math.ceil(motion.t.length / step);
  const points = new Float64Array(3 * (times * far.reduce((n, list) => n + list.length, 0) + fixed.length));
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  let reach = 0, count = 0;
  for (let n = 0; n < motion.t.length; n += step) {
    const least = [Infinity, Infinity, Infinity], most = [-Infinity, -Infinity, -Infinity];
    far.forEach((list, i) => {
      const m = motion.poseAt(i, n);
      for (const [x, y, z] of list)
        for (let k = 0; k < 3; k++) {
          const p = m[k] * x + m[4 + k] * y + m[8 + k] * z + m[12 + k];
          points[count++] = p;
          if (p < least[k]) least[k] = p;
          if (p > most[k]) most[k] = p;
        }
    });
    for (let k = 0; k < 3; k++) {
      low[k] = Math.min(low[k], least[k]);
      high[k] = Math.max(high[k], most[k]);
    }
    reach = Math.max(reach, length(subtract(most, least)));
  }
  points.set(fixed.flat(), count);
  return { low, high, reach, points };
}

// Corners of a body that lie farthest out in 14 directions.
function outermost(groups) {
  const directions = [];
  for (let i = 0; i < 3; i++) for (const s of [-1, 1]) directions.push([0, 1, 2].map((k) => (k === i ? s : 0)));
  for (let c = 0; c < 8; c++) directions.push([0, 1, 2].map((k) => ((c >> k) & 1 ? 1 : -1)));
  return directions.map((n) => {
    let best = null, most = -Infinity;
    for (const list of groups)
      for (let i = 0; i < list.length; i += STRIDE) {
        const h = n[0] * list[i] + n[1] * list[i + 1] + n[2] * list[i + 2];
        if (h > most) [most, best] = [h, [list[i], list[i + 1], list[i + 2]]];
      }
    return best;
  }).filter((p) => p);
}

// Grid of a plane around everything that moves, as one path that runs back and forth.
function grid({ at, normal }, bounds, size) {
  const a = across(normal), b = cross(normal, a), step = 10 ** Math.round(Math.log10(0.5 * size));
  const middle = scale(0.5, add(bounds.low, bounds.high));
  const o = add(middle, scale(-dot(subtract(middle, at), normal), normal));
  const half = 0.5 * length(subtract(bounds.high, bounds.low)) + size;
  const by = step * Math.max(1, Math.ceil(half / (20 * step))), n = Math.ceil(half / by), points = [];
  const put = (x, y) => points.push(...add(o, add(scale(x * by, a), scale(y * by, b))));
  for (let i = -n; i <= n; i++) {
    const side = (i + n) % 2 ? -n : n;
    put(i, -side);
    put(i, side);
  }
  for (let i = n; i >= -n; i--) { // the second set starts at the corner where the first ends
    const side = (i + n) % 2 ? -n : n;
    put(side, i);
    put(-side, i);
  }
  return { points: new Float32Array(points) };
}

// A spring between two points as a helix, a damper as a straight line.
function coil(a, b, kind, size) {
  const d = subtract(b, a), l = length(d);
  if (kind !== "spring" || l < 1e-9 * size) return [a, b];
  const n = scale(1 / l, d), x = across(n), y = cross(n, x), r = 0.035 * size, turns = 9, result = [a];
  for (let i = 0; i <= 16 * turns; i++) {
    const s = i / (16 * turns), h = 2 * Math.PI * turns * s, wide = r * Math.min(1, 12 * s, 12 * (1 - s));
    result.push(add(a, add(scale(l * (0.08 + 0.84 * s), n), add(scale(wide * Math.cos(h), x), scale(wide * Math.sin(h), y)))));
  }
  result.push(b);
  return result;
}

// Cones that the angular velocity of a body draws in space and in the body.
function conePair(motion, { body, apex }, long, renderer) {
  const { spin, quaternion } = motion.bodies[body], directions = [[], []];
  let most = 0;
  for (let k = 0; k < spin.length; k += 3) most = Math.max(most, Math.hypot(spin[k], spin[k + 1], spin[k + 2]));
  for (let k = 0; k < motion.t.length; k++) {
    const w = Array.from(spin.subarray(3 * k, 3 * k + 3));
    const ok = length(w) > 1e-3 * most, m = placed(quaternion.subarray(4 * k, 4 * k + 4), [0, 0, 0]);
    const n = ok ? scale(long, unit(w)) : null;
    directions[0].push(n);
    directions[1].push(n && [0, 1, 2].map((i) => m[4 * i] * n[0] + m[4 * i + 1] * n[1] + m[4 * i + 2] * n[2]));
  }
  const [space, inBody] = directions.map((list) => {
    const out = [];
    for (let i = 0; i + 1 < list.length; i++) {
      const a = list[i], b = list[i + 1];
      if (!a || !b || dot(a, b) < 0.5 * long * long) continue;
      const n = unit(cross(a, b));
      for (const p of [[0, 0, 0], a, b]) out.push(...p, ...n, 1);
    }
    return out.length ? renderer.surface(new Float32Array(out)) : null;
  });
  return { body, apex, space, inBody };
}
