// The page in a real browser: node page.mjs FOVEAD FOVEACTL SOURCE. The daemon is the real one, the pictures are compared
// with foveactl's, and what hands do is done by Chromium's own input.
import { spawn, execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, readFileSync, existsSync } from 'node:fs';
import { createServer as createPage } from 'node:http';
import { createServer } from 'node:net';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';

const [fovead, foveactl, source, keep] = process.argv.slice(2);
const place = mkdtempSync(join(tmpdir(), 'fovead-page-'));
const socket = 'unix:' + join(place, 'socket');
const browserPath = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);
let daemon, browser, checks = 0, stopping = false;

function check(good, text) {
  if (!good) throw new Error('FAIL: ' + text);
  checks++;
}

// Wait for what is to come, however slow the machine: there is an end only so that a failure is told.
async function until(text, condition) {
  for (let i = 0; i < 3000; i++) {
    if (await condition()) return void checks++;
    await new Promise((done) => setTimeout(done, 100));
  }
  throw new Error('FAIL: waited in vain for ' + text);
}

function freePort() {
  return new Promise((done) => {
    const server = createServer().listen(0, '127.0.0.1', () => {
      const { port } = server.address();
      server.close(() => done(port));
    });
  });
}

async function start(port, options = [], environment = {}) {
  stopping = false;
  daemon = spawn(fovead, ['--scene', join(source, 'fixtures/hall.gltf'), '--env', join(source, 'fixtures/sky.hdr'), '--size', '256',
    '--listen', 'http:127.0.0.1:' + port, '--listen', socket, ...options], { env: { ...process.env, ...environment }, stdio: ['ignore', 'pipe', 'inherit'] });
  let text = '';
  daemon.stdout.on('data', (data) => { text += data; });
  daemon.once('exit', (code, signal) => { if (!stopping) console.error('the daemon has ended:', code, signal); });
  await until('the daemon', () => {
    check(daemon.exitCode === null, 'the daemon has ended: ' + text);
    return text.includes('fovead: ready');
  });
}

async function stop() {
  stopping = true;
  const ended = new Promise((done) => daemon.once('exit', done));
  daemon.kill();
  await ended;
}

const ctl = (...words) => execFileSync(foveactl, ['--connect', socket, ...words], { encoding: 'utf8' });

async function open(url, script) {
  const page = await browser.newPage({ viewport: { width: 320, height: 180 }, deviceScaleFactor: 1 });
  page.on('pageerror', (error) => { page.failed = error.message; });
  if (script) await page.addInitScript(script);
  await page.goto(url);
  return page;
}

const status = (page) => page.textContent('#status');
const state = (page) => page.evaluate(() => {
  const { picture, view } = window.fovead;
  return { finest: [...(picture.finest ?? [])], gaze: picture.gaze[0], view: { yaw: view.yaw, pitch: view.pitch, fov: view.fov } };
});
const showsPicture = async (page) => {
  const { finest } = await state(page);
  return finest.length > 0 && finest.every((level) => level < 255);
};
const angle = (a, b) => Math.acos(Math.min(1, a[0] * b[0] + a[1] * b[1] + a[2] * b[2])) * 180 / Math.PI;

// A decoded PNG of the page without its panel, as RGBA.
async function pixels(page) {
  await page.evaluate(() => { document.getElementById('panel').classList.add('hidden'); window.fovead.picture.trail = false; });
  const png = await page.locator('#view').screenshot();
  return decode(page, png);
}

function decode(page, png) {
  return page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes]));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
    context.drawImage(bitmap, 0, 0);
    return [...context.getImageData(0, 0, bitmap.width, bitmap.height).data];
  }, png.toString('base64'));
}

const mean = (rgba) => rgba.reduce((sum, v, i) => sum + (i % 4 < 3 ? v : 0), 0) / rgba.length;

// PSNR of what changes least: of the 95 % of pixels that are most alike, since others may have changed meanwhile.
function psnr(a, b) {
  const squares = [];
  for (let i = 0; i < a.length; i += 4) squares.push(((a[i] - b[i]) ** 2 + (a[i + 1] - b[i + 1]) ** 2 + (a[i + 2] - b[i + 2]) ** 2) / 3);
  squares.sort((x, y) => x - y);
  const kept = squares.slice(0, Math.floor(squares.length * 0.95));
  return 10 * Math.log10(255 ** 2 / (kept.reduce((sum, v) => sum + v, 0) / kept.length || 1e-9));
}

async function look(page, yaw, pitch, fov) {
  await page.evaluate(([y, p, f]) => {
    const { view } = window.fovead;
    Object.assign(view, { yaw: y, pitch: p, fov: f });
    view.turn(0, 0);
    document.getElementById('exposure').dispatchEvent(new Event('input'));
  }, [yaw, pitch, fov].map((degrees) => degrees * Math.PI / 180));
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
}

// --- the tests

async function picture(port) {
  await start(port, ['--gaze', 'pointer', '--mode', 'od']);
  const page = await open('http://127.0.0.1:' + port + '/');
  await until('a picture', () => showsPicture(page));
  check((await page.textContent('#gaze')).includes('Your pointer is the gaze'), 'nobody says that the pointer is the gaze');

  // The same as foveactl's picture of the same view: ahead, over the seam, to both poles.
  await until('a picture with few changes', async () => Number(JSON.parse(ctl('stats', '--json')).paths) > 60 * 256 * 128);
  for (const [yaw, pitch] of [[0, 0], [180, 0], [30, 88], [-60, -88]]) {
    await look(page, yaw, pitch, 90);
    let best = 0;
    await until(`the same picture at ${yaw},${pitch}`, async () => {
      ctl('snapshot', join(place, 'view.png'), '--view', `${yaw},${pitch},90`, '--size', '320x180', '--settle', '0');
      best = Math.max(best, psnr(await pixels(page), await decode(page, readFileSync(join(place, 'view.png')))));
      return best > 40;
    });
    if (keep) await page.screenshot({ path: join(keep, `page-${yaw}-${pitch}.png`) });
    console.log(`PSNR against foveactl at ${yaw},${pitch}: ${best.toFixed(1)} dB`);
  }

  // Hands: drag, wheel, keys; the point under the pointer stays under it.
  await look(page, 0, 0, 80);
  await page.mouse.move(160, 90);
  await page.mouse.down();
  await page.mouse.move(110, 75, { steps: 5 });
  await page.mouse.up();
  let { view } = await state(page);
  check(view.yaw > 0.2 && view.pitch < -0.05, 'a drag to the left turns to the right: ' + JSON.stringify(view));
  await page.mouse.wheel(0, -300);
  await until('a zoom by the wheel', async () => (await state(page)).view.fov < view.fov * 0.9);
  await page.focus('#view');
  await page.keyboard.press('Home');
  await page.keyboard.press('ArrowLeft');
  ({ view } = await state(page));
  check(view.yaw < -0.01 && view.pitch === 0, 'keys turn: ' + JSON.stringify(view));

  // The pointer is the gaze, and what is aimed at follows.
  await look(page, 40, -10, 60);
  let wanted;
  await until('a gaze at the pointer', async () => {
    await page.mouse.move(200 + Math.random(), 60);
    wanted = await page.evaluate(() => window.fovead.view.direction(200 / 160 - 1, 1 - 60 / 90, 320 / 180));
    const { gaze } = await state(page);
    return gaze && angle(gaze, wanted) < 2;
  });

  // Exposure, the curve, overlays, freezing; each by its control and seen in the picture.
  await look(page, 0, 0, 90);
  const plain = mean(await pixels(page));
  await page.evaluate(() => document.getElementById('panel').classList.remove('hidden'));
  await page.fill('#exposure', '2');
  const bright = mean(await pixels(page));
  check(bright > plain * 1.3, `exposure 2 has mean ${bright}, exposure 0 ${plain}`);
  await page.focus('#view');
  for (let i = 0; i < 8; i++) await page.keyboard.press('[');
  check(await page.inputValue('#exposure') === '0', 'the keys [ and ] do not change the exposure');
  for (const overlay of ['2', '3', '4']) {
    await page.keyboard.press(overlay);
    const other = await pixels(page);
    if (keep) await page.screenshot({ path: join(keep, `overlay-${overlay}.png`) });
    await page.keyboard.press('1');
    check(psnr(other, await pixels(page)) < 30, `overlay ${overlay} does not show`);
  }
  await page.keyboard.press('f');
  await until('a frozen gaze', async () => JSON.parse(ctl('stats', '--json')).frozen && (await page.getAttribute('#freeze', 'aria-pressed')) === 'true');
  await page.keyboard.press('f');
  const generation = JSON.parse(ctl('stats', '--json')).generation;
  await page.keyboard.press('w');
  await until('a move of the camera', async () => JSON.parse(ctl('stats', '--json')).generation > generation);

  // The daemon ends, and comes back.
  await stop();
  await until('a word on its end', async () => (await status(page)).length > 0);
  await start(port, ['--gaze', 'synthetic:3']);
  await until('its picture again', async () => (await status(page)) === '' && showsPicture(page));
  await until('a gaze to picture time', async () => /ms/.test(await page.textContent('#latency')));
  check(!page.failed, 'the page has an error: ' + page.failed);
  await page.close();
  await stop();
}

async function token(port) {
  await start(port, [], { FOVEAD_TOKEN: 'right' });
  let page = await open('http://127.0.0.1:' + port + '/');
  await until('a word on the token', async () => (await status(page)).includes('token'));
  await page.close();
  page = await open('http://127.0.0.1:' + port + '/#token=wrong');
  await until('a word on the wrong token', async () => (await status(page)).includes('wrong'));
  await page.evaluate(() => { location.hash = '#token=right'; });
  await until('a picture with the token', () => showsPicture(page));
  // A page of another origin, which knows the token, is refused all the same.
  const other = createPage((request, response) => response.end('<title>another site</title>')).listen(0, '127.0.0.1');
  await new Promise((done) => other.once('listening', done));
  await page.goto('http://127.0.0.1:' + other.address().port + '/');
  for (const protocol of [['fovea'], [], ['raw'], ['http']]) {
    const code = await page.evaluate(([url, words]) => new Promise((done) => {
      const socket = new WebSocket(url, words);
      socket.onopen = () => done('open');
      socket.onerror = () => done('refused');
    }), [`ws://127.0.0.1:${port}/`, protocol]);
    check(code === 'refused', `a page of another origin comes in with the protocol '${protocol}'`);
  }
  other.close();
  await page.close();
  await stop();
}

async function headset(port) {
  await start(port, ['--gaze', 'pointer']);
  const emulator = readFileSync(createRequire(import.meta.url).resolve('iwer/build/iwer.js'), 'utf8');
  const page = await open('http://127.0.0.1:' + port + '/', emulator + `
    window.device = new IWER.XRDevice(IWER.metaQuest3);
    window.device.installRuntime({ forceInstall: true });
    window.device.stereoEnabled = true;`);
  await until('a picture', () => showsPicture(page));
  await until('a button for the headset', () => page.isVisible('#headset'));
  await page.click('#headset');
  await until('a session', async () => (await page.textContent('#headset')) === 'Leave headset');
  // Turned a quarter to the right; without a pointer the aim is where the view is.
  await page.evaluate(() => window.device.quaternion.set(0, -Math.SQRT1_2, 0, Math.SQRT1_2));
  await until('the head where the daemon aims', async () => {
    const { gaze } = await state(page);
    return gaze && angle(gaze, [1, 0, 0]) < 5;
  });
  const drawn = await page.evaluate(() => new Promise((done) => {
    const gl = window.fovead.picture.gl, seen = new Set(), viewport = gl.viewport.bind(gl);
    gl.viewport = (...box) => { seen.add(box.join()); viewport(...box); };
    setTimeout(() => done(seen.size), 2000);
  }));
  check(drawn === 2, `${drawn} eyes are drawn`);
  check(!page.failed, 'the page has an error: ' + page.failed);
  await page.close();
  await stop();
}

try {
  browser = await chromium.launch({ executablePath: browserPath, args: ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking',
    '--disable-component-update', '--disable-sync', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'] });
  for (const test of [picture, token, headset]) {
    await test(await freePort());
    console.log(test.name + ': passed');
  }
  console.log(`${checks} checks`);
} catch (error) {
  console.error(error.message);
  process.exitCode = 1;
} finally {
  await browser?.close();
  daemon?.kill();
  rmSync(place, { recursive: true, force: true });
}
