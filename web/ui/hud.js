// The head-up display: a line of figures, and what a screen reader is told of news.

const NONE = '–';
/** @param {number | null} value @param {number} digits */
const number = (value, digits) => (value === null ? NONE : value.toFixed(digits));

export class Hud {
  /** @param {HTMLElement} root with elements that have `data-figure` @param {HTMLElement} news of role status */
  constructor(root, news) {
    const fields = /** @type {HTMLElement[]} */ ([...root.querySelectorAll('[data-figure]')]);
    this.fields = new Map(fields.map((each) => [each.dataset.figure, each]));
    this.news = news;
  }

  /** @param {string} name @param {string} text */
  set(name, text) {
    const field = this.fields.get(name);
    if (field && field.textContent !== text) field.textContent = text;
  }

  /** @param {ReturnType<import('./figures.js').Figures['summary']>} figures */
  show(figures) {
    this.set('fps', number(figures.fps, 0));
    this.set('masks', number(figures.masksPerSecond, 0));
    this.set('response', number(figures.responseMs, 0));
    this.set('rate', number(figures.kilobytesPerSecond, 0));
    this.set('predicted', number(100 * figures.predicted, 0));
    this.set('server', number(figures.serverMs, 1));
  }

  /** Tells people once; a message that is there already is not repeated. @param {string} text */
  tell(text) {
    if (this.news.textContent !== text) this.news.textContent = text;
    this.news.hidden = text === '';
  }
}
