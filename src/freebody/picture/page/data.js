"use strict";
// The data of the page: a tree with arrays, as packing.py writes them.

async function unpacked(text) {
  const raw = atob(text), packed = Uint8Array.from(raw, (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const buffer = await new Response(stream).arrayBuffer(), from = 4 + new DataView(buffer).getUint32(0, true);
  const tree = new TextDecoder().decode(new Uint8Array(buffer, 4, from - 4));
  return JSON.parse(tree, (_, value) => (value && value["#"] ? numbers(buffer, from, value["#"]) : value));
}

function numbers(buffer, from, [kind, count, places]) {
  if (kind === "byte") return new Uint8Array(buffer, from + places, count);
  const whole = (place) => { // the lowest bytes of all come first
    const all = new Uint8Array(buffer, from + place, 4 * count);
    return Uint32Array.from({ length: count }, (_, i) => all[i] | (all[count + i] << 8) | (all[2 * count + i] << 16) | (all[3 * count + i] << 24));
  };
  if (kind !== "rounded") {
    const bits = whole(places);
    for (let i = 1; i < count; i++) bits[i] += bits[i - 1];
    return kind === "real" ? new Float32Array(bits.buffer) : bits;
  }
  const width = places.length, result = new Float32Array(count * width);
  places.forEach(([step, order, place], j) => {
    const zigzags = whole(place);
    for (let i = 0, difference = 0, value = 0; i < count; i++) {
      const stored = (zigzags[i] >>> 1) ^ -(zigzags[i] & 1);
      difference = order === 2 ? difference + stored : stored;
      value += difference;
      result[i * width + j] = step * value;
    }
  });
  return result;
}
