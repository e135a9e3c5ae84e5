/* Draws many copies of a few shapes with WebGL 2, lit by one sun that throws shadows. */

const SUN = unit([0.38, -0.52, 0.86]);       // towards the sun
const SHADOW_SIZE = 2048;                    // pixels of the shadow's picture
const INSTANCE = 16;                         // numbers of a copy: its frame, its colour and opacity

/** The ways in which a copy is drawn; what is `clear` is seen through. */
const MATERIALS = {
  solid: { lit: 1, casts: true },
  edged: { lit: 1, casts: true, edges: 1 },
  pane: { lit: 1, edges: 1, clear: true },            // a wall that is seen through
  glow: { lit: 0, clear: true },
  striped: { lit: 0, clear: true, stripes: 1 },
};

const VERTEX_SHADER = `#version 300 es
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in float fade;
layout(location = 3) in vec4 x_axis;         // the last of each: red, green, blue, opacity
layout(location = 4) in vec4 y_axis;
layout(location = 5) in vec4 z_axis;
layout(location = 6) in vec4 origin;
uniform mat4 view;
uniform mat4 sun_view;
out vec3 world, outwards, local, size, in_shadow;
out vec4 color;
void main() {
  mat3 axes = mat3(x_axis.xyz, y_axis.xyz, z_axis.xyz);
  size = vec3(length(x_axis.xyz), length(y_axis.xyz), length(z_axis.xyz));
  local = position;
  world = axes * position + origin.xyz;
  outwards = axes * (normal / max(size * size, 1e-9));
  color = vec4(x_axis.w, y_axis.w, z_axis.w, origin.w * fade);
  in_shadow = (sun_view * vec4(world, 1.0)).xyz * 0.5 + 0.5;
  gl_Position = view * vec4(world, 1.0);
}`;

const FRAGMENT_SHADER = `#version 300 es
precision highp float;
precision highp sampler2DShadow;
in vec3 world, outwards, local, size, in_shadow;
in vec4 color;
uniform float lit, edges, stripes, painted;
uniform vec3 sun, line;
uniform vec4 area;                           // left, bottom, width, height of the painted floor
uniform sampler2D picture;
uniform sampler2DShadow shadow;
out vec4 result;

float sunlight(vec3 normal) {
  float slope = dot(normal, sun);
  if (slope <= 0.0) return 0.0;
  vec3 at = in_shadow - vec3(0.0, 0.0, 0.0006 + 0.0012 * (1.0 - slope));
  if (any(lessThan(at, vec3(0.0))) || any(greaterThan(at, vec3(1.0)))) return slope;
  float sum = 0.0;
  for (int i = -1; i <= 1; i++)
    for (int j = -1; j <= 1; j++) sum += texture(shadow, at + vec3(vec2(i, j) / ${SHADOW_SIZE}.0, 0.0));
  return slope * sum / 9.0;
}

void main() {
  vec4 base = color;
  if (painted > 0.5) {
    vec2 place = (world.xy - area.xy) / area.zw;
    base = texture(picture, vec2(place.x, 1.0 - place.y));
    base.rgb = pow(base.rgb, vec3(2.2));
  }
  if (edges > 0.5) {                         // a thin line along the edges of a box
    vec3 away = vec3(0.5 - abs(local.xy), 0.5 - abs(local.z - 0.5)) * size;
    float near = max(min(away.x, away.y), min(max(away.x, away.y), away.z));
    float pixel = max(fwidth(near), 1e-5);
    base.rgb = mix(base.rgb, line, 0.55 * (1.0 - smoothstep(0.6, 1.6, near / pixel)) * clamp(0.02 / pixel, 0.15, 1.0));
  }
  if (stripes > 0.5) base.a *= 0.45 + 0.9 * step(0.5, fract((world.x + world.y + world.z) * 2.5));
  vec3 light = vec3(1.0);
  if (lit > 0.5) {
    vec3 normal = normalize(outwards) * (gl_FrontFacing ? 1.0 : -1.0);
    light *= mix(0.38, 0.58, 0.5 + 0.5 * normal.z) + 0.42 / sun.z * sunlight(normal);
  }
  result = vec4(pow(base.rgb * light, vec3(1.0 / 2.2)), base.a);
}`;

/** Copies of one shape in one material. */
class Copies {
  constructor(shape, material) {
    Object.assign(this, { shape, material, count: 0, isSent: false });
    this.numbers = new Float32Array(8 * INSTANCE);
  }

  clear() {
    this.count = 0;
    this.isSent = false;
  }

  /** `color` is red, green and blue as light (not as the screen's numbers). */
  add(frame, color, opacity = 1) {
    this.#reserve(1);
    const { numbers } = this;
    let at = INSTANCE * this.count++;
    for (let axis = 0; axis < 4; axis++) {
      numbers[at++] = frame[3 * axis];
      numbers[at++] = frame[3 * axis + 1];
      numbers[at++] = frame[3 * axis + 2];
      numbers[at++] = axis < 3 ? color[axis] : opacity;
    }
  }

  /** Adds the first `count` copies of others. */
  append(others, count) {
    this.#reserve(count);
    this.numbers.set(others.numbers.subarray(0, INSTANCE * count), INSTANCE * this.count);
    this.count += count;
  }

  #reserve(count) {
    const wanted = (this.count + count) * INSTANCE;
    if (wanted > this.numbers.length) {
      const more = new Float32Array(2 * wanted);
      more.set(this.numbers);
      this.numbers = more;
    }
    this.isSent = false;
  }
}

/** Copies of shapes, by material and shape; they can be emptied and filled anew at every frame. */
class Pile {
  constructor() {
    this.lists = [];
    this.byMaterial = new Map(Object.keys(MATERIALS).map(name => [name, new Map()]));
  }

  clear() {
    for (const list of this.lists) list.clear();
  }

  /** The copies of a shape. */
  of(shape, material) {
    const byShape = this.byMaterial.get(material);
    let list = byShape.get(shape);
    if (!list) {
      byShape.set(shape, list = new Copies(shape, material));
      this.lists.push(list);
    }
    return list;
  }

  add(shape, material, frame, color, opacity = 1) {
    this.of(shape, material).add(frame, color, opacity);
  }
}

class Renderer {
  /** Throws an Error where the browser has no WebGL 2; `onLost` is called where it is taken away. */
  constructor(canvas, onLost) {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: false });
    if (!gl) throw new Error("no WebGL 2");
    this.gl = gl;
    this.canvas = canvas;
    canvas.addEventListener("webglcontextlost", onLost);
    this.program = linked(gl, VERTEX_SHADER, FRAGMENT_SHADER);
    this.shadowProgram = linked(gl, VERTEX_SHADER, "#version 300 es\nprecision highp float;\nvoid main() {}");
    this.places = new Map();
    this.meshes = new Map(Object.entries(SOLIDS).map(([name, make]) => [name, this.#loaded(make())]));
    this.own = new WeakMap();            // names of shapes by what they belong to
    this.buffers = new WeakMap();
    this.picture = gl.createTexture();
    this.#makeShadow();
    gl.enable(gl.CULL_FACE);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  /** The name of a shape that belongs to a thing, and is made where it is not yet known. */
  learned(thing, make) {
    if (!this.own.has(thing)) {
      const name = `own ${this.meshes.size}`;
      this.meshes.set(name, this.#loaded(make()));
      this.own.set(thing, name);
    }
    return this.own.get(thing);
  }

  /** The picture that lies on the floor, and the box of the floor that it shows. */
  paint(canvas, { left, right, bottom, top }) {
    const { gl } = this;
    this.area = [left, bottom, right - left, top - bottom];
    gl.bindTexture(gl.TEXTURE_2D, this.picture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, canvas);
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    const finer = gl.getExtension("EXT_texture_filter_anisotropic");
    if (finer) gl.texParameterf(gl.TEXTURE_2D, finer.TEXTURE_MAX_ANISOTROPY_EXT, 8);
  }

  /** Draws piles as `eye` sees them; `background` and `line` are colours. */
  draw(piles, eye, background, line) {
    const { gl, area: [left, bottom, width, height] } = this;
    const middle = [left + width / 2, bottom + height / 2, 0];
    const around = 0.5 * Math.hypot(width, height) + 3;
    const sunView = product(parallelMatrix(around, 0, 2 * around),
      viewMatrix(middle.map((value, i) => value + SUN[i] * around), middle));
    const lists = piles.flatMap(pile => pile.lists).filter(list => list.count);
    const ofKind = isWanted => lists.filter(({ material }) => isWanted(MATERIALS[material]));
    for (const list of lists) this.#fill(list);

    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowFrame);
    gl.viewport(0, 0, SHADOW_SIZE, SHADOW_SIZE);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    this.#use(this.shadowProgram, sunView, sunView);
    gl.enable(gl.POLYGON_OFFSET_FILL);         // so that what is lit at a slant throws no shadow on itself
    gl.polygonOffset(2, 4);
    for (const list of ofKind(({ casts }) => casts)) this.#copy(list);
    gl.disable(gl.POLYGON_OFFSET_FILL);

    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(...background.map(value => value ** (1 / 2.2)), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.#use(this.program, eye.matrix, sunView);
    const set = (name, value) => gl.uniform1f(this.#place(name), value);
    gl.uniform3fv(this.#place("sun"), SUN);
    gl.uniform3fv(this.#place("line"), line);
    gl.uniform4fv(this.#place("area"), this.area);
    gl.uniform1i(this.#place("picture"), 0);
    gl.uniform1i(this.#place("shadow"), 1);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, this.shadow);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.picture);
    const drawAll = wanted => {
      for (const list of wanted) {
        const { lit, edges = 0, stripes = 0 } = MATERIALS[list.material];
        set("lit", lit);
        set("edges", list.shape === "box" ? edges : 0);
        set("stripes", stripes);
        this.#copy(list);
      }
    };
    set("painted", 0);
    drawAll(ofKind(({ clear }) => !clear));
    gl.enable(gl.BLEND);
    this.#drawFloor(set, middle);
    gl.depthMask(false);
    gl.disable(gl.CULL_FACE);
    drawAll(ofKind(({ clear }) => clear));
    gl.enable(gl.CULL_FACE);
  }

  #drawFloor(set, middle) {
    this.floor ??= new Pile();
    this.floor.clear();
    const [, , width, height] = this.area;
    this.floor.add("square", "solid", sized(frameAt(middle[0], middle[1]), width, height, 1), [1, 1, 1]);
    const [list] = this.floor.lists;
    this.#fill(list);
    set("lit", 1);
    set("edges", 0);
    set("stripes", 0);
    set("painted", 1);
    this.#copy(list);
    set("painted", 0);
  }

  #use(program, view, sunView) {
    const { gl } = this;
    gl.useProgram(program);
    this.current = program;
    gl.uniformMatrix4fv(this.#place("view"), false, view);
    gl.uniformMatrix4fv(this.#place("sun_view"), false, sunView);
  }

  /** Where a variable of the program in use is. */
  #place(name) {
    const key = `${this.current === this.program} ${name}`;
    if (!this.places.has(key)) this.places.set(key, this.gl.getUniformLocation(this.current, name));
    return this.places.get(key);
  }

  /** Sends the copies of a list to the graphics card, if they have changed. */
  #fill(list) {
    if (list.isSent) return;
    list.isSent = true;
    const { gl } = this;
    if (!this.buffers.has(list)) this.buffers.set(list, this.#wired(this.meshes.get(list.shape)));
    const { buffer } = this.buffers.get(list);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, list.numbers.subarray(0, INSTANCE * list.count), gl.DYNAMIC_DRAW);
  }

  #copy(list) {
    const { gl } = this;
    const { array, count } = this.buffers.get(list);
    gl.bindVertexArray(array);
    gl.drawElementsInstanced(gl.TRIANGLES, count, gl.UNSIGNED_SHORT, 0, list.count);
  }

  #loaded(mesh) {
    const { gl } = this;
    const load = (target, numbers) => {
      const buffer = gl.createBuffer();
      gl.bindVertexArray(null);
      gl.bindBuffer(target, buffer);
      gl.bufferData(target, numbers, gl.STATIC_DRAW);
      return buffer;
    };
    return {
      vertices: load(gl.ARRAY_BUFFER, new Float32Array(mesh.vertices)),
      triangles: load(gl.ELEMENT_ARRAY_BUFFER, new Uint16Array(mesh.triangles)),
      count: mesh.triangles.length,
    };
  }

  /** A mesh with a buffer for its copies. */
  #wired({ vertices, triangles, count }) {
    const { gl } = this;
    const array = gl.createVertexArray();
    const buffer = gl.createBuffer();
    gl.bindVertexArray(array);
    const attribute = (place, numbers, stride, offset, divisor) => {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, numbers, gl.FLOAT, false, 4 * stride, 4 * offset);
      gl.vertexAttribDivisor(place, divisor);
    };
    gl.bindBuffer(gl.ARRAY_BUFFER, vertices);
    attribute(0, 3, 7, 0, 0);
    attribute(1, 3, 7, 3, 0);
    attribute(2, 1, 7, 6, 0);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    for (let k = 0; k < 4; k++) attribute(3 + k, 4, INSTANCE, 4 * k, 1);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, triangles);
    gl.bindVertexArray(null);
    return { array, buffer, count };
  }

  #makeShadow() {
    const { gl } = this;
    this.shadow = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.shadow);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SHADOW_SIZE, SHADOW_SIZE);
    for (const [name, value] of [
      ["MIN_FILTER", gl.LINEAR], ["MAG_FILTER", gl.LINEAR], ["WRAP_S", gl.CLAMP_TO_EDGE],
      ["WRAP_T", gl.CLAMP_TO_EDGE], ["COMPARE_MODE", gl.COMPARE_REF_TO_TEXTURE],
    ]) gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${name}`], value);
    this.shadowFrame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowFrame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.shadow, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }
}

function linked(gl, vertexShader, fragmentShader) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertexShader], [gl.FRAGMENT_SHADER, fragmentShader]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
    const logs = gl.getAttachedShaders(program).map(shader => gl.getShaderInfoLog(shader));
    throw new Error([gl.getProgramInfoLog(program), ...logs].join(" "));
  }
  return program;
}

/** A colour of the style sheet (#rrggbb) as light: red, green and blue from 0 to 1. */
function lightOf(color) {
  const number = Number.parseInt(color.slice(1), 16);
  return [16, 8, 0].map(shift => (((number >> shift) & 255) / 255) ** 2.2);
}

const mixed = (a, b, share) => a.map((value, i) => value + share * (b[i] - value));
