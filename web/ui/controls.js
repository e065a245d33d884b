// Moves a gaze by pointer, touch, keyboard and gamepad. step() is called once a frame and says whether it moved.
//
//   drag, one finger        look            wheel, pinch        forward and back
//   two fingers             sideways, up    W A S D, arrows     move (arrows turn with Ctrl)
//   Q E, Page Up, Down      down, up        Shift               faster
//   left and right stick    move, look      double click        pointer lock, Escape ends it

const TURN_PER_PIXEL = 0.0035; // radians
const TURN_PER_SECOND = 1.6;
const DEAD_ZONE = 0.15; // of a gamepad's stick
const FASTER = 4;
const MOVE_KEYS = {
  KeyW: [0, 0, 1],
  ArrowUp: [0, 0, 1],
  KeyS: [0, 0, -1],
  ArrowDown: [0, 0, -1],
  KeyA: [-1, 0, 0],
  ArrowLeft: [-1, 0, 0],
  KeyD: [1, 0, 0],
  ArrowRight: [1, 0, 0],
  KeyE: [0, 1, 0],
  PageUp: [0, 1, 0],
  KeyQ: [0, -1, 0],
  PageDown: [0, -1, 0],
};
const TURN_KEYS = { ArrowUp: [0, 1], ArrowDown: [0, -1], ArrowLeft: [1, 0], ArrowRight: [-1, 0] };

export class Controls {
  /**
   * @param {HTMLElement} target that has the focus and gets the pointers
   * @param {import('./gaze.js').Gaze} gaze
   * @param {{speed: number, onUse: () => void}} options speed: metres a second; onUse: a person takes over
   */
  constructor(target, gaze, { speed, onUse }) {
    this.target = target;
    this.gaze = gaze;
    this.speed = speed;
    this.onUse = onUse;
    this.keys = new Set();
    /** @type {Map<number, {x: number, y: number}>} pointers that are down */
    this.pointers = new Map();
    this.stick = { x: 0, y: 0 }; // of the screen, each -1 to 1
    this.turned = { left: 0, up: 0 }; // radians since the last step
    this.moved = [0, 0, 0]; // metres since the last step
    const on = (type, react, options) => target.addEventListener(type, react, options);
    on('pointerdown', (event) => this.down(event));
    on('pointermove', (event) => this.drag(event));
    for (const type of ['pointerup', 'pointercancel', 'lostpointercapture']) {
      on(type, (event) => this.pointers.delete(event.pointerId));
    }
    on('wheel', (event) => this.wheel(event), { passive: false });
    on('dblclick', () => target.requestPointerLock?.());
    on('keydown', (event) => this.key(event, true));
    on('keyup', (event) => this.key(event, false));
    on('blur', () => this.keys.clear());
    on('contextmenu', (event) => event.preventDefault());
  }

  /** @param {PointerEvent} event */
  down(event) {
    this.target.focus({ preventScroll: true });
    this.target.setPointerCapture?.(event.pointerId);
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    this.onUse();
  }

  /** @param {PointerEvent} event */
  drag(event) {
    const locked = document.pointerLockElement === this.target;
    const before = this.pointers.get(event.pointerId);
    if (locked) return this.look(event.movementX, event.movementY); // leads the gaze
    if (!before) return;
    const now = { x: event.clientX, y: event.clientY };
    const others = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
    this.pointers.set(event.pointerId, now);
    const [dx, dy] = [now.x - before.x, now.y - before.y];
    if (others.length === 0) return this.look(-dx, -dy);
    const apart = (from) => Math.hypot(from.x - others[0].x, from.y - others[0].y);
    const metres = this.speed / 200;
    this.moved[2] += 2 * metres * (apart(now) - apart(before));
    this.moved[0] -= (metres * dx) / 2;
    this.moved[1] += (metres * dy) / 2;
  }

  /** The picture follows the finger; a locked pointer leads the gaze. @param {number} right @param {number} down */
  look(right, down) {
    this.turned.left -= TURN_PER_PIXEL * right;
    this.turned.up -= TURN_PER_PIXEL * down;
    this.onUse();
  }

  /** @param {WheelEvent} event */
  wheel(event) {
    event.preventDefault();
    this.moved[2] -= (Math.sign(event.deltaY) * this.speed) / 6;
    this.onUse();
  }

  /** @param {KeyboardEvent} event @param {boolean} pressed */
  key(event, pressed) {
    if (event.altKey || event.metaKey) return;
    const known = event.code in MOVE_KEYS || event.code.startsWith('Shift') || event.code.startsWith('Control');
    if (!known) return;
    if (event.code in MOVE_KEYS) event.preventDefault();
    if (!pressed) return void this.keys.delete(event.code);
    this.keys.add(event.code);
    if (event.code in MOVE_KEYS) this.onUse();
  }

  /** @returns {{move: number[], turn: number[]}} each part -1 to 1 */
  held() {
    const move = [this.stick.x, 0, -this.stick.y];
    const turn = [0, 0];
    const turns = this.keys.has('ControlLeft') || this.keys.has('ControlRight');
    for (const key of this.keys) {
      const by = turns && TURN_KEYS[key];
      if (by)
        by.forEach((part, i) => {
          turn[i] += part;
        });
      else
        MOVE_KEYS[key]?.forEach((part, i) => {
          move[i] += part;
        });
    }
    this.readGamepad(move, turn);
    return { move, turn };
  }

  /** @param {number[]} move @param {number[]} turn */
  readGamepad(move, turn) {
    const pad = navigator.getGamepads?.().find((each) => each?.connected && each.axes.length >= 4);
    if (!pad) return;
    const axis = (i) => (Math.abs(pad.axes[i]) > DEAD_ZONE ? pad.axes[i] : 0);
    move[0] += axis(0);
    move[2] -= axis(1);
    move[1] += (pad.buttons[7]?.value ?? 0) - (pad.buttons[6]?.value ?? 0);
    turn[0] -= axis(2);
    turn[1] -= axis(3);
    if (axis(0) || axis(1) || axis(2) || axis(3)) this.onUse();
  }

  /** Moves the gaze by what was done since the last step. @param {number} seconds */
  step(seconds) {
    const { move, turn } = this.held();
    const pace = this.speed * seconds * (this.keys.has('ShiftLeft') || this.keys.has('ShiftRight') ? FASTER : 1);
    const left = this.turned.left + turn[0] * TURN_PER_SECOND * seconds;
    const up = this.turned.up + turn[1] * TURN_PER_SECOND * seconds;
    const way = this.moved.map((part, i) => part + move[i] * pace);
    this.turned = { left: 0, up: 0 };
    this.moved = [0, 0, 0];
    if (left === 0 && up === 0 && way.every((part) => part === 0)) return false;
    this.gaze.turn(left, up);
    this.gaze.move(way[0], way[1], way[2]);
    return true;
  }
}

/**
 * A stick on the screen, for those who have no keys.
 * @param {HTMLElement} base @param {HTMLElement} knob @param {Controls} controls
 */
export function attachStick(base, knob, controls) {
  const set = (x, y) => {
    controls.stick = { x, y };
    knob.style.transform = `translate(${x * 60}%, ${y * 60}%)`;
  };
  const follow = (event) => {
    if (!base.hasPointerCapture(event.pointerId)) return;
    const box = base.getBoundingClientRect();
    const x = (2 * (event.clientX - box.left)) / box.width - 1;
    const y = (2 * (event.clientY - box.top)) / box.height - 1;
    const far = Math.max(1, Math.hypot(x, y));
    set(x / far, y / far);
    controls.onUse();
  };
  base.addEventListener('pointerdown', (event) => {
    base.setPointerCapture(event.pointerId);
    follow(event);
    event.preventDefault();
  });
  base.addEventListener('pointermove', follow);
  for (const type of ['pointerup', 'pointercancel']) base.addEventListener(type, () => set(0, 0));
}
