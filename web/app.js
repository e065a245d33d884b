// The page: connects what a person does with the viewer, and what the viewer tells with the page.
import { addressOf } from './link/door.js';
import { headersOf } from './link/headers.js';
import { Controls, attachStick } from './ui/controls.js';
import { Figures } from './ui/figures.js';
import { Flight } from './ui/flight.js';
import { Gaze } from './ui/gaze.js';
import { Hud } from './ui/hud.js';
import { attachDivider, attachPanels, listLights } from './ui/panels.js';
import { Poster } from './ui/poster.js';
import { format, takeFromAddress } from './ui/permalink.js';
import { Viewer } from './viewer.js';
import { shownPart } from './prediction/border.js';

/** @template {HTMLElement} T @param {string} id @returns {T} */
const element = (id) => /** @type {T} */ (document.getElementById(id));

const canvas = /** @type {HTMLCanvasElement} */ (element('picture'));
const hud = new Hud(element('hud'), element('news'));
const poster = new Poster(element('poster'), { open: (wanted) => open(wanted), again: () => open(place) });
const figures = new Figures();
const gaze = new Gaze({ position: [0, 0, 0], yaw: 0, pitch: 0, verticalFov: 0.9 });
const controls = new Controls(canvas, gaze, { speed: 2, onUse: () => setFlying(false) });
const viewer = new Viewer(canvas, (event) => reactions[event.is]?.(event));
/** The server says so in the head of the page (fleet.name). */
const fleet = /** @type {HTMLMetaElement | null} */ (document.querySelector('meta[name=gnomon-fleet]'))?.content ?? '';
const place = takeFromAddress(location, history, sessionStorage);
viewer.set(countingOf(place));
/** @type {Flight | null} */
let flight = null;
let viewIsSet = false;
let speed = 2;

/** Of a link, what is counted, and how it is shown. @param {import('./ui/permalink.js').Place} said */
function countingOf({ samples, occlusion, filter, accumulate }) {
  return { samples, occlusion, filter, accumulate };
}

/** What the viewer tells. @type {Record<string, (event: any) => void>} */
const reactions = {
  connecting: () => (viewer.renderer ? hud.tell('connecting again') : poster.say('connecting')),
  waiting: (event) => (viewer.renderer ? hud.tell(event.text) : poster.say(event.text, event.percent)),
  progress: ({ done, total }) => poster.say('the scene is on its way', total > 0 ? (100 * done) / total : null),
  interrupted: () => {
    const text = 'the scene did not come whole; trying again';
    if (viewer.renderer) hud.tell(text);
    else poster.say(text);
  },
  open: (event) => {
    hud.tell('');
    hud.set('transport', 'WebSocket');
    element('about').textContent =
      `${event.scene.name}: ${event.scene.triangles.toLocaleString()} triangles, ` +
      `${event.scene.lights.length} lights, traced by ${event.tracer}`;
    startView(event);
  },
  scene: ({ pack, welcome }) => {
    flight = new Flight(pack);
    const { min, max } = pack.info.bounds;
    speed = Math.max(0.5, Math.hypot(...max.map((part, i) => part - min[i])) / 12);
    controls.speed = speed;
    listLights(element('light-list'), pack, welcome.scene.lights, (on) => viewer.set({ lightsOn: on }));
    hud.set('lights', String(welcome.scene.lights.length));
    document.title = `${welcome.scene.name} – Gnomon`;
    poster.hide();
  },
  frame: (event) => figures.frame({ at: performance.now(), ...event }),
  picture: ({ predicted, hasMasks }) => {
    if (!hasMasks) return;
    figures.firstMs ??= performance.now();
    figures.picture(performance.now(), predicted);
  },
  degraded: (event) => hud.tell(`${event.reason}: ${event.width} x ${event.height}`),
  transport: ({ name }) => hud.set('transport', name),
  draining: ({ moveNow, deadlineMs }) => {
    if (!moveNow && deadlineMs < Infinity) hud.tell('this server is about to stop');
  },
  fits: () => hud.tell('the server has room for fewer pixels'),
  closed: (event) => {
    const text = event.againInMs === null ? event.why : `${event.why}; trying again`;
    if (viewer.renderer) hud.tell(text);
    else poster.fail(text, event.refusal, event.againInMs !== null);
  },
  failed: ({ why }) => poster.fail(why, null, false),
};

/** The view of the link, or that of the server where the link says none. @param {any} welcome */
function startView(welcome) {
  if (viewIsSet) return;
  viewIsSet = true;
  if (place.view) return void Object.assign(gaze, place.view);
  const camera = shownPart(welcome.scene.defaultCamera, viewer.size);
  const verticalFov = Math.atan(camera.tanUp) + Math.atan(camera.tanDown);
  Object.assign(gaze, Gaze.of({ ...camera, verticalFov }));
}

/** @param {{scene: string, tenant: string, token: string}} wanted */
function open(wanted) {
  Object.assign(place, wanted);
  if (!place.scene) return choose();
  poster.say('connecting');
  goOn().catch((error) => poster.fail(error.message, null, false));
}

// Of a fleet, the page goes on where the scene is.
async function goOn() {
  const elsewhere = await addressOf(place, location, fleet);
  if (elsewhere) location.replace(elsewhere);
  else await viewer.open(place);
}

// Who may see the names of scenes is told them.
async function choose() {
  poster.choose(place);
  const answer = await fetch('scene/', { headers: headersOf(place) });
  if (answer.ok) poster.offer((await answer.json()).scenes);
}

/** @param {boolean} on */
function setFlying(on) {
  if (flying === on) return;
  flying = on;
  element('fly').setAttribute('aria-pressed', String(on));
}
let flying = false;

function link() {
  return new URL(format({ ...place, ...viewer.picture, view: { ...gaze } }), location.href).href;
}

async function copyLink() {
  history.replaceState(null, '', link());
  try {
    await navigator.clipboard.writeText(link());
    hud.tell('the link is copied');
  } catch {
    hud.tell('the link is in the address bar');
  }
  setTimeout(() => hud.tell(''), 2500);
}

async function headsetIsThere() {
  const { xr } = /** @type {any} */ (navigator);
  return Boolean(xr && (await xr.isSessionSupported('immersive-vr').catch(() => false)));
}

async function fillScreen() {
  if (document.fullscreenElement) return document.exitFullscreen();
  await element('stage')
    .requestFullscreen?.()
    .catch(() => {});
}

// A phone that is looked at while a flight goes on should not go dark.
async function keepAwake() {
  if (document.visibilityState === 'visible')
    await /** @type {any} */ (navigator).wakeLock?.request('screen').catch(() => {});
}

element('fly').onclick = () => {
  setFlying(!flying);
  keepAwake();
};
element('link').onclick = copyLink;
element('full').onclick = fillScreen;
// What few need comes when they do.
headsetIsThere().then(async (isThere) => {
  if (!isThere) return;
  const { Headset } = await import('./xr.js');
  const headset = new Headset(viewer, gaze, (text) => hud.tell(text));
  element('headset').onclick = () => headset.enter().catch((error) => hud.tell(error.message));
  element('headset').hidden = false;
  Object.assign(/** @type {any} */ (window).gnomon, { headset });
});
/** @type {Promise<import('./ui/sides.js').Sides> | null} */
let sides = null;
element('sides-button').onclick = async () => {
  sides ??= import('./ui/sides.js').then(({ Sides }) => new Sides(element, viewer));
  try {
    (await sides).open(gaze.pose);
  } catch (error) {
    sides = null;
    hud.tell(`what shows them cannot be had: ${/** @type {Error} */ (error).message}`);
  }
};
attachStick(element('stick'), element('knob'), controls);
attachDivider(element, (split) => viewer.set({ split }));
attachPanels(element, viewer, {
  link,
  setSpeed: (factor) => {
    controls.speed = speed * factor;
  },
});
window.addEventListener('hashchange', () => {
  const said = takeFromAddress(location, history, sessionStorage);
  if (said.view) Object.assign(gaze, said.view);
  if (said.scene && said.scene !== place.scene) {
    viewIsSet = Boolean(said.view);
    Object.assign(viewer.picture, countingOf(said));
    open(said);
  } else {
    viewer.set(countingOf(said));
  }
  /** @type {HTMLSelectElement} */ (element('samples')).value = String(said.samples);
  /** @type {HTMLSelectElement} */ (element('occlusion')).value = said.occlusion;
  /** @type {HTMLInputElement} */ (element('filter')).checked = said.filter;
  /** @type {HTMLInputElement} */ (element('accumulate')).checked = said.accumulate;
});
window.addEventListener('pagehide', () => viewer.close());

let before = performance.now();
let told = 0;
/** @param {number} now */
function turn(now) {
  requestAnimationFrame(turn);
  const seconds = Math.min(Math.max(now - before, 0) / 1000, 0.25);
  before = now;
  if (flying && flight) Object.assign(gaze, flight.step(seconds));
  else controls.step(seconds);
  if (viewIsSet) viewer.frame(gaze.pose, performance.now());
  if (now - told > 250) {
    told = now;
    hud.show(figures.summary(performance.now()));
    hud.set('size', `${viewer.size.width} x ${viewer.size.height}`);
  }
}
requestAnimationFrame(turn);
open(place);

// For tests, and for the curious with a console.
Object.assign(window, { gnomon: { viewer, gaze, figures, controls, setFlying } });
