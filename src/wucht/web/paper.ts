/** Colours and letters of curves, from the style of the page. */

export interface Paper {
  readonly ink: string;
  readonly muted: string;
  readonly grid: string;
  readonly surface: string;
  readonly font: string;
  readonly accents: readonly string[];
  /** The font at a number of device pixels for a CSS pixel. */
  canvasFont(ratio: number): string;
}

/** Read the style of an element. */
export function paperOf(root: Element): Paper {
  const style = getComputedStyle(root);
  const value = (name: string) => style.getPropertyValue(name).trim();
  const family = "system-ui, sans-serif";
  return {
    ink: value("--ink"),
    muted: value("--muted"),
    grid: value("--grid"),
    surface: value("--surface"),
    font: `12px ${family}`,
    accents: [1, 2, 3, 4, 5].map((i) => value(`--accent-${i}`)),
    canvasFont: (ratio) => `${12 * ratio}px ${family}`,
  };
}
