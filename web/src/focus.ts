// The focus of the keyboard stays near what was pressed. A button that removes itself, or its section, would otherwise
// leave it at the beginning of the page; and so would one that is disabled while its work is done.

const CONTROLS = "a[href], button:not(:disabled), input:not(:disabled):not([hidden]), select:not(:disabled), summary, [tabindex='0']";

/** What takes the focus where no control is left. */
const REGIONS = "section, dialog, [role=region], [role=group], main";

const isShown = (one: HTMLElement): boolean => one.offsetParent !== null || getComputedStyle(one).position === "fixed";

/** The controls in a node, itself among them. */
const controls = (node: Node | null): HTMLElement[] =>
  (node instanceof HTMLElement ? [...(node.matches(CONTROLS) ? [node] : []), ...node.querySelectorAll<HTMLElement>(CONTROLS)].filter(isShown) : []);

/** The first control that follows a place, else the last before it; of the same parent. */
function beside({ target, nextSibling, previousSibling }: MutationRecord): HTMLElement | undefined {
  for (let node = nextSibling; node?.parentNode === target; node = node.nextSibling) if (controls(node)[0]) return controls(node)[0];
  for (let node = previousSibling; node?.parentNode === target; node = node.previousSibling) if (controls(node)[0]) return controls(node).at(-1);
  return undefined;
}

/** The control that takes the focus of what was removed there: one beside it, or the region that it was in. */
function next(record: MutationRecord, lost: HTMLElement): HTMLElement | null {
  const { target, removedNodes } = record;
  const wasSection = [...removedNodes].some((node) => node.contains(lost) && node instanceof HTMLElement && node.matches(REGIONS));
  const region = (target as HTMLElement).closest<HTMLElement>(REGIONS) ?? document.querySelector("main");
  // What stands beside a section is about something else.
  if (!wasSection) {
    const found = beside(record);
    if (found) return found;
    for (let around = target as HTMLElement; around !== region && around.parentElement; around = around.parentElement) {
      const after = [...around.parentElement.children].slice([...around.parentElement.children].indexOf(around) + 1).flatMap(controls)[0];
      if (after) return after;
    }
  }
  return region;
}

/** Keeps the focus in a page from now on. */
export function keepFocus(page: HTMLElement): void {
  let last: HTMLElement | undefined;
  page.addEventListener("focusin", (event) => void (last = event.target as HTMLElement));
  // A click beside all controls takes the focus away: that is meant.
  page.addEventListener("focusout", (event) => setTimeout(() => {
    if (last === event.target && last?.isConnected && !last.matches(":disabled") && document.activeElement !== last) last = undefined;
  }));
  new MutationObserver((records) => {
    if (!last || (document.activeElement ?? document.body) !== document.body) return;
    const lost = last;
    if (lost.isConnected) {
      if (!lost.matches(":disabled") && records.some(({ type, target }) => type === "attributes" && target === lost)) lost.focus({ preventScroll: true });
      return;
    }
    const record = [...records].reverse().find(({ target, removedNodes }) => target.isConnected && [...removedNodes].some((node) => node.contains(lost)));
    const found = record && next(record, lost);
    if (!found) return;
    if (!found.matches(CONTROLS) && !found.hasAttribute("tabindex")) found.tabIndex = -1;
    found.focus({ preventScroll: true });
  }).observe(page, { childList: true, subtree: true, attributeFilter: ["disabled"] });
}
