// The four pictures of side_by_side.js beside each other, each with what is known of it. A click makes one large.
import { difference, SideBySide } from '../side_by_side.js';

/** @typedef {import('../side_by_side.js').Side} Side */

/** What a picture is made of. @param {Side} side */
export function captionOf({ name, points, occlusion, views, gpuMs }) {
  const of = views > 1 ? `, means of ${views} views` : '';
  const lights = points > 1 ? `${points} points of each lamp` : 'one point of each lamp';
  return `${name}: ${lights}${occlusion ? ' and ambient occlusion' : ''}${of}, ${gpuMs.toFixed(1)} ms a mask`;
}

/**
 * @param {(id: string) => any} find
 * @param {import('../viewer.js').Viewer} viewer
 * @param {() => import('../prediction/border.js').Pose} pose of now
 */
export function attachSides(find, viewer, pose) {
  const [section, button, text, grid] = ['sides', 'sides-button', 'sides-text', 'sides-grid'].map(find);
  const sideBySide = new SideBySide(viewer);
  let round = 0;

  /** @param {Side} side */
  const figureOf = (side) => {
    const canvas = Object.assign(document.createElement('canvas'), viewer.size);
    side.draw(/** @type {CanvasRenderingContext2D} */ (canvas.getContext('2d')));
    const caption = Object.assign(document.createElement('figcaption'), { textContent: captionOf(side) });
    const figure = document.createElement('figure');
    figure.onclick = () => figure.toggleAttribute('data-large');
    figure.append(canvas, caption);
    return { figure, caption };
  };

  const open = async () => {
    const mine = ++round;
    section.hidden = false;
    grid.replaceChildren();
    /** @type {{side: Side, caption: HTMLElement}[]} */
    const shown = [];
    text.textContent = 'the first of four pictures is traced';
    try {
      await sideBySide.open(pose(), (side) => {
        if (mine !== round) return;
        const { figure, caption } = figureOf(side);
        shown.push({ side, caption });
        grid.append(figure);
        text.textContent = shown.length < 3 ? `picture ${shown.length + 1} of 4 is traced` : 'the reference is traced, in 16 views';
      });
      if (mine !== round) return;
      const reference = shown[shown.length - 1].side;
      for (const { side, caption } of shown.slice(0, -1))
        caption.textContent += `; ${difference(side.pixels, reference.pixels).toFixed(1)} of 255 from the reference`;
      text.textContent = 'one view, each picture as the server traced it; the difference is the root mean square of the bytes';
    } catch (error) {
      if (mine === round) text.textContent = error instanceof Error ? error.message : String(error);
    }
  };
  const close = () => {
    if (section.hidden) return;
    ++round;
    section.hidden = true;
    grid.replaceChildren();
    sideBySide.close();
    button.focus();
  };
  button.onclick = open;
  find('sides-close').onclick = close;
  document.addEventListener('keydown', (event) => {
    if (event.key === 'Escape') close();
  });
}
