// The live page: asks /status once a second and plots the last two minutes, a colour for each tenant.
'use strict';

const INTERVAL_MS = 1000;
const KEPT = 120;
const SESSIONS_SHOWN = 30;
const WIDTH = 320, HEIGHT = 150, LEFT = 38, BOTTOM = 16;
const COLOURS = ['#2f6fb5', '#c8641b', '#2c8a5b', '#8a4fa8', '#b43c4e', '#7a6b12', '#0f8a96', '#6b6f76'];

const PLOTS = [
  {id: 'vbps', title: 'Visibility buffers a second', value: (tenant) => tenant.vbps, unit: ''},
  {id: 'share', title: 'Share of the device', value: (tenant) => tenant.share * 100, unit: '%',
    aim: (tenant) => tenant.expected_share * 100 || undefined, note: 'dashed: by weight'},
  {id: 'latency', title: 'Arrival to sent, mean', value: (tenant) => tenant.total_ms, unit: ' ms'},
  {id: 'rate', title: 'Sent', value: (tenant) => tenant.mbit_per_s, unit: ' Mbit/s'},
];

const history = [];          // of {at, tenants: {name: {...}}}
const colours = new Map();   // by tenant, for as long as the page is open
let last = null;             // the newest status, with its time
let token = '';              // that somebody typed in; kept for as long as the page is open
let waitUntil = 0;           // when the server looks at a token again

const at = (id) => document.getElementById(id);

function colourOf(tenant) {
  if (!colours.has(tenant)) colours.set(tenant, COLOURS[colours.size % COLOURS.length]);
  return colours.get(tenant);
}

function element(name, attributes = {}, text = '') {
  const svg = ['svg', 'path', 'line', 'text', 'title'].includes(name);
  const made = svg ? document.createElementNS('http://www.w3.org/2000/svg', name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.textContent = text;
  return made;
}

// The mean over a tenant's frames since the request before: each session's mean of the last second counts as often as it
// was answered.
function meanUs(sessions, before) {
  const earlier = new Map((before ? before.sessions : []).map((session) => [session.id, session.frames]));
  let frames = 0, sum = 0;
  for (const session of sessions) {
    const answered = Math.max(0, session.frames - (earlier.get(session.id) || 0));
    frames += answered;
    sum += answered * session.total_us;
  }
  return frames > 0 ? sum / frames : 0;
}

// A tenant's figures between two requests.
function figures(tenant, status, before, seconds) {
  const earlier = before && before.tenants.find((other) => other.name === tenant.name);
  const since = (key) => earlier && seconds > 0 ? Math.max(0, tenant[key] - earlier[key]) / seconds : 0;
  const sessions = status.sessions.filter((session) => session.tenant === tenant.name && session.total_us > 0);
  return {
    vbps: since('buffers'),
    mbit_per_s: since('bytes') * 8 / 1e6,
    share: tenant.share || 0,
    expected_share: tenant.expected_share || 0,
    total_ms: meanUs(sessions, before) / 1000,
  };
}

function remember(status) {
  const now = performance.now();
  const seconds = last ? (now - last.at) / 1000 : 0;
  const tenants = {};
  for (const tenant of status.tenants) {
    tenants[tenant.name] = figures(tenant, status, last && last.status, seconds);
  }
  if (last) history.push({at: now, tenants});
  while (history.length > KEPT) history.shift();
  last = {at: now, status};
}

// The smallest value of 1, 2 or 5 times a power of ten that is not below `value`.
function round(value) {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((step) => step * power).find((step) => step >= value * 0.999);
}

function shown(value) {
  return value === 0 ? '0' : value >= 100 ? value.toFixed(0) : value >= 1 ? value.toFixed(1) : value.toFixed(2);
}

function path(values, top) {
  let text = '', pen = 'M';
  values.forEach((value, i) => {
    if (value === undefined) {
      pen = 'M';
      return;
    }
    const x = LEFT + (WIDTH - LEFT) * (KEPT - values.length + i) / (KEPT - 1);
    const y = (HEIGHT - BOTTOM) * (1 - value / top) + 4;
    text += `${pen}${x.toFixed(1)} ${y.toFixed(1)}`;
    pen = 'L';
  });
  return text;
}

function series(name, value) {
  return history.map((look) => look.tenants[name] && value(look.tenants[name]));
}

function drawPlot(plot, names) {
  const figure = at(plot.id);
  const svg = figure.querySelector('svg');
  const all = names.flatMap((name) => [series(name, plot.value), plot.aim ? series(name, plot.aim) : []]).flat();
  const top = round(Math.max(0, ...all.filter((value) => value !== undefined)));
  const parts = [];
  for (const part of [0, 0.5, 1]) {
    const y = (HEIGHT - BOTTOM) * (1 - part) + 4;
    parts.push(element('line', {class: 'grid', x1: LEFT, x2: WIDTH, y1: y, y2: y}));
    parts.push(element('text', {x: LEFT - 5, y: y + 3.5, 'text-anchor': 'end'}, shown(top * part)));
  }
  parts.push(element('text', {x: LEFT, y: HEIGHT}, '2 min ago'));
  parts.push(element('text', {x: WIDTH, y: HEIGHT, 'text-anchor': 'end'}, 'now'));
  for (const name of names) {
    const colour = colourOf(name);
    if (plot.aim) parts.push(element('path', {class: 'line aim', stroke: colour, d: path(series(name, plot.aim), top)}));
    parts.push(element('path', {class: 'line', 'data-tenant': name, stroke: colour,
      d: path(series(name, plot.value), top)}));
  }
  svg.replaceChildren(...parts);
  const newest = history[history.length - 1];
  figure.querySelector('.keys').replaceChildren(...names.map((name) => {
    const key = element('li');
    const mark = element('i');
    mark.style.background = colourOf(name);
    const value = newest && newest.tenants[name] ? shown(plot.value(newest.tenants[name])) + plot.unit : '';
    key.append(mark, `${name} ${value}`);
    return key;
  }));
}

function makePlots() {
  at('plots').replaceChildren(...PLOTS.map((plot) => {
    const figure = element('figure', {id: plot.id});
    const caption = element('figcaption', {}, plot.title);
    if (plot.note) caption.append(element('small', {}, plot.note));
    const svg = element('svg', {viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: 'img', 'aria-label': plot.title});
    figure.append(caption, svg, element('ul', {class: 'keys'}));
    return figure;
  }));
}

// `columns`: [title, value of a row, whether it is a number].
function fillTable(id, columns, rows) {
  const head = element('tr');
  for (const [title, , number] of columns) head.append(element('th', number ? {class: 'number'} : {}, title));
  at(id).replaceChildren(head, ...rows.map((row) => {
    const line = element('tr');
    for (const [, value, number] of columns) {
      line.append(element('td', number ? {class: 'number'} : {}, String(value(row))));
    }
    return line;
  }));
}

const percent = (ratio) => ((ratio || 0) * 100).toFixed(1) + '%';
const mebibytes = (bytes) => (bytes / 1048576).toFixed(1);
const ms = (us) => (us / 1000).toFixed(1);

// The state of a scene's light buffers. Until they are built, frames are as exact but cost more.
function lightBuffers(built) {
  if (built.state !== 'building') return built.state;
  const done = built.lights_percent.filter((share) => share >= 100).length;
  return `${built.percent.toFixed(0)}%, light ${done + 1} of ${built.lights_percent.length}`;
}

function showTables(status) {
  const newest = history[history.length - 1];
  fillTable('tenants', [
    ['Tenant', (t) => t.name], ['Weight', (t) => t.weight, true], ['Sessions', (t) => t.sessions, true],
    ['vbps', (t) => newest && newest.tenants[t.name] ? shown(newest.tenants[t.name].vbps) : '', true],
    ['Share', (t) => percent(t.share), true], ['By weight', (t) => t.expected_share ? percent(t.expected_share) : '', true],
    ['Lag, ms', (t) => (t.lag_ms || 0).toFixed(1), true], ['GPU, s', (t) => (t.gpu_seconds || 0).toFixed(1), true],
  ], status.tenants);
  fillTable('scenes', [
    ['Scene', (s) => s.name], ['Triangles', (s) => s.triangles.toLocaleString('en'), true],
    ['Lights', (s) => s.lights, true], ['Sessions', (s) => s.sessions, true],
    ['Host, MiB', (s) => mebibytes(s.memory_bytes), true],
    ['Device, MiB', (s) => mebibytes(s.device_memory_bytes), true],
    ['Loaded in, s', (s) => s.load_seconds.toFixed(2), true],
    ['Built in, s', (s) => s.tracer_build_seconds.toFixed(2), true],
    ['Light buffers', (s) => lightBuffers(s.light_buffers)],
  ], status.scenes);
  const sessions = [...status.sessions].sort((a, b) => b.total_us - a.total_us);
  fillTable('sessions', [
    ['Session', (s) => s.id], ['Tenant', (s) => s.tenant], ['Scene', (s) => s.scene],
    ['Size', (s) => `${s.width}x${s.height}`, true], ['Frames', (s) => s.frames, true],
    ['Queue, ms', (s) => ms(s.queue_us), true], ['GPU, ms', (s) => ms(s.gpu_us), true],
    ['Total, ms', (s) => ms(s.total_us), true],
  ], sessions.slice(0, SESSIONS_SHOWN));
  const hidden = sessions.length - SESSIONS_SHOWN;
  at('more').textContent = hidden > 0 ? `the slowest ${SESSIONS_SHOWN} of ${sessions.length}` : '';
}

function setState(name, text) {
  at('state').className = name;
  at('state').textContent = text;
  document.title = `gnomond: ${text}`;
}

function show(status) {
  remember(status);
  at('version').textContent = status.version;
  const leaving = status.stopping ? 'stopping' : status.draining ? 'draining' : '';
  setState(leaving ? 'draining' : status.ready ? 'ready' : 'down', leaving || (status.ready ? 'ready' : 'not ready'));
  const device = status.devices[0] || {};
  at('facts').textContent = `${device.name || 'no device'}, ${device.tracer || 'no tracer'}, policy ${status.policy}, ` +
    `${status.sessions.length} sessions, Jain ${status.jain.toFixed(3)}, worst lag ${status.worst_lag_ms.toFixed(1)} ms`;
  const names = status.tenants.map((tenant) => tenant.name);
  for (const plot of PLOTS) drawPlot(plot, names);
  showTables(status);
}

// Off loopback the daemon shows its status to those who have its token. A token that was refused is not sent again.
function askForToken(answer, said) {
  token = '';
  if (answer.status === 429) waitUntil = performance.now() + 1000 * Number(answer.headers.get('Retry-After') || 1);
  at('refused').textContent = said;
  at('access').hidden = false;
  setState('', 'locked');
}

// Asks for /status. If the daemon does not answer, the page shows that and keeps asking, as another may start.
async function look() {
  try {
    const headers = token ? {Authorization: `Bearer ${token}`} : {};
    const answer = await fetch('/status', {cache: 'no-store', headers, signal: AbortSignal.timeout(5000)});
    if (answer.status === 401 || answer.status === 429) {
      askForToken(answer, token ? await answer.text() : '');
      return;  // until a token is typed in
    }
    at('access').hidden = true;
    show(await answer.json());
  } catch (error) {
    if (last && last.status.stopping) setState('draining', 'stopped');
    else setState('down', 'does not answer');
  }
  setTimeout(look, INTERVAL_MS);
}

at('access').addEventListener('submit', (event) => {
  event.preventDefault();
  token = at('token').value;
  at('token').value = '';
  setTimeout(look, Math.max(0, waitUntil - performance.now()));
});

makePlots();
look();
