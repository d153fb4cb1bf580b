// This script measures the page: sh page.sh PROGRAMS SOURCE bars.mjs [DATA], where DATA is the folder that has
// scenes/dabrovic-sponza and envmaps; without it the shipped hall is used throughout. It prints how soon the first picture is
// there, how many frames per second are drawn while tiles come, and how long it takes from a jump of the gaze to the screen.
// Chromium has no GPU here: SwiftShader draws on the processor, beside the daemon.
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { hall, open, rest, run, showsPicture, signal, start, stop, until } from './room.mjs';

const [data] = rest, LOADS = 5, JUMPS = 12, JUMP_MS = 30000, FRAMES_MS = 3000, TILES_A_SECOND = 200;
const sponza = data && existsSync(join(data, 'scenes/dabrovic-sponza'))
  ? ['--scene', join(data, 'scenes/dabrovic-sponza/dabrovic-sponza.gltf'), '--env', join(data, 'envmaps/kiara_1_dawn_1k.hdr'),
    '--sun', '60,60,5,0.53', '--camera', '0,2,0'] : hall;
const address = (port) => 'http://127.0.0.1:' + port + '/';
const quantile = (list, share) => [...list].sort((a, b) => a - b)[Math.min(list.length - 1, Math.floor(share * list.length))];
const figures = (list) => list.length ? `p50 ${quantile(list, 0.5).toFixed(1)} ms, p99 ${quantile(list, 0.99).toFixed(1)} ms, of ${list.length}` : 'none';

// Milliseconds from the start of the page's load to the first frame on the screen that shows something everywhere.
async function firstPicture(port) {
  await start(port, ['--gaze', 'synthetic:7']);
  const times = [];
  for (let i = 0; i < LOADS; i++) {
    const page = await open(address(port), `
      const look = () => {
        const { picture, times } = window.fovead ?? {};
        if (picture?.finest?.every((level) => level < 255) && times.lists.shown.length && !times.flights.length) window.firstMs = performance.now();
        else requestAnimationFrame(look);
      };
      requestAnimationFrame(look);`, { width: 1280, height: 720 });
    await until('a picture', () => page.evaluate(() => window.firstMs > 0));
    times.push(await page.evaluate(() => window.firstMs));
    await page.close();
  }
  console.log(`first picture after the page's load begins (the shipped hall, 1280 x 720): ${times.map((t) => t.toFixed(0)).join(', ')} ms (bar: 1000)`);
  await stop();
}

// Tiles that have come are put again, so many per second, while frames are counted; beside the daemon, and without it.
async function frames(port) {
  await start(port, ['--gaze', 'synthetic:7']);
  const page = await open(address(port), `
    let fovead;
    window.kept = [];
    Object.defineProperty(window, 'fovead', { get: () => fovead, set(value) {
      const { picture } = fovead = value;
      window.put = picture.put.bind(picture);
      picture.put = (tile) => { if (window.kept.length < 400) window.kept.push(tile); return window.put(tile); };
    } });`, { width: 1920, height: 1080 });
  await until('a picture', () => showsPicture(page));
  await until('many tiles', () => page.evaluate(() => window.kept.length >= 400));
  const measure = () => page.evaluate(([ms, rate]) => new Promise((done) => {
    const { picture, view } = window.fovead, { gl } = picture, began = performance.now();
    let frames = 0, tiles = 0, busy = 0;
    const frame = () => {
      const now = performance.now() - began;
      if (now >= ms) return done({ perSecond: frames * 1000 / now, drawMs: busy / frames, tiles: tiles * 1000 / now });
      for (; tiles < now * rate / 1000; tiles++) window.put(window.kept[tiles % window.kept.length]);
      gl.viewport(0, 0, gl.canvas.width, gl.canvas.height);
      const before = performance.now();
      picture.draw(view.toWorld(gl.canvas.width / gl.canvas.height));
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); // waits until it is drawn
      busy += performance.now() - before;
      frames++;
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }), [FRAMES_MS, TILES_A_SECOND]);
  const print = (where, { perSecond, drawMs, tiles }) =>
    console.log(`frames at 1920 x 1080, ${tiles.toFixed(0)} tiles per second, ${where}: ${perSecond.toFixed(1)} per second, ${drawMs.toFixed(1)} ms each by SwiftShader (bar: 60)`);
  print('beside the daemon', await measure());
  signal('SIGSTOP');
  print('while the daemon stands still', await measure());
  signal('SIGCONT');
  await page.close();
  await stop();
}

// The pointer is the gaze and jumps between two places; each time the page notes when it shows a tile there that answers the
// jump, and when a settled one.
async function jumps(port) {
  await start(port, ['--gaze', 'pointer', '--size', '2048'], {}, sponza);
  const page = await open(address(port), '', { width: 1280, height: 720 });
  await until('a picture', () => showsPicture(page));
  await page.evaluate(() => document.getElementById('panel').classList.add('hidden'));
  const lists = () => page.evaluate(() => window.fovead.times.lists);
  for (let i = 0; i < JUMPS; i++) {
    const before = (await lists()).settled.length, began = Date.now();
    await page.mouse.move(i % 2 ? 320 + 17 * i : 960 - 17 * i, 300 + 11 * i);
    while ((await lists()).settled.length === before && Date.now() - began < JUMP_MS) await new Promise((done) => setTimeout(done, 50));
  }
  const { answer, received, shown, jump, settled } = await lists();
  console.log(`${sponza === hall ? 'the hall' : 'Sponza'}, film 2048 x 1024, view 1280 x 720, ${JUMPS} jumps of the gaze:`);
  console.log(`  gaze to the screen:                          ${figures(answer)}`);
  console.log(`  gaze jump to the first tile there, shown:    ${figures(jump)}`);
  console.log(`  gaze jump to a settled tile there, shown:    ${figures(settled)}; the others were not settled within ${JUMP_MS / 1000} s`);
  console.log(`  encoded to received, the stream's own share: ${figures(received)} (bar: p99 10)`);
  console.log(`  encoded to the screen:                       ${figures(shown)}`);
  await page.close();
  await stop();
}

await run([firstPicture, frames, jumps]);
