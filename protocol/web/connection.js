// This file talks to the daemon over a WebSocket: it says Hello, receives messages, estimates the difference of the two
// clocks by Ping and Pong, and connects again after the connection has broken.
import { pack, unpack } from './messages.js';

const RGB9E5 = 3, AGAIN_MS = 1000, MOST_AGAIN_MS = 30000, PING_MS = 1000, SILENT_MS = 5000;

export class Connection {
  // on: functions Welcome, Tile, Gaze, Stats, Viewing, Done by message, and status(text), where '' means that all is well.
  // widest: the widest level that the GPU can hold, pixels.
  constructor(on, widest) {
    this.on = on;
    this.widest = widest;
    this.offsetNs = null; // the daemon's clock minus ours
    this.roundTripMs = Infinity;
    this.acknowledged = this.serial = 0;
    this.againMs = AGAIN_MS;
    this.open();
    setInterval(() => this.ping(), PING_MS);
  }

  // The token is in the URL's fragment, which browsers send to nobody.
  token() {
    return new URLSearchParams(location.hash.slice(1)).get('token') || '';
  }

  open() {
    this.why = '';
    this.isWelcome = this.isLocked = false;
    this.heardMs = performance.now();
    this.socket = new WebSocket(location.href.replace(/^http/, 'ws').replace(/#.*/, ''), 'fovea');
    this.socket.binaryType = 'arraybuffer';
    this.socket.onopen = () => this.send('Hello', { version: 1, client: 'web page', tiles: RGB9E5, window: 256, gaze: true, stats: true, viewing: true, token: this.token(), widest: this.widest });
    this.socket.onmessage = (event) => this.take(event.data);
    this.socket.onclose = () => {
      this.acknowledged = this.serial = 0;
      this.offsetNs = null;
      this.roundTripMs = Infinity;
      this.on.status(this.why || 'The connection to ' + location.host + ' failed or was refused. Trying again.');
      if (this.isLocked) return addEventListener('hashchange', () => this.open(), { once: true });
      setTimeout(() => this.open(), this.againMs);
      this.againMs = Math.min(2 * this.againMs, MOST_AGAIN_MS);
    };
  }

  get isOpen() {
    return this.socket.readyState === WebSocket.OPEN;
  }

  send(name, values) {
    if (this.isOpen) this.socket.send(pack(name, values));
  }

  // The daemon takes nothing but Hello before it says Welcome, and then says something four times per second.
  ping() {
    if (!this.isOpen || !this.isWelcome) return;
    if (performance.now() - this.heardMs > SILENT_MS) {
      this.why = 'The daemon has been silent for some seconds. Trying again.';
      this.socket.close();
      return;
    }
    this.send('Ping', { clientNs: Math.round(performance.now() * 1e6) });
  }

  take(data) {
    let name, message;
    this.heardMs = performance.now();
    try {
      [name, message] = unpack(data);
    } catch (error) {
      this.why = 'The daemon sent what is no message: ' + error.message + '. Trying again.';
      this.socket.close();
      return;
    }
    if (name === 'Pong') {
      const now = performance.now(), roundTrip = now - message.clientNs * 1e-6;
      this.roundTripMs *= 1.01; // clocks drift apart, so an old estimate loses weight
      if (roundTrip <= this.roundTripMs) {
        this.roundTripMs = roundTrip;
        this.offsetNs = message.daemonNs - (now - roundTrip / 2) * 1e6;
      }
      return;
    }
    if (name === 'Welcome') {
      this.isWelcome = true;
      this.againMs = AGAIN_MS;
      this.ping();
    }
    if (name === 'Bye') this.why = 'The daemon has ended. Waiting for it to come back.';
    if (name === 'Done' && !message.ok && message.request === 0) {
      // Another try with the same token would only slow down everybody else's.
      this.isLocked = /no token|token is wrong/.test(message.text);
      this.why = this.isLocked ? 'The daemon asks for a token, and ' + (this.token() ? 'this one is wrong' : 'there is none') + ': add #token=TOKEN to the address.'
                               : 'The daemon says: ' + message.text + '.';
    }
    if (name === 'Tile') this.serial = message.serial;
    this.on[name]?.(message);
  }

  // All tiles that came so far are on the screen.
  acknowledge() {
    if (this.serial > this.acknowledged) this.send('Acknowledge', { serial: this.acknowledged = this.serial });
  }

  // Milliseconds from a moment of the daemon's clock to now; NaN before the clocks are known.
  since(ns) {
    return this.offsetNs === null ? NaN : (performance.now() * 1e6 + this.offsetNs - ns) * 1e-6;
  }
}
