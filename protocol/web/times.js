// This file measures how long things take until they are on the screen, by the daemon's clock.
//
// A frame is on the screen when the GPU has drawn it: a fence behind the frame's commands tells, and is looked at once per
// frame. What came since the frame before is shown by that frame.

const MOST = 2000, JUMP_DEG = 5;

export class Times {
  // connection tells how long ago a moment of the daemon's clock was.
  constructor(gl, connection) {
    this.gl = gl;
    this.connection = connection;
    this.lists = {
      answer: [],   // from a gaze sample's arrival to the first tile that answers it, on the screen, ms
      received: [], // from a tile's encoding to its arrival
      shown: [],    // from a tile's encoding to the screen
      jump: [],     // from a gaze jump to the first tile there that answers it, on the screen
      settled: [],  // from a gaze jump to the first settled tile of the finest level there, on the screen
    };
    this.begin();
  }

  // A new film, or another daemon.
  begin(film) {
    this.film = film;
    this.answered = 0; // newest gaze that a tile has answered
    this.came = []; // [list, the moment from which it counts, ns] of what the next frame shows
    this.flights = []; // frames that the GPU has not drawn yet
    this.aim = null; // where the gaze has jumped: { direction, ns, sequence, isAnswered, isSettled }
  }

  // Forget what waits: the page has shown nothing for a while.
  pause() {
    this.came = [];
    this.flights = [];
    if (this.aim) this.aim.isAnswered = this.aim.isSettled = true;
  }

  add(list, ms) {
    if (!Number.isFinite(ms)) return;
    this.lists[list].push(ms);
    if (this.lists[list].length > MOST) this.lists[list].shift();
  }

  // A Gaze has come.
  look(gaze) {
    if (gaze.aim.length !== 3 || gaze.frozen) return;
    const cosine = this.aim ? gaze.aim.reduce((sum, c, i) => sum + c * this.aim.direction[i], 0) : -1;
    if (Math.acos(Math.min(1, Math.max(-1, cosine))) * 180 / Math.PI < JUMP_DEG) return;
    this.aim = { direction: gaze.aim, ns: gaze.arrivalNs, sequence: gaze.sequence, isAnswered: !this.aim, isSettled: !this.aim };
  }

  // A Tile has come, and the next frame will show it. finest: the finest level that this client can hold.
  take(tile, finest, isFrozen) {
    this.add('received', this.connection.since(tile.encodedNs));
    this.came.push(['shown', tile.encodedNs]);
    // Later tiles of the same gaze would tell how long the eye has rested.
    if (tile.gazeNs && tile.gazeSequence > this.answered && !isFrozen) {
      this.answered = tile.gazeSequence;
      this.came.push(['answer', tile.gazeNs]);
    }
    const aim = this.aim;
    if (!aim || tile.gazeSequence < aim.sequence || !this.isAt(tile, aim.direction)) return;
    if (!aim.isAnswered) this.came.push(['jump', aim.ns]);
    aim.isAnswered = true;
    if (aim.isSettled || !tile.settled || tile.level > finest) return;
    this.came.push(['settled', aim.ns]);
    aim.isSettled = true;
  }

  isAt({ level, x, y }, [dx, dy, dz]) {
    const { width, height, tileSize } = this.film, side = tileSize * 2 ** level;
    const u = 0.5 + Math.atan2(dx, -dz) / (2 * Math.PI), v = 0.5 - Math.asin(Math.max(-1, Math.min(1, dy))) / Math.PI;
    return Math.floor(u * width / side) === x && Math.floor(Math.min(v * height, height - 1) / side) === y;
  }

  // The commands of a frame have been given. Returns the newest time of an answer that has reached the screen, or NaN.
  frame() {
    const gl = this.gl;
    let newest = NaN;
    while (this.flights.length && gl.clientWaitSync(this.flights[0].fence, 0, 0) !== gl.TIMEOUT_EXPIRED) {
      const { fence, came } = this.flights.shift();
      gl.deleteSync(fence);
      for (const [list, ns] of came) {
        const ms = this.connection.since(ns);
        this.add(list, ms);
        if (list === 'answer') newest = ms;
      }
    }
    if (!this.came.length) return newest;
    this.flights.push({ fence: gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0), came: this.came });
    this.came = [];
    gl.flush();
    return newest;
  }

  // The time that so large a share of the list's times does not exceed; NaN of none.
  quantile(list, share) {
    const sorted = [...this.lists[list]].sort((a, b) => a - b);
    return sorted.length ? sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] : NaN;
  }
}
