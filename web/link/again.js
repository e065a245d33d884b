// What the network took away is asked for again, as a session is: a phone that goes from one network to another loses
// whatever is under way.
import { Backoff } from './backoff.js';

/** Whether no answer came, or not the whole of it: fetch() throws this error then, beside those for wrong arguments. */
const isOfNetwork = (/** @type {unknown} */ error) => error instanceof TypeError;

/**
 * What `attempt` brings, which fetches something and does nothing beside. Other errors than those of the network are the
 * caller's, and so are these once `isWanted` says no.
 * @template T
 * @param {() => Promise<T>} attempt
 * @param {object} [options]
 * @param {() => boolean} [options.isWanted]
 * @param {(error: Error) => void} [options.onLoss] is told before each wait
 * @returns {Promise<T>}
 */
export async function again(attempt, options = {}) {
  const { isWanted = () => true, onLoss = () => {} } = options;
  const backoff = new Backoff();
  for (;;) {
    try {
      return await attempt();
    } catch (error) {
      if (!isOfNetwork(error) || !isWanted()) throw error;
      onLoss(/** @type {Error} */ (error));
      await new Promise((resolve) => setTimeout(resolve, backoff.wait()));
    }
  }
}
