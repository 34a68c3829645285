// What a designer would not sign on the page that is shown: text that is cut off, that leaves its box or the window, that
// lies on other text or under a button, and a page that scrolls sideways. Returns one sentence for each.
() => {
  const SLACK = 1.5; // pixels: rounding
  const faults = new Set();
  const style = (element) => getComputedStyle(element);
  const words = (text) => `"${text.trim().replace(/\s+/g, " ").slice(0, 60)}"`;
  const parents = function* (element) {
    for (let each = element; each instanceof Element; each = each.parentElement) yield each;
  };

  /** Whether it is drawn: not hidden, nor only for screen readers. */
  function isDrawn(element) {
    if (!element.checkVisibility({ opacityProperty: true, visibilityProperty: true })) return false;
    for (const each of parents(element)) {
      if (each.hasAttribute("inert")) return false;
      const { clip, clipPath, position } = style(each);
      if (position === "absolute" && (clip !== "auto" || clipPath === "inset(50%)")) return false;
    }
    return true;
  }

  const scrolls = (overflow) => overflow === "auto" || overflow === "scroll";
  const hides = (overflow) => overflow === "hidden" || overflow === "clip";

  /** The part of a rectangle that can be seen, and what cuts it off; null where a scrolled container hides it. */
  function visiblePart(element, rect) {
    let { left, right, top, bottom } = rect;
    let cutBy = null;
    let inScroller = false;
    for (const each of parents(element)) {
      const { overflowX, overflowY, textOverflow, position, webkitLineClamp } = style(each);
      const box = each.getBoundingClientRect();
      if (!(each instanceof SVGElement) && each !== document.documentElement && each !== document.body) {
        if (scrolls(overflowX) || scrolls(overflowY)) inScroller = true;
        const sideways = left < box.left - SLACK || right > box.right + SLACK;
        const upDown = top < box.top - SLACK || bottom > box.bottom + SLACK;
        // Where the end of a text is left out, all of it can be read by pointing at it.
        const shortened = textOverflow === "ellipsis" || webkitLineClamp !== "none";
        const ellipsis = shortened && element.closest("[title]") !== null;
        if (hides(overflowX) && sideways && !ellipsis && !inScroller) cutBy ??= each;
        if (hides(overflowY) && upDown && !ellipsis && !inScroller) cutBy ??= each;
        if (overflowX !== "visible") [left, right] = [Math.max(left, box.left), Math.min(right, box.right)];
        if (overflowY !== "visible") [top, bottom] = [Math.max(top, box.top), Math.min(bottom, box.bottom)];
      }
      if (position === "fixed") break;
    }
    return right - left > 1 && bottom - top > 1 ? { left, right, top, bottom, cutBy } : { cutBy };
  }

  /** The element that moves by itself when the page is scrolled, if one is around it. */
  const layer = (element) =>
    [...parents(element)].find((each) => ["fixed", "sticky"].includes(style(each).position)) ?? document.body;

  /** The nearest element around it that looks like a box: with a border or a background of its own. */
  function boxOf(element) {
    for (const each of parents(element)) {
      if (each === document.body || each instanceof SVGElement) return null;
      const { backgroundColor, borderLeftWidth, borderRightWidth, display } = style(each);
      if (display === "inline" || display === "contents") continue;
      const bordered = Number.parseFloat(borderLeftWidth) > 0 && Number.parseFloat(borderRightWidth) > 0;
      if (bordered || !/^(rgba\(.*, 0\)|transparent)$/.test(backgroundColor)) return each;
    }
    return null;
  }

  const CONTROLS = "button, a[href], input, select, textarea, [role=button], [role=switch], [role=tab]";
  const FREE = ".react-flow, canvas"; // what people zoom and drag
  const items = [];

  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node !== null; node = walker.nextNode()) {
    const element = node.parentElement;
    if (node.data.trim() === "" || element === null || element.closest(FREE) !== null) continue;
    if (["SCRIPT", "STYLE", "NOSCRIPT", "OPTION"].includes(element.tagName) || !isDrawn(element)) continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    for (const rect of range.getClientRects()) {
      if (rect.width < 1) continue;
      const part = visiblePart(element, rect);
      if (part.cutBy !== null) faults.add(`${words(node.data)} is cut off`);
      if (part.left === undefined || part.right <= 0) continue; // beside the window: shown once it has the focus
      if (part.left < -SLACK || part.right > window.innerWidth + SLACK)
        faults.add(`${words(node.data)} leaves the window`);
      const box = boxOf(element)?.getBoundingClientRect();
      if (box !== undefined && (part.left < box.left - SLACK || part.right > box.right + SLACK))
        faults.add(`${words(node.data)} leaves its box`);
      // A line is higher than its letters: a third less is what they need.
      const inset = (part.bottom - part.top) / 6;
      const letters = { ...part, top: part.top + inset, bottom: part.bottom - inset };
      items.push({ element, name: words(node.data), layer: layer(element), ...letters });
    }
  }
  for (const element of document.querySelectorAll(CONTROLS)) {
    if (element.closest(FREE) !== null || !isDrawn(element) || style(element).display === "inline") continue;
    const name = element.getAttribute("aria-label") ?? (element.textContent || element.localName);
    const part = visiblePart(element, element.getBoundingClientRect());
    if (part.left === undefined || part.right <= 0) continue;
    if (part.left < -SLACK || part.right > window.innerWidth + SLACK)
      faults.add(`the control ${words(name)} leaves the window`);
    items.push({ element, name: `the control ${words(name)}`, layer: layer(element), ...part });
  }

  items.sort((one, other) => one.top - other.top);
  const FIELD = "label, [data-with-left-section], .mantine-Input-wrapper, .mantine-InlineInput-root";
  const related = (one, other) => one.contains(other) || (one.closest(FIELD) ?? one).contains(other);
  items.forEach((one, index) => {
    for (const other of items.slice(index + 1)) {
      if (other.top >= one.bottom) break;
      const across = Math.min(one.right, other.right) - Math.max(one.left, other.left);
      const down = Math.min(one.bottom, other.bottom) - Math.max(one.top, other.top);
      if (across <= 2 || down <= 2 || one.layer !== other.layer) continue;
      if ([one, other].some(({ element }) => style(element).pointerEvents === "none")) continue; // a mark on a button
      if (related(one.element, other.element) || related(other.element, one.element)) continue;
      faults.add(`${one.name} lies on ${other.name}`);
    }
  });

  const tight = [...document.body.querySelectorAll("*")].filter((element) => {
    const { display, overflowX, position } = style(element);
    const arranges = /flex|grid/.test(display) && overflowX === "visible" && position !== "absolute";
    return arranges && element.scrollWidth > element.clientWidth + 2 && element.closest(FREE) === null && isDrawn(element);
  });
  for (const element of tight.filter((each) => !tight.some((other) => other !== each && each.contains(other))))
    faults.add(
      `${words(element.innerText || element.localName)} needs ${element.scrollWidth - element.clientWidth} pixels more`,
    );

  const wider = document.documentElement.scrollWidth - window.innerWidth;
  if (wider > 0) faults.add(`the page is ${wider} pixels wider than the window`);
  return [...faults];
}
