"use strict";
// Values of a motion at any time, interpolated between the keyframes of the page.

class Motion {
  constructor(scene) {
    this.scene = scene;
    this.t = scene.t;
    this.first = this.t[0];
    this.last = this.t[this.t.length - 1];
    this.bodies = scene.bodies.map((body) => ({
      position: body.position, quaternion: body.quaternion, spin: body.spin,
    }));
    this.channels = {};
    for (const [key, { values, width }] of Object.entries(scene.channels))
      this.channels[key] = { values, width };
    this.seek(this.first);
  }

  // Sets the time: finds the interval between keyframes that contains it, and the fraction of the interval before it.
  seek(time) {
    const t = this.t;
    let low = 0, high = t.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (t[middle] <= time) low = middle; // at the time of a jump, the keyframe after it
      else high = middle;
    }
    this.now = time;
    this.index = low;
    // at a jump there are two keyframes at one time
    this.part = t[high] > t[low] ? Math.min(1, Math.max(0, (time - t[low]) / (t[high] - t[low]))) : 0;
  }

  vector(values, width = 3) {
    const i = width * this.index, j = i + width < values.length ? i + width : i, result = [];
    for (let k = 0; k < width; k++) result.push(mix(values[i + k], values[j + k], this.part));
    return result;
  }

  quaternion(i) {
    const { quaternion: q, spin } = this.bodies[i], j = this.index, n = Math.min(j + 1, this.t.length - 1);
    const mean = [0, 1, 2].map((k) => (spin[3 * j + k] + spin[3 * n + k]) / 2);
    const turn = scale(this.t[n] - this.t[j], mean);
    return between(q.subarray(4 * j, 4 * j + 4), q.subarray(4 * n, 4 * n + 4), turn, this.part);
  }

  pose(i) {
    return i < 0 ? placed([1, 0, 0, 0], [0, 0, 0]) : placed(this.quaternion(i), this.vector(this.bodies[i].position));
  }

  poseAt(i, k) {
    const { position, quaternion } = this.bodies[i];
    return placed(quaternion.subarray(4 * k, 4 * k + 4), position.subarray(3 * k, 3 * k + 3));
  }
}
