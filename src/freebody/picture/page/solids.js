"use strict";
// Surfaces of the parts of a body as triangles: three corners each, seven numbers per corner (position, normal, tone).
// The tone is 1, and less in every other eighth of a turn of a round part, so that its spin can be seen.

const STRIDE = 7, SHADE = 0.78;

const FINEST = 48; // divisions of a full turn
const CREASE = Math.cos(0.6); // edges sharper than this are not smoothed

// ``size`` is the size of the machine: small parts have fewer divisions.
function triangles(part, size) {
  const make = { box, lathe, ellipsoid, mesh }[part.kind];
  return moved(make(part, size), placed(part.turn || [1, 0, 0, 0], part.at || [0, 0, 0]));
}

function moved(corners, m) {
  const result = new Float32Array(corners.length);
  for (let i = 0; i < corners.length; i += STRIDE) {
    result.set(point(m, [corners[i], corners[i + 1], corners[i + 2]]), i);
    result.set(turned(m, [corners[i + 3], corners[i + 4], corners[i + 5]]), i + 3);
    result[i + 6] = corners[i + 6];
  }
  return result;
}

function box({ size }) {
  const out = [];
  for (let i = 0; i < 3; i++)
    for (const sign of [-1, 1]) {
      const corner = (a, b) => {
        const p = [0, 0, 0], n = [0, 0, 0];
        p[i] = (sign * size[i]) / 2;
        p[(i + 1) % 3] = (sign * a * size[(i + 1) % 3]) / 2;
        p[(i + 2) % 3] = (b * size[(i + 2) % 3]) / 2;
        n[i] = sign;
        return [...p, ...n, 1];
      };
      out.push(...corner(-1, -1), ...corner(1, -1), ...corner(1, 1), ...corner(-1, -1), ...corner(1, 1), ...corner(-1, 1));
    }
  return new Float32Array(out);
}

// A profile of (radius, z) turned about z. Where z increases along the profile, its normals point away from the axis.
function lathe({ profile, around = 0 }, size = 0) {
  around ||= divisions(Math.max(...profile.map(([r]) => r)), size);
  const edges = [];
  for (let i = 0; i + 1 < profile.length; i++) {
    const [r, z] = profile[i], [R, Z] = profile[i + 1], l = Math.hypot(R - r, Z - z);
    edges.push(l > 0 ? [(Z - z) / l, (r - R) / l] : null);
  }
  // one normal at a smooth corner, two at a sharp corner; a profile that returns to its start has no ends
  const count = edges.length, closed = same(profile[0], profile[count]);
  const shared = (i, j) => {
    const a = edges[i], b = j < 0 || j >= count ? (closed ? edges[(j + count) % count] : null) : edges[j];
    if (!a || !b || a[0] * b[0] + a[1] * b[1] < CREASE) return a || [1, 0];
    const l = Math.hypot(a[0] + b[0], a[1] + b[1]);
    return [(a[0] + b[0]) / l, (a[1] + b[1]) / l];
  };
  const out = [];
  for (let i = 0; i < count; i++) {
    if (!edges[i]) continue;
    const low = [...profile[i], ...shared(i, i - 1)], high = [...profile[i + 1], ...shared(i, i + 1)];
    for (let k = 0; k < around; k++) {
      const a = (2 * Math.PI * k) / around, b = (2 * Math.PI * (k + 1)) / around;
      const tone = Math.floor((8 * k) / around) % 2 ? SHADE : 1;
      const at = ([r, z, nr, nz], h) => {
        const c = Math.cos(h), s = Math.sin(h);
        return [r * c, r * s, z, nr * c, nr * s, nz, tone];
      };
      if (low[0] > 0) out.push(...at(low, a), ...at(low, b), ...at(high, b));
      if (high[0] > 0) out.push(...at(low, a), ...at(high, b), ...at(high, a));
    }
  }
  return new Float32Array(out);
}

// Divisions of a full turn of a part, by its radius relative to the size of the machine.
const SMALL = { 16: 0.05, 24: 0.15 };
const divisions = (radius, size) => (radius < SMALL[16] * size ? 16 : radius < SMALL[24] * size ? 24 : FINEST);

const same = (a, b) => a[0] === b[0] && a[1] === b[1];

function ellipsoid({ radii }, size = 0) {
  const around = divisions(Math.max(...radii), size), profile = [], half = around / 2;
  for (let i = 0; i <= half; i++) profile.push([Math.sin((Math.PI * i) / half), -Math.cos((Math.PI * i) / half)]);
  profile[0][0] = profile[half][0] = 0;
  const out = lathe({ profile, around });
  for (let i = 0; i < out.length; i += STRIDE) {
    const n = unit([out[i + 3] / radii[0], out[i + 4] / radii[1], out[i + 5] / radii[2]]);
    for (let k = 0; k < 3; k++) {
      out[i + k] *= radii[k];
      out[i + 3 + k] = n[k];
    }
  }
  return out;
}

function mesh({ vertices, faces }) {
  const v = vertices, f = faces, out = new Float32Array(STRIDE * f.length);
  for (let i = 0; i < f.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => Array.from(v.subarray(3 * f[i + k], 3 * f[i + k] + 3)));
    const n = unit(cross(subtract(b, a), subtract(c, a)));
    [a, b, c].forEach((p, k) => out.set([...p, ...n, 1], STRIDE * (i + k)));
  }
  return out;
}
