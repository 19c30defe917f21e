/** Parts of the drawing in the hand: held, moved, let go. */

import type { MachineDrawing, Part } from "./drawing.ts";

export interface DragHandlers {
  /** The state that is drawn. */
  state(): ArrayLike<number>;
  /** A part is taken. */
  take(): void;
  /** It is in another place. */
  hold(state: Float64Array): void;
  /** It is let go there; null where it was not moved. */
  release(state: Float64Array | null): void;
}

/** Let the parts of a drawing be grabbed. */
export function enableDragging(canvas: HTMLCanvasElement, drawing: MachineDrawing, hand: DragHandlers) {
  let part: Part | null = null;
  let held: Float64Array | null = null;
  const place = (event: PointerEvent) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top] as const;
  };
  canvas.addEventListener("pointerdown", (event) => {
    part = event.button === 0 ? drawing.partAt(...place(event)) : null;
    held = null;
    if (part === null) return;
    event.preventDefault();
    canvas.setPointerCapture(event.pointerId);
    canvas.classList.add("holding");
    hand.take();
  });
  canvas.addEventListener("pointermove", (event) => {
    if (part === null) {
      canvas.classList.toggle("grabbable", event.pointerType === "mouse" && drawing.partAt(...place(event)) !== null);
      return;
    }
    held = drawing.stateWithPartAt(part, ...place(event), held ?? hand.state());
    hand.hold(held);
  });
  const release = () => {
    if (part === null) return;
    part = null;
    canvas.classList.remove("holding");
    hand.release(held);
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  // A finger on a part moves it; elsewhere it scrolls the page.
  canvas.addEventListener("touchstart", (event) => part !== null && event.preventDefault(), { passive: false });
}
