/** The token of `wucht app`, kept by its pages: of the browser's storage, unlike its cookies, each port has its own. */

const NAME = "wucht-token";

/** Keep the token for the pages that are opened from now on. */
export function keepToken(token: string) {
  localStorage.setItem(NAME, token);
}

/** What a request must bear beside the cookie. */
export function tokenHeaders(): Readonly<Record<string, string>> {
  return { "x-wucht-token": localStorage.getItem(NAME) ?? "" };
}
