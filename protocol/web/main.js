// This file is the page itself: it hands messages from the connection to the picture, draws frames, and turns input by
// mouse, touch, keyboard and controls into changes of the view or messages to the daemon.
import { Chart } from './chart.js';
import { Connection } from './connection.js';
import { enter, isThere } from './headset.js';
import { Picture } from './picture.js';
import { Times } from './times.js';
import { onScreen, View } from './view.js';

const at = (id) => document.getElementById(id);
const canvas = at('view'), view = new View();
const chart = {
  rate: new Chart('rate', (v) => (v * 1e-6).toFixed(2) + ' M'),
  converged: new Chart('converged', (v) => (v * 100).toFixed(1) + ' %'),
  latency: new Chart('latency', (v) => `${v.toFixed(0)} ms (p50 ${times.quantile('answer', 0.5).toFixed(0)}, p99 ${times.quantile('answer', 0.99).toFixed(0)})`),
};
const VIEW_MS = 40, POINTER_MS = 8, MOVE_M = 0.25, LOOK = 0.08;

let picture = null, headset = null, pointed = false, frozen = false;
let isStale = true; // the canvas does not show what it should
let asks = false; // the user has turned the view: it asks to steer
let sentView = '', sentViewMs = 0, sentPointerMs = 0;

function say(text) {
  if (at('status').textContent !== text) at('status').textContent = text;
}

// --- messages from the daemon

function takeTile(tile) {
  if (!picture.put(tile)) return;
  isStale = true;
  times.take(tile, picture.least, frozen);
}

function takeStats(stats) {
  const share = (tiles) => stats.tiles ? tiles / stats.tiles : 0, percent = (tiles) => (100 * share(tiles)).toFixed(0) + ' %';
  chart.rate.add(stats.samplesPerSecond);
  chart.converged.add(share(stats.tilesConverged));
  at('progress').value = share(stats.tilesConverged);
  at('progress-text').textContent = `${percent(stats.tilesVisited)} of the tiles have paths, ${percent(stats.tilesSettled)} look settled from here, `
    + `${(stats.samples * 1e-6).toFixed(0)} million paths`;
  takeScene(stats);
  showFrozen(stats.frozen);
}

function takeScene({ scene, gazeSource, refused }) {
  at('scene').textContent = scene + (refused ? ' The last edit was not taken: ' + refused : '');
  pointed = gazeSource.startsWith('pointer');
  at('gaze').textContent = pointed ? 'Your pointer is the gaze: no eye tracker is used.' : 'Gaze: ' + gazeSource;
}

function showFrozen(now) {
  frozen = now;
  at('freeze').setAttribute('aria-pressed', now);
  at('freeze').textContent = now ? 'Unfreeze gaze (F)' : 'Freeze gaze (F)';
}

try {
  picture = new Picture(canvas);
} catch (error) {
  say(error.message);
}
const connection = picture && new Connection({
  status: say,
  Welcome(welcome) {
    picture.begin(welcome);
    times.begin(welcome);
    sentView = '';
    takeScene(welcome);
    showFrozen(welcome.frozen);
    say('');
  },
  Tile: takeTile,
  Gaze(gaze) {
    picture.look(gaze.aim.length ? gaze.aim : gaze.direction);
    times.look(gaze);
    isStale ||= picture.trail || picture.rings;
  },
  Stats: takeStats,
  Viewing({ yours, who, headset }) {
    at('steers').textContent = yours ? 'This page steers the view.' : !who ? 'No view steers.'
      : headset ? 'A headset steers the view: ' + who : 'Another client steers the view: ' + who;
  },
  Done(done) {
    say(done.text);
    setTimeout(() => at('status').textContent === done.text && say(''), 4000);
  },
}, picture.widest);
const times = picture && new Times(picture.gl, connection);

// --- drawing

function aspect() {
  return canvas.width / canvas.height;
}

// A frame has been drawn, here or in the headset.
function shown() {
  connection.acknowledge();
  chart.latency.add(times.frame());
}

function draw() {
  const gl = picture.gl;
  gl.viewport(0, 0, canvas.width, canvas.height);
  picture.draw(view.toWorld(aspect()));
}

// A view that no hand has turned does not ask to steer; a hidden page shows none.
function tell(shown) {
  const text = JSON.stringify(shown) + asks, now = performance.now();
  if (text === sentView || now - sentViewMs < (shown.headset ? POINTER_MS : VIEW_MS)) return;
  sentView = JSON.stringify(shown) + false;
  sentViewMs = now;
  connection.send('View', { ...shown, unasked: !asks });
  asks = false;
}

function turned() {
  isStale = asks = true;
}

function frame() {
  requestAnimationFrame(frame);
  if (headset) return;
  const scale = devicePixelRatio, w = Math.round(canvas.clientWidth * scale), h = Math.round(canvas.clientHeight * scale);
  if (!w || !h) return;
  if (canvas.width !== w || canvas.height !== h) {
    canvas.width = w;
    canvas.height = h;
    isStale = true;
  }
  if (connection.isOpen && picture.finest) {
    const [x, y] = view.halves(aspect());
    tell({ orientation: view.orientation, fovX: 2 * Math.atan(x), fovY: 2 * Math.atan(y), screen: onScreen(canvas) });
  }
  if (isStale || picture.isFading) draw();
  isStale = false;
  shown();
}

// --- mouse and touch

const fingers = new Map();

function turnBy(dx, dy) {
  const [x, y] = view.halves(aspect());
  view.turn(-2 * x * dx / canvas.clientWidth, 2 * y * dy / canvas.clientHeight);
  turned();
}

function point(event) {
  const now = performance.now(), box = canvas.getBoundingClientRect();
  if (!pointed || now - sentPointerMs < POINTER_MS) return;
  sentPointerMs = now;
  const x = (event.clientX - box.left) / box.width * 2 - 1, y = 1 - (event.clientY - box.top) / box.height * 2;
  connection.send('Pointer', { direction: view.direction(x, y, aspect()) });
}

canvas.addEventListener('pointerdown', (event) => {
  canvas.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, [event.clientX, event.clientY]);
});
canvas.addEventListener('pointermove', (event) => {
  const before = fingers.get(event.pointerId), now = [event.clientX, event.clientY];
  point(event);
  if (!before) return;
  if (fingers.size === 2) {
    const [other] = [...fingers].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
    view.zoom(Math.hypot(before[0] - other[0], before[1] - other[1]) / Math.max(1, Math.hypot(now[0] - other[0], now[1] - other[1])));
    turned();
  } else {
    turnBy(now[0] - before[0], now[1] - before[1]);
  }
  fingers.set(event.pointerId, now);
});
for (const name of ['pointerup', 'pointercancel']) canvas.addEventListener(name, (event) => fingers.delete(event.pointerId));
canvas.addEventListener('wheel', (event) => {
  event.preventDefault();
  view.zoom(Math.exp(event.deltaY * 0.001));
  turned();
}, { passive: false });

// --- controls, each of them by a key too

function savePng() {
  draw();
  canvas.toBlob((blob) => {
    const link = document.createElement('a');
    link.href = URL.createObjectURL(blob);
    link.download = 'fovead.png';
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  });
}

function walk(right, up, ahead) {
  const sin = Math.sin(view.yaw), cos = Math.cos(view.yaw);
  connection.send('Move', { request: 1, relative: true, camera: [right * cos + ahead * sin, up, right * sin - ahead * cos] });
}

function expose(stops) {
  const slider = at('exposure');
  slider.value = Number(slider.value) + stops;
  slider.dispatchEvent(new Event('input'));
}

function show(overlay) {
  at('overlay').value = overlay;
  at('overlay').dispatchEvent(new Event('input'));
}

function togglePanel() {
  const isHidden = at('panel').classList.toggle('hidden');
  at('toggle').setAttribute('aria-expanded', !isHidden);
  at('toggle').textContent = isHidden ? 'Show controls (H)' : 'Hide controls (H)';
}

const freeze = () => {
  showFrozen(!frozen);
  connection.send('Freeze', { frozen });
};
const recentre = () => connection.send('Recentre', { request: 2 });
const lookAhead = () => { view.yaw = view.pitch = 0; turned(); };
const look = (x, y) => { view.turn(x * LOOK * view.fov, y * LOOK * view.fov); turned(); };
const zoom = (factor) => { view.zoom(factor); turned(); };
const KEYS = {
  ArrowLeft: () => look(-1, 0), ArrowRight: () => look(1, 0), ArrowUp: () => look(0, 1), ArrowDown: () => look(0, -1),
  '+': () => zoom(0.9), '=': () => zoom(0.9), '-': () => zoom(1 / 0.9), Home: lookAhead,
  w: () => walk(0, 0, MOVE_M), s: () => walk(0, 0, -MOVE_M), a: () => walk(-MOVE_M, 0, 0), d: () => walk(MOVE_M, 0, 0),
  e: () => walk(0, MOVE_M, 0), q: () => walk(0, -MOVE_M, 0),
  f: freeze, c: recentre, p: savePng, '[': () => expose(-0.25), ']': () => expose(0.25),
  1: () => show(0), 2: () => show(1), 3: () => show(2), 4: () => show(3),
  h: togglePanel,
};
addEventListener('keydown', (event) => {
  if (event.target.matches('select, input') || (event.repeat && event.key.length === 1 && 'fcph'.includes(event.key.toLowerCase()))) return;
  const act = KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!act || event.ctrlKey || event.altKey || event.metaKey) return;
  event.preventDefault();
  act();
});

function bind(id, apply) {
  at(id).addEventListener('input', (event) => {
    apply(event.target);
    isStale = true;
  });
}
bind('exposure', ({ value }) => {
  picture.exposure = 2 ** value;
  at('exposure-text').value = value;
});
bind('curve', ({ value }) => { picture.curve = Number(value); });
bind('overlay', ({ value }) => { picture.overlay = Number(value); });
bind('rings', ({ checked }) => { picture.rings = checked; });
bind('trail', ({ checked }) => { picture.trail = checked; });
at('freeze').onclick = freeze;
at('recentre').onclick = recentre;
at('png').onclick = savePng;
at('front').onclick = lookAhead;
at('toggle').onclick = togglePanel;
for (const button of document.querySelectorAll('[data-key]')) button.onclick = KEYS[button.dataset.key];
at('headset').onclick = async () => {
  if (headset) return headset.end();
  at('headset').disabled = true;
  try {
    headset = await enter(picture, tell, shown, () => {
      headset = null;
      isStale = true;
      at('headset').textContent = 'Enter headset';
    });
    at('headset').textContent = 'Leave headset';
  } catch (error) {
    say('The headset cannot be entered: ' + error.message);
  }
  at('headset').disabled = false;
};

if (picture) frame();
addEventListener('visibilitychange', () => {
  times?.pause();
  if (!document.hidden || headset) return;
  sentView = '';
  connection?.send('View', {}); // a hidden page shows nothing
});
canvas.addEventListener('webglcontextlost', (event) => {
  event.preventDefault();
  say('The GPU has dropped the picture. Waiting for it.');
});
canvas.addEventListener('webglcontextrestored', () => location.reload());
isThere().then((there) => { at('headset').hidden = !there; });
window.fovead = { picture, view, connection, chart, times }; // for the console
