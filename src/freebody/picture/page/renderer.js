"use strict";
// Two renderers with the same functions: WebGL, and a 2-D canvas (farthest first) for browsers without WebGL.
//
//   canvas                             the canvas on which it draws
//   fine                               points of the canvas per point of the page, each way: of pictures that stay, of a motion that plays, of one that follows a slider
//   surface(corners)                   returns a surface, from triangles as solids.js makes them
//   path(points)                       returns a polyline, from numbers x, y, z, ...
//   begin(camera)                      begins a new picture
//   solid(surface, matrix, color, opacity, through)     draws a surface; with ``through``, pale where hidden (WebGL only)
//   floor(surface, matrix, color)      draws a surface that everything else covers, in one plain colour
//   line(path, color, width, first, last, opacity, under)      draws segments of a polyline; ``under`` all bodies, like a floor
//   end()                              ends the picture
//   forget(item)                       frees a surface or a path
//   release()                          frees all surfaces and paths
//   revive()                           begins anew after a loss of the graphics card's memory: surfaces and paths are gone

const PAPER = [1, 1, 1];

const SOLID_VERTEX = `
attribute vec3 position, normal; attribute float tone;
uniform mat4 model, eye; varying vec3 n, p; varying float k;
void main() { vec4 q = model * vec4(position, 1.0); p = q.xyz; n = mat3(model) * normal; k = tone; gl_Position = eye * q; }`;
const SOLID_FRAGMENT = `
precision mediump float;
uniform vec3 color, light, camera; uniform float opacity; varying vec3 n, p; varying float k;
void main() {
  vec3 e = normalize(camera - p), m = normalize(n);
  if (dot(m, e) < 0.0) m = -m;
  float d = max(dot(m, light), 0.0), s = pow(max(dot(m, normalize(light + e)), 0.0), 40.0);
  gl_FragColor = vec4(color * k * (0.48 + 0.56 * d) + 0.16 * s, opacity);
}`;
// A segment is a rectangle of two triangles on the screen.
const LINE_VERTEX = `
attribute vec3 a, b; attribute vec2 corner; uniform mat4 eye; uniform vec2 pixels; uniform float width;
void main() {
  vec4 p = eye * vec4(a, 1.0), q = eye * vec4(b, 1.0);
  vec2 d = (q.xy / max(q.w, 1e-6) - p.xy / max(p.w, 1e-6)) * pixels;
  float l = length(d); d = l > 1e-6 ? d / l : vec2(1.0, 0.0);
  vec4 r = corner.x < 0.5 ? p : q;
  r.xy += (vec2(-d.y, d.x) * corner.y + d * (corner.x - 0.5)) * width * r.w / pixels;
  gl_Position = r;
}`;
const CORNERS = [0, -1, 1, -1, 1, 1, 0, -1, 1, 1, 0, 1];
// A surface in one plain colour.
const PLAIN_VERTEX = `
attribute vec3 position; uniform mat4 model, eye;
void main() { gl_Position = eye * (model * vec4(position, 1.0)); }`;
const PLAIN_FRAGMENT = `
precision mediump float; uniform vec3 color; uniform float opacity;
void main() { gl_FragColor = vec4(color, opacity); }`;

// Where no graphics card draws, the time of a picture grows with its points: pictures have half as many each way while they follow a slider. Antialiasing
// by WebGL would be there in all of them; instead, pictures that stay have twice as many points each way, which the browser averages.
function webgl(canvas, slow = false) {
  const gl = canvas.getContext("webgl", { antialias: !slow, alpha: false });
  if (!gl) return null;
  const card = gl.getExtension("WEBGL_debug_renderer_info");
  if (!slow && /swiftshader|llvmpipe|softpipe|software|basic render/i.test(gl.getParameter(card ? card.UNMASKED_RENDERER_WEBGL : gl.RENDERER))) {
    const other = canvas.cloneNode(); // a canvas keeps its kind of context
    canvas.replaceWith(other);
    return webgl(other, true);
  }
  const program = (vertex, fragment) => {
    const result = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(result, shader);
    }
    gl.linkProgram(result);
    if (!gl.getProgramParameter(result, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(result));
    const names = { attributes: {}, uniforms: {}, program: result };
    for (let i = gl.getProgramParameter(result, gl.ACTIVE_ATTRIBUTES); i--; ) {
      const { name } = gl.getActiveAttrib(result, i);
      names.attributes[name] = gl.getAttribLocation(result, name);
    }
    for (let i = gl.getProgramParameter(result, gl.ACTIVE_UNIFORMS); i--; ) {
      const { name } = gl.getActiveUniform(result, i);
      names.uniforms[name] = gl.getUniformLocation(result, name);
    }
    return names;
  };
  let solids, lines, plain;
  const buffers = new Set();
  const revive = () => {
    buffers.clear();
    [solids, lines, plain] = [[SOLID_VERTEX, SOLID_FRAGMENT], [LINE_VERTEX, PLAIN_FRAGMENT], [PLAIN_VERTEX, PLAIN_FRAGMENT]].map((pair) => program(...pair));
    gl.enable(gl.DEPTH_TEST);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  };
  revive();
  canvas.addEventListener("webglcontextlost", (event) => event.preventDefault()); // so that it can be restored
  const newBuffer = () => {
    const buffer = gl.createBuffer();
    buffers.add(buffer);
    return buffer;
  };
  let camera, later, behind, used = null, room = new Float32Array(0);
  // Numbers for the segments of a path, in the same place each time.
  const strips = (count) => {
    if (room.length < count) room = new Float32Array(2 * count);
    return room.subarray(0, count);
  };

  const use = (names, buffer, layout, stride) => {
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    if (used !== names) { // no program has more than three attributes
      gl.useProgram(names.program);
      for (const [name] of layout) gl.enableVertexAttribArray(names.attributes[name]);
      gl.uniformMatrix4fv(names.uniforms.eye, false, camera.matrix);
      if (names === solids) {
        gl.uniform3fv(names.uniforms.light, camera.light);
        gl.uniform3fv(names.uniforms.camera, camera.eye);
      } else if (names === lines) gl.uniform2f(names.uniforms.pixels, canvas.width / 2, canvas.height / 2);
      used = names;
    }
    for (const [name, size, offset] of layout) gl.vertexAttribPointer(names.attributes[name], size, gl.FLOAT, false, 4 * stride, 4 * offset);
  };
  const LAYOUT = [["position", 3, 0], ["normal", 3, 3], ["tone", 1, 6]];
  const drawSolid = (surface, matrix, color, opacity, names = solids) => {
    use(names, surface.buffer, names === plain ? LAYOUT.slice(0, 1) : LAYOUT, STRIDE);
    gl.uniformMatrix4fv(names.uniforms.model, false, matrix);
    gl.uniform3fv(names.uniforms.color, color);
    gl.uniform1f(names.uniforms.opacity, opacity);
    gl.drawArrays(gl.TRIANGLES, 0, surface.count);
  };
  return {
    kind: "webgl", canvas, fine: slow ? [2, 1, 0.5] : [1, 1, 1],
    surface(corners) {
      const buffer = newBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, corners, gl.STATIC_DRAW);
      return { buffer, count: corners.length / STRIDE };
    },
    path(points, old) {
      const segments = Math.max(points.length / 3 - 1, 0), data = strips(48 * segments);
      for (let i = 0, k = 0; i < segments; i++)
        for (let n = 0; n < 12; n += 2) {
          for (let j = 0; j < 6; j++) data[k++] = points[3 * i + j];
          data[k++] = CORNERS[n];
          data[k++] = CORNERS[n + 1];
        }
      const buffer = old ? old.buffer : newBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, data, old ? gl.DYNAMIC_DRAW : gl.STATIC_DRAW);
      return { buffer, segments };
    },
    begin(view) {
      camera = view;
      later = [];
      behind = [];
      used = null;
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.clearColor(...PAPER, 1);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    },
    solid(surface, matrix, color, opacity = 1, through = false) {
      if (opacity < 1) later.push([surface, matrix, color, opacity]);
      else drawSolid(surface, matrix, color, opacity);
      if (through) behind.push([surface, matrix, color, 0.3]);
    },
    floor(surface, matrix, color) {
      gl.disable(gl.DEPTH_TEST);
      drawSolid(surface, matrix, color, 1, plain);
      gl.enable(gl.DEPTH_TEST);
    },
    line(path, color, width, first = 0, last = path.segments, opacity = 1, under = false) {
      if (last <= first) return;
      if (under) gl.disable(gl.DEPTH_TEST);
      use(lines, path.buffer, [["a", 3, 0], ["b", 3, 3], ["corner", 2, 6]], 8);
      gl.uniform1f(lines.uniforms.width, (width * camera.ratio) / 2);
      gl.uniform3fv(lines.uniforms.color, color);
      gl.uniform1f(lines.uniforms.opacity, opacity);
      if (opacity < 1) gl.enable(gl.BLEND);
      gl.drawArrays(gl.TRIANGLES, 6 * first, 6 * (last - first));
      gl.disable(gl.BLEND);
      gl.enable(gl.DEPTH_TEST);
    },
    end() {
      gl.enable(gl.BLEND);
      gl.depthMask(false);
      for (const solid of later) drawSolid(...solid);
      gl.depthFunc(gl.GREATER); // only the hidden parts
      for (const solid of behind) drawSolid(...solid);
      gl.depthFunc(gl.LESS);
      gl.depthMask(true);
      gl.disable(gl.BLEND);
      // A renderer that is a program begins to draw where something reads the picture (ANGLE ends its pass there), else when the page is shown: the page
      // would wait for it then.
      if (slow) gl.copyTexImage2D(gl.TEXTURE_2D, 0, gl.RGB, 0, 0, 1, 1, 0);
      gl.flush();
    },
    forget({ buffer }) {
      gl.deleteBuffer(buffer);
      buffers.delete(buffer);
    },
    release() {
      for (const buffer of buffers) gl.deleteBuffer(buffer);
      buffers.clear();
    },
    revive,
  };
}

function flat(canvas) {
  const pen = canvas.getContext("2d");
  let camera, list;
  // x, y and depth on the screen, a smaller depth is nearer; null behind the eye
  const projected = (m, p) => {
    const w = m[3] * p[0] + m[7] * p[1] + m[11] * p[2] + m[15];
    if (w < 1e-6) return null;
    const [x, y] = point(m, p);
    return [((1 + x / w) * canvas.width) / 2, ((1 - y / w) * canvas.height) / 2, w];
  };
  const css = (color, k, opacity) =>
    `rgba(${color.map((c) => Math.round(255 * Math.min(1, c * k))).join()},${opacity})`;
  return {
    kind: "canvas", canvas, fine: [1, 0.5, 0.5],
    surface: (corners) => ({ corners, count: corners.length / STRIDE }),
    path: (points) => ({ points, segments: Math.max(points.length / 3 - 1, 0) }),
    begin(view) {
      camera = view;
      list = [];
      pen.fillStyle = css(PAPER, 1, 1);
      pen.fillRect(0, 0, canvas.width, canvas.height);
    },
    solid({ corners }, matrix, color, opacity = 1) {
      const all = product(camera.matrix, matrix);
      for (let i = 0; i < corners.length; i += 3 * STRIDE) {
        const corner = (k) => corners.subarray(i + k * STRIDE, i + (k + 1) * STRIDE);
        const points = [0, 1, 2].map((k) => projected(all, corner(k)));
        if (points.includes(null)) continue;
        let n = unit(turned(matrix, corner(0).subarray(3)));
        if (dot(n, subtract(camera.eye, point(matrix, corner(0)))) < 0) n = scale(-1, n);
        const light = corners[i + 6] * (0.48 + 0.56 * Math.max(dot(n, camera.light), 0));
        list.push([(points[0][2] + points[1][2] + points[2][2]) / 3, points, css(color, light, opacity), 0]);
      }
    },
    floor({ corners }, matrix, color) {
      const all = product(camera.matrix, matrix);
      for (let i = 0; i < corners.length; i += 3 * STRIDE) {
        const points = [0, 1, 2].map((k) => projected(all, corners.subarray(i + k * STRIDE, i + (k + 1) * STRIDE)));
        if (!points.includes(null)) list.push([Infinity, points, css(color, 1, 1), 0]);
      }
    },
    line({ points }, color, width, first = 0, last = points.length / 3 - 1, opacity = 1, under = false) {
      for (let i = first; i < last; i++) {
        const a = projected(camera.matrix, points.slice(3 * i, 3 * i + 3));
        const b = projected(camera.matrix, points.slice(3 * i + 3, 3 * i + 6));
        if (a && b) list.push([under ? Infinity : (a[2] + b[2]) / 2, [a, b], css(color, 1, opacity), width * camera.ratio]);
      }
    },
    end() {
      list.sort((a, b) => (a[0] === b[0] ? 0 : b[0] - a[0]));
      pen.lineCap = "round";
      for (const [, points, color, width] of list) {
        pen.beginPath();
        points.forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
        pen.strokeStyle = pen.fillStyle = color;
        pen.lineWidth = width || 0.7; // closes the seams between triangles
        if (!width) {
          pen.closePath();
          pen.fill();
        }
        pen.stroke();
      }
    },
    forget() {},
    release() {},
    revive() {},
  };
}
