/** A picture of what is seen: title, drawing and curves on one sheet. */

const [MARGIN, GAP, LINE] = [24, 16, 22];

export interface Sheet {
  readonly title: string;
  readonly lines: readonly string[];
  readonly drawings: readonly HTMLCanvasElement[];
  readonly curves: readonly { readonly title: string; readonly canvas: HTMLCanvasElement }[];
  readonly surface: string;
  readonly ink: string;
}

/** Paint the sheet: the machine on the left, the curves below each other on the right. */
export function paintedSheet(sheet: Sheet): HTMLCanvasElement {
  const ratio = devicePixelRatio;
  const size = (canvas: HTMLCanvasElement) => ({ width: canvas.width / ratio, height: canvas.height / ratio });
  const left = { width: Math.max(...sheet.drawings.map((one) => size(one).width), 0), height: 0 };
  for (const one of sheet.drawings) left.height += size(one).height + GAP;
  const widest = Math.max(...sheet.curves.map(({ canvas }) => size(canvas).width), 0);
  const top = MARGIN + (sheet.lines.length + 1) * LINE + GAP;
  const right = sheet.curves.reduce((sum, { canvas }) => sum + size(canvas).height + LINE, 0);
  const target = document.createElement("canvas");
  target.width = (2 * MARGIN + left.width + GAP + widest) * ratio;
  target.height = (top + Math.max(left.height, right) + MARGIN) * ratio;
  const context = target.getContext("2d")!;
  context.scale(ratio, ratio);
  context.fillStyle = sheet.surface;
  context.fillRect(0, 0, target.width, target.height);
  context.fillStyle = sheet.ink;
  context.textBaseline = "top";
  context.font = "600 18px system-ui, sans-serif";
  context.fillText(sheet.title, MARGIN, MARGIN);
  context.font = "14px system-ui, sans-serif";
  sheet.lines.forEach((line, i) => context.fillText(line, MARGIN, MARGIN + (i + 1.2) * LINE));
  let y = top;
  for (const one of sheet.drawings) {
    context.drawImage(one, MARGIN, y, size(one).width, size(one).height);
    y += size(one).height + GAP;
  }
  y = top;
  for (const { title, canvas } of sheet.curves) {
    const { width, height } = size(canvas);
    context.fillText(title, MARGIN + left.width + GAP + 8, y);
    context.drawImage(canvas, MARGIN + left.width + GAP, y + LINE, width, height);
    y += height + LINE;
  }
  return target;
}

/** Hand a canvas to the user as a file. */
export function savePicture(canvas: HTMLCanvasElement, name: string) {
  canvas.toBlob((blob) => {
    if (blob === null) return;
    const address = URL.createObjectURL(blob);
    const anchor = document.createElement("a");
    anchor.href = address;
    anchor.download = name;
    anchor.click();
    setTimeout(() => URL.revokeObjectURL(address), 10_000);
  }, "image/png");
}
