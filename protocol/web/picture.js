// This file keeps the panorama on the GPU and draws a view of it.
//
// All tiles lie in one texture: level n of the protocol is mip level n. A second texture has an entry for each tile of level
// 0, which says what is the finest level that has come there; the shader shows that level. A third one has what the overlays
// show. The fragment shader turns every pixel of the view into a direction and looks the direction up in the panorama.
//
// Some tiles must fade in (Tile.fade_ms). What was shown in their place is first drawn into a slot of an atlas, and the
// shader mixes the two until the fade is over. There are 255 slots; if all are in use, a tile is shown at once.

const VERTEX = `#version 300 es
const vec2 corner[3] = vec2[3](vec2(-1, -1), vec2(3, -1), vec2(-1, 3));
out vec2 at;
void main() {
  at = corner[gl_VertexID];
  gl_Position = vec4(at, 0, 1);
}`;

const TRAIL = 24; // gaze samples that are drawn
const SLOTS = 256, ACROSS = 16; // slots of the atlas, and how many lie in a row; slot 0 stands for none

// What the panorama shows in a place.
const LOOK_UP = `#version 300 es
precision highp float;
precision highp int;
precision highp usampler2D;
in vec2 at;
out vec4 colour;
uniform sampler2D film;
uniform usampler2D shown;    // per tile of level 0: finest level that has come, or 255; slot of what it replaces, or 0
uniform sampler2D former;    // the atlas
uniform vec4 progress[${SLOTS / 4}]; // of the fade in each slot: 0 at its beginning, 1 at its end
uniform ivec2 size;          // of level 0, pixels
uniform int tile, least;     // least: finest level that the texture holds

// A texel of a level, or what is shown instead of it: a texel of the finest level that has come there.
vec3 texelAt(ivec2 texel, int level) {
  uvec2 state = texelFetch(shown, (texel << level) / tile, 0).rg;
  int own = int(state.r), slot = int(state.g);
  if (own == 255) return vec3(0);
  texel = own > level ? texel >> (own - level) : (texel << (level - own)) + ((1 << (level - own)) >> 1);
  vec3 c = texelFetch(film, texel, own - least).rgb;
  if (slot == 0) return c;
  ivec2 place = ivec2(slot % ${ACROSS}, slot / ${ACROSS}) * tile + texel % tile;
  return mix(texelFetch(former, place, 0).rgb, c, progress[slot / 4][slot % 4]);
}

// The four texels of the level that is shown in a place, interpolated.
vec3 lookUp(vec2 uv) {
  ivec2 cell = clamp(ivec2(uv * vec2(size)) / tile, ivec2(0), size / tile - 1);
  int level = int(texelFetch(shown, cell, 0).r);
  if (level == 255) return vec3(0);
  ivec2 levelSize = size >> level;
  vec2 p = uv * vec2(levelSize) - 0.5, f = fract(p);
  ivec2 first = ivec2(floor(p));
  vec3 sum = vec3(0);
  for (int k = 0; k < 4; k++) {
    ivec2 corner = ivec2(k & 1, k >> 1), texel = first + corner;
    // Beyond a pole is the same row again, half a turn further.
    if (texel.y < 0 || texel.y >= levelSize.y) texel = ivec2(texel.x + levelSize.x / 2, texel.y < 0 ? 0 : levelSize.y - 1);
    texel.x = (texel.x + levelSize.x) % levelSize.x;
    sum += texelAt(texel, level) * (corner.x == 1 ? f.x : 1.0 - f.x) * (corner.y == 1 ? f.y : 1.0 - f.y);
  }
  return sum;
}

`;

// What is shown where a tile will be, at its own level.
const KEEP = LOOK_UP + `
uniform ivec2 corner;        // the tile's first texel
uniform int level;
void main() {
  colour = vec4(lookUp((vec2(corner) + gl_FragCoord.xy) / vec2(size >> level)), 1);
}`;

const FRAGMENT = LOOK_UP + `
uniform mat4 toWorld;        // from the view's clip space to directions in the world
uniform sampler2D figures;   // per tile of level 0: log2 of paths per pixel over 16, error, converged, settled
uniform int overlay, curve;
uniform float exposure;
uniform bool rings, trail;
uniform vec3 gaze[${TRAIL}]; // newest first
uniform int gazes;
const float PI = 3.14159265358979;

// Near a pole texels are narrow. This is the mean of texels side by side that are together as wide as one is high.
vec3 lookAround(vec2 uv, float slimness) {
  float wide = min(1.0 / max(slimness, 1e-4), float(size.x)) - 1.0;
  int taps = int(clamp(wide + 1.5, 1.0, 32.0));
  vec3 sum = vec3(0);
  for (int k = 0; k < taps; k++) {
    float aside = ((float(k) + 0.5) / float(taps) - 0.5) * wide / float(size.x);
    sum += lookUp(vec2(fract(uv.x + aside), uv.y));
  }
  return sum / float(taps);
}

vec3 display(vec3 linear) {
  vec3 c = linear * exposure;
  // Hable 2010, "Filmic tonemapping for real-time rendering", with white at 11.2
  if (curve == 1) {
    vec4 x = vec4(2.0 * c, 11.2);
    vec4 y = (x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 0.02 / 0.3;
    c = y.rgb / y.a;
  }
  c = clamp(c, 0.0, 1.0);
  return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(vec3(0.0031308), c));
}

// From dark violet over green to yellow: a polynomial through viridis (van der Walt and Smith 2015).
vec3 scale(float t) {
  t = clamp(t, 0.0, 1.0);
  return clamp(vec3(0.28 + t * (-0.33 + t * (-0.6 + t * 1.65)), 0.01 + t * (1.45 - t * 0.56), 0.33 + t * (1.2 + t * (-2.5 + t * 1.1))), 0.0, 1.0);
}

void main() {
  vec4 far = toWorld * vec4(at, 1, 1);
  vec3 d = normalize(far.xyz);
  vec2 uv = vec2(0.5 + atan(d.x, -d.z) / (2.0 * PI), 0.5 - asin(clamp(d.y, -1.0, 1.0)) / PI);
  uv = vec2(fract(uv.x), clamp(uv.y, 0.0, 1.0));
  vec3 c = display(lookAround(uv, length(d.xz)));
  vec4 figure = texelFetch(figures, clamp(ivec2(uv * vec2(size)) / tile, ivec2(0), size / tile - 1), 0);
  if (overlay == 1) c = scale(figure.r);
  if (overlay == 2) c = scale(figure.g);
  if (overlay == 3) {
    float grey = dot(c, vec3(0.2, 0.7, 0.1));
    float stripes = step(0.5, fract((gl_FragCoord.x + gl_FragCoord.y) / 12.0));
    c = figure.b > 0.5 ? mix(vec3(grey), vec3(0.2, 0.9, 0.4), 0.4) : figure.a > 0.5 ? mix(vec3(grey), vec3(0.3, 0.6, 1.0), 0.25 + 0.3 * stripes) : vec3(grey);
  }
  if (gazes > 0) {
    float away = degrees(acos(clamp(dot(d, gaze[0]), -1.0, 1.0))), pixel = fwidth(away) + 1e-4;
    if (rings) {
      for (int k = 0; k < 4; k++) {
        float line = smoothstep(1.5, 0.5, abs(away - (k == 0 ? 5.79 : 5.0 * exp2(float(k)))) / pixel);
        c = mix(c, vec3(1.0, 0.85, 0.2), 0.7 * line);
      }
    }
    if (trail) {
      for (int k = gazes - 1; k >= 0; k--) {
        float near = degrees(acos(clamp(dot(d, gaze[k]), -1.0, 1.0)));
        float dot1 = smoothstep(0.35, 0.2, near) * (1.0 - float(k) / float(${TRAIL}));
        c = mix(c, k == 0 ? vec3(1.0, 0.2, 0.2) : vec3(1.0, 0.5, 0.2), 0.8 * dot1);
      }
    }
  }
  colour = vec4(c, 1);
}`;

function compile(gl, kind, text) {
  const shader = gl.createShader(kind);
  gl.shaderSource(shader, text);
  gl.compileShader(shader);
  if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
  return shader;
}

// A program of VERTEX and that fragment shader; place has the locations of its uniforms by name.
function makeProgram(gl, fragment) {
  const program = gl.createProgram();
  gl.attachShader(program, compile(gl, gl.VERTEX_SHADER, VERTEX));
  gl.attachShader(program, compile(gl, gl.FRAGMENT_SHADER, fragment));
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  return { program, place: new Proxy({}, { get: (known, name) => known[name] ??= gl.getUniformLocation(program, name) }) };
}

export class Picture {
  constructor(canvas) {
    const gl = this.gl = canvas.getContext('webgl2', { antialias: false, alpha: false, xrCompatible: true });
    if (!gl) throw new Error('This browser has no WebGL2.');
    this.view = makeProgram(gl, FRAGMENT);
    this.keep = makeProgram(gl, KEEP);
    this.canFade = Boolean(gl.getExtension('EXT_color_buffer_float') || gl.getExtension('EXT_color_buffer_half_float'));
    gl.bindVertexArray(gl.createVertexArray());
    this.textures = [];
    this.framebuffer = gl.createFramebuffer();
    this.widest = gl.getParameter(gl.MAX_TEXTURE_SIZE); // level that fits, pixels
    this.fades = new Map(); // by slot: { level, x, y, began, ends }, times in ms
    this.free = []; // slots
    this.progress = new Float32Array(SLOTS);
    this.now = () => performance.now();
    this.exposure = 1;
    this.curve = this.overlay = 0;
    this.rings = false;
    this.trail = true;
    this.gaze = []; // newest first
  }

  // Begin an empty film: width x height pixels in so many levels of tiles.
  begin({ width, height, tileSize, levels, generation }) {
    const gl = this.gl;
    for (const texture of this.textures) gl.deleteTexture(texture);
    this.width = width;
    this.height = height;
    this.tile = tileSize;
    this.generation = generation;
    this.least = 0;
    while (width >> this.least > this.widest) this.least++;
    this.columns = width / tileSize;
    this.rows = height / tileSize;
    const make = (unit, format, levels, w, h, filter) => {
      const texture = gl.createTexture();
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texStorage2D(gl.TEXTURE_2D, levels, format, w, h);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, levels > 1 ? gl.NEAREST_MIPMAP_NEAREST : filter);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
      return texture;
    };
    this.textures = [
      make(0, gl.RGB9_E5, levels - this.least, width >> this.least, height >> this.least, gl.NEAREST),
      make(1, gl.RG8UI, 1, this.columns, this.rows, gl.NEAREST),
      make(2, gl.RGBA8, 1, this.columns, this.rows, gl.NEAREST),
      make(3, gl.RGBA16F, 1, ACROSS * tileSize, SLOTS / ACROSS * tileSize, gl.NEAREST),
      make(4, gl.RGBA16F, 1, tileSize, tileSize, gl.NEAREST), // where KEEP draws: it cannot draw into what it reads
    ];
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.textures[4], 0);
    this.canFade &&= gl.checkFramebufferStatus(gl.FRAMEBUFFER) === gl.FRAMEBUFFER_COMPLETE;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    this.finest = new Uint8Array(this.columns * this.rows);
    this.slot = new Uint8Array(this.columns * this.rows); // of what a tile replaces
    this.figures = new Uint8Array(this.columns * this.rows * 4);
    this.empty(generation);
  }

  empty(generation) {
    this.generation = generation;
    this.finest.fill(255);
    this.slot.fill(0);
    this.figures.fill(0);
    this.fades.clear();
    this.free = Array.from({ length: SLOTS - 1 }, (_, i) => i + 1);
    this.changed = true;
  }

  // Take a tile to the GPU. False if it is not of this film, or finer than the GPU can hold.
  put({ generation, level, x, y, data, samples, error, converged, settled, fadeMs }) {
    if (!this.finest || generation < this.generation || level < this.least) return false;
    if (generation > this.generation) this.empty(generation);
    const gl = this.gl, words = new Uint32Array(data.slice().buffer), pixels = this.tile;
    if (words.length !== pixels * pixels) return false;
    const slot = fadeMs > 0 ? this.keepFormer(level, x, y, fadeMs) : 0;
    const w = Math.min(pixels, (this.width >> level) - x * pixels), h = Math.min(pixels, (this.height >> level) - y * pixels);
    gl.activeTexture(gl.TEXTURE0);
    gl.pixelStorei(gl.UNPACK_ROW_LENGTH, pixels);
    gl.texSubImage2D(gl.TEXTURE_2D, level - this.least, x * pixels, y * pixels, w, h, gl.RGB, gl.UNSIGNED_INT_5_9_9_9_REV, words);
    gl.pixelStorei(gl.UNPACK_ROW_LENGTH, 0);
    const perPixel = samples / (pixels * pixels * 4 ** level);
    const figure = [Math.log2(1 + perPixel) / 16 * 255, Number.isFinite(error) ? Math.min(error * 4, 1) * 255 : 255, converged * 255, settled * 255];
    for (const i of this.cells(level, x, y)) {
      if (level > this.finest[i]) continue; // a finer one shows there already
      this.finest[i] = level;
      this.slot[i] = slot;
      this.figures.set(figure, 4 * i);
    }
    return this.changed = true;
  }

  // The tiles of level 0 that a tile covers.
  *cells(level, x, y) {
    const span = 1 << level;
    for (let row = y * span; row < Math.min((y + 1) * span, this.rows); row++)
      for (let column = x * span; column < Math.min((x + 1) * span, this.columns); column++) yield row * this.columns + column;
  }

  // Is a tile fading in?
  get isFading() {
    return this.fades.size > 0;
  }

  // Keep what is shown where a tile will be, and begin its fade. The slot; 0 if none can be had.
  keepFormer(level, x, y, fadeMs) {
    const gl = this.gl, pixels = this.tile, began = this.now();
    this.advance(began);
    const slot = this.canFade && this.free.pop();
    if (!slot) return 0;
    this.update();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    gl.viewport(0, 0, pixels, pixels);
    this.use(this.keep);
    gl.uniform2i(this.keep.place.corner, x * pixels, y * pixels);
    gl.uniform1i(this.keep.place.level, level);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.activeTexture(gl.TEXTURE3);
    gl.copyTexSubImage2D(gl.TEXTURE_2D, 0, slot % ACROSS * pixels, Math.floor(slot / ACROSS) * pixels, 0, 0, pixels, pixels);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    this.fades.set(slot, { level, x, y, began, ends: began + fadeMs });
    this.progress[slot] = 0;
    return slot;
  }

  // Take all fades to this time, and end those that are over or whose tile is not shown any more.
  advance(now) {
    for (const [slot, { level, x, y, began, ends }] of this.fades) {
      const cells = [...this.cells(level, x, y)].filter((i) => this.slot[i] === slot);
      this.progress[slot] = Math.min(1, (now - began) / (ends - began));
      if (now < ends && cells.length) continue;
      for (const i of cells) this.slot[i] = 0;
      this.fades.delete(slot);
      this.free.push(slot);
      this.changed = true;
    }
  }

  // Bring what is known of tiles to the GPU.
  update() {
    const gl = this.gl;
    if (!this.changed) return;
    const shown = new Uint8Array(2 * this.finest.length);
    this.finest.forEach((level, i) => {
      shown[2 * i] = level;
      shown[2 * i + 1] = this.slot[i];
    });
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.activeTexture(gl.TEXTURE1);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, this.columns, this.rows, gl.RG_INTEGER, gl.UNSIGNED_BYTE, shown);
    gl.activeTexture(gl.TEXTURE2);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, this.columns, this.rows, gl.RGBA, gl.UNSIGNED_BYTE, this.figures);
    this.changed = false;
  }

  // Use a program, with what LOOK_UP needs.
  use({ program, place }) {
    const gl = this.gl;
    gl.useProgram(program);
    gl.uniform1i(place.film, 0);
    gl.uniform1i(place.shown, 1);
    gl.uniform1i(place.former, 3);
    gl.uniform4fv(place.progress, this.progress);
    gl.uniform2i(place.size, this.width, this.height);
    gl.uniform1i(place.tile, this.tile);
    gl.uniform1i(place.least, this.least);
  }

  // Draw what is seen through toWorld, the inverse of projection times rotation, into the viewport that is set.
  draw(toWorld) {
    const gl = this.gl, place = this.view.place;
    if (!this.finest) return;
    this.advance(this.now());
    this.update();
    this.use(this.view);
    gl.uniformMatrix4fv(place.toWorld, false, toWorld);
    gl.uniform1i(place.figures, 2);
    gl.uniform1i(place.overlay, this.overlay);
    gl.uniform1i(place.curve, this.curve);
    gl.uniform1f(place.exposure, this.exposure);
    gl.uniform1i(place.rings, this.rings ? 1 : 0);
    gl.uniform1i(place.trail, this.trail ? 1 : 0);
    gl.uniform1i(place.gazes, this.gaze.length);
    if (this.gaze.length) gl.uniform3fv(place.gaze, this.gaze.flat());
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  // The gaze is there now.
  look(direction) {
    this.gaze.unshift(direction);
    if (this.gaze.length > TRAIL) this.gaze.pop();
  }

  // Share of the film that shows the finest level that the texture holds.
  get coverage() {
    return this.finest ? this.finest.reduce((n, level) => n + (level === this.least), 0) / this.finest.length : 0;
  }
}
