"use strict";
// The stage: canvases, a floor with a grid and the shadows of the bodies where there is a vertical, and the axes of the ground in the corner.

const FLOOR = [0.955, 0.96, 0.968], SHADOW = [0.845, 0.855, 0.87], GRID = [0.885, 0.895, 0.91];

// A stage with the canvas for the machine, the canvas above it for texts, and the renderer.
function staged(plainly) {
  const stage = element("div", { class: "stage" }), canvas = element("canvas", { class: "view", tabindex: 0 }, stage);
  const overlay = element("canvas", { class: "labels" }, stage), renderer = (!plainly && webgl(canvas)) || flat(canvas);
  return { stage, canvas: renderer.canvas, overlay, renderer };
}

// The floor under everything: the level plane that the machine stands on, or else a level below the lowest point of its ``fixed``
// parts, or a little below that of its bodies. Returns null without a vertical, or if the machine stands on a plane that is not level.
function stageFloor({ up, gravity, ground }, { low, high, points }, fixed, size, renderer) {
  const level = ground.planes.find(({ normal }) => dot(unit(normal), up) > 0.999);
  if (!gravity || (ground.planes.length && !level)) return null;
  const lowest = (list) => {
    let least = Infinity;
    for (let i = 0; i < list.length; i += 3) least = Math.min(least, up[0] * list[i] + up[1] * list[i + 1] + up[2] * list[i + 2]);
    return least;
  };
  const support = lowest(fixed.flat()), stands = support <= lowest(points); // ``points`` has the fixed ones, too
  const height = level ? dot(up, level.at) : stands ? support : lowest(points) - 0.12 * size, middle = scale(0.5, add(low, high));
  const at = add(middle, scale(height - dot(up, middle), up)), a = across(up), b = cross(up, a);
  const radius = 0.5 * length(subtract(high, low)) + 0.75 * size;
  // chords of the disk, back and forth, as one path each way; squares of a round length
  const step = round(radius / 5), n = Math.floor(radius / step);
  const chords = (along, over) => {
    const result = [];
    for (let i = -n; i <= n; i++) {
      const half = Math.sqrt(Math.max(0, radius * radius - i * i * step * step)) * (i % 2 ? 1 : -1);
      for (const sign of [-1, 1]) result.push(...add(at, add(scale(i * step, along), scale(sign * half, over))));
    }
    return renderer.path(new Float32Array(result));
  };
  // shadows fall along the direction d: p - d (n·(p - at))/(n·d)
  const d = unit(add(scale(-1, up), add(scale(0.3, a), scale(0.18, b)))), k = 1 / dot(up, d);
  const column = (i) => [0, 1, 2].map((j) => (i === j ? 1 : 0) - k * d[j] * up[i]);
  return {
    pose: along(up, at, radius, 1),
    grid: [chords(a, b), chords(b, a)],
    shadow: columns(column(0), column(1), column(2), scale(k * dot(up, at), d)),
  };
}

// The largest of 1, 2, 5 times a power of ten that is not above x.
function round(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  return power * [5, 2, 1].find((k) => k * power <= x * (1 + 1e-9));
}

function drawFloor(renderer, disk, { pose, grid, shadow }, groups) {
  renderer.floor(disk, pose, FLOOR);
  for (const [surfaces, matrix] of groups)
    for (const { surface } of surfaces) renderer.floor(surface, product(shadow, matrix), SHADOW);
  for (const path of grid) renderer.line(path, GRID, 1, 0, undefined, 1, true);
}

// Draws the axes of the ground, and the sense of gravity, in the lower left corner of the picture.
function drawCorner(pen, camera, { up, gravity }, ratio) {
  const long = 26 * ratio, x = 44 * ratio, y = pen.canvas.height - 44 * ratio;
  const axes = AXES.map((color, k) => [[0, 1, 2].map((i) => (i === k ? 1 : 0)), color, "XYZ"[k], long]);
  if (gravity) axes.push([scale(-1, up), [0.3, 0.3, 0.33], "g", 0.75 * long]);
  pen.lineCap = "round";
  pen.textAlign = "center";
  pen.font = `${11 * ratio}px system-ui, sans-serif`;
  axes.sort((one, other) => dot(one[0], camera.back) - dot(other[0], camera.back)); // the nearest last
  for (const [n, color, name, size] of axes) {
    const right = dot(n, camera.right), top = dot(n, camera.top), flat = Math.hypot(right, top);
    if (flat < 0.15) continue; // an axis towards the eye
    const from = name === "g" ? [x + 2.5 * long, y - 0.5 * long] : [x, y];
    const tip = [from[0] + size * right, from[1] - size * top], u = [right / flat, -top / flat], h = 5 * ratio;
    pen.strokeStyle = pen.fillStyle = `rgb(${color.map((c) => Math.round(230 * c)).join()})`;
    pen.lineWidth = 1.6 * ratio;
    pen.beginPath();
    pen.moveTo(...from);
    pen.lineTo(tip[0] - 0.8 * h * u[0], tip[1] - 0.8 * h * u[1]);
    pen.stroke();
    pen.beginPath();
    pen.moveTo(...tip);
    for (const side of [-0.5, 0.5]) pen.lineTo(tip[0] - h * (u[0] + side * u[1]), tip[1] - h * (u[1] - side * u[0]));
    pen.fill();
    pen.fillText(name, tip[0] + 9 * ratio * u[0], tip[1] + 9 * ratio * u[1]);
  }
  pen.textAlign = "start";
}

// The picture as it is, in a canvas that stays while the page is printed: that of WebGL is empty by then.
function printed({ stage, canvas, overlay }) {
  const { width, height } = canvas, copy = element("canvas", { class: "printed", width, height }, stage), pen = copy.getContext("2d");
  for (const layer of [canvas, overlay]) pen.drawImage(layer, 0, 0, width, height);
  return copy;
}
