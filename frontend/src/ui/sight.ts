/**
 * Tells whether an element is in the part of the page that can be seen, until the returned function is called. Of no use
 * for whether the page itself can be seen: that is `document.hidden`.
 */
export function watchSight(element: Element, onChange: (inSight: boolean) => void): () => void {
  const observer = new IntersectionObserver((entries) => {
    const last = entries.at(-1);
    if (last !== undefined) onChange(last.isIntersecting);
  });
  observer.observe(element);
  return () => observer.disconnect();
}
