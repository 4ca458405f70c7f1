"use strict";
// Vectors are arrays of three numbers, quaternions [w, x, y, z], matrices 16 numbers by columns (as in WebGL).

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

// A unit vector perpendicular to another.
function across(n) {
  const least = [0, 1, 2].reduce((i, j) => (Math.abs(n[j]) < Math.abs(n[i]) ? j : i), 0);
  return unit(cross(n, [0, 1, 2].map((i) => (i === least ? 1 : 0))));
}

// Matrix of a rotation by the quaternion q and a displacement by p, with a scale along each axis.
function placed(q, p, size = [1, 1, 1]) {
  const [w, x, y, z] = q, [a, b, c] = size;
  return [
    a * (1 - 2 * (y * y + z * z)), a * 2 * (x * y + w * z), a * 2 * (x * z - w * y), 0,
    b * 2 * (x * y - w * z), b * (1 - 2 * (x * x + z * z)), b * 2 * (y * z + w * x), 0,
    c * 2 * (x * z + w * y), c * 2 * (y * z - w * x), c * (1 - 2 * (x * x + y * y)), 0,
    p[0], p[1], p[2], 1,
  ];
}

// Matrix with the columns x, y, z and the origin p.
const columns = (x, y, z, p) => [...x, 0, ...y, 0, ...z, 0, ...p, 1];

// Matrix with the z axis along a unit vector, and scales across and along it.
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

// Quaternion of a rotation vector; product of two quaternions, the rotation q before p.
function turning(v) {
  const angle = length(v), k = angle > 1e-12 ? Math.sin(angle / 2) / angle : 0.5;
  return [Math.cos(angle / 2), k * v[0], k * v[1], k * v[2]];
}

const composed = (p, q) => [
  p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
  p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
  p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3],
  p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1],
];

// Quaternion at the fraction s of the way from a to b, for a body that turns by the rotation vector v; the remaining turn
// to b is spread evenly.
function between(a, b, v, s) {
  const [w, x, y, z] = composed(turning(v), a);
  const d = composed(b, [w, -x, -y, -z]), sine = Math.hypot(d[1], d[2], d[3]);
  const angle = (d[0] < 0 ? -2 : 2) * Math.atan2(sine, Math.abs(d[0])), k = sine > 0 ? (s * angle) / sine : 0;
  return composed(turning([k * d[1], k * d[2], k * d[3]]), composed(turning(scale(s, v)), a));
}

// Perspective of a camera at ``eye`` that looks at ``target``; ``aspect`` is width / height of the picture.
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
