// Draws bodies with WebGL2, in one context for the page.
// A value is one float per vertex; its colour is looked up for each pixel, so that contours follow
// the value and bands stay sharp.

const VERTEX = `#version 300 es
in vec3 place; in vec3 normal; in float value;
uniform mat4 clip; uniform mat3 turn;
out vec3 facing; out float shown;
void main() { gl_Position = clip * vec4(place, 1.0); facing = turn * normal; shown = value; }`;
const FRAGMENT = `#version 300 es
precision highp float;
in vec3 facing; in float shown;
uniform sampler2D map; uniform vec2 range; uniform float bands; uniform vec4 plain;
out vec4 colour;
void main() {
  vec3 n = normalize(facing);
  if (!(dot(n, n) > 0.5)) n = vec3(0.0, 0.0, 1.0);
  if (n.z < 0.0) n = -n;
  float light = 0.60 + 0.28 * max(dot(n, vec3(-0.32, 0.55, 0.77)), 0.0) + 0.18 * n.z;
  float t = clamp((shown - range.x) / max(range.y - range.x, 1e-30), 0.0, 1.0);
  if (bands > 0.0) t = (min(floor(t * bands), bands - 1.0) + 0.5) / bands;
  vec3 tint = texelFetch(map, ivec2(t * 255.0 + 0.5, 0), 0).rgb;
  colour = vec4(mix(tint, plain.rgb, plain.a) * light, 1.0);
}`;
const EDGE_VERTEX = `#version 300 es
in vec3 place; uniform mat4 clip;
void main() { gl_Position = clip * vec4(place, 1.0); }`;
const EDGE_FRAGMENT = `#version 300 es
precision mediump float; uniform vec4 ink; out vec4 colour;
void main() { colour = vec4(ink.rgb * ink.a, ink.a); }`;

// Whether a surface has no rim: each edge is gone along as often one way as the other, so the
// marks of all edges, counted with their way, cancel.
const isClosed = ({ triangles, node }) => {
  const mark = (a, b) => (Math.imul(a, 0x9e3779b1) ^ Math.imul(b + 0x7f4a7c15, 0x85ebca6b)) >>> 0;
  let sum = 0;
  for (let t = 0; t < triangles.length; t += 3)
    for (let k = 0; k < 3; k++) {
      const a = node[triangles[t + k]], b = node[triangles[t + (k + 1) % 3]];
      sum += a < b ? mark(a, b) : -mark(b, a);
    }
  return sum === 0;
};

// A part as it is drawn: values and shape per vertex, and its place on the screen.
class Body {
  constructor(part) {
    this.part = part;
    const vertices = part.node.length;
    this.vertices = vertices;
    this.nodal = new Float32Array(part.n); // a value per node
    this.values = new Float32Array(vertices);
    this.shape = Float32Array.from(part.positions); // as drawn: with the deformation, if shown
    this.moved = null; // displacement per node, made when first needed
    this.screen = new Float64Array(3 * vertices);
    this.pose = NO_POSE;
    this.found = null; // what fieldValues told
    this.closed = isClosed(part);
    this.plain = true; // without colours of a field
    this.key = ""; // field and position of the values
    this.factor = 0; // of the deformation that is shown
    this.stamp = 0; // counts changes of the shape
    this.handles = null;
  }

  spread() { // values of nodes to vertices
    const { node } = this.part, { values, nodal } = this;
    for (let v = 0; v < values.length; v++) values[v] = nodal[node[v]];
  }

  deform(factor) { // by the displacement of the nodes times `factor`; 0 takes it back
    const { node, positions } = this.part, { shape, moved } = this;
    if (!factor || !moved) { shape.set(positions); return; }
    for (let v = 0; v < node.length; v++)
      for (let axis = 0; axis < 3; axis++)
        shape[3 * v + axis] = positions[3 * v + axis] + factor * moved[3 * node[v] + axis];
  }
}

// Whether WebGL2 is drawn by the processor: multisampling would then cost 2.5 times the time.
const drawnBySoftware = () => {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) throw new Error("this browser gives no WebGL2");
  const told = gl.getExtension("WEBGL_debug_renderer_info");
  const name = told ? String(gl.getParameter(told.UNMASKED_RENDERER_WEBGL)) : "";
  gl.getExtension("WEBGL_lose_context")?.loseContext(); // a page has 16 contexts
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
};

class Scene {
  // Raises an Error in words when there is no WebGL2.
  constructor(canvas, { lost, restored }) {
    this.canvas = canvas;
    this.software = drawnBySoftware();
    const wanted = { antialias: !this.software, alpha: true, premultipliedAlpha: true };
    this.gl = this.canvas.getContext("webgl2", wanted);
    if (!this.gl) throw new Error("this browser gives no WebGL2");
    this.bodies = new Set();
    this.canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault(); // else it is never restored
      for (const body of this.bodies) body.handles = null;
      lost();
    });
    this.canvas.addEventListener("webglcontextrestored", () => {
      this.prepare();
      restored();
    });
    this.prepare();
  }

  get isLost() { return this.gl.isContextLost(); }

  prepare() {
    const gl = this.gl;
    this.surface = this.program(VERTEX, FRAGMENT,
      ["clip", "turn", "map", "range", "bands", "plain"]);
    this.edge = this.program(EDGE_VERTEX, EDGE_FRAGMENT, ["clip", "ink"]);
    this.map = gl.createTexture();
    this.mapShown = null;
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.polygonOffset(1, 1);
    for (const body of this.bodies) this.upload(body);
  }

  program(vertex, fragment, uniforms) {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    ["place", "normal", "value"].forEach((name, at) => gl.bindAttribLocation(program, at, name));
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost())
      throw new Error(`a shader was refused: ${gl.getProgramInfoLog(program)}`);
    const places = uniforms.map((name) => [name, gl.getUniformLocation(program, name)]);
    return { program, ...Object.fromEntries(places) };
  }

  add(body) {
    this.bodies.add(body);
    if (!this.isLost) this.upload(body);
  }

  upload(body) {
    const gl = this.gl, { part } = body;
    const array = (data, at, size, usage) => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, data, usage);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, size, gl.FLOAT, false, 0, 0);
      return buffer;
    };
    const indices = (data) => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, data, gl.STATIC_DRAW);
    };
    const faces = gl.createVertexArray();
    gl.bindVertexArray(faces);
    const shape = array(body.shape, 0, 3, gl.DYNAMIC_DRAW);
    array(part.normals, 1, 3, gl.STATIC_DRAW);
    const values = array(body.values, 2, 1, gl.DYNAMIC_DRAW);
    indices(part.triangles);
    const lines = gl.createVertexArray();
    gl.bindVertexArray(lines);
    gl.bindBuffer(gl.ARRAY_BUFFER, shape);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    indices(part.edges);
    gl.bindVertexArray(null);
    body.handles = { faces, lines, shape, values };
  }

  // Take over new values, or a new shape, of a body that was added.
  renew(body, { shape = false } = {}) {
    if (!body.handles) return; // lost: all is uploaded when the context comes back
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, shape ? body.handles.shape : body.handles.values);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, shape ? body.shape : body.values);
  }

  useMap(table) {
    const gl = this.gl;
    gl.bindTexture(gl.TEXTURE_2D, this.map);
    if (this.mapShown === table) return;
    const { RGB8, RGB, UNSIGNED_BYTE, TEXTURE_2D } = gl;
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(TEXTURE_2D, 0, RGB8, table.length / 3, 1, 0, RGB, UNSIGNED_BYTE, table);
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T])
      gl.texParameteri(TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
      gl.texParameteri(TEXTURE_2D, filter, gl.LINEAR);
    this.mapShown = table;
  }

  // Draw bodies as the camera sees them. look: {table (256 * 3 bytes), from, to, bands, ink [r, g,
  // b, a], plain [r, g, b]}; `ratio` device pixels per CSS pixel.
  draw(bodies, camera, look, ratio) {
    if (this.isLost) return;
    const gl = this.gl;
    const width = Math.max(1, Math.round(camera.width * ratio));
    const height = Math.max(1, Math.round(camera.height * ratio));
    if (this.canvas.width !== width || this.canvas.height !== height)
      Object.assign(this.canvas, { width, height });
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const drawn = bodies.filter((body) => body.handles);
    gl.useProgram(this.surface.program);
    this.useMap(look.table);
    gl.uniform2f(this.surface.range, look.from, look.to);
    gl.uniform1f(this.surface.bands, look.bands);
    gl.disable(gl.BLEND);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    for (const body of drawn) {
      gl.uniformMatrix4fv(this.surface.clip, false, camera.clip(body.pose));
      gl.uniformMatrix3fv(this.surface.turn, false, camera.normals(body.pose));
      gl.uniform4f(this.surface.plain, ...look.plain, body.plain ? 1 : 0);
      gl.bindVertexArray(body.handles.faces);
      if (body.closed) gl.enable(gl.CULL_FACE); else gl.disable(gl.CULL_FACE);
      gl.drawElements(gl.TRIANGLES, body.part.triangles.length, gl.UNSIGNED_INT, 0);
    }
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.enable(gl.BLEND);
    gl.useProgram(this.edge.program);
    gl.uniform4f(this.edge.ink, ...look.ink);
    for (const body of drawn) {
      gl.uniformMatrix4fv(this.edge.clip, false, camera.clip(body.pose));
      gl.bindVertexArray(body.handles.lines);
      gl.drawElements(gl.LINES, body.part.edges.length, gl.UNSIGNED_INT, 0);
    }
    gl.bindVertexArray(null);
  }
}
