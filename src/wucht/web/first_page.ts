/**
 * The first page of `wucht app` at any of its addresses, which holds no data: it exchanges the token for a key, which opens the
 * page once. The token is in it where it was opened with the first key.
 */

import { keepToken, tokenHeaders } from "./session.ts";

const NO_TOKEN =
  "This page belongs to the user who started wucht app: open the address that it printed. It is good once, in one browser.";
const NO_ANSWER = "No answer from wucht app: is it still running?";

async function open() {
  const { token } = document.documentElement.dataset;
  if (token) keepToken(token);
  const answer = await fetch("/key", { method: "POST", headers: tokenHeaders() });
  if (!answer.ok) return say(NO_TOKEN);
  const page = new URL(location.href); // its path alone could be `//HOST/`, which would lead the key to another server
  page.search = `key=${await answer.text()}`;
  location.replace(page);
}

function say(sentence: string) {
  document.body.textContent = sentence;
}

open().catch((error: unknown) => say(error instanceof DOMException ? NO_TOKEN : NO_ANSWER));
