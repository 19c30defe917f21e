/** Colours of canvases: the page's custom properties, or the house's palette, which any colour vision distinguishes. */

export interface Colours {
  readonly ink: string;
  readonly muted: string;
  readonly surface: string;
  readonly accents: readonly [string, string, string, string, string];
}

/** M. Okabe, K. Ito, "Color Universal Design", 2008; in the dark its lighter ones. */
const LIGHT: Colours = {
  ink: "#1b1f24",
  muted: "#666666",
  surface: "#ffffff",
  accents: ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9"],
};
const DARK: Colours = {
  ink: "#e6e8eb",
  muted: "#9aa1a9",
  surface: "#20252b",
  accents: ["#56B4E9", "#E69F00", "#2FC79A", "#E3A3C8", "#F0E442"],
};

/** The colours of an element, read again when the theme changes. */
export class Theme {
  private readonly element: HTMLElement;
  private colours: Colours | null = null;

  constructor(element: HTMLElement) {
    this.element = element;
    if (typeof window === "undefined" || typeof MutationObserver === "undefined") return;
    const forget = (): void => {
      this.colours = null;
    };
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", forget);
    new MutationObserver(forget).observe(document.documentElement, { attributeFilter: ["class", "style", "data-theme"] });
  }

  get current(): Colours {
    this.colours ??= this.read();
    return this.colours;
  }

  private read(): Colours {
    if (typeof getComputedStyle === "undefined") return LIGHT;
    const style = getComputedStyle(this.element);
    const isDark = style.colorScheme.includes("dark") && !style.colorScheme.includes("light")
      ? true
      : window.matchMedia("(prefers-color-scheme: dark)").matches && !/^(only )?light$/.test(style.colorScheme);
    const fallback = isDark ? DARK : LIGHT;
    const value = (name: string, otherwise: string): string => style.getPropertyValue(name).trim() || otherwise;
    const [a, b, c, d, e] = fallback.accents;
    return {
      ink: value("--ink", fallback.ink),
      muted: value("--muted", fallback.muted),
      surface: value("--surface", fallback.surface),
      accents: [
        value("--accent-1", a), value("--accent-2", b), value("--accent-3", c), value("--accent-4", d), value("--accent-5", e),
      ],
    };
  }
}

/** Give a canvas as many pixels as the device has on its area, and the unit of a CSS pixel. Returns whether it has an area. */
export function fitCanvas(canvas: HTMLCanvasElement, context: CanvasRenderingContext2D): boolean {
  const ratio = globalThis.devicePixelRatio || 1;
  const width = Math.round(canvas.clientWidth * ratio);
  const height = Math.round(canvas.clientHeight * ratio);
  if (canvas.width !== width) canvas.width = width;
  if (canvas.height !== height) canvas.height = height;
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return width > 0 && height > 0;
}
