/** The page in a cell of a notebook: in a frame that can reach nothing of the notebook, and tells what it shows. */

/** The part of a widget's model that is used here; see anywidget. */
interface Model {
  get(name: "page" | "study"): string;
  get(name: "height"): number;
  set(name: "study", value: string): void;
  save_changes(): void;
  on(event: string, action: () => void): void;
  off(event: string, action: () => void): void;
}

interface Message {
  readonly wucht: "study";
  readonly study: string;
}

function isMessage(data: unknown): data is Message {
  const { wucht, study } = (data ?? {}) as Partial<Message>;
  return wucht === "study" && typeof study === "string";
}

function render({ model, el }: { readonly model: Model; readonly el: HTMLElement }) {
  const frame = document.createElement("iframe");
  frame.setAttribute("sandbox", "allow-scripts allow-downloads");
  frame.setAttribute("allow", "clipboard-write");
  frame.setAttribute("title", "live machine");
  frame.style.cssText = "display: block; width: 100%; border: 0";
  const listen = (event: MessageEvent<unknown>) => {
    if (event.source !== frame.contentWindow || !isMessage(event.data)) return;
    model.set("study", event.data.study);
    model.save_changes();
  };
  const show = () => {
    frame.srcdoc = model.get("page");
  };
  const fit = () => {
    frame.style.height = `${model.get("height")}px`;
  };
  addEventListener("message", listen);
  model.on("change:page", show);
  model.on("change:height", fit);
  fit();
  show();
  el.append(frame);
  return () => {
    removeEventListener("message", listen);
    model.off("change:page", show);
    model.off("change:height", fit);
  };
}

export default { render };
