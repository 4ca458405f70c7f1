"use strict";
// The machine of a live page in WebAssembly: from values of the sliders to the data of a motion.
//
// The module works on one record in its memory. The page knows the address and the length of each field.

const MET = 0;
const NO_CLOSING = {
  1: "There is no direction to close this setting in.",
  2: "This setting cannot be closed: the parts do not reach each other.",
  3: "These initial speeds contradict the conditions",
  4: "Closing this setting needs more memory than the page has.",
  5: "Other conditions are independent here. Simulate with these values, and write the page again.",
};

// Returns the simulator; throws where WebAssembly is not allowed.
async function simulator(live, scene) {
  const module = await WebAssembly.compile(live.module);
  const env = { exp2: (x) => 2 ** x };
  for (const { name } of WebAssembly.Module.imports(module)) env[name] = env[name] || Math[name];
  const { exports } = await WebAssembly.instantiate(module, { env });
  const field = {};
  for (const [name, [place, kind, shape]] of Object.entries(live.fields)) {
    const count = shape.reduce((product, n) => product * n, 1);
    field[name] = new (kind === "real" ? Float64Array : BigInt64Array)(exports.memory.buffer, place, count);
  }
  const whole = (name) => Number(field[name][0]);
  const wide = { outputs: live.fields.outputs[2][1], states: live.fields.states[2][1] };
  const usual = Float64Array.from(field.parameters), drawn = structuredClone({ bodies: scene.bodies, ground: scene.ground, lines: scene.lines, arrows: scene.arrows, cones: scene.cones });
  let shape = "";

  // Components of a frame over time.
  function column(source, place, count) {
    const n = whole("frames"), result = new Float32Array(n * count), values = field[source], width = wide[source];
    for (let k = 0; k < n; k++) for (let i = 0; i < count; i++) result[k * count + i] = values[k * width + place + i];
    return result;
  }
  // Puts the numbers of the drawing that follow the parameters; returns whether any changed.
  function draw() {
    const used = new Set(live.figure.flatMap(([, , slopes, tables]) => [...slopes, ...tables].map(([k]) => k)));
    const now = [...used].map((k) => field.parameters[k]).join();
    if (now === shape) return false;
    const first = shape === "" && [...used].every((k) => field.parameters[k] === usual[k]);
    shape = now;
    if (first) return false;
    for (const [path, value, slopes, tables] of live.figure) {
      const place = path.slice(0, -1).reduce((tree, key) => tree[key], drawn);
      const linear = slopes.reduce((sum, [k, slope]) => sum + slope * (field.parameters[k] - usual[k]), value);
      place[path[path.length - 1]] = tables.reduce((sum, [k, row]) => sum + tabulated(k, row), linear);
    }
    return true;
  }
  // Change of a number at the nodes of a parameter, interpolated.
  function tabulated(k, row) {
    const [first, step] = live.nodes[k], x = (field.parameters[k] - first) / step;
    const i = Math.min(row.length - 2, Math.max(0, Math.floor(x)));
    return mix(row[i], row[i + 1], x - i);
  }
  // Events in the order of time, the modes of contacts, and the first frames of phases after the first.
  function phases() {
    const events = [], count = whole("phases"), last = field.reached[0], width = live.contacts.length;
    for (let k = 0; k < whole("events"); k++) events.push([field.event_times[k], live.events[Number(field.event_numbers[k])]]);
    const modes = live.contacts.map(({ name, modes: names, gap }, i) => {
      const spans = [];
      let before = -1;
      for (let p = 0; p < count; p++) {
        const mode = Number(field.modes[p * width + i]), t = field.phase_times[p];
        const gapped = Math.abs(field.outputs[Number(field.phase_frames[p]) * wide.outputs + gap]) > 1e-7 * scene.size;
        if (p && mode !== before) events.push([t, `contact ${name}: ${names[before]} → ${names[mode]}`]);
        else if (p && mode === 0 && !gapped) events.push([t, `${name}: impact`]);
        if (mode !== before) spans.push([names[mode], t, last, `${name}: ${names[mode]} from ${digits(t)} s`]);
        if (spans.length > 1 && mode !== before) spans[spans.length - 2][2] = t;
        before = mode;
      }
      return { contact: name, spans };
    });
    events.sort(([a], [b]) => a - b);
    return { events, modes, breaks: Array.from(field.phase_frames.subarray(1, Math.max(1, count)), Number) };
  }
  // Distances of all contacts over time: beyond the ends of a side that of its nearest corner, else infinite.
  function distances() {
    const result = live.contacts.map(({ gap, reach }) => {
      const ends = column("outputs", reach, 2);
      return column("outputs", gap, 1).map((x, k) => (ends[2 * k] < 0 || ends[2 * k + 1] < 0 ? Infinity : x));
    });
    live.contacts.forEach(({ side }, i) => {
      if (side !== i) result[side] = result[side].map((x, k) => Math.min(x, result[i][k]));
    });
    return result;
  }
  // Points of a contact over time, and whether it is closed.
  function touching({ name, gap, forces, point }) {
    const all = column("outputs", gap + 1, forces), n = whole("frames");
    const closed = Float32Array.from({ length: n }, (_, k) => (all.subarray(k * forces, (k + 1) * forces).some((x) => x !== 0) ? 1 : 0));
    return { name, path: column("outputs", point, 3), closed };
  }
  function motion() {
    const n = whole("frames"), channels = {};
    for (const [key, { unit, width }] of Object.entries(scene.channels)) {
      const place = live.channels[key];
      if (place) channels[key] = { unit, width, values: column(...place) };
    }
    distances().forEach((values, i) => (channels[`gap ${live.contacts[i].name}`].values = values));
    const gained = (key, k) => { // since the start, in double precision
      if (!live.channels[key]) return 0;
      const [source, place] = live.channels[key], values = field[source];
      return values[k * wide[source] + place] - values[place];
    };
    const residual = Float32Array.from({ length: n }, (_, k) => gained("energy total", k) - gained("energy work", k));
    channels["energy residual"] = { unit: "J", width: 1, values: residual };
    const shaped = draw(), { events, modes, breaks } = phases();
    return {
      shaped,
      scene: {
        ...scene, channels, events, breaks, modes, touching: live.contacts.map(touching), ground: drawn.ground, lines: drawn.lines, cones: drawn.cones,
        t: Float32Array.from(field.times.subarray(0, n)),
        bodies: drawn.bodies.map((body, i) => ({
          ...body,
          position: column("outputs", live.bodies[i], 3),
          quaternion: quaternions(column("outputs", live.bodies[i] + 3, 9)),
          spin: column("outputs", live.bodies[i] + 12, 3),
        })),
        arrows: drawn.arrows.map((arrow) => {
          const point = arrow.path && live.points[arrow.channel];
          if (arrow.contact !== undefined) return { ...arrow, path: column("outputs", live.contacts[arrow.contact].point, 3) };
          return point === undefined ? arrow : { ...arrow, path: column("outputs", point, 3) };
        }),
      },
    };
  }
  // What stands in the way of a motion, as text; empty if it reached its end.
  function trouble() {
    const status = whole("status"), at = `at t = ${digits(field.reached[0])} s`;
    if (whole("fault") >= 0) return `Expected ${live.assumed[whole("fault")]} > 0.`;
    if (whole("closed") !== MET) {
      const text = NO_CLOSING[whole("closed")];
      return whole("closed") === 3 ? `${text}: ${live.conditions[whole("worst")]}.` : text;
    }
    const name = live.state[whole("blame")];
    return {
      1: "", 2: "",
      3: `${name} has no value ${at}: the motion is shown until then.`,
      4: `The steps become too short ${at}: the machine does not pass this position.`,
      7: `More than ${whole("steps")} steps: the motion is shown until t = ${digits(field.reached[0])} s.`,
      104: `No motion satisfies the laws of contact ${at} (Painlevé): the motion is shown until then.`,
      105: `Several motions satisfy the laws of contact ${at} (Painlevé): the motion is shown until then.`,
      110: `Contacts change their modes again and again ${at}: the motion is shown until then.`,
      114: `A contact was passed over within one step ${at}: the motion is shown until then.`,
      120: `The contact "${(live.contacts[whole("blame")] || {}).name}" begins below its surface.`,
      121: `More phases than the page has room for: the motion is shown until t = ${digits(field.reached[0])} s.`,
      14: `${live.laws[whole("blame")]} reaches zero ${at}, and the forces on either side of it lead back: what happens there is open.`,
      11: `The event "${live.events[whole("blame")]}" has no value ${at}.`,
    }[status] ?? `The motion stopped ${at}.`;
  }
  return {
    // Computes the motion with values of parameters, start values and length that the user chose.
    run({ values, initial, until }) {
      field.parameters.set(usual);
      field.given.fill(0n);
      for (const { group, name, place } of live.sliders) {
        if (group === "values" && name in values) field.parameters[place] = values[name];
        if (group === "initial" && name in initial) {
          field.given[place] = 1n;
          field.initial[place] = initial[name];
        }
      }
      field.until[0] = live.start + until;
      exports.simulate(live.record);
      const start = {};
      if (whole("frames")) for (const { group, name, place } of live.sliders) if (group === "initial") start[name] = field.states[place];
      return { problem: trouble(), steps: whole("steps"), start, answers: Array.from(field.answers), ...(whole("frames") > 1 ? motion() : {}) };
    },
  };
}

// Unit quaternions of rotation matrices (nine numbers by rows each), without jumps of sign (Shepperd, 1978).
function quaternions(rotations) {
  const count = rotations.length / 9, result = new Float32Array(4 * count);
  let lw = 1, lx = 0, ly = 0, lz = 0;
  for (let k = 0, j = 0; k < count; k++, j += 9) {
    const a = rotations[j], b = rotations[j + 1], c = rotations[j + 2], d = rotations[j + 3], e = rotations[j + 4];
    const f = rotations[j + 5], g = rotations[j + 6], h = rotations[j + 7], i = rotations[j + 8], trace = a + e + i;
    let w, x, y, z;
    if (trace >= a && trace >= e && trace >= i) [w, x, y, z] = [1 + trace, h - f, c - g, d - b];
    else if (a >= e && a >= i) [w, x, y, z] = [h - f, 1 + a - e - i, b + d, c + g];
    else if (e >= i) [w, x, y, z] = [c - g, b + d, 1 - a + e - i, f + h];
    else [w, x, y, z] = [d - b, c + g, f + h, 1 - a - e + i];
    const size = Math.sqrt(w * w + x * x + y * y + z * z) * (w * lw + x * lx + y * ly + z * lz < 0 ? -1 : 1);
    result[4 * k] = lw = w / size;
    result[4 * k + 1] = lx = x / size;
    result[4 * k + 2] = ly = y / size;
    result[4 * k + 3] = lz = z / size;
  }
  return result;
}
