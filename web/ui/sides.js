// The four pictures of side_by_side.js beside each other, each with what is known of it. A click makes one large.
import { difference, SideBySide } from '../side_by_side.js';

/** @typedef {import('../side_by_side.js').Side} Side */

/** What a picture is made of. @param {Side} side */
export function captionOf({ name, points, occlusion, views, gpuMs }) {
  const of = views > 1 ? `, means of ${views} views` : '';
  const lights = points > 1 ? `${points} points of each lamp` : 'one point of each lamp';
  return `${name}: ${lights}${occlusion ? ' and ambient occlusion' : ''}${of}, ${gpuMs.toFixed(1)} ms a mask`;
}

export class Sides {
  /** @param {(id: string) => any} find @param {import('../viewer.js').Viewer} viewer */
  constructor(find, viewer) {
    this.section = find('sides');
    this.button = find('sides-button');
    this.text = find('sides-text');
    this.grid = find('sides-grid');
    this.viewer = viewer;
    this.sideBySide = new SideBySide(viewer);
    this.round = 0; // what comes of an earlier one is of no use
    find('sides-close').onclick = () => this.close();
    document.addEventListener('keydown', (event) => {
      if (event.key === 'Escape') this.close();
    });
  }

  /** @param {import('../prediction/border.js').Pose} pose */
  async open(pose) {
    const round = ++this.round;
    const tell = (/** @type {string} */ text) => {
      if (round === this.round) this.text.textContent = text;
    };
    this.section.hidden = false;
    this.grid.replaceChildren();
    /** @type {{side: Side, caption: HTMLElement}[]} */
    const shown = [];
    tell('the first of four pictures is traced');
    try {
      await this.sideBySide.open(pose, (side) => {
        if (round !== this.round) return;
        shown.push({ side, caption: this.show(side) });
        tell(shown.length < 3 ? `picture ${shown.length + 1} of 4 is traced` : 'the reference is traced, in 16 views');
      });
      this.compare(shown);
      tell('one view, each picture as the server traced it; the difference is the root mean square of the bytes');
    } catch (error) {
      tell(error instanceof Error ? error.message : String(error));
    }
  }

  /** @private @param {Side} side @returns {HTMLElement} its caption */
  show(side) {
    const canvas = Object.assign(document.createElement('canvas'), this.viewer.size);
    side.draw(/** @type {CanvasRenderingContext2D} */ (canvas.getContext('2d')));
    const caption = Object.assign(document.createElement('figcaption'), { textContent: captionOf(side) });
    const figure = document.createElement('figure');
    figure.onclick = () => figure.toggleAttribute('data-large');
    figure.append(canvas, caption);
    this.grid.append(figure);
    return caption;
  }

  /** @private @param {{side: Side, caption: HTMLElement}[]} shown the reference is the last one */
  compare(shown) {
    const reference = shown[shown.length - 1].side;
    for (const { side, caption } of shown.slice(0, -1))
      caption.textContent += `; ${difference(side.pixels, reference.pixels).toFixed(1)} of 255 from the reference`;
  }

  close() {
    if (this.section.hidden) return;
    ++this.round;
    this.section.hidden = true;
    this.grid.replaceChildren();
    this.sideBySide.close();
    this.button.focus();
  }
}
