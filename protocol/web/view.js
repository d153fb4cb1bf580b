// Where the page looks: turned by yaw and pitch, no roll. Angles in radians; yaw to the right of -Z, pitch up.

const MOST_PITCH = Math.PI / 2, LEAST_FOV = 0.1, MOST_FOV = 2.4;

export class View {
  constructor() {
    this.yaw = this.pitch = 0;
    this.fov = 1.4; // of the longer side
  }

  turn(yaw, pitch) {
    this.yaw = Math.atan2(Math.sin(this.yaw + yaw), Math.cos(this.yaw + yaw));
    this.pitch = Math.max(-MOST_PITCH, Math.min(MOST_PITCH, this.pitch + pitch));
  }

  zoom(factor) {
    this.fov = Math.max(LEAST_FOV, Math.min(MOST_FOV, this.fov * factor));
  }

  // Half the width and half the height of the picture at distance 1.
  halves(aspect) {
    const half = Math.tan(this.fov / 2);
    return aspect >= 1 ? [half, half / aspect] : [half * aspect, half];
  }

  // x y z w, view to world.
  get orientation() {
    const sy = Math.sin(-this.yaw / 2), cy = Math.cos(-this.yaw / 2), sp = Math.sin(this.pitch / 2), cp = Math.cos(this.pitch / 2);
    return [cy * sp, sy * cp, -sy * sp, cy * cp];
  }

  // The world's direction at (x, y) of the picture, each from -1 to 1, up and right.
  direction(x, y, aspect) {
    const [w, h] = this.halves(aspect), d = rotate(this.orientation, [x * w, y * h, -1]), length = Math.hypot(...d);
    return d.map((c) => c / length);
  }

  // From clip space to directions in the world, column by column.
  toWorld(aspect) {
    const [w, h] = this.halves(aspect), q = this.orientation;
    return [...rotate(q, [w, 0, 0]), 0, ...rotate(q, [0, h, 0]), 0, ...rotate(q, [0, 0, -1]), 0, 0, 0, 0, 1];
  }
}

// Where a canvas is on the screen: left, top, width and height, as shares of the screen's; [] where that is not known.
// Exact in full screen. Else the window's frame is taken to be equally wide at the left, the right and the bottom; if the
// inside is much narrower than the window, the page is zoomed. Chromium does not tell where one of several screens begins.
export function onScreen(canvas) {
  const box = canvas.getBoundingClientRect();
  if (matchMedia('(display-mode: fullscreen)').matches) return [box.left / innerWidth, box.top / innerHeight, box.width / innerWidth, box.height / innerHeight];
  if (!outerWidth || !screen.width || !screen.height || screen.isExtended) return [];
  const scale = outerWidth - innerWidth > 32 ? outerWidth / innerWidth : 1, frame = (outerWidth - innerWidth * scale) / 2;
  const left = screenX - (screen.left ?? 0) + frame, top = screenY - (screen.top ?? 0) + outerHeight - frame - innerHeight * scale;
  return [(left + box.left * scale) / screen.width, (top + box.top * scale) / screen.height, box.width * scale / screen.width, box.height * scale / screen.height];
}

// A vector turned by a unit quaternion.
export function rotate([x, y, z, w], [a, b, c]) {
  const tx = 2 * (y * c - z * b), ty = 2 * (z * a - x * c), tz = 2 * (x * b - y * a);
  return [a + w * tx + y * tz - z * ty, b + w * ty + z * tx - x * tz, c + w * tz + x * ty - y * tx];
}
