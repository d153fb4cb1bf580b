// This file has what the browser tests and measurements share: it starts and stops the real daemon, opens its page in Debian's
// Chromium, and reads what the page shows.
import { spawn, execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, existsSync } from 'node:fs';
import { createServer } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';

export const [fovead, foveactl, source, ...rest] = process.argv.slice(2);
export const place = mkdtempSync(join(tmpdir(), 'fovead-page-'));
const socket = 'unix:' + join(place, 'socket');
export const hall = ['--scene', 'fixtures/hall.gltf', '--env', 'fixtures/sky.hdr']; // where fovead runs
export const counted = { checks: 0 };
let daemon = null, browser = null, stopping = false;

export function check(good, text) {
  if (!good) throw new Error('FAIL: ' + text);
  counted.checks++;
}

// Wait until the condition holds. Five minutes are far more than any machine needs: they only make sure that a failure is
// reported instead of waiting for ever.
export async function until(text, condition) {
  for (let i = 0; i < 3000; i++) {
    if (await condition()) return void counted.checks++;
    await new Promise((done) => setTimeout(done, 100));
  }
  throw new Error('FAIL: waited in vain for ' + text);
}

export function freePort() {
  return new Promise((done) => {
    const server = createServer().listen(0, '127.0.0.1', () => {
      const { port } = server.address();
      server.close(() => done(port));
    });
  });
}

// Start the daemon with a page on that port, and wait until it is ready.
export async function start(port, options = [], environment = {}, scene = hall) {
  stopping = false;
  daemon = spawn(fovead, [...scene, '--listen', 'http:127.0.0.1:' + port, '--listen', socket, ...options],
    { cwd: source, env: { ...process.env, ...environment }, stdio: ['ignore', 'pipe', 'inherit'] });
  let text = '';
  daemon.stdout.on('data', (data) => { text += data; });
  daemon.once('exit', (code, signal) => { if (!stopping) console.error('the daemon has ended:', code, signal); });
  await until('the daemon', () => {
    check(daemon.exitCode === null, 'the daemon has ended: ' + text);
    return text.includes('fovead: ready');
  });
}

export async function stop() {
  stopping = true;
  const ended = new Promise((done) => daemon.once('exit', done));
  daemon.kill();
  await ended;
}

export const signal = (name) => daemon.kill(name);
export const ctl = (...words) => execFileSync(foveactl, ['--connect', socket, ...words], { encoding: 'utf8' });

// Open a page of that size, in which the script runs before the page's own ones.
export async function open(url, script, viewport = { width: 320, height: 180 }) {
  const page = await browser.newPage({ viewport, deviceScaleFactor: 1 });
  page.setDefaultTimeout(300000); // as until()
  page.on('pageerror', (error) => { page.failed = error.message; });
  if (script) await page.addInitScript(script);
  await page.goto(url);
  return page;
}

export const status = (page) => page.textContent('#status');
export const state = (page) => page.evaluate(() => {
  const { picture, view } = window.fovead;
  return { finest: [...(picture.finest ?? [])], gaze: picture.gaze[0], view: { yaw: view.yaw, pitch: view.pitch, fov: view.fov } };
});
export const showsPicture = async (page) => {
  const { finest } = await state(page);
  return finest.length > 0 && finest.every((level) => level < 255);
};
// Degrees between two directions.
export const angle = (a, b) => Math.acos(Math.min(1, a[0] * b[0] + a[1] * b[1] + a[2] * b[2])) * 180 / Math.PI;

// The pixels of a PNG, as RGBA.
export function decode(page, png) {
  return page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes]));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
    context.drawImage(bitmap, 0, 0);
    return [...context.getImageData(0, 0, bitmap.width, bitmap.height).data];
  }, png.toString('base64'));
}

// The pixels of the view as they are on the screen, without the panel and its button.
export async function pixels(page) {
  const clip = await page.evaluate(() => {
    document.getElementById('panel').classList.add('hidden');
    document.getElementById('toggle').hidden = true;
    window.fovead.picture.trail = false;
    const { x, y, width, height } = document.getElementById('view').getBoundingClientRect();
    return { x, y, width, height };
  });
  return decode(page, await page.screenshot({ clip }));
}

// Look there, in degrees, and wait until the frame that shows it has been drawn.
export async function look(page, yaw, pitch, fov) {
  await page.evaluate(([y, p, f]) => {
    const { view } = window.fovead;
    Object.assign(view, { yaw: y, pitch: p, fov: f });
    view.turn(0, 0);
    document.getElementById('exposure').dispatchEvent(new Event('input'));
  }, [yaw, pitch, fov].map((degrees) => degrees * Math.PI / 180));
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
}

// Run the functions one after the other, each with a free port, in one browser. The exit status tells whether all went well.
export async function run(functions) {
  const path = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);
  try {
    browser = await chromium.launch({ executablePath: path, args: ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking',
      '--disable-component-update', '--disable-sync', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'] });
    for (const each of functions) await each(await freePort());
  } catch (error) {
    console.error(error.message);
    process.exitCode = 1;
  } finally {
    await browser?.close();
    daemon?.kill();
    rmSync(place, { recursive: true, force: true });
  }
}
