// What is seen before the first picture: what is waited for, how far it is, what went wrong, and the choice of a scene.

const BAD_TOKEN = 4,
  UNKNOWN_TENANT = 3,
  UNKNOWN_SCENE = 5;

export class Poster {
  /**
   * @param {HTMLElement} root
   * @param {{open: (wanted: {scene: string, tenant: string, token: string}) => void, again: () => void}} wishes
   */
  constructor(root, wishes) {
    this.root = root;
    this.text = /** @type {HTMLElement} */ (root.querySelector('#poster-text'));
    this.progress = /** @type {HTMLProgressElement} */ (root.querySelector('progress'));
    this.form = /** @type {HTMLFormElement} */ (root.querySelector('form'));
    this.again = /** @type {HTMLButtonElement} */ (root.querySelector('#again'));
    this.again.onclick = () => wishes.again();
    this.form.onsubmit = (event) => {
      event.preventDefault();
      const said = new FormData(this.form);
      wishes.open({
        scene: String(said.get('scene')),
        tenant: String(said.get('tenant')),
        token: String(said.get('token')),
      });
    };
  }

  /** @param {string} text @param {number | null} [percent] null: not known */
  say(text, percent = null) {
    this.root.hidden = false;
    this.form.hidden = this.again.hidden = true;
    this.progress.hidden = false;
    this.text.textContent = text;
    if (percent === null) this.progress.removeAttribute('value');
    else this.progress.value = percent / 100;
  }

  /** @param {string} why @param {{code: number} | null} refusal @param {boolean} goesOn it is tried again by itself */
  fail(why, refusal, goesOn) {
    this.say(why);
    this.progress.hidden = !goesOn;
    this.again.hidden = goesOn;
    const canBeMended = refusal && [BAD_TOKEN, UNKNOWN_TENANT, UNKNOWN_SCENE].includes(refusal.code);
    if (canBeMended) this.form.hidden = false;
  }

  /** Asks which scene is wanted. @param {{scene: string, tenant: string, token: string}} known */
  choose(known) {
    this.say('Which scene?');
    this.progress.hidden = true;
    this.form.hidden = false;
    const field = (/** @type {string} */ name) =>
      /** @type {HTMLInputElement} */ (this.form.elements.namedItem(name));
    field('scene').value = known.scene;
    field('tenant').value = known.tenant;
    field('scene').focus();
  }

  /** The scenes that there are. @param {string[]} names */
  offer(names) {
    const list = /** @type {HTMLElement} */ (this.form.querySelector('datalist'));
    list.replaceChildren(...names.map((name) => new Option(name, name)));
    this.text.textContent = `Which scene? There are ${names.join(', ')}.`;
  }

  hide() {
    this.root.hidden = true;
  }
}
