// Questions to the program, and their answers.

/** How long a page waits for an answer, in milliseconds. */
const PATIENCE = 5000;

/**
 * Makes questions of one page, which are told apart by numbers.
 * @param {number} me
 * @param {(request: object) => void} request
 */
export function makeAsker(me, request) {
  /** @type {Map<number, (answer: any) => void>} */
  const waiting = new Map();
  return {
    /**
     * Asks. The answer is `undefined` if none comes.
     * @param {object} question
     * @param {number} patience in milliseconds
     * @returns {Promise<any>}
     */
    ask(question, patience = PATIENCE) {
      const number = Math.floor(Math.random() * 2 ** 32);
      request({ ...question, by: me, number });
      return new Promise((answer) => {
        waiting.set(number, answer);
        if (patience < Infinity) setTimeout(() => {
          if (waiting.delete(number)) answer(undefined);
        }, patience);
      });
    },
    /** Gives all questions up: the connection is lost. */
    giveUp() {
      for (const answer of waiting.values()) answer(undefined);
      waiting.clear();
    },
    /** @param {{by: number, number: number}} news */
    answer(news) {
      if (news.by === me) waiting.get(news.number)?.(news);
      waiting.delete(news.number);
    },
  };
}
