"use strict";
// The animation: draws the machine at a time, from the keyframes of the page, with controls for the time and the eye.

const ANGLE = 0.5; // of the camera [rad]
const SPEEDS = [0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10];
const AXES = [[0.84, 0.22, 0.15], [0.1, 0.58, 0.25], [0.12, 0.36, 0.75]];
const DARK = [0.25, 0.25, 0.28], PALE = [0.85, 0.86, 0.88];
const SWITCHES = {
  trails: "Trails", frames: "Frames", names: "Names", forces: "Forces", reactions: "Reactions",
  contacts: "Contacts", cones: "Cones", follow: "Follow", repeat: "Repeat",
};

function player(root, scene, options = {}) {
  const listeners = [];
  let motion = new Motion(scene);
  const on = { trails: true, frames: false, names: false, forces: false, reactions: false, contacts: true, cones: false, follow: false, repeat: true };
  let playing = false, speed = 1, arrowSize = 1, last = null, drawn = 0, written = null;
  const heads = [], before = {}; // arrows of the picture; places of its texts, which they keep

  // -- elements of the page
  root.classList.add("player");
  const canvases = options.canvases || staged(options.flat); // from another player if given: new ones take long to make
  const { stage, canvas, overlay, renderer } = canvases, hands = new AbortController(), { signal } = hands;
  let [fineness] = renderer.fine, rest = 0;
  root.append(stage);
  canvas.setAttribute("aria-label", `Animation of ${scene.title}: space plays, arrows move the time, with shift the eye, plus and minus its distance`);
  const bar = element("div", { class: "bar" }, root);
  const button = element("button", { type: "button", class: "play", title: "Play or pause (space)" }, bar);
  const slider = element("input", { type: "range", class: "scrub", min: 0, max: 1, step: "any", value: 0, "aria-label": "Time" }, bar);
  const clock = element("output", { class: "clock" }, bar);
  const rate = element("select", { class: "speed", "aria-label": "Speed" }, bar);
  for (const x of SPEEDS) element("option", { value: x }, rate, `× ${x}`);
  const rail = element("div", {}, root);
  let strip = null;
  // what the page has measured: to ask for it after each change of the page would lay out the page each time
  const measured = { wide: 1, high: 1, left: 0, slider: 0 };
  function measure() {
    const [bar, whole] = [slider, rail].map((part) => part.getBoundingClientRect());
    Object.assign(measured, { wide: canvas.clientWidth, high: canvas.clientHeight, left: bar.left - whole.left, slider: bar.width });
  }
  const panel = element("div", { class: "bar switches" }, root);
  const boxes = {};
  const present = {
    forces: scene.arrows.some((arrow) => arrow.group === "force"),
    reactions: scene.arrows.some((arrow) => arrow.group === "reaction"),
    cones: scene.cones.length > 0,
    contacts: scene.touching.length > 0,
  };
  for (const [name, text] of Object.entries(SWITCHES)) {
    if (present[name] === false) continue;
    const label = element("label", {}, panel);
    boxes[name] = element("input", { type: "checkbox", name }, label);
    label.append(` ${text}`);
    boxes[name].addEventListener("change", () => show(name, boxes[name].checked));
  }
  if (present.forces || present.reactions) {
    const label = element("label", {}, panel, "Arrows ");
    const size = element("input", { type: "range", min: -1, max: 1, step: "any", value: 0, class: "arrows", "aria-label": "Length of arrows" }, label);
    size.addEventListener("input", () => {
      arrowSize = 10 ** Number(size.value);
      draw();
    });
  }
  const views = element("span", { class: "views" }, panel, "View ");
  for (const name of ["fit", "x", "y", "z"])
    element("button", { type: "button", title: name === "fit" ? "Show everything" : `Along the ${name} axis` }, views, name)
      .addEventListener("click", () => look(name));

  // -- things to draw
  const size = scene.size, up = scene.up;
  const surfaces = (parts, color) => {
    const groups = new Map();
    for (const part of parts) {
      const key = JSON.stringify(part.color || color);
      groups.set(key, [...(groups.get(key) || []), triangles(part, size)]);
    }
    return [...groups].map(([key, lists]) => {
      const all = new Float32Array(lists.reduce((n, list) => n + list.length, 0));
      lists.reduce((n, list) => (all.set(list, n), n + list.length), 0);
      return { color: JSON.parse(key), corners: all, surface: renderer.surface(all) };
    });
  };
  let shaft, head, ball, disk, loose; // loose: polylines that change with time, by name
  const dynamic = (name, points) => (loose[name] = renderer.path(new Float32Array(points.flat()), loose[name]));
  let bodies, ground, far, fixed, bounds, trails, cones, planes, floor, struck, paths, greatest, tips, span, places;
  // Makes everything that is drawn.
  function build() {
    shaft = renderer.surface(lathe({ profile: [[0, 0], [1, 0], [1, 1], [0, 1]], around: 12 }).map(plain));
    head = renderer.surface(lathe({ profile: [[0, 0], [1, 0], [0, 1]], around: 16 }).map(plain));
    disk = renderer.surface(lathe({ profile: [[0, 0], [1, 0]], around: 96 }).map(plain));
    ball = renderer.surface(ellipsoid({ radii: [1, 1, 1] }, Infinity)); // with few divisions, like all that is small
    [loose, bodies, ground, trails, planes, cones, floor] = [{}, [], [], [], [], null, null];
    shape();
    trace();
  }
  // Makes the surfaces of the bodies and of the ground.
  function shape() {
    for (const { surface } of [...bodies.flat(), ...ground]) renderer.forget(surface);
    bodies = scene.bodies.map((body) => surfaces(body.parts, body.color));
    ground = surfaces(scene.ground.parts, DARK);
    far = bodies.map((groups) => outermost(groups.map(({ corners }) => corners)));
    fixed = outermost(ground.map(({ corners }) => corners));
  }
  // Makes what depends on the motion as a whole.
  function trace() {
    for (const item of [...(cones || []).flatMap(({ space, inBody }) => [space, inBody]), ...planes, ...(floor ? floor.grid : [])])
      if (item) renderer.forget(item);
    cones = null; // made when they are first shown
    bounds = extent(motion, far, fixed);
    trails = scene.bodies.map((body, i) => trail(motion, i, body.center, 0.0015 * bounds.reach, renderer, trails[i] && trails[i].path));
    floor = stageFloor(scene, bounds, fixed, size, renderer);
    planes = floor ? [] : scene.ground.planes.map((plane) => renderer.path(grid(plane, bounds, size).points));
    struck = impacts(motion, scene);
    paths = scene.arrows.map((arrow) => arrow.path);
    greatest = { force: 0, moment: 0 };
    for (const { channel, kind } of scene.arrows) {
      const v = motion.channels[channel].values;
      for (let i = 0; i < v.length; i += 3) greatest[kind] = Math.max(greatest[kind], Math.hypot(v[i], v[i + 1], v[i + 2]));
    }
    tips = scene.arrows.map((arrow, i) => arrowTips(arrow, paths[i]));
    span = motion.last - motion.first;
    places = Math.max(0, Math.min(6, 3 - Math.floor(Math.log10(span || 1))));
    rail.replaceChildren();
    strip = timeline(rail, measured, scene, motion, (time) => (pause(), seek(time)));
  }
  // Tips of an arrow at many times, x, y, z, ...
  function arrowTips({ channel, kind, body, at }, path) {
    const v = motion.channels[channel].values, step = Math.max(1, Math.floor(motion.t.length / 60)), result = [];
    for (let n = 0; n < motion.t.length; n += step) {
      const tail = path ? [0, 1, 2].map((k) => path[3 * n + k]) : body < 0 ? at : point(motion.poseAt(body, n), at);
      for (let k = 0; k < 3; k++) result.push(tail[k] + (0.55 * size * v[3 * n + k]) / (greatest[kind] || 1));
    }
    return result;
  }
  build();
  on.trails = bodies.length <= 12; // more trails would hide the machine
  on.forces = on.reactions = scene.arrows.length <= 6; // more arrows would, too

  // -- the eye
  const eye = { target: [0, 0, 0], toward: unit(scene.toward), up, distance: 1, chosen: false }; // by the user
  const aspect = () => Math.max(measured.wide, 1) / Math.max(measured.high, 1);
  // Distance from which everything that is visible at any time is in the picture around a target, and its middle.
  function framing(target) {
    const { right, top } = view(eye.toward, [0, 0, 0], eye.up, ANGLE, 1, 1, 2), room = 1.3 / Math.tan(ANGLE / 2);
    const lists = [bounds.points, ...tips.filter((_, i) => on[scene.arrows[i].group === "force" ? "forces" : "reactions"])];
    const span = (n) => {
      let low = Infinity, high = -Infinity;
      for (const list of lists)
        for (let i = 0; i < list.length; i += 3) {
          const h = n[0] * list[i] + n[1] * list[i + 1] + n[2] * list[i + 2];
          if (h < low) low = h;
          if (h > high) high = h;
        }
      const at = target ? dot(n, target) : (high + low) / 2;
      return [at, Math.max(high - at, at - low)];
    };
    const [[x, wide], [y, tall], [z, deep]] = [right, top, eye.toward].map(span);
    return {
      target: add(add(scale(x, right), scale(y, top)), scale(z, eye.toward)),
      distance: Math.max(tall * room, (wide * room) / aspect(), 0.1 * size * room) + deep,
    };
  }
  // Puts everything that is visible at any time (when following: at one time) in the middle, as large as possible.
  function fit() {
    eye.chosen = false;
    if (on.follow) {
      const room = 1.3 / Math.tan(ANGLE / 2);
      eye.target = middle();
      eye.distance = 0.5 * bounds.reach * room * Math.max(1, 1 / aspect()) + 0.5 * bounds.reach;
    } else Object.assign(eye, framing());
  }
  const middle = () =>
    scale(1 / bodies.length, scene.bodies.reduce((sum, body, i) => add(sum, point(motion.pose(i), body.center)), [0, 0, 0]));
  let followed = middle();
  function look(name) {
    if (name !== "fit") {
      const n = [0, 1, 2].map((k) => ("xyz"[k] === name ? 1 : 0));
      eye.toward = n;
      eye.up = Math.abs(dot(n, up)) > 0.9 ? across(n) : up;
    } else {
      eye.toward = unit(scene.toward);
      eye.up = up;
    }
    fit();
    draw();
  }
  function orbit(dx, dy) {
    const { right, top } = view(add(eye.target, eye.toward), eye.target, eye.up, ANGLE, 1, 1, 2);
    const moved = unit(add(eye.toward, add(scale(-dx, right), scale(dy, top))));
    if (Math.abs(dot(moved, eye.up)) < 0.995) eye.toward = moved; // the eye does not pass over the pole
    hurry(1);
    draw();
  }
  function pan(dx, dy) {
    const { right, top } = view(add(eye.target, eye.toward), eye.target, eye.up, ANGLE, 1, 1, 2);
    eye.chosen = true;
    eye.target = add(eye.target, add(scale(-dx * eye.distance, right), scale(dy * eye.distance, top)));
    hurry(1);
    draw();
  }
  function zoom(factor) {
    eye.chosen = true;
    eye.distance = Math.min(1e4 * size, Math.max(0.05 * size, eye.distance * factor));
    hurry(1);
    draw();
  }

  // -- one picture
  // Draws as fine as a picture is that stays, or one of a motion that plays.
  function settle() {
    clearTimeout(rest);
    const fine = renderer.fine[playing ? 1 : 0];
    if (fine === fineness) return;
    fineness = fine;
    draw();
  }
  // Draws coarser, until nothing moves for a while: 1 while the eye moves, 2 while a motion follows a slider.
  function hurry(k) {
    clearTimeout(rest);
    fineness = Math.min(fineness, renderer.fine[k]);
    rest = setTimeout(settle, 150);
  }
  function draw() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const wide = Math.round(measured.wide * ratio), high = Math.round(measured.high * ratio);
    if (!wide || !high) return;
    for (const [layer, fine] of [[canvas, fineness], [overlay, 1]]) {
      const size = [Math.round(fine * wide), Math.round(fine * high)];
      if (layer.width !== size[0] || layer.height !== size[1]) [layer.width, layer.height] = size;
    }
    if (on.follow) {
      const now = middle();
      eye.target = add(eye.target, subtract(now, followed));
      followed = now;
    }
    const place = add(eye.target, scale(eye.distance, eye.toward));
    const beyond = eye.distance + 2 * length(subtract(bounds.high, bounds.low)) + 10 * size;
    const camera = view(place, eye.target, eye.up, ANGLE, wide / high, Math.max(eye.distance / 100, beyond / 5000), beyond);
    camera.ratio = fineness * ratio;
    camera.light = unit(add(camera.back, add(scale(0.7, camera.top), scale(-0.45, camera.right))));
    const texts = [];
    heads.length = 0;
    renderer.begin(camera);
    const poses = bodies.map((_, i) => motion.pose(i)), still = placed([1, 0, 0, 0], [0, 0, 0]);
    if (floor) drawFloor(renderer, disk, floor, [[ground, still], ...bodies.map((groups, i) => [groups, poses[i]])]);
    for (const path of planes) renderer.line(path, PALE, 1);
    for (const { color, surface } of ground) renderer.solid(surface, still, color);
    bodies.forEach((groups, i) => groups.forEach(({ color, surface }) => renderer.solid(surface, poses[i], color)));
    const at = ([body, p]) => (body < 0 ? p : point(poses[body], p));
    for (const { name, kind, ends } of scene.lines) {
      const points = ends.map(at);
      renderer.line(dynamic(`line ${name}`, kind === "rope" ? points : coil(points[0], points[1], kind, size)), DARK, 2);
    }
    if (on.trails) drawTrails(poses);
    if (on.frames) drawFrames(poses, texts);
    if (on.names) scene.bodies.forEach((body, i) => texts.push([point(poses[i], body.center), body.name.replaceAll("_", " "), DARK]));
    if (on.forces || on.reactions) drawArrows(poses, texts);
    if (on.cones) drawCones(poses);
    if (on.contacts) drawContacts();
    renderer.end();
    const pen = overlay.getContext("2d");
    pen.clearRect(0, 0, overlay.width, overlay.height);
    written = writeTexts(pen, texts, heads, far.map((list, i) => list.map((p) => point(poses[i], p))), camera, ratio, ANGLE, before);
    drawCorner(pen, camera, scene, ratio);
    drawn++;
  }
  function drawTrails(poses) {
    trails.forEach(({ points, path, number }, i) => {
      if (points.length < 6) return;
      const color = scene.bodies[i].color.map((c) => 0.7 * c), now = number[motion.index];
      const old = number[Math.floor((2 * motion.index) / 3)];
      renderer.line(path, color.map((c) => mix(c, 1, 0.55)), 1.4, 0, old);
      renderer.line(path, color, 1.8, old, now);
      const tip = [Array.from(points.subarray(3 * now, 3 * now + 3)), point(poses[i], scene.bodies[i].center)];
      renderer.line(dynamic(`tip ${i}`, tip), color, 1.8);
    });
  }
  function drawFrames(poses, texts) {
    const axes = (m, long, names, key) =>
      AXES.forEach((color, k) => {
        const o = [m[12], m[13], m[14]], end = add(o, scale(long, [m[4 * k], m[4 * k + 1], m[4 * k + 2]]));
        renderer.line(dynamic(`axis ${key} ${k}`, [o, end]), color, 2.2);
        texts.push([add(o, scale(1.12, subtract(end, o))), names[k], color]);
      });
    axes(placed([1, 0, 0, 0], [0, 0, 0]), 0.45 * size, "XYZ", "ground");
    poses.forEach((m, i) => axes(m, 0.3 * size, bodies.length > 8 ? ["", "", ""] : "xyz", i));
  }
  function drawArrows(poses, texts) {
    const shown = scene.arrows.filter(({ group }) => on[group === "force" ? "forces" : "reactions"]);
    scene.arrows.forEach((arrow, i) => {
      if (!on[arrow.group === "force" ? "forces" : "reactions"]) return;
      const v = motion.vector(motion.channels[arrow.channel].values), l = length(v);
      const long = (0.55 * size * arrowSize * l) / (greatest[arrow.kind] || 1);
      if (!(long > 2e-3 * size)) return;
      const tail = paths[i] ? motion.vector(paths[i]) : at(poses, arrow), n = scale(1 / l, v);
      const tip = drawArrow(tail, n, long, arrow.kind === "moment", arrow.color, shown.length <= 120);
      if (shown.length <= 14) texts.push([tip, `${arrow.label} ${digits(l)} ${arrow.kind === "force" ? "N" : "N m"}`, arrow.color, tail]);
    });
  }
  const at = (poses, { body, at: p }) => (body < 0 ? p : point(poses[body], p));
  // Draws an arrow, with a double head for a moment; returns its tip.
  function drawArrow(tail, n, long, moment, color, through) {
    const thick = 0.011 * size, tip = Math.min(0.1 * size, 0.5 * long), wide = Math.min(0.028 * size, 0.3 * long);
    const end = add(tail, scale(long, n)), double = moment ? [1, 1.7] : [1];
    renderer.solid(shaft, along(n, tail, Math.min(thick, 0.4 * wide), long - tip), color, 1, through);
    for (const k of double) renderer.solid(head, along(n, add(end, scale(-k * tip, n)), wide, tip), color, 1, through);
    heads.push([tail, end, double[double.length - 1] * tip, wide]);
    return end;
  }
  // Draws a dark dot where bodies touch, and a red dot where they have struck each other.
  function drawContacts() {
    const r = 0.014 * size;
    scene.touching.forEach(({ path, closed }) => {
      if (closed[motion.index] > 0) renderer.solid(ball, along([0, 0, 1], motion.vector(path), r, r), DARK, 1, true);
    });
    for (const [time, p] of struck) if (time <= motion.now) renderer.solid(ball, along([0, 0, 1], p, r, r), [0.84, 0.37, 0], 1, true);
  }
  function drawCones(poses) {
    cones = cones || scene.cones.map((cone) => conePair(motion, cone, 0.6 * size, renderer));
    for (const { body, apex, space, inBody } of cones) {
      const m = poses[body], o = point(m, apex);
      if (space) renderer.solid(space, placed([1, 0, 0, 0], o), [0.85, 0.55, 0.1], 0.35);
      if (inBody) renderer.solid(inBody, columns([m[0], m[1], m[2]], [m[4], m[5], m[6]], [m[8], m[9], m[10]], o), [0.2, 0.45, 0.8], 0.35);
      const w = motion.vector(motion.bodies[body].spin);
      if (length(w) > 0) renderer.line(dynamic(`spin ${body}`, [o, add(o, scale(0.7 * size, unit(w)))]), AXES[0], 2.5);
    }
  }
  // -- time
  function seek(time) {
    put(time);
    for (const listener of listeners) listener(motion.now);
  }
  // Shows a time on the stage alone.
  function put(time) {
    motion.seek(Math.min(motion.last, Math.max(motion.first, time)));
    slider.value = (motion.now - motion.first) / (motion.last - motion.first || 1);
    clock.textContent = `${motion.now.toFixed(places)} s`;
    strip();
    draw();
  }
  function tick(stamp) {
    if (!playing) return;
    if (last !== null) {
      let time = motion.now + (speed * (stamp - last)) / 1000;
      if (time >= motion.last) {
        if (on.repeat) time = motion.first + ((time - motion.first) % (span || 1));
        else pause();
      }
      seek(time);
    }
    last = stamp;
    if (playing) requestAnimationFrame(tick);
  }
  function play() {
    if (playing) return;
    if (motion.now >= motion.last) seek(motion.first);
    playing = true;
    last = null;
    button.textContent = "❚❚";
    button.setAttribute("aria-label", "Pause");
    settle();
    requestAnimationFrame(tick);
  }
  function pause() {
    playing = false;
    button.textContent = "▶";
    button.setAttribute("aria-label", "Play");
    settle();
  }
  function show(name, value) {
    if (!(name in on)) return;
    on[name] = value;
    if (boxes[name]) boxes[name].checked = value;
    if (name === "follow") {
      followed = middle();
      fit();
    }
    draw();
  }
  function pace(x) {
    speed = x;
    if (![...rate.options].some((option) => Number(option.value) === x)) element("option", { value: x }, rate, `× ${x}`);
    rate.value = x;
  }

  // -- mouse, fingers and keys
  button.addEventListener("click", () => (playing ? pause() : play()));
  slider.addEventListener("input", () => {
    pause();
    seek(motion.first + span * Number(slider.value));
  });
  rate.addEventListener("change", () => pace(Number(rate.value)));
  canvas.addEventListener("keydown", (event) => {
    const { key, shiftKey } = event, step = { ArrowLeft: -span / 100, ArrowRight: span / 100 }[key];
    const turn = shiftKey && { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[key];
    if (key === " ") playing ? pause() : play();
    else if (turn) orbit(...turn);
    else if (step) seek(motion.now + step);
    else if ("+-".includes(key)) zoom(key === "+" ? 0.9 : 1 / 0.9);
    else if (key === "0") look("fit");
    else return;
    event.preventDefault();
  }, { signal });
  const fingers = new Map();
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
  }, { signal });
  for (const name of ["pointerup", "pointercancel"])
    canvas.addEventListener(name, (event) => fingers.delete(event.pointerId), { signal });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const dx = (event.clientX - before[0]) / canvas.clientHeight, dy = (event.clientY - before[1]) / canvas.clientHeight;
    if (fingers.size === 2) {
      const other = [...fingers].find(([id]) => id !== event.pointerId)[1];
      const gap = (x, y) => Math.hypot(x - other[0], y - other[1]) || 1;
      zoom(gap(...before) / gap(event.clientX, event.clientY));
    } else if (event.shiftKey || event.buttons & 6) pan(dx * 2 * Math.tan(ANGLE / 2), dy * 2 * Math.tan(ANGLE / 2));
    else orbit(3 * dx, 3 * dy);
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
  }, { signal });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault(), { signal });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(0.0012 * event.deltaY));
  }, { passive: false, signal });
  canvas.addEventListener("dblclick", () => look("fit"), { signal });
  canvas.addEventListener("webglcontextrestored", () => (renderer.revive(), build(), draw()), { signal });
  let copy = null;
  window.addEventListener("beforeprint", () => (([fineness] = renderer.fine), draw(), (copy = printed(canvases))), { signal });
  window.addEventListener("afterprint", () => copy && copy.remove(), { signal });
  const watch = new ResizeObserver(() => (measure(), strip(), draw()));
  watch.observe(stage);

  for (const [name, box] of Object.entries(boxes)) box.checked = on[name];
  const natural = span / 10; // speed at which the motion takes 10 s
  pace(span >= 4 && span <= 60 ? 1 : SPEEDS.reduce((a, b) => (Math.abs(Math.log(b / natural)) < Math.abs(Math.log(a / natural)) ? b : a)));
  pause();
  if (length(subtract(bounds.high, bounds.low)) > 5 * bounds.reach) on.follow = boxes.follow.checked = true;
  followed = middle();
  measure();
  fit();
  seek(motion.first);
  // Takes over the state of another player: switches, eye, speed and time.
  function restore(old) {
    for (const [name, value] of Object.entries(old.on)) {
      on[name] = value;
      if (boxes[name]) boxes[name].checked = value;
    }
    [eye.target, eye.toward, eye.up, eye.distance] = [old.target, old.toward, old.up, old.distance];
    followed = middle();
    pace(old.speed);
    seek(old.time);
    if (old.playing) play();
  }
  // Shows another motion of the machine, at the same time and, if it does not leave the picture, from the same place;
  // with ``shaped``, bodies have other shapes.
  function take(next, shaped) {
    const time = motion.now;
    hurry(2);
    scene = next;
    motion = new Motion(scene);
    if (shaped) shape();
    trace();
    followed = middle();
    const needed = framing(eye.target).distance / eye.distance;
    if (!eye.chosen && !on.follow && !(needed > 0.4 && needed < 1.15)) fit();
    put(time); // who shows another motion draws its charts anew
  }
  function dispose() {
    playing = false;
    clearTimeout(rest);
    watch.disconnect();
    hands.abort();
    renderer.release();
    return canvases;
  }
  return {
    get motion() {
      return motion;
    },
    signal, take, restore, dispose, play, pause, seek, show, look, orbit, pan, zoom, pace, draw,
    listen: (listener) => listeners.push(listener),
    // Boxes [left, top, right, bottom] of the texts and of the heads of arrows in the picture [pixels of the canvas], and how many texts had no room.
    get written() {
      return written;
    },
    get state() {
      return { time: motion.now, playing, speed, drawn, kind: renderer.kind, on: { ...on }, toward: [...eye.toward], target: [...eye.target], up: [...eye.up], distance: eye.distance };
    },
  };
}
