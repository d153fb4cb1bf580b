// This test drives the page in a real browser: node page.mjs FOVEAD FOVEACTL SOURCE [FOLDER]. The daemon is the real one.
// Views are compared with those of foveactl snapshot, and all input is made by Chromium itself, as from a mouse and a
// keyboard. Pictures of the page are left in FOLDER.
import { readFileSync, readdirSync, statSync } from 'node:fs';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { angle, check, counted, ctl, decode, look, open, pixels, place, rest, run, showsPicture, source, start, state, status, stop, until } from './room.mjs';

const [keep] = rest;
const mean = (rgba) => rgba.reduce((sum, v, i) => sum + (i % 4 < 3 ? v : 0), 0) / rgba.length;

// The PSNR of two pictures over the 95 % of their pixels that differ least: the others may have been sent anew between the
// two.
function psnr(a, b) {
  const squares = [];
  for (let i = 0; i < a.length; i += 4) squares.push(((a[i] - b[i]) ** 2 + (a[i + 1] - b[i + 1]) ** 2 + (a[i + 2] - b[i + 2]) ** 2) / 3);
  squares.sort((x, y) => x - y);
  const kept = squares.slice(0, Math.floor(squares.length * 0.95));
  return 10 * Math.log10(255 ** 2 / (kept.reduce((sum, v) => sum + v, 0) / kept.length || 1e-9));
}

// --- the tests

async function picture(port) {
  await start(port, ['--size', '256', '--gaze', 'pointer', '--mode', 'od']);
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

  // A drag, the wheel and keys turn and zoom the view.
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
  await page.evaluate(() => {
    document.getElementById('panel').classList.remove('hidden');
    document.getElementById('toggle').hidden = false;
  });
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
  await until('a move of the camera by a key', async () => JSON.parse(ctl('stats', '--json')).generation > generation);

  await controls(page);

  // The daemon ends, and comes back.
  await stop();
  await until('a word on its end', async () => (await status(page)).length > 0);
  await start(port, ['--size', '256', '--gaze', 'synthetic:3']);
  await until('its picture again', async () => (await status(page)) === '' && showsPicture(page));
  await until('a time from gaze to screen', async () => /ms/.test(await page.textContent('#latency')));
  const times = await page.evaluate(() => window.fovead.times.lists);
  check(times.shown.length > 0 && times.received.length > 0, 'no times of tiles');
  // A tile is on the screen after it has come, and both after it was encoded, but for the error of the clocks.
  const [shown, received, answer] = ['shown', 'received', 'answer'].map((name) => times[name].reduce((a, b) => a + b) / times[name].length);
  check(received > -5 && shown > received && answer > 0, `received after ${received} ms, shown after ${shown}, answered after ${answer}`);
  check(!page.failed, 'the page has an error: ' + page.failed);
  await page.close();
  await stop();
}

// Every control can be reached by the Tab key and has a name; the panel can be hidden by its button, and each of the buttons
// works by the keyboard alone.
async function controls(page) {
  const names = new Set();
  await page.evaluate(() => {
    document.getElementById('panel').classList.remove('hidden');
    document.getElementById('toggle').hidden = false;
  });
  await page.focus('#view');
  for (let i = 0; i < 40; i++) {
    await page.keyboard.press('Tab');
    const at = await page.evaluate(() => {
      const { id, dataset, labels, ariaLabel, textContent } = document.activeElement;
      return { id: id || dataset.key || '', name: labels?.[0]?.textContent || ariaLabel || textContent.trim() };
    });
    check(at.id === '' || at.name, 'a control without a name: ' + at.id);
    names.add(at.id);
  }
  const all = await page.evaluate(() => [...document.querySelectorAll('button:not([hidden]), input, select')].map((e) => e.id || e.dataset.key));
  check(all.length > 12 && all.every((id) => names.has(id)), 'not every control is reached by Tab: ' + all.filter((id) => !names.has(id)));
  await page.focus('#toggle');
  await page.keyboard.press('Enter');
  check(!(await page.isVisible('#panel')) && (await page.getAttribute('#toggle', 'aria-expanded')) === 'false', 'the button does not hide the panel');
  await page.keyboard.press('Enter');
  check((await page.isVisible('#panel')) && (await page.getAttribute('#toggle', 'aria-expanded')) === 'true', 'the button does not show the panel');
  const { generation } = JSON.parse(ctl('stats', '--json'));
  await page.focus('[data-key=s]');
  await page.keyboard.press('Enter');
  await until('a move of the camera by a button', async () => JSON.parse(ctl('stats', '--json')).generation > generation);
}

// A tile that must fade in goes over from what was there, at its own pace; the picture is put together by hand here.
async function fades(port) {
  await start(port, ['--size', '256']);
  const page = await open('http://127.0.0.1:' + port + '/');
  await until('a picture', () => showsPicture(page));
  await stop(); // what is put from here on stays
  await until('the end of all fades', () => page.evaluate(() => !window.fovead.picture.isFading));
  const grey = await page.evaluate(() => {
    const { picture, view } = window.fovead, { gl } = picture, out = {};
    let now = 1000;
    picture.now = () => now;
    picture.trail = picture.rings = false;
    Object.assign(view, { yaw: Math.PI / 8, pitch: -Math.PI / 16, fov: 0.1 });
    // All of the film, at a level: one grey of RGB9E5, value times 2^-9 times 2^(exponent - 15).
    const put = (level, x, y, value, fadeMs) => picture.put({ generation: picture.generation, level, x, y, fadeMs, samples: 1e6, error: 0, converged: false, settled: false,
      data: new Uint8Array(new Uint32Array(64 * 64).fill((15 << 27 | value << 18 | value << 9 | value) >>> 0).buffer) });
    // The radiance in the middle of the view, from what the page would show.
    const middle = (at) => {
      now = at;
      gl.viewport(0, 0, picture.gl.canvas.width, picture.gl.canvas.height);
      picture.draw(view.toWorld(gl.canvas.width / gl.canvas.height));
      const rgba = new Uint8Array(4);
      gl.readPixels(gl.canvas.width / 2, gl.canvas.height / 2, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, rgba);
      const s = rgba[1] / 255;
      return s <= 0.04045 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4;
    };
    const x = 2, y = 1;
    picture.empty(picture.generation + 1);
    put(1, 1, 0, 64, 0);
    out.coarse = middle(1000);
    put(0, x, y, 256, 400);
    out.began = middle(1000);
    out.half = middle(1200);
    put(0, x, y, 448, 400); // another one, while the first is half way
    out.again = middle(1200);
    out.halfAgain = middle(1400);
    out.end = middle(1600);
    out.isFading = picture.isFading;
    put(0, x, y, 64, 0);
    out.atOnce = middle(1600);
    // More fades than there are slots: the rest is shown at once, and all slots come back.
    for (let i = 0; i < 1000; i++) put(0, x, y, i % 2 ? 64 : 128, 100);
    middle(3000);
    picture.free = picture.free.slice(0, 3);
    for (let i = 0; i < 8; i++) put(0, i % 4, i >> 2, 256, 100);
    out.many = picture.fades.size;
    out.rest = middle(3000);
    out.after = middle(5000);
    out.left = picture.fades.size + 3 - picture.free.length;
    return out;
  });
  const near = (value, wanted, what) => check(Math.abs(value - wanted) < 0.01, `${what}: radiance ${value}, wanted ${wanted}`);
  near(grey.coarse, 64 / 512, 'a coarse tile');
  near(grey.began, 64 / 512, 'the beginning of a fade');
  near(grey.half, 160 / 512, 'half of a fade');
  near(grey.again, 160 / 512, 'a new fade from the middle of another');
  near(grey.halfAgain, 304 / 512, 'half of that');
  near(grey.end, 448 / 512, 'the end of a fade');
  check(!grey.isFading, 'a fade does not end');
  near(grey.atOnce, 64 / 512, 'a tile without a fade');
  check(grey.many === 3 && grey.left === 0, `${grey.many} fades in three slots, ${grey.left} of them never end`);
  near(grey.rest, 256 / 512, 'a tile for which there is no slot');
  near(grey.after, 256 / 512, 'the last of many');
  check(!page.failed, 'the page has an error: ' + page.failed);
  await page.close();
}

// A phone whose textures are smaller than the film is sent no level that it cannot hold, and shows the rest.
async function phone(port) {
  await start(port, ['--size', '512', '--gaze', 'pointer', '--mode', 'od']);
  const page = await open('http://127.0.0.1:' + port + '/', `
    const get = WebGL2RenderingContext.prototype.getParameter;
    WebGL2RenderingContext.prototype.getParameter = function (name) { return name === this.MAX_TEXTURE_SIZE ? 256 : get.call(this, name); };
    window.levels = new Set();
    let fovead;
    Object.defineProperty(window, 'fovead', { get: () => fovead, set(value) {
      const { picture } = fovead = value, put = picture.put;
      picture.put = (tile) => { window.levels.add(tile.level); return put.call(picture, tile); };
    } });`);
  await until('all of level 1', async () => {
    const { finest } = await state(page);
    return finest.length === 32 && finest.every((level) => level === 1);
  });
  await until('four paths per pixel of level 0', async () => Number(JSON.parse(ctl('stats', '--json')).paths) > 6 * 512 * 256);
  check(!(await page.evaluate(() => window.levels.has(0))), 'it is sent tiles of level 0');
  check(!page.failed, 'the page has an error: ' + page.failed);
  await page.close();
  await stop();
}

// The page's own files are few bytes: it is the same page on a slow link.
async function size() {
  const folder = join(source, 'protocol/web'), bytes = readdirSync(folder).reduce((sum, name) => sum + statSync(join(folder, name)).size, 0);
  check(bytes < 100000, `the page has ${bytes} bytes`);
  console.log(`the page has ${bytes} bytes`);
}

// The picture of the page that README.md shows.
async function portrait(port) {
  if (!keep) return;
  await start(port, ['--size', '2048', '--gaze', 'pointer']);
  const page = await open('http://127.0.0.1:' + port + '/', '', { width: 1280, height: 720 });
  await page.check('#rings');
  await page.mouse.move(480, 400); // the gaze
  await until('a picture', () => showsPicture(page));
  await until('many paths', async () => Number(JSON.parse(ctl('stats', '--json')).paths) > 8e6);
  await page.screenshot({ path: join(keep, 'page.jpg'), type: 'jpeg', quality: 85 });
  await page.close();
  await stop();
}

async function token(port) {
  await start(port, ['--size', '256'], { FOVEAD_TOKEN: 'right' });
  let page = await open('http://127.0.0.1:' + port + '/');
  await until('a word on the token', async () => (await status(page)).includes('token'));
  await page.close();
  page = await open('http://127.0.0.1:' + port + '/#token=wrong');
  await until('a word on the wrong token', async () => (await status(page)).includes('wrong'));
  await page.evaluate(() => { location.hash = '#token=right'; });
  await until('a picture with the token', () => showsPicture(page));
  // A page of another origin, which knows the token, is refused all the same.
  const other = createServer((request, response) => response.end('<title>another site</title>')).listen(0, '127.0.0.1');
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
  await start(port, ['--size', '256', '--gaze', 'pointer']);
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
  await until('a word on who steers', async () => (await page.textContent('#steers')) === 'This page steers the view.');
  check(!page.failed, 'the page has an error: ' + page.failed);
  await page.close();
  await stop();
}

await run([size, picture, fades, phone, token, headset, portrait].map((test) => async (port) => {
  await test(port);
  console.log(test.name + ': passed');
}));
console.log(`${counted.checks} checks`);
