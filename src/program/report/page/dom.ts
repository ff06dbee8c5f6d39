/** Returns the element with an id of page.html. */
export const find = <T extends HTMLElement>(id: string) => document.getElementById(id) as T;

export const make = (tag: string, text = "", className = "") =>
  Object.assign(document.createElement(tag), { textContent: text, className });

/** Fills a list with one item for each entry, or with one word if there is none. */
export function fillList(id: string, items: HTMLElement[], none = ""): void {
  find(id).replaceChildren(...(items.length || !none ? items : [make("li", none)]));
}
