// Begins the page. Where a part of it does not come, as while a phone goes from one network to another, a browser says
// nothing and some do not ask for it again: the page is loaded again, which takes from the cache what has come.
//
// The server puts this into the page itself, so that it comes with it (daemon/web/page_source.h). It stands at the end:
// what is above is there, and the style sheet has come or failed.
(() => {
  const FAILED = 'gnomon-failed-starts'; // in turn, kept for this tab
  const MOST = 8; // after them a person says when
  const FIRST_MS = 500; // doubled each time
  const LONGEST_MS = 8_000;

  /** @param {Error} error */
  function startAgain(error) {
    const failed = Number(sessionStorage.getItem(FAILED)) + 1;
    const text = /** @type {HTMLElement} */ (document.getElementById('poster-text'));
    if (failed <= MOST) {
      sessionStorage.setItem(FAILED, String(failed));
      text.textContent = 'a part of the page did not come; trying again';
      setTimeout(() => location.reload(), Math.min(FIRST_MS * 2 ** (failed - 1), LONGEST_MS));
      return;
    }
    sessionStorage.removeItem(FAILED);
    text.textContent = `a part of the page did not come: ${error.message}`;
    const again = /** @type {HTMLButtonElement} */ (document.getElementById('again'));
    again.onclick = () => location.reload();
    again.hidden = false;
    /** @type {HTMLElement} */ (document.getElementById('progress')).hidden = true;
  }

  const style = /** @type {HTMLLinkElement} */ (document.querySelector('link[rel=stylesheet]'));
  if (style.sheet) import('./app.js').then(() => sessionStorage.removeItem(FAILED), startAgain);
  else startAgain(new Error('its style is missing'));
})();
