// Where the moving nodes, vertices and lights of a scene are at a scene time (web/PACK.md, WIRE.md "Scenes that change"):
// sampled in binary64 and rounded to binary32, as the server does.
import { isNormal, localTransform, product } from './matrices.js';

const f = Math.fround;

/**
 * @typedef {import('./matrices.js').Matrix} Matrix
 * @typedef {{path: string, interpolation: string, times: Float32Array, values: Float32Array}} Channel
 */

/**
 * The value of a channel; before the first key and after the last, the key's value holds.
 * @param {Channel} channel
 * @param {number} seconds
 * @returns {number[]} four numbers of binary64
 */
export function sample({ path, interpolation, times, values }, seconds) {
  const spline = interpolation === 'cubic_spline';
  const quad = (/** @type {number} */ i) => Array.from(values.subarray(4 * i, 4 * i + 4));
  const key = (/** @type {number} */ k) => quad(spline ? 3 * k + 1 : k);
  let next = 0;
  while (next < times.length && times[next] <= seconds) ++next;
  if (next === 0) return key(0);
  if (next === times.length) return key(times.length - 1);
  const k = next - 1;
  const span = times[next] - times[k];
  const t = (seconds - times[k]) / span;
  if (spline) return onSpline(quad(3 * k + 1), quad(3 * k + 2), quad(3 * next), quad(3 * next + 1), t, span);
  if (interpolation === 'step') return key(k);
  if (path === 'rotation') return slerp(unit(key(k)), unit(key(next)), t);
  const to = key(next);
  return key(k).map((from, i) => from * (1 - t) + to[i] * t);
}

/** glTF 2.0, appendix C.5: a Hermite spline whose tangents are given per second. */
function onSpline(
  /** @type {number[]} */ start,
  /** @type {number[]} */ leaving,
  /** @type {number[]} */ arriving,
  /** @type {number[]} */ end,
  /** @type {number} */ t,
  /** @type {number} */ span,
) {
  const t2 = t * t,
    t3 = t2 * t;
  return start.map(
    (value, i) =>
      (2 * t3 - 3 * t2 + 1) * value +
      (t3 - 2 * t2 + t) * (leaving[i] * span) +
      (3 * t2 - 2 * t3) * end[i] +
      (t3 - t2) * (arriving[i] * span),
  );
}

function dot(/** @type {number[]} */ a, /** @type {number[]} */ b) {
  return a[3] * b[3] + a[0] * b[0] + (a[1] * b[1] + a[2] * b[2]);
}

function unit(/** @type {number[]} */ q) {
  const length = Math.sqrt(dot(q, q));
  if (length <= 0) return [0, 0, 0, 1];
  const inverse = 1 / length;
  return q.map((value) => value * inverse);
}

/** As glm::slerp: the short way, and linear where the two nearly coincide. */
function slerp(/** @type {number[]} */ from, /** @type {number[]} */ to, /** @type {number} */ t) {
  let cosine = dot(from, to);
  let end = to;
  if (cosine < 0) {
    end = to.map((value) => -value);
    cosine = -cosine;
  }
  if (cosine > 1 - Number.EPSILON) return from.map((value, i) => value * (1 - t) + end[i] * t);
  const angle = Math.acos(cosine);
  const first = Math.sin((1 - t) * angle),
    second = Math.sin(t * angle),
    whole = Math.sin(angle);
  return from.map((value, i) => (first * value + second * end[i]) / whole);
}

/** The motion of one scene. */
export class Motion {
  /** @param {import('./pack.js').ScenePack} pack */
  constructor(pack) {
    this.pack = pack;
    const { moving, period_us: period } = pack.info;
    this.period = period;
    this.nodes = moving.nodes.map((/** @type {any} */ node) => ({
      ...node,
      channels: node.channels.map((/** @type {any} */ channel) => ({
        ...channel,
        times: pack.floats(channel.times),
        values: pack.floats(channel.values),
      })),
    }));
    this.instances = moving.instances;
    /** @type {Map<number, number>} node of each moving light */
    this.lightNodes = new Map(moving.lights.map((/** @type {any} */ entry) => [entry.light, entry.node]));
  }

  get moves() {
    return this.nodes.length > 0;
  }

  /** The time within one period; 0 if nothing moves. */
  withinPeriod(/** @type {number} */ us) {
    if (this.period <= 0) return 0;
    const rest = us % this.period;
    return rest < 0 ? rest + this.period : rest;
  }

  /** Node to world of each moving node. @returns {Matrix[]} */
  transforms(/** @type {number} */ us) {
    const seconds = us * 1e-6;
    /** @type {Matrix[]} */
    const toWorld = [];
    for (const node of this.nodes) {
      const local = { ...node };
      for (const channel of node.channels) local[channel.path] = sample(channel, seconds).map(f);
      toWorld.push(product(node.parent < 0 ? node.parent_to_world : toWorld[node.parent], localTransform(local)));
    }
    return toWorld;
  }

  /**
   * The lights of WIRE.md at that time, the moving ones at their places.
   * @template {{position: number[], direction: number[]}} Light
   * @param {Light[]} lights
   * @param {number} us
   * @returns {Light[]}
   */
  lightsAt(lights, us) {
    if (this.lightNodes.size === 0) return lights;
    const toWorld = this.transforms(us);
    return lights.map((light, i) => {
      const node = this.lightNodes.get(i);
      return node === undefined ? light : placed(light, toWorld[node]);
    });
  }
}

/** A light shines along its node's -Z; a node that is scaled to 0 has no direction. */
function placed(/** @type {any} */ light, /** @type {Matrix} */ m) {
  const position = [f(m[12]), f(m[13]), f(m[14])];
  const forward = [-m[8], -m[9], -m[10]];
  const length = Math.sqrt(forward[0] * forward[0] + forward[1] * forward[1] + forward[2] * forward[2]);
  if (!isNormal(length)) return { ...light, position };
  const direction = forward.map((value) => f(value / length));
  const again = f(
    1 /
      f(
        Math.sqrt(
          f(f(f(direction[0] * direction[0]) + f(direction[1] * direction[1])) + f(direction[2] * direction[2])),
        ),
      ),
  );
  return { ...light, position, direction: direction.map((value) => f(value * again)) };
}
