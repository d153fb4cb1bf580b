// The daemon at the other end of a WebSocket: says hello, keeps the clocks together, comes back after it was lost.
import { pack, unpack } from './messages.js';

const RGB9E5 = 3, AGAIN_MS = 1000, PING_MS = 1000;

export class Connection {
  // on: functions Welcome, Tile, Gaze, Stats, Done by message, and status(text), where '' means that all is well.
  constructor(on) {
    this.on = on;
    this.offsetNs = null; // the daemon's clock minus ours
    this.roundTripMs = Infinity;
    this.acknowledged = this.serial = 0;
    this.open();
    setInterval(() => this.ping(), PING_MS);
  }

  // The token is in the URL's fragment, which browsers send to nobody.
  token() {
    return new URLSearchParams(location.hash.slice(1)).get('token') || '';
  }

  open() {
    this.why = '';
    this.socket = new WebSocket(location.href.replace(/^http/, 'ws').replace(/#.*/, ''), 'fovea');
    this.socket.binaryType = 'arraybuffer';
    this.socket.onopen = () => this.send('Hello', { version: 1, client: 'web page', tiles: RGB9E5, window: 256, gaze: true, stats: true, token: this.token() });
    this.socket.onmessage = (event) => this.take(event.data);
    this.socket.onclose = () => {
      this.acknowledged = this.serial = 0;
      this.offsetNs = null;
      this.roundTripMs = Infinity;
      this.on.status(this.why || 'No daemon answers at ' + location.host + '. Trying again.');
      setTimeout(() => this.open(), AGAIN_MS);
    };
  }

  get isOpen() {
    return this.socket.readyState === WebSocket.OPEN;
  }

  send(name, values) {
    if (this.isOpen) this.socket.send(pack(name, values));
  }

  ping() {
    this.send('Ping', { clientNs: Math.round(performance.now() * 1e6) });
  }

  take(data) {
    let name, message;
    try {
      [name, message] = unpack(data);
    } catch (error) {
      this.why = 'The daemon spoke nonsense: ' + error.message + '. Trying again.';
      this.socket.close();
      return;
    }
    if (name === 'Pong') {
      const now = performance.now(), roundTrip = now - message.clientNs * 1e-6;
      if (roundTrip <= this.roundTripMs * 1.05) {
        this.roundTripMs = roundTrip;
        this.offsetNs = message.daemonNs - (now - roundTrip / 2) * 1e6;
      }
      return;
    }
    if (name === 'Welcome') this.ping();
    if (name === 'Bye') this.why = 'The daemon has ended. Waiting for it to come back.';
    if (name === 'Done' && !message.ok && message.request === 0) this.why = 'The daemon says: ' + message.text + '.';
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
