// The connection to the program.

import { decode } from './picture.js';

/** The time until the page tries to connect again, in milliseconds. */
const AGAIN = 1000;

/**
 * @typedef {object} Listener
 * @property {(picture: import('./picture.js').Picture) => void} picture
 * @property {(news: any) => void} news
 * @property {(isOpen: boolean) => void} connection
 */

/**
 * Connects, and connects again when the connection is lost.
 * @param {Listener} listener
 * @returns {(request: object) => void} sends a request, or drops it without a connection
 */
export function connect(listener) {
  /** @type {WebSocket} */
  let socket;
  const open = () => {
    socket = new WebSocket(new URL('socket', location.href.replace(/^http/, 'ws')));
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => listener.connection(true);
    socket.onmessage = ({ data }) => {
      if (typeof data === 'string') listener.news(JSON.parse(data));
      else listener.picture(decode(data));
    };
    socket.onclose = () => {
      listener.connection(false);
      setTimeout(open, AGAIN);
    };
  };
  open();
  return (request) => {
    if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(request));
  };
}
