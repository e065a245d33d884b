// The panels of the page: lights, settings, and the divider between two pictures.

/** @typedef {(id: string) => any} Find */

const KIND_NAMES = ['point', 'spot', 'sun'];

/** The colour of a light as it looks on a screen. @param {number[]} color linear */
function swatch(color) {
  const most = Math.max(...color, 1e-6);
  return `rgb(${color.map((part) => Math.round(255 * Math.pow(part / most, 1 / 2.2))).join(' ')})`;
}

/**
 * Lists the lights with a switch each. `onChange` gets one byte for each light, 0 where it is off; null if all are on.
 * @param {HTMLElement} root @param {import('../pack/pack.js').ScenePack} pack @param {any[]} lights
 * @param {(on: Uint8Array | null) => void} onChange
 */
export function listLights(root, pack, lights, onChange) {
  const entries = lights.map((light, i) => {
    const label = document.createElement('label');
    const box = Object.assign(document.createElement('input'), { type: 'checkbox', checked: true, onchange: tell });
    const dot = Object.assign(document.createElement('span'), { className: 'swatch' });
    dot.style.setProperty('background', swatch(light.color));
    label.append(box, dot, pack.info.lights[i] || `${KIND_NAMES[light.kind]} ${i + 1}`);
    return { label, box };
  });
  root.replaceChildren(...entries.map(({ label }) => label));
  function tell() {
    const on = Uint8Array.from(entries, ({ box }) => (box.checked ? 1 : 0));
    onChange(on.includes(0) ? on : null);
  }
  const setAll = (/** @type {boolean} */ checked) => {
    for (const { box } of entries) box.checked = checked;
    tell();
  };
  const [allOn, allOff] = ['all-on', 'all-off'].map((id) => /** @type {HTMLElement} */ (document.getElementById(id)));
  allOn.onclick = () => setAll(true);
  allOff.onclick = () => setAll(false);
}

/**
 * The divider of the comparison: by pointer, by arrow keys.
 * @param {Find} find @param {(split: {at: number, left: string, right: string} | null) => void} onSplit
 */
export function attachDivider(find, onSplit) {
  const [divider, button, against] = [find('divider'), find('compare'), find('against')];
  let at = 0.5;
  const show = () => {
    const on = !divider.hidden;
    divider.style.left = `${100 * at}%`;
    divider.setAttribute('aria-valuenow', String(Math.round(100 * at)));
    find('right-name').textContent = against.selectedOptions[0].textContent;
    onSplit(on ? { at, left: 'exact', right: against.value } : null);
  };
  const move = (to) => {
    at = Math.max(0, Math.min(1, to));
    show();
  };
  button.onclick = () => {
    divider.hidden = !divider.hidden;
    button.setAttribute('aria-pressed', String(!divider.hidden));
    show();
  };
  against.onchange = show;
  divider.addEventListener('pointerdown', (event) => {
    divider.setPointerCapture(event.pointerId);
    event.preventDefault();
    divider.focus();
  });
  divider.addEventListener('pointermove', (event) => {
    if (divider.hasPointerCapture(event.pointerId)) move(event.clientX / window.innerWidth);
  });
  divider.addEventListener('keydown', (event) => {
    const by = { ArrowLeft: -0.02, ArrowRight: 0.02, Home: -1, End: 1 }[event.key];
    if (by === undefined) return;
    event.preventDefault();
    move(at + by);
  });
}

/**
 * @param {Find} find @param {import('../viewer.js').Viewer} viewer
 * @param {{link: () => string, setSpeed: (factor: number) => void}} wishes
 */
export function attachPanels(find, viewer, { link, setSpeed }) {
  const panels = [
    ['lights-button', 'lights'],
    ['more-button', 'more'],
  ].map(([button, panel]) => [find(button), find(panel)]);
  const show = (chosen) =>
    panels.forEach(([button, panel]) => {
      panel.hidden = panel !== chosen || !panel.hidden;
      button.setAttribute('aria-expanded', String(!panel.hidden));
      if (panel.id === 'more' && !panel.hidden) showCode(find('qr'), link());
    });
  for (const [button, panel] of panels) button.onclick = () => show(panel);
  document.addEventListener('keydown', (event) => {
    if (event.key === 'Escape') show(null);
  });
  find('codec').onchange = (event) => viewer.set({ codec: event.target.value });
  find('samples').value = String(viewer.picture.samples);
  find('samples').onchange = (event) => viewer.set({ samples: Number(event.target.value) });
  find('occlusion').value = viewer.picture.occlusion;
  find('occlusion').onchange = (event) => viewer.set({ occlusion: event.target.value });
  for (const estimate of ['filter', 'accumulate']) {
    find(estimate).checked = viewer.picture[estimate];
    find(estimate).onchange = (event) => viewer.set({ [estimate]: event.target.checked });
  }
  find('sharpness').onchange = (event) => {
    viewer.quality.automatic = event.target.value === 'auto';
    viewer.quality.become(viewer.quality.automatic ? 0 : Number(event.target.value));
    viewer.resizeAt = 0;
  };
  find('smooth').onchange = (event) => viewer.set({ smooth: event.target.checked });
  find('show-hud').onchange = (event) => {
    find('hud').hidden = !event.target.checked;
  };
  find('speed').oninput = (event) => setSpeed(Math.pow(2, Number(event.target.value)));
}

// The server draws the code, as it has a library for that. What it is sent is a link without a token.
/** @param {HTMLImageElement} image @param {string} text */
function showCode(image, text) {
  const { hash } = new URL(text);
  image.onload = () => {
    image.hidden = false;
  };
  image.onerror = () => {
    image.hidden = true;
  };
  image.src = `qr/${encodeURIComponent(hash.slice(1))}.svg`;
}
