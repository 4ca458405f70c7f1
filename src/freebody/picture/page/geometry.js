"use strict";
// Vectors are arrays of three numbers, quaternions [w, x, y, z], matrices 16 numbers by columns (as WebGL takes them).

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const scale = (k, a) => [k * a[0], k * a[1], k * a[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.hypot(a[0], a[1], a[2]);
const mix = (a, b, s) => a + (b - a) * s;

function unit(a) {
  const l = length(a);
  return l > 0 ? scale(1 / l, a) : [0, 0, 1];
}

// A unit vector at right angles to another.
function across(n) {
  const least = [0, 1, 2].reduce((i, j) => (Math.abs(n[j]) < Math.abs(n[i]) ? j : i), 0);
  return unit(cross(n, [0, 1, 2].map((i) => (i === least ? 1 : 0))));
}

// Rotation by the quaternion q and displacement by p, with a size along each axis.
function placed(q, p, size = [1, 1, 1]) {
  const [w, x, y, z] = q, [a, b, c] = size;
  return [
    a * (1 - 2 * (y * y + z * z)), a * 2 * (x * y + w * z), a * 2 * (x * z - w * y), 0,
    b * 2 * (x * y - w * z), b * (1 - 2 * (x * x + z * z)), b * 2 * (y * z + w * x), 0,
    c * 2 * (x * z + w * y), c * 2 * (y * z - w * x), c * (1 - 2 * (x * x + y * y)), 0,
    p[0], p[1], p[2], 1,
  ];
}

// Columns x, y, z and origin p as a matrix.
const columns = (x, y, z, p) => [...x, 0, ...y, 0, ...z, 0, ...p, 1];

// The z axis along a unit vector, sizes across and along it.
function along(n, p, wide, long) {
  const x = across(n), y = cross(n, x);
  return columns(scale(wide, x), scale(wide, y), scale(long, n), p);
}

function product(a, b) {
  const c = new Array(16);
  for (let j = 0; j < 4; j++)
    for (let i = 0; i < 4; i++)
      c[4 * j + i] = a[i] * b[4 * j] + a[4 + i] * b[4 * j + 1] + a[8 + i] * b[4 * j + 2] + a[12 + i] * b[4 * j + 3];
  return c;
}

const point = (m, p) => [
  m[0] * p[0] + m[4] * p[1] + m[8] * p[2] + m[12],
  m[1] * p[0] + m[5] * p[1] + m[9] * p[2] + m[13],
  m[2] * p[0] + m[6] * p[1] + m[10] * p[2] + m[14],
];
const turned = (m, v) => [
  m[0] * v[0] + m[4] * v[1] + m[8] * v[2],
  m[1] * v[0] + m[5] * v[1] + m[9] * v[2],
  m[2] * v[0] + m[6] * v[1] + m[10] * v[2],
];

// From the quaternion a to b, both unit, at the same rate all the way: sin((1-s) h) a + sin(s h) b over sin h.
function between(a, b, s) {
  let c = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  const sign = c < 0 ? -1 : 1;
  c = Math.min(1, sign * c);
  let u = 1 - s, v = s;
  if (c < 1 - 1e-7) {
    const h = Math.acos(c);
    u = Math.sin(u * h) / Math.sin(h);
    v = Math.sin(s * h) / Math.sin(h);
  }
  v *= sign;
  const q = [0, 1, 2, 3].map((i) => u * a[i] + v * b[i]);
  const l = Math.hypot(...q);
  return q.map((x) => x / l);
}

// What the eye sees: perspective of a camera at ``eye`` that looks at ``target``, with the picture's width / height.
function view(eye, target, up, angle, aspect, near, far) {
  const back = unit(subtract(eye, target));
  let right = cross(up, back);
  right = length(right) > 1e-9 ? unit(right) : across(back);
  const top = cross(back, right), f = 1 / Math.tan(angle / 2), d = 1 / (near - far);
  const look = [
    right[0], top[0], back[0], 0, right[1], top[1], back[1], 0, right[2], top[2], back[2], 0,
    -dot(right, eye), -dot(top, eye), -dot(back, eye), 1,
  ];
  const frustum = [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) * d, -1, 0, 0, 2 * far * near * d, 0];
  return { matrix: product(frustum, look), right, top, back, eye };
}

// -- numbers that the page carries ------------------------------------------------------------------------

function bytes(text) {
  const raw = atob(text), result = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) result[i] = raw.charCodeAt(i);
  return result.buffer;
}
const floats = (text) => new Float32Array(bytes(text));
const integers = (text) => new Uint32Array(bytes(text));
