// Messages of fovea.proto to bytes and back: the few kinds of field that they have, and no more.

// kind: u number, b truth, s text, y bytes, f float, d double, F floats, or the name of a message.
const SCHEMA = {
  Hello: { version: [1, 'u'], client: [2, 's'], tiles: [3, 'u'], window: [4, 'u'], gaze: [5, 'b'], stats: [6, 'b'], token: [7, 's'], widest: [8, 'u'], viewing: [9, 'b'] },
  View: { orientation: [1, 'F'], fovX: [2, 'f'], fovY: [3, 'f'], headset: [4, 'b'], screen: [5, 'F'], unasked: [6, 'b'] },
  Pointer: { direction: [1, 'F'] },
  Freeze: { frozen: [1, 'b'] },
  Acknowledge: { serial: [1, 'u'] },
  Ping: { clientNs: [1, 'u'] },
  Recentre: { request: [1, 'u'], direction: [2, 'F'] },
  Move: { request: [1, 'u'], camera: [2, 'F'], relative: [3, 'b'] },
  Welcome: { version: [1, 'u'], server: [2, 's'], width: [3, 'u'], height: [4, 'u'], tileSize: [5, 'u'], levels: [6, 'u'], generation: [7, 'u'], scene: [8, 's'], gazeSource: [9, 's'], distribution: [10, 's'], frozen: [11, 'b'] },
  Tile: { serial: [1, 'u'], generation: [2, 'u'], level: [3, 'u'], x: [4, 'u'], y: [5, 'u'], encoding: [6, 'u'], data: [7, 'y'], samples: [8, 'u'], error: [9, 'f'], converged: [10, 'b'], settled: [11, 'b'], gazeSequence: [12, 'u'], gazeNs: [13, 'u'], aimedNs: [14, 'u'], encodedNs: [15, 'u'], fadeMs: [16, 'u'] },
  Gaze: { sequence: [1, 'u'], direction: [2, 'F'], valid: [3, 'b'], frozen: [4, 'b'], arrivalNs: [6, 'u'], aim: [8, 'F'], spread: [9, 'f'], state: [10, 's'], source: [11, 's'] },
  Stats: { timeNs: [1, 'u'], samples: [2, 'u'], samplesPerSecond: [3, 'd'], tiles: [5, 'u'], tilesVisited: [6, 'u'], tilesConverged: [7, 'u'], tilesSettled: [8, 'u'], clients: [13, 'u'], frozen: [15, 'b'], finished: [16, 'b'], gazeSource: [18, 's'], generation: [22, 'u'], scene: [24, 's'], refused: [25, 's'] },
  Done: { request: [1, 'u'], ok: [2, 'b'], text: [3, 's'] },
  Pong: { clientNs: [1, 'u'], daemonNs: [2, 'u'] },
  Bye: {},
  Viewing: { yours: [1, 'b'], who: [2, 's'], headset: [3, 'b'] },
  Message: { Hello: [1, 'Hello'], View: [2, 'View'], Pointer: [3, 'Pointer'], Freeze: [4, 'Freeze'], Acknowledge: [5, 'Acknowledge'], Ping: [7, 'Ping'], Recentre: [8, 'Recentre'], Move: [10, 'Move'], Welcome: [16, 'Welcome'], Tile: [17, 'Tile'], Gaze: [18, 'Gaze'], Stats: [19, 'Stats'], Done: [20, 'Done'], Pong: [21, 'Pong'], Bye: [22, 'Bye'], Viewing: [23, 'Viewing'] },
};
const FIELDS = {};
for (const [name, fields] of Object.entries(SCHEMA))
  FIELDS[name] = new Map(Object.entries(fields).map(([key, [number, kind]]) => [number, { key, kind }]));

const EMPTY = { u: 0, b: false, s: '', y: new Uint8Array(), f: 0, d: 0, F: [] };
const utf8 = { encode: new TextEncoder(), decode: new TextDecoder() };

// --- to bytes

function putVarint(out, value) {
  while (value > 127) {
    out.push((value % 128) | 128);
    value = Math.floor(value / 128);
  }
  out.push(value);
}

function putBytes(out, number, bytes) {
  putVarint(out, number * 8 + 2);
  putVarint(out, bytes.length);
  for (const byte of bytes) out.push(byte);
}

function fill(name, values, out) {
  for (const [key, value] of Object.entries(values)) {
    const [number, kind] = SCHEMA[name][key];
    if (kind === 'u' || kind === 'b') {
      putVarint(out, number * 8);
      putVarint(out, Number(value));
    } else if (kind === 'f') {
      putVarint(out, number * 8 + 5);
      out.push(...new Uint8Array(Float32Array.of(value).buffer));
    } else if (kind === 'F') {
      putBytes(out, number, new Uint8Array(Float32Array.from(value).buffer));
    } else if (kind === 's') {
      putBytes(out, number, utf8.encode.encode(value));
    } else {
      putBytes(out, number, fill(kind, value, []));
    }
  }
  return out;
}

// pack('Ping', {clientNs: 5}): the bytes of that Message.
export function pack(name, values) {
  return Uint8Array.from(fill('Message', { [name]: values }, []));
}

// --- from bytes

function read(name, bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength), out = {};
  let at = 0;
  const varint = () => {
    let value = 0, unit = 1, byte;
    do {
      byte = bytes[at++];
      if (byte === undefined) throw new Error('a message is cut short');
      value += (byte & 127) * unit;
      unit *= 128;
    } while (byte & 128);
    return value;
  };
  for (const [key, [, kind]] of Object.entries(SCHEMA[name])) if (kind in EMPTY) out[key] = EMPTY[kind];
  while (at < bytes.length) {
    const tag = varint(), wire = tag % 8, field = FIELDS[name].get(Math.floor(tag / 8));
    let value;
    if (wire === 0) value = varint();
    else if (wire === 1) { value = view.getFloat64(at, true); at += 8; }
    else if (wire === 5) { value = view.getFloat32(at, true); at += 4; }
    else if (wire === 2) {
      const length = varint();
      if (length > bytes.length - at) throw new Error('a message is cut short');
      value = bytes.subarray(at, at += length);
    } else throw new Error('a message of an unknown kind');
    if (!field) continue; // of a newer daemon
    const { key, kind } = field;
    if (kind === 'b') out[key] = value !== 0;
    else if (kind === 's') out[key] = utf8.decode.decode(value);
    else if (kind === 'F') out[key] = [...new Float32Array(value.slice().buffer)];
    else out[key] = kind in EMPTY ? value : read(kind, value);
  }
  return out;
}

// [name, values] of the Message in an ArrayBuffer; throws what is wrong with it.
export function unpack(buffer) {
  const [entry] = Object.entries(read('Message', new Uint8Array(buffer)));
  if (!entry) throw new Error('a message with no known body');
  return entry;
}
